"""Both exact methods agree with brute force under every rule, and their certificates verify."""

from dataclasses import replace

import numpy as np
import pytest
from oracles.brute_force import AllPlans, Best
from oracles.random_instances import LAYOUTS, mirrored, moved, permuted, random_instance

from cutgap.formulations import solve
from cutgap.formulations.certificate import verify
from cutgap.instances import Contour, Instance, Result, Rules, check
from cutgap.instances.formats.json_format import format_instance

HOLES = (0, 1, 2, 3, 3, 4, 4, 5, 5, 6)
GAPS = (None, None, 0.0, 1.0, 40.0, 150.0)
QUARTER = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
ALWAYS = Rules(non_overlap=None, empty_heads=True)


def draw_rules(rng: np.random.Generator, instance: Instance) -> Rules:
    objective = str(rng.choice(["makespan", "travel", "weighted"]))
    v_jump = instance.machine.v_jump
    weight = float(rng.choice([0.0, 0.3, 1.0, 2.5])) * v_jump if objective == "weighted" else 0.0
    gap = GAPS[int(rng.integers(len(GAPS)))]
    limit = [None, None, 0.4, 3.0][int(rng.integers(4))]
    via_points, empty_heads = (bool(each) for each in rng.random(2) < 0.5)
    return Rules(objective, weight, gap, limit, via_points, empty_heads)


def assert_proved(instance: Instance, rules: Rules, best: Best | None, result: Result) -> None:
    """Status, value and bound are right, and the certificate proves the bound to 1e-4 mm or s."""
    assert result.certificate is not None
    verdict = verify(result.certificate, format_instance(instance))
    if best is None:
        assert (result.status, result.plan, result.lower_bound) == ("infeasible", None, None)
        assert verdict.bound is None
        return
    slack = 1e-6 * max(1.0, best.value)
    assert result.status == "optimal"
    assert check(instance, rules, result.plan) == []
    assert result.value == pytest.approx(best.value, abs=slack)
    assert result.lower_bound == pytest.approx(best.value, abs=slack)
    assert verdict.bound is not None
    assert best.value - 1e-4 - slack <= float(verdict.bound) <= best.value * (1 + 1e-12)


def assert_bounded(instance: Instance, rules: Rules, best: Best | None, result: Result) -> None:
    """What is claimed is true and certified, though it may be less than the optimum."""
    assert result.certificate is not None
    verdict = verify(result.certificate, format_instance(instance))
    if best is None:
        assert result.plan is None
        assert result.status in ("infeasible", "unknown")
        return
    assert verdict.bound is not None
    assert float(verdict.bound) <= best.value * (1 + 1e-12)
    if result.plan is not None:
        assert check(instance, rules, result.plan) == []
        assert result.value >= best.value * (1 - 1e-9)


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("layout", LAYOUTS)
def test_free_is_optimal_and_certified(layout, seed):
    rng = np.random.default_rng((11, LAYOUTS.index(layout), seed))
    instance = random_instance(rng, int(rng.choice(HOLES)), layout=layout)
    plans = AllPlans(instance)
    for _ in range(2):
        rules = draw_rules(rng, instance)
        result = solve(instance, rules, method="free", certify=True)
        assert_proved(instance, rules, plans.best(rules), result)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("layout", LAYOUTS)
def test_split_is_optimal_and_certified(layout, seed):
    rng = np.random.default_rng((12, LAYOUTS.index(layout), seed))
    instance = random_instance(rng, int(rng.choice(HOLES)), layout=layout)
    plans = AllPlans(instance)
    for _ in range(2):
        rules = draw_rules(rng, instance)
        # Heads may not overlap, and a weight above v_jump leaves a gap here.
        weight = min(rules.weight, instance.machine.v_jump)
        rules = replace(rules, weight=weight, non_overlap=rules.non_overlap or 0.0)
        free = replace(rules, balance=None)
        assert_proved(instance, free, plans.best(free), solve(instance, free, method="split", certify=True))
        if rules.balance is not None:
            assert_bounded(
                instance, rules, plans.best(rules), solve(instance, rules, method="split", certify=True)
            )


def assert_same(image: Instance, rules: Rules, expected: Result) -> None:
    result = solve(image, rules, method="free")
    assert result.status == expected.status
    assert (result.value is None) == (expected.value is None)
    if expected.value is not None:
        slack = 1e-7 * max(1.0, expected.value)
        assert result.value == pytest.approx(expected.value, abs=slack)
        assert result.lower_bound == pytest.approx(expected.value, abs=slack)


@pytest.mark.parametrize("seed", range(12))
def test_moving_permuting_and_mirroring_change_nothing(seed):
    rng = np.random.default_rng((13, seed))
    instance = random_instance(rng, int(rng.integers(2, 10)))
    rules = replace(draw_rules(rng, instance), balance=None)
    expected = solve(instance, rules, method="free")
    assert_same(permuted(instance, rng.permutation(len(instance.contours))), rules, expected)
    assert_same(moved(instance, np.eye(3), rng.integers(-500, 500, 3)), rules, expected)
    if not rules.via_points:
        assert_same(mirrored(instance), rules, expected)
        anywhere = replace(rules, non_overlap=None)
        assert_same(moved(instance, QUARTER), anywhere, solve(instance, anywhere, method="free"))


@pytest.mark.parametrize("seed", range(10))
def test_a_coincident_hole_without_work_keeps_the_optimum(seed):
    """Empty heads are allowed, as the new hole could be the work of a head that had none."""
    rng = np.random.default_rng((14, seed))
    instance = random_instance(rng, int(rng.integers(1, 8)))
    instance = replace(instance, machine=replace(instance.machine, t_aux=0.0))
    twin = instance.contours[int(rng.integers(len(instance.contours)))]
    more = replace(instance, contours=(*instance.contours, Contour("twin", twin.entry_points, perimeter=0.0)))
    for rules in (ALWAYS, replace(ALWAYS, objective="travel"), replace(ALWAYS, non_overlap=40.0)):
        assert_same(more, rules, solve(instance, rules, method="free"))


@pytest.mark.parametrize("seed", range(10))
def test_removing_a_hole_never_costs(seed):
    rng = np.random.default_rng((15, seed))
    instance = random_instance(rng, int(rng.integers(1, 10)))
    gone = int(rng.integers(len(instance.contours)))
    fewer = replace(instance, contours=instance.contours[:gone] + instance.contours[gone + 1 :])
    for rules in (ALWAYS, replace(ALWAYS, objective="travel"), replace(ALWAYS, non_overlap=0.0)):
        all_holes, less = (solve(each, rules, method="free") for each in (instance, fewer))
        assert less.value <= all_holes.value + 1e-7 * max(1.0, all_holes.value)
