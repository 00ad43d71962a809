"""The live notebook without a browser: its functions as plain Python, and all its cells in one run."""

import importlib.util
import re
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from oracles.brute_force import brute_force

from cutgap.instances import Status

NOTEBOOK = Path(__file__).parents[2] / "docs" / "live" / "two_heads.py"
SMALL = 6


@pytest.fixture(scope="module")
def live():
    spec = importlib.util.spec_from_file_location("two_heads", NOTEBOOK)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules[spec.name]


def test_all_cells_run(live):
    outputs, names = live.app.run()
    shown = " ".join(output.text for output in outputs if hasattr(output, "text"))
    assert names["result"].status is Status.OPTIMAL
    assert f"{names['result'].value:.2f} mm" in shown
    assert all(rung.bound <= names["result"].value * (1 + 1e-9) for rung in names["rungs"])
    assert [rung.formulation in live.FAST_RUNGS for rung in names["rungs"]] == [True] * len(names["rungs"])


@pytest.mark.parametrize("objective", ["travel", "makespan"])
@pytest.mark.parametrize("seed", range(3))
def test_values_and_price_of_balance_are_those_of_brute_force(live, objective, seed):
    setting = live.Setting(holes=SMALL, seed=seed, objective=objective, balance_s=8.0)
    free = replace(setting, balance_s=None)
    best = [brute_force(each.instance(), each.rules()) for each in (setting, free)]
    results = [live.solved(each) for each in (setting, free)]
    for result, expected in zip(results, best, strict=True):
        assert result.value == pytest.approx(expected.value, rel=1e-9)
        assert f"{expected.value:.2f}" in live.headline(result)
    cost, said = best[0].value - best[1].value, live.balance_price(*results)
    assert ("costs nothing" in said) == (cost < 1e-6)
    assert cost < 1e-6 or f"{cost:.2f}" in said


def test_a_wide_gap_is_infeasible_and_said_so(live):
    setting = live.Setting(holes=SMALL, non_overlap_mm=1000.0, balance_s=1.0)
    result = live.solved(setting)
    assert result.status is Status.INFEASIBLE
    assert re.search(r"No plan is allowed.*1000 mm", live.headline(result))
    assert "no plan" in live.balance_price(result, live.solved(replace(setting, balance_s=None)))
    assert "no plan" in live.plan_picture(setting.instance(), result).text


def test_perfect_balance_finds_no_plan_and_the_bound_is_still_shown(live):
    result = live.solved(live.Setting(holes=12, balance_s=0.0))
    assert result.value is None
    assert f"{result.lower_bound:.2f} mm" in live.headline(result)
    assert "Loosen the balance limit" in live.headline(result)


def test_speeds_and_number_of_holes_change_the_makespan(live):
    slow = live.Setting(holes=SMALL, objective="makespan")
    for other in (replace(slow, v_jump=300.0), replace(slow, v_cut=80.0), replace(slow, holes=2)):
        assert live.solved(other).value < live.solved(slow).value
