"""The published claim by optima: every figure against all plans of small plates, and the words for bounds."""

import pytest
from oracles.heat import hot_plans

from cutgap.benchmark import heat_bounds
from cutgap.benchmark.heat_bounds import Answer, ask, verdict
from cutgap.benchmark.heat_readings import RULES
from cutgap.instances import Result, Status
from cutgap.instances.generate import generate


@pytest.mark.parametrize("seed", range(3))
def test_figures_are_those_of_the_best_of_all_plans(seed):
    instance = generate("dense-plate", holes=3, seed=seed)
    answer, every = ask(instance, 20.0), hot_plans(instance, clear_rapids=True)

    def coolest(limit):
        return min(plan.peak for plan in every.plans if plan.travel <= limit * (1.0 + 1e-12))

    travel = every.least_travel().travel
    peak = coolest(travel)
    assert answer.shortest.value == pytest.approx(travel)
    assert answer.coolest.value == pytest.approx(peak)
    assert answer.within.value == pytest.approx(coolest(1.05 * travel))
    for half, cap in zip(answer.halves, (peak / 2, 20.0 + (peak - 20.0) / 2), strict=True):
        best = every.least_travel(cap)
        assert half.value == (None if best is None else pytest.approx(best.travel))
        holds = best is not None and best.travel <= 1.05 * travel
        assert answer.claim(half) == ("holds" if holds else "refuted")


def result(value, bound, status=Status.FEASIBLE):
    return Result(status, RULES, "any", 0.0, value=value, lower_bound=bound)


@pytest.mark.parametrize(
    ("half", "claim", "price"),
    [
        (result(105.0, 101.0), "holds", "1.01 to 1.05"),
        (result(120.0, 106.0), "refuted", "1.06 to 1.20"),
        (result(120.0, 104.0), "open", "1.04 to 1.20"),
        (result(None, 104.0, Status.UNKNOWN), "open", "1.04 to ?"),
        (result(None, None, Status.INFEASIBLE), "refuted", "no plan"),
        (result(110.0, 110.0, Status.OPTIMAL), "refuted", "= 1.10"),
    ],
)
def test_what_a_bound_and_a_plan_say_of_the_claim(half, claim, price):
    first = result(100.0, 100.0, Status.OPTIMAL)
    answer = Answer(first, result(80.0, 80.0), result(60.0, 60.0), (half, half))
    assert answer.claim(half) == claim
    assert answer.price(half) == price
    assert f"{claim} on 1" in verdict([answer])
    assert "0.75 +- 0.00 of the peak" in verdict([answer])


def test_the_command_prints_a_row_for_each_plate(capsys):
    assert heat_bounds.main(["--plates", "2", "--contours", "2", "--seconds", "5"]) == 0
    shown = capsys.readouterr()
    assert len(shown.err.splitlines()) == 2
    assert "of 2 plates" in shown.out


def test_no_plates_are_refused(capsys):
    with pytest.raises(SystemExit):
        heat_bounds.main(["--plates", "0"])
    assert "at least 1" in capsys.readouterr().err
