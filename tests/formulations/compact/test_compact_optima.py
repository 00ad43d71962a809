"""Each compact model finds the optimum that listing all plans finds, under each rule, and relaxes it."""

from dataclasses import replace

import numpy as np
import pytest
from oracles.brute_force import brute_force
from oracles.entry_tours import best_plan
from oracles.random_instances import mirrored, moved, permuted, random_instance
from oracles.random_sheets import random_sheet

from cutgap.formulations.compact import TOUR_FORMULATIONS, compact_model
from cutgap.instances import Head, Instance, Rules, check

EXACT = [name for name in TOUR_FORMULATIONS if name != "assignment"]

SHEET_RULES = {
    "none": {},
    "parts in one go": {"parts_in_one_go": True},
    "neighbours only": {"neighbours_only": True},
    "clear rapids": {"clear_rapids": True},
    "backward price": {"objective": "travel", "backward_price": 1.5},
    "via points": {"via_points": True},
    "together": {
        "parts_in_one_go": True,
        "neighbours_only": True,
        "clear_rapids": True,
        "objective": "travel",
        "backward_price": 0.5,
    },
}


def assert_agrees(instance: Instance, rules: Rules, formulation: str, expected: float | None) -> None:
    model = compact_model(instance, rules, formulation)
    relaxation, result = model.relax(), model.solve()
    if expected is None:
        assert (result.status, result.plan, result.lower_bound) == ("infeasible", None, None)
        assert result.reason == "HIGHS claims that there is no plan"
        return
    slack = 1e-6 * max(1.0, expected)
    assert result.status == "optimal"
    assert check(instance, rules, result.plan) == []
    assert result.value == pytest.approx(expected, abs=slack)
    assert result.method == f"compact {formulation}"
    assert relaxation.value <= expected + slack
    assert relaxation.lower_bound <= relaxation.value


@pytest.mark.parametrize("formulation", EXACT)
@pytest.mark.parametrize("name", SHEET_RULES)
def test_one_head_on_a_sheet(name, formulation):
    seeds = (list(SHEET_RULES).index(name), EXACT.index(formulation))
    rng = np.random.default_rng((1, *seeds))
    instance = random_sheet(rng, 3 + sum(seeds) % 2, homes=None, nested=float(rng.choice([0.1, 0.8])))
    rules = Rules(**{"objective": str(rng.choice(["travel", "makespan"])), **SHEET_RULES[name]})
    best = best_plan(instance, rules)
    assert_agrees(instance, rules, formulation, best and best.value)


@pytest.mark.parametrize("formulation", EXACT)
@pytest.mark.parametrize("name", SHEET_RULES)
def test_two_heads_on_a_sheet(name, formulation):
    """In general position, as ties in time are decided by the last bits."""
    seeds = (list(SHEET_RULES).index(name), EXACT.index(formulation))
    rng = np.random.default_rng((2, *seeds))
    instance = random_sheet(
        rng, 2 + sum(seeds) % 3, entries=2, heads=2, homes=None, shape="polygons", nested=0.8
    )
    rules = Rules(
        **{"objective": str(rng.choice(["travel", "makespan", "weighted"])), **SHEET_RULES[name]},
        non_overlap=[None, 0.0, 30.0][int(rng.integers(3))],
        empty_heads=bool(rng.random() < 0.5),
    )
    if rules.objective == "weighted":
        rules = replace(rules, weight=float(rng.choice([0.3, 2.5])) * instance.machine.v_jump)
    best = best_plan(instance, rules)
    assert_agrees(instance, rules, formulation, best and best.value)


@pytest.mark.parametrize("formulation", EXACT)
@pytest.mark.parametrize("metric", ["euclidean", "matrix"])
@pytest.mark.parametrize("heads", [1, 2])
def test_agrees_with_brute_force(heads, metric, formulation):
    """Ties, asymmetric lengths, balance, heads without home, no contours; precedence on one head."""
    for seed in range(2):
        rng = np.random.default_rng((3, heads, EXACT.index(formulation), seed, metric == "matrix"))
        pairs = 0.3 if heads == 1 else 0.0
        instance = random_instance(
            rng, int(rng.integers(0, 5)), heads=heads, homes=None, metric=metric, entries=2, precedence=pairs
        )
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
        assert_agrees(instance, rules, formulation, best and best.value)


@pytest.mark.parametrize("solver", ["HIGHS", "SCIPY"])
def test_solvers_agree(solver):
    instance = random_instance(np.random.default_rng(11), 5, layout="uniform", entries=2)
    best = brute_force(instance, Rules())
    model = compact_model(instance, Rules(), "single-commodity")
    result = model.solve(solver)
    assert (result.status, result.value) == ("optimal", pytest.approx(best.value))
    assert model.relax(solver).value == pytest.approx(model.relax().value, rel=1e-6)


@pytest.mark.parametrize("formulation", TOUR_FORMULATIONS)
def test_relaxations_of_images_agree(formulation):
    """Moved, or with contours in another order, an instance has the same relaxation; mirrored, one head has."""
    rng = np.random.default_rng(5)
    # Heads with homes: where a closed tour begins depends on the order of contours.
    two = random_instance(rng, 5, layout="uniform", entries=2)
    one = replace(two, heads=(Head("h", two.heads[0].home),))
    shift = np.array([300.0, -70.0, 20.0])
    order = rng.permutation(5)
    value = compact_model(two, Rules(), formulation).relax().value
    for image in (moved(two, np.eye(3), shift), permuted(two, order)):
        assert compact_model(image, Rules(), formulation).relax().value == pytest.approx(value, rel=1e-6)
    alone = [compact_model(each, Rules(), formulation).relax().value for each in (one, mirrored(one))]
    assert alone[0] == pytest.approx(alone[1], rel=1e-6)
