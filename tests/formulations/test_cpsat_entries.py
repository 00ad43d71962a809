"""The CP-SAT model with entry points agrees with listing all plans: each rule alone and all together."""

from dataclasses import replace

import numpy as np
import pytest
from oracles.brute_force import brute_force
from oracles.entry_tours import best_plan
from oracles.random_instances import random_instance
from oracles.random_sheets import random_sheet

from cutgap.formulations.cpsat.solving import solve_cpsat
from cutgap.instances import Contour, Head, Instance, Machine, Plan, Rules, check, evaluate

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


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("metric", ["euclidean", "matrix"])
@pytest.mark.parametrize("heads", [1, 2])
def test_agrees_with_brute_force(heads, metric, seed):
    """Ties, asymmetric lengths, balance; precedence on one head."""
    rng = np.random.default_rng((2, heads, seed))
    count, pairs = int(rng.integers(0, 6)), 0.3 if heads == 1 else 0.0
    instance = random_instance(rng, count, heads=heads, homes=None, metric=metric, entries=2, precedence=pairs)
    objective = str(rng.choice(["makespan", "travel", "weighted"]))
    rules = Rules(
        objective,
        float(rng.choice([0.3, 2.5])) * instance.machine.v_jump if objective == "weighted" else 0.0,
        non_overlap=[None, 0.0, 40.0][int(rng.integers(3))],
        balance=[None, 3.0][int(rng.integers(2))],
        via_points=bool(rng.random() < 0.5),
        empty_heads=bool(rng.random() < 0.5),
    )
    best = brute_force(instance, rules)
    assert_agrees(instance, rules, best and best.value)


def test_a_plan_that_crosses_at_the_very_end_of_a_cut_is_not_taken():
    """One head would go from c to a across b at 1 s, as the other is done with b: the model lets it pass."""
    square = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])
    contours = tuple(
        Contour(name, [[x, 0, 0]], 0.0, geometry=square + np.array([x, 0.0]))
        for name, x in zip("abc", (0.0, 20.0, 40.0), strict=True)
    )
    heads = (Head("l"), Head("r"))
    far = np.array([[0.0, 500.0, 20.0], [500.0, 0.0, 500.0], [20.0, 500.0, 0.0]])
    machine = Machine(v_jump=10.0, t_aux=1.0, metric="matrix")
    sheet = Instance("row", contours, heads, machine, precedence=((2, 0),), matrix=far)
    rules = Rules("travel", non_overlap=None, clear_rapids=True)
    tied = Plan.of_contours([[2, 0], [1]])
    assert [violation.constraint for violation in check(sheet, rules, tied)] == ["clear rapids"]
    best = best_plan(sheet, rules)
    result = solve_cpsat(sheet, rules, workers=1, isolated=False)
    assert check(sheet, rules, result.plan) == []
    assert result.value == pytest.approx(best.value)
    assert result.lower_bound == pytest.approx(evaluate(sheet, tied).total_travel_mm)
    assert result.lower_bound < best.value


def test_a_start_with_entry_points_is_kept():
    instance = random_sheet(np.random.default_rng(3), 6, heads=2, shape="polygons")
    rules = Rules("travel", non_overlap=None, empty_heads=True)
    found = solve_cpsat(instance, rules, workers=1, isolated=False)
    again = solve_cpsat(instance, rules, workers=1, isolated=False, start=found.plan, time_limit=0.0)
    assert again.plan == found.plan


def test_a_contour_may_start_on_one_head_when_the_one_before_it_ends_on_the_other():
    contours = (Contour("a", [[0, 0, 0]], 0.0), Contour("b", [[110, 0, 0]], 0.0))
    heads = (Head("l"), Head("r", [100, 0, 0]))
    instance = Instance("relay", contours, heads, Machine(v_jump=10.0, t_aux=1.0), precedence=((0, 1),))
    result = solve_cpsat(instance, Rules("travel"), workers=1, isolated=False)
    assert (result.status, result.plan) == ("optimal", Plan.of_contours([[0], [1]]))
