"""The spanning-tree bound: below every optimum, met where theory says so, and half of what doubling gives."""

from dataclasses import replace
from fractions import Fraction
from itertools import combinations

import numpy as np
import pytest
import shapely
from oracles.linked_strokes import least_value
from oracles.random_outlines import random_outlines

from cutgap.formulations import spanning_tree
from cutgap.formulations.relaxations.spanning_tree import curve_distances
from cutgap.instances import Contour, Head, Instance, Machine, Rules


def box(name, x, y, side=10.0, entries=slice(None)):
    corners = np.array([[x, y], [x + side, y], [x + side, y + side], [x, y + side]], dtype=float)
    return Contour(name, np.column_stack((corners, np.zeros(4)))[entries], 4 * side, geometry=corners)


def random_rules(rng):
    objective = str(rng.choice(["travel", "makespan"]))
    return Rules(objective, links=True, pierces=[None, 1, 2][int(rng.integers(3))])


@pytest.mark.parametrize("seed", range(30))
def test_bound_is_below_the_optimum(seed):
    rng = np.random.default_rng(seed)
    instance = random_outlines(rng, int(rng.integers(1, 5)), entries=3, metric="euclidean")
    rules = random_rules(rng)
    least = least_value(instance, rules)
    assert least is None or spanning_tree(instance, rules).bound <= least


@pytest.mark.parametrize("seed", range(12))
def test_with_the_nearest_points_the_optimum_is_between_bound_and_doubled_tree(seed):
    rng = np.random.default_rng((1, seed))
    plane = random_outlines(rng, int(rng.integers(2, 5)), entries=1, nested=0.0, metric="euclidean")
    home = np.append(rng.integers(-10, 30, 2), 0.0)
    instance = replace(plane, heads=(Head("head", home),))
    rules = Rules("travel", links=True, pierces=[None, 1, 2][int(rng.integers(3))])
    tree = spanning_tree(instance, rules)
    rings = [*(shapely.LinearRing(c.geometry) for c in instance.contours), shapely.Point(home[:2])]
    points = [[] for _ in rings]
    for i, j in tree.tree:
        ends = shapely.get_coordinates(shapely.shortest_line(rings[i], rings[j]))
        points[i].append(ends[0])
        points[j].append(ends[1])
    places = [np.unique(np.array(each), axis=0) for each in points]
    contours = [
        replace(contour, entry_points=np.column_stack((each, np.zeros(len(each)))))
        for contour, each in zip(instance.contours, places, strict=False)
    ]
    rich = replace(instance, contours=tuple(contours))
    least = least_value(rich, rules)
    assert spanning_tree(rich, rules).bound <= least <= tree.doubled * (1 + 1e-9)
    assert spanning_tree(rich, rules).bound == pytest.approx(tree.bound, rel=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_distances_are_never_too_long(seed):
    """In fractions, point by edge; and no shorter than by what coordinates of this size are rounded."""
    instance = random_outlines(np.random.default_rng((2, seed)), 3, metric="euclidean")
    found = curve_distances(instance)
    for i, j in combinations(range(len(instance.contours)), 2):
        exact = exact_distance_squared(instance.contours[i].geometry, instance.contours[j].geometry)
        assert Fraction(found[i, j]) ** 2 <= exact
        assert found[i, j] == pytest.approx(float(exact) ** 0.5, abs=1e-9)


def exact_distance_squared(one, other):
    """Of curves that do not meet: the least over corners of either and edges of the other."""
    sides = [[tuple(map(Fraction, point)) for point in curve.tolist()] for curve in (one, other)]
    found = []
    for corners, curve in (sides, sides[::-1]):
        for x, y in corners:
            for (ax, ay), (bx, by) in zip(curve, curve[1:] + curve[:1], strict=True):
                dx, dy = bx - ax, by - ay
                t = min(max(((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy), Fraction(0)), Fraction(1))
                found.append((x - ax - t * dx) ** 2 + (y - ay - t * dy) ** 2)
    return min(found)


def row(*contours, t_aux=7.0):
    return Instance(
        "row", contours, (Head("head", np.zeros(3)),), Machine(v_jump=100.0, v_cut=10.0, t_aux=t_aux)
    )


def test_bound_is_met():
    one = row(box("a", 10, 0))
    assert spanning_tree(one, Rules("travel", links=True)).bound == pytest.approx(2 * 10)
    assert spanning_tree(one, Rules(links=True)).bound == pytest.approx(20 / 100 + 4 + 7)
    # Flames: a link of 1 s; the home 10 mm off, half a pierce at either end.
    pair = row(box("a", 10, 0), box("b", 30, 0), t_aux=80.0)
    single = Rules(links=True, pierces=1)
    assert spanning_tree(pair, single).bound == pytest.approx(20 / 100 + 80 + 8 + 1)
    assert least_value(pair, single) == pytest.approx((20 + 30) / 100 + 80 + 8 + 1)


def test_the_tree_and_its_dearest_edge_are_met():
    """Two tips and the home are the corners of a triangle of equal sides, which the head goes around."""
    tips = [(10.0, 0.0), (5.0, 75**0.5)]
    spikes = [
        Contour(
            f"spike {x}",
            np.array([[x, y, 0.0]]),
            20.0,
            geometry=np.array([(x, y), (1.9 * x, 1.9 * y - 1), (1.9 * x, 1.9 * y + 1)]),
        )
        for x, y in tips
    ]
    triangle = row(*spikes)
    for pierces in (None, 1):
        rules = Rules("travel", links=True, pierces=pierces)
        assert spanning_tree(triangle, rules).bound == pytest.approx(30.0)
        assert least_value(triangle, rules) == pytest.approx(30.0)


def test_what_does_not_suit_is_refused():
    pair = row(box("a", 10, 0), box("b", 30, 0))
    assert spanning_tree(replace(pair, contours=()), Rules(links=True)).bound == 0.0
    with pytest.raises(ValueError, match="needs rules with links"):
        spanning_tree(pair, Rules("travel"))
    with pytest.raises(ValueError, match="Euclidean"):
        spanning_tree(replace(pair, machine=Machine(metric="chebyshev")), Rules(links=True))


def test_nested_contours_have_no_upper_bound():
    nested = row(box("plate", 10, 0, side=30.0), box("hole", 20, 10))
    assert spanning_tree(nested, Rules("travel", links=True)).doubled is None
    assert spanning_tree(nested, Rules(links=True)).doubled is None
