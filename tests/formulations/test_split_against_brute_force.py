"""The threshold search agrees with brute force over all plans, on every kind of tie, and under symmetries."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from oracles.brute_force import AllPlans
from oracles.held_karp import shortest_tour
from oracles.problem import Figures, plain_problem
from oracles.random_instances import LAYOUTS, mirrored, moved, permuted, random_instance, scaled

from cutgap.formulations import solve
from cutgap.instances import Contour, Head, Instance, Machine, Plan, Result, Rules, check, evaluate

HOLES = (0, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 7)
GAPS = (0.0, 0.0, 1.0, 40.0, 50.0, 150.0)
ALWAYS = Rules(empty_heads=True)
"""Without a constraint that could make a plan infeasible."""


def split(instance: Instance, rules: Rules, **options) -> Result:
    return solve(instance, rules, method="split", **options)


def objectives(instance: Instance) -> tuple[tuple[str, float], ...]:
    """Names and weights; up to v_jump the method proves optimality."""
    v_jump = instance.machine.v_jump
    return ("makespan", 0.0), ("travel", 0.0), ("weighted", 0.0), ("weighted", 30.0), ("weighted", v_jump)


def draw_rules(rng: np.random.Generator, instance: Instance) -> Rules:
    objective, weight = objectives(instance)[int(rng.integers(5))]
    gap, (via_points, empty_heads) = GAPS[int(rng.integers(len(GAPS)))], rng.random(2) < 0.5
    return Rules(objective, weight, gap, via_points=bool(via_points), empty_heads=bool(empty_heads))


def assert_optimal(instance: Instance, rules: Rules, result: Result, optimum: float | None) -> None:
    if optimum is None:
        assert (result.status, result.plan, result.lower_bound) == ("infeasible", None, None)
        assert result.reason
        return
    slack = 1e-6 * max(1.0, optimum)
    assert result.status == "optimal"
    assert result.plan is not None
    assert check(instance, rules, result.plan) == []
    assert result.value == pytest.approx(optimum, abs=slack)
    assert optimum - slack <= result.lower_bound <= optimum + slack


def assert_agrees(instance: Instance, draws: list[Rules]) -> None:
    plans = AllPlans(instance)
    for rules in draws:
        best = plans.best(rules)
        assert_optimal(instance, rules, split(instance, rules), None if best is None else best.value)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("layout", LAYOUTS)
def test_agrees_on_random_instances(layout, seed):
    rng = np.random.default_rng((LAYOUTS.index(layout), seed))
    for _ in range(2):
        instance = random_instance(rng, int(rng.choice(HOLES)), layout=layout)
        assert_agrees(instance, [draw_rules(rng, instance) for _ in range(3)])


@pytest.mark.parametrize("layout", LAYOUTS)
def test_agrees_under_all_rules(layout):
    instance = random_instance(np.random.default_rng(LAYOUTS.index(layout)), 5, layout=layout)
    choices = product(objectives(instance), (0.0, 40.0), (False, True), (False, True))
    assert_agrees(
        instance,
        [
            Rules(objective, weight, gap, via_points=via_points, empty_heads=empty_heads)
            for (objective, weight), gap, via_points, empty_heads in choices
        ],
    )


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("metric", ["chebyshev", "matrix"])
def test_agrees_with_other_metrics_and_without_homes(metric, seed):
    """The matrix is symmetric but no metric: a larger set may have the shorter tour."""
    rng = np.random.default_rng(seed)
    instance = random_instance(rng, int(rng.integers(0, 7)), metric=metric, homes=None)
    if instance.matrix is not None:
        instance = replace(instance, matrix=instance.matrix + instance.matrix.T)
    assert_agrees(instance, [draw_rules(rng, instance) for _ in range(4)])


@pytest.mark.parametrize("xs", [(0, 1, 2, 3), (0, 0, 0, 0), (0, 1, 2, 2)])
def test_without_a_metric_more_holes_may_be_nearer(xs):
    """Left: a to b is 100 mm, but 2 mm by way of the hub. Right: 20 mm to these three, 1 mm to the fourth."""
    a, b, hub, fourth, left, right = range(6)
    rapids = np.full((6, 6), 100.0)
    near = {1.0: [(a, hub), (hub, b), (left, a), (left, b), (right, fourth)]}
    near[20.0] = [(hole, other) for hole in (a, b, hub) for other in (right, fourth)]
    for length, pairs in near.items():
        for one, other in pairs:
            rapids[one, other] = rapids[other, one] = length
    contours = tuple(Contour(f"c{i}", [[x, 0, 0]], 0.0) for i, x in enumerate(xs))
    heads = (Head("left", [0, 0, 0]), Head("right", [0, 0, 0]))
    instance = Instance("hub", contours, heads, Machine(metric="matrix"), matrix=rapids)
    assert split(instance, replace(ALWAYS, objective="travel")).value == pytest.approx(4.0 + 2.0)
    assert_agrees(instance, [ALWAYS, replace(ALWAYS, objective="travel")])


def test_with_via_points_more_holes_may_be_nearer():
    """Without p the right head must start in the middle of its tour; p lets it start at an end."""
    points = {"p": (1, 0), "middle": (100, 0), "up": (101, 200), "down": (101, -200)}
    contours = tuple(Contour(name, [[x, y, 0]], 0.0) for name, (x, y) in points.items())
    heads = (Head("left", [-400, 0, 0]), Head("right", [0, 0, 0]))
    instance = Instance("via", contours, heads, Machine(v_jump=100.0, t_aux=0.1))
    rules = replace(ALWAYS, via_points=True)
    all_right, three_right = (
        evaluate(instance, Plan.of_contours(orders)).travel_mm[1]
        for orders in ([[], [0, 2, 1, 3]], [[0], [1, 2, 3]])
    )
    assert all_right < three_right
    assert_agrees(instance, [rules, replace(rules, objective="travel")])


@pytest.mark.parametrize("seed", range(20))
def test_bounds_hold_for_weights_above_the_jump_speed(seed):
    """A longer tour may then be better: the bound stays below the optimum, the value above."""
    rng = np.random.default_rng(seed)
    instance = random_instance(rng, int(rng.integers(1, 7)))
    plans = AllPlans(instance)
    for via_points in (False, True):
        weight = instance.machine.v_jump * float(rng.choice([1.5, 4.0]))
        rules = Rules("weighted", weight, via_points=via_points)
        best, result = plans.best(rules), split(instance, rules)
        assert best is not None
        assert result.value is not None
        assert result.lower_bound is not None
        assert check(instance, rules, result.plan) == []
        slack = 1e-6 * max(1.0, best.value)
        assert result.lower_bound - slack <= best.value <= result.value + slack


@pytest.mark.parametrize("seed", range(10))
def test_start_changes_nothing_but_the_way(seed):
    rng = np.random.default_rng(seed)
    instance = random_instance(rng, 5)
    rules = replace(draw_rules(rng, instance), non_overlap=0.0, via_points=False)
    expected = split(instance, rules).value
    optimal = AllPlans(instance).best(rules)
    backwards = Plan.of_contours([[4, 3, 2, 1], [0]])  # not always allowed
    for start in (optimal.plan, backwards):
        result = split(instance, rules, start=start)
        assert result.status == "optimal"
        assert result.value == pytest.approx(expected, rel=1e-6)


def test_stopped_run_keeps_a_valid_bound():
    rng = np.random.default_rng(3)
    instance = random_instance(rng, 7, layout="uniform")
    for rules in (Rules(), Rules("travel", via_points=True)):
        optimum = AllPlans(instance).best(rules).value
        result = split(instance, rules, time_limit=0.0)
        assert result.status in ("feasible", "optimal", "unknown")
        if result.lower_bound is not None:
            assert result.lower_bound <= optimum * (1 + 1e-9)
        if result.plan is not None:
            assert check(instance, rules, result.plan) == []
            assert result.value >= optimum * (1 - 1e-9)


def test_all_x_equal_with_a_positive_gap_is_infeasible():
    instance = random_instance(np.random.default_rng(0), 4, layout="column")
    assert_optimal(instance, Rules(non_overlap=1.0), split(instance, Rules(non_overlap=1.0)), None)


@pytest.mark.parametrize("holes", [0, 1])
def test_nothing_and_one_hole_need_no_second_head(holes):
    instance = random_instance(np.random.default_rng(1), holes, layout="uniform")
    rules = Rules(non_overlap=1e4, empty_heads=False)
    assert_agrees(instance, [rules])
    assert split(instance, rules).status == "optimal"


def thresholds(instance: Instance, via_points: bool) -> list[Figures]:
    """Figures of every threshold between distinct x, with both tours by dynamic programming."""
    problem = plain_problem(instance)
    order = sorted(range(len(problem.entries)), key=lambda hole: problem.entries[hole][0][0])
    found = []
    for count in range(len(order) + 1):
        lengths, times = [], []
        for head, share in enumerate((order[:count], order[count:])):
            nodes = [problem.home_node(head), *share]
            table = [[problem.lengths[a][b] for b in nodes] for a in nodes]
            lengths.append(shortest_tour(table, 1 if via_points and share else None)[0])
            times.append(lengths[-1] / problem.v_jump + problem.work(share))
        found.append(Figures(tuple(lengths), tuple(times), None))
    return found


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("via_points", [False, True])
def test_agrees_with_dynamic_programming_on_larger_instances(seed, via_points):
    instance = random_instance(np.random.default_rng(seed), 11, layout="uniform")
    plans = thresholds(instance, via_points)
    for objective, weight in objectives(instance):
        rules = replace(ALWAYS, objective=objective, weight=weight, via_points=via_points)
        optimum = min(plan.objective(rules) for plan in plans)
        assert_optimal(instance, rules, split(instance, rules), optimum)


@pytest.mark.parametrize("seed", range(12))
def test_symmetries(seed):
    rng = np.random.default_rng(seed)
    instance = random_instance(rng, int(rng.integers(2, 9)))
    rules = draw_rules(rng, instance)
    expected = split(instance, rules)
    order = rng.permutation(len(instance.contours))
    images = [moved(instance, np.eye(3), rng.integers(-500, 500, 3)), permuted(instance, order)]
    images.append(moved(instance, np.diag([1.0, -1.0, -1.0])))
    if not rules.via_points:
        images.append(mirrored(instance))
    for image in images:
        assert_same(split(image, rules), expected)
    factor = 4.0
    enlarged = replace(rules, non_overlap=rules.non_overlap * factor, weight=rules.weight * factor)
    assert_same(split(scaled(instance, factor), enlarged), expected, 1.0 if rules.unit == "s" else factor)


def assert_same(result: Result, expected: Result, factor: float = 1.0) -> None:
    assert result.status == expected.status
    for name in ("value", "lower_bound"):
        before, after = getattr(expected, name), getattr(result, name)
        assert (before is None) == (after is None)
        assert before is None or after == pytest.approx(factor * before, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("seed", range(10))
def test_a_coincident_hole_without_work_keeps_the_travel(seed):
    rng = np.random.default_rng(seed)
    instance = random_instance(rng, int(rng.integers(1, 8)))
    instance = replace(instance, machine=replace(instance.machine, t_aux=0.0))
    twin = instance.contours[int(rng.integers(len(instance.contours)))]
    more = replace(instance, contours=(*instance.contours, Contour("twin", twin.entry_points, perimeter=0.0)))
    for rules in (
        replace(ALWAYS, objective="travel"),
        replace(ALWAYS, objective="travel", via_points=True),
        replace(ALWAYS, objective="travel", non_overlap=40.0),
    ):
        assert_same(split(more, rules), split(instance, rules))


@pytest.mark.parametrize("seed", range(10))
def test_removing_a_hole_never_costs(seed):
    rng = np.random.default_rng(seed)
    instance = random_instance(rng, int(rng.integers(1, 8)))
    gone = int(rng.integers(len(instance.contours)))
    fewer = replace(instance, contours=instance.contours[:gone] + instance.contours[gone + 1 :])
    for objective in ("makespan", "travel"):
        rules = replace(ALWAYS, objective=objective, non_overlap=float(rng.choice(GAPS)))
        assert split(fewer, rules).value <= split(instance, rules).value + 1e-6
