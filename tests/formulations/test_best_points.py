"""Link points of a fixed topology: value and bound meet, any multipliers bound, plans stay allowed."""

import numpy as np
import pytest
from oracles.random_outlines import random_outlines
from scipy.optimize import minimize

from cutgap.formulations import best_link_points, links_model, polish
from cutgap.formulations.links.best_points import edges_of, exact_bound, topology_of
from cutgap.instances import Contour, Head, Instance, Link, Machine, Plan, Rules, Visit, check, evaluate

TRAVEL = Rules("travel", links=True)


def box(name, x, y, places):
    corners = np.array([[x, y], [x + 10, y], [x + 10, y + 10], [x, y + 10]], dtype=float)
    points = np.array([[*place, 0] for place in places], dtype=float)
    return Contour(name, points, 40.0, geometry=corners)


def linked(rng):
    """A random sheet and a plan with links, optimal for its entry points."""
    while True:
        instance = random_outlines(rng, int(rng.integers(2, 5)), entries=3, metric="euclidean")
        rules = Rules(str(rng.choice(["travel", "makespan"])), links=True, pierces=1)
        plan = links_model(instance, rules).solve().plan
        if plan is not None and plan.links:
            return instance, rules, plan


@pytest.mark.parametrize("seed", range(12))
def test_bound_and_value_meet_where_nothing_is_in_the_way(seed):
    instance, rules, plan = linked(np.random.default_rng(seed))
    before = evaluate(instance, plan).objective(rules)
    for found in (best_link_points(instance, rules, plan), polish(instance, rules, plan)):
        assert check(found.instance, rules, found.plan) == []
        assert found.value == evaluate(found.instance, found.plan).objective(rules)
        assert found.lower_bound <= found.value <= before
    topology = topology_of(instance, rules, plan, edges_of(instance, plan))
    found = best_link_points(instance, rules, plan)

    def worth(shares):
        places = topology.points(np.clip(shares, 0, 1))
        apart = places[topology.edges[:, 1]] - places[topology.edges[:, 0]]
        return topology.weights @ np.linalg.norm(apart, axis=1) + float(topology.constant)

    # Another solver, of a smooth kind: never below the bound, and near it from some start.
    rng = np.random.default_rng((1, seed))
    starts = [topology.shares, *rng.random((6, len(topology.shares)))]
    limits = [(0.0, 1.0)] * len(topology.shares)
    others = [minimize(worth, each, method="Powell", bounds=limits).fun for each in starts]
    assert found.lower_bound <= min(others) + 1e-9
    assert found.lower_bound == pytest.approx(min(others), rel=2e-3)
    for spread in (0.01, 1.0, 10.0):
        u = found.multipliers + spread * topology.weights.max() * rng.normal(size=found.multipliers.shape)
        assert float(exact_bound(topology, u) + topology.constant) <= min(others) + 1e-9


def pair_of_boxes(second):
    """Two boxes 4 mm apart; start and link share the lower corner of the first one's facing side."""
    boxes = box("a", 10, 0, [(20, 0)]), box("b", 24, 0, [second])
    return Instance("pair", boxes, (Head("head", np.zeros(3)),), Machine(v_jump=100.0, v_cut=10.0, t_aux=7.0))


def test_two_boxes_face_each_other():
    plan, pair = Plan(((Visit(0, 0),),), (Link(0, 0, 1, 0),)), pair_of_boxes((24, 5))
    found = best_link_points(pair, TRAVEL, plan)
    assert found.value == pytest.approx(2 * 20 + 2 * 4, rel=1e-6)
    assert found.lower_bound == pytest.approx(found.value, rel=1e-7)
    timed = best_link_points(pair, Rules("makespan", links=True), plan)
    assert timed.value == pytest.approx(40 / 100 + (80 + 8) / 10 + 7, rel=1e-6)
    assert timed.lower_bound == pytest.approx(timed.value, rel=1e-7)


def test_ends_of_blocked_links_stay():
    """On the lower edge of the one and the upper edge of the other, a shorter link leads through the first."""
    plan, pair = Plan(((Visit(0, 0),),), (Link(0, 0, 1, 0),)), pair_of_boxes((24, 10))
    found = best_link_points(pair, TRAVEL, plan)
    assert found.value == evaluate(pair, plan).total_travel_mm
    assert found.lower_bound == pytest.approx(20 + 2 * np.hypot(14, 10), rel=1e-6)


def test_points_go_around_a_corner():
    """A point on a lower edge may only come to the corner; then it turns onto the side that faces the other."""
    pair = Instance(
        "pair",
        (box("a", 0, 0, [(10, 0), (0, 0)]), box("b", 24, 4, [(24, 9)])),
        (Head("head", np.zeros(3)),),
    )
    plan = Plan(((Visit(0, 1),),), (Link(0, 0, 1, 0),))
    found, polished = (each(pair, TRAVEL, plan) for each in (best_link_points, polish))
    assert found.value == pytest.approx(2 * np.hypot(14, 4), rel=1e-6)
    assert polished.value == pytest.approx(2 * 14, rel=1e-6)
    assert polished.lower_bound == pytest.approx(2 * 14, rel=1e-6)


def test_what_does_not_suit_is_refused():
    rng = np.random.default_rng(0)
    instance, rules, plan = linked(rng)
    with pytest.raises(ValueError, match="needs rules with links"):
        best_link_points(instance, Rules("travel"), plan)
    with pytest.raises(ValueError, match="breaks each contour once"):
        polish(instance, rules, Plan(plan.tours))
    other = random_outlines(rng, 2, metric="chebyshev")
    with pytest.raises(ValueError, match="Euclidean"):
        best_link_points(other, rules, plan)
