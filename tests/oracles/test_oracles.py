"""The oracles agree with each other, and with the plainest possible enumeration."""

from itertools import permutations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cutgap.instances import Contour, Head, Instance, Machine, Rules
from oracles.brute_force import AllPlans, brute_force
from oracles.held_karp import shortest_tour
from oracles.problem import figures, plain_problem
from oracles.random_instances import random_instance

SEEDS = st.integers(0, 2**32 - 1)


def every_plan(instance: Instance):
    """All assignments, then all orders, then all entry points."""
    sizes = [len(contour.entry_points) for contour in instance.contours]
    for heads in product(range(len(instance.heads)), repeat=len(sizes)):
        shares = [[c for c, h in enumerate(heads) if h == head] for head in range(len(instance.heads))]
        for orders in product(*(permutations(share) for share in shares)):
            for entries in product(*(range(size) for size in sizes)):
                yield tuple(tuple((c, entries[c]) for c in order) for order in orders)


def allowed(instance: Instance, rules: Rules, tours) -> bool:
    problem = plain_problem(instance)
    measured = figures(problem, tours)
    enough = len(instance.contours) >= len(instance.heads)
    if enough and not rules.empty_heads and not all(tours):
        return False
    if rules.balance is not None and measured.imbalance > rules.balance * (1 + 1e-12) + 1e-9:
        return False
    gap = measured.partition_gap
    if rules.non_overlap is not None and gap is not None and gap < rules.non_overlap:
        return False
    for tour in tours:
        xs = [problem.entries[c][e][0] for c, e, *_ in tour]
        if rules.via_points and tour and xs[0] != min(xs):
            return False
        order = [c for c, *_ in tour]
        if any(order.index(a) > order.index(b) for a, b in instance.precedence):
            return False
    return True


def enumerated_best(instance: Instance, rules: Rules) -> float | None:
    problem = plain_problem(instance)
    values = [
        figures(problem, tours).objective(rules)
        for tours in every_plan(instance)
        if allowed(instance, rules, tours)
    ]
    return min(values, default=None)


def random_rules(rng: np.random.Generator) -> Rules:
    objective = str(rng.choice(["makespan", "travel", "weighted"]))
    return Rules(
        objective=objective,
        weight=float(rng.choice([0, 30, 150, 400])) if objective == "weighted" else 0.0,
        non_overlap=[None, 0.0, 20.0, 50.0][int(rng.integers(4))],
        balance=[None, None, 0.5, 2.0][int(rng.integers(4))],
        via_points=bool(rng.random() < 0.5),
        empty_heads=bool(rng.random() < 0.7),
    )


@settings(max_examples=60, deadline=None)
@given(SEEDS, st.integers(0, 4), st.integers(1, 2), st.sampled_from(["euclidean", "chebyshev", "matrix"]))
def test_brute_force_agrees_with_plain_enumeration(seed, holes, heads, metric):
    rng = np.random.default_rng(seed)
    instance = random_instance(
        rng,
        holes,
        heads=heads,
        homes=None,
        metric=metric,
        entries=1 if holes > 3 else 2,
        precedence=0.3 if heads == 1 else 0.0,
    )
    plans = AllPlans(instance)
    for _ in range(3):
        rules = random_rules(rng)
        best, expected = plans.best(rules), enumerated_best(instance, rules)
        assert (best is None) == (expected is None)
        if best is not None:
            assert best.value == pytest.approx(expected, rel=1e-12, abs=1e-9)
            assert allowed(instance, rules, best.tours)


@settings(max_examples=25, deadline=None)
@given(SEEDS, st.integers(1, 6), st.sampled_from(["euclidean", "matrix"]), st.booleans())
def test_held_karp_agrees_with_brute_force(seed, holes, metric, via_points):
    rng = np.random.default_rng(seed)
    instance = random_instance(rng, holes, heads=1, metric=metric)
    problem = plain_problem(instance)
    home = problem.home_node(0)
    nodes = [home, *range(holes)]
    lengths = [[problem.lengths[a][b] for b in nodes] for a in nodes]
    xs = [points[0][0] for points in problem.entries]
    firsts = [c + 1 for c in range(holes) if xs[c] == min(xs)] if via_points else [None]
    tours = [shortest_tour(lengths, first) for first in firsts]
    for length, order in tours:
        assert sorted(order) == list(range(holes + 1))
        walked = sum(lengths[a][b] for a, b in zip(order, order[1:] + order[:1], strict=True))
        assert walked == pytest.approx(length, abs=1e-9)
    best = brute_force(instance, Rules("travel", via_points=via_points))
    assert min(length for length, _ in tours) == pytest.approx(best.value, abs=1e-9)


def test_held_karp_finds_the_hull_of_a_circle():
    angles = np.random.default_rng(5).permutation(12) * np.pi / 6
    points = np.column_stack((np.cos(angles), np.sin(angles)))
    lengths = np.linalg.norm(points[:, None] - points[None], axis=2)
    length, _ = shortest_tour(lengths.tolist())
    assert length == pytest.approx(12 * 2 * np.sin(np.pi / 12))


def test_a_longer_tour_can_keep_the_balance():
    """Left 100 mm. Right 80 mm there and back, but 100 mm in the order 40, 20, 30."""
    contours = [Contour(str(x), [[x, 0, 0]], 0.0) for x in (-50, 1030, 1040, 1020)]
    heads = (Head("left", [0, 0, 0]), Head("right", [1000, 0, 0]))
    instance = Instance("longer", tuple(contours), heads, Machine(v_jump=100, t_aux=0))
    shortest = brute_force(instance, Rules("travel"))
    balanced = brute_force(instance, Rules("travel", balance=0.1))
    assert shortest.value == pytest.approx(100 + 80)
    assert balanced.value == pytest.approx(100 + 100)
    assert balanced.figures.imbalance == pytest.approx(0.0, abs=1e-9)


def test_two_heads_cannot_share_a_point_under_a_positive_gap():
    contours = tuple(Contour(name, [[10, 0, 0]], 1.0) for name in "ab")
    instance = Instance("same", contours, (Head("left"), Head("right")))
    assert brute_force(instance, Rules(non_overlap=0.0)) is not None
    assert brute_force(instance, Rules(non_overlap=1.0)) is None
    assert brute_force(instance, Rules(non_overlap=1.0, empty_heads=True)) is not None
