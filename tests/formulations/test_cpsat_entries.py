"""The CP-SAT model with entry points agrees with listing all plans: each rule alone and all together."""

from dataclasses import replace

import numpy as np
import pytest
from oracles.entry_tours import best_plan
from oracles.random_sheets import random_sheet

from cutgap.formulations.cpsat.solving import solve_cpsat
from cutgap.instances import Instance, Rules, check

SLACK = 1e-7
"""Relative slack of values; the scale lets single roundings be far smaller."""

ALONE = {
    "none": {},
    "parts in one go": {"parts_in_one_go": True},
    "neighbours only": {"neighbours_only": True},
    "clear rapids": {"clear_rapids": True},
    "backward price": {"objective": "travel", "backward_price": 1.5},
    "via points": {"via_points": True},
}
TOGETHER = {
    "parts_in_one_go": True,
    "neighbours_only": True,
    "clear_rapids": True,
    "objective": "travel",
    "backward_price": 0.5,
}
RULES = {**ALONE, "together": TOGETHER}


def assert_agrees(instance: Instance, rules: Rules, expected: float | None) -> None:
    result = solve_cpsat(instance, rules, workers=1, isolated=False)
    if expected is None:
        assert (result.status, result.plan, result.certificate) == ("infeasible", None, None)
        return
    assert result.status in ("feasible", "optimal")
    assert check(instance, rules, result.plan) == []
    slack = SLACK * max(1.0, expected)
    assert result.value == pytest.approx(expected, abs=slack)
    assert expected - slack <= result.lower_bound <= expected + 1e-9 * max(1.0, expected)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("name", RULES)
def test_one_head(name, seed):
    rng = np.random.default_rng((list(RULES).index(name), seed))
    instance = random_sheet(rng, int(rng.integers(1, 6)), homes=None, nested=float(rng.choice([0.1, 0.8])))
    rules = Rules(**{"objective": str(rng.choice(["travel", "makespan"])), **RULES[name]})
    best = best_plan(instance, rules)
    assert_agrees(instance, rules, best and best.value)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("name", RULES)
def test_two_heads(name, seed):
    """In general position, as ties in time are decided by the last bits."""
    rng = np.random.default_rng((1, list(RULES).index(name), seed))
    instance = random_sheet(
        rng, int(rng.integers(1, 5)), entries=2, heads=2, homes=None, shape="polygons", nested=0.8
    )
    objective = str(rng.choice(["travel", "makespan", "weighted"]))
    rules = Rules(
        **{"objective": objective, **RULES[name]},
        non_overlap=[None, 0.0, 30.0][int(rng.integers(3))],
        empty_heads=bool(rng.random() < 0.5),
    )
    if rules.objective == "weighted":
        rules = replace(rules, weight=float(rng.choice([0.3, 2.5])) * instance.machine.v_jump)
    best = best_plan(instance, rules)
    assert_agrees(instance, rules, best and best.value)
