"""Cuts of tours through one node of each contour: no tour breaks one, and violated ones are found."""

from dataclasses import replace
from itertools import permutations, product

import numpy as np
import pytest
from scipy.optimize import linprog

from cutgap.formulations.branch_and_cut.generalized_cuts import (
    GeneralizedCut,
    Point,
    combs,
    minimum_cuts,
    quick_cuts,
)

SIZES = (2, 1, 3, 2)
CONTOUR_OF = np.repeat(np.arange(len(SIZES)), SIZES)


def point_of(contour_of, edges):
    """The point with these edges and weights; y by the degree equations."""
    tails, heads = (np.array([edge[side] for edge in edges]) for side in (0, 1))
    x = np.array(list(edges.values()), dtype=float)
    count = len(contour_of)
    y = (np.bincount(tails, weights=x, minlength=count) + np.bincount(heads, weights=x, minlength=count)) / 2
    return Point(contour_of, y, tails, heads, x)


def tours(contour_of):
    """Every tour as a point."""
    members = [np.flatnonzero(contour_of == h) for h in range(contour_of[-1] + 1)]
    for order in permutations(range(1, len(members))):
        for nodes in product(*(members[h] for h in (0, *order))):
            pairs = zip(nodes, (*nodes[1:], nodes[0]), strict=True)
            yield point_of(contour_of, {(min(pair), max(pair)): 1.0 for pair in pairs})


def random_point(rng, contour_of):
    """A vertex of the degree and contour equations alone: often several small cycles, often half a node."""
    count = len(contour_of)
    tails, heads = np.nonzero(np.triu(contour_of[:, None] != contour_of))
    degree = np.zeros((count, count + len(tails)))
    degree[np.arange(count), np.arange(count)] = -2.0
    degree[tails, count + np.arange(len(tails))] += 1.0
    degree[heads, count + np.arange(len(tails))] += 1.0
    once = np.zeros((contour_of[-1] + 1, count + len(tails)))
    once[contour_of, np.arange(count)] = 1.0
    costs = np.concatenate([np.zeros(count), rng.uniform(0, 1, len(tails))])
    right = np.concatenate([np.zeros(count), np.ones(len(once))])
    solved = linprog(costs, A_eq=np.concatenate([degree, once]), b_eq=right, bounds=(0, 1), method="highs")
    x = solved.x[count:]
    used = x > 1e-9
    return Point(contour_of, solved.x[:count], tails[used], heads[used], x[used])


def all_borders(contour_of):
    """(G) for every set and every two contours."""
    count, contours = len(contour_of), range(contour_of[-1] + 1)
    for chosen in product((False, True), repeat=count):
        mask = np.array(chosen)
        if mask.any() and not mask.all():
            for pair in product(contours, repeat=2):
                yield GeneralizedCut((frozenset(np.flatnonzero(mask).tolist()),), (pair,))


def test_no_tour_breaks_a_border():
    cuts = list(all_borders(CONTOUR_OF))[::3]
    for point in list(tours(CONTOUR_OF))[::5]:
        assert max(point.violation(cut) for cut in cuts) <= 1e-9


def test_whole_contours_ask_as_much_as_their_names():
    """``None`` and a contour within the set are the same, at any point."""
    rng = np.random.default_rng(1)
    inside = frozenset([0, 1, 3])
    for _ in range(5):
        point = random_point(rng, CONTOUR_OF)
        named = [GeneralizedCut((inside,), ((h, k),)) for h, k in ((0, 3), (None, 3), (0, None), (None, None))]
        assert np.ptp([point.violation(cut) for cut in named]) < 1e-9


@pytest.mark.parametrize("seed", range(12))
def test_minimum_cuts_are_exact(seed):
    """They find something whenever some border is violated, and the worst border of each pair."""
    point = random_point(np.random.default_rng(seed), CONTOUR_OF)
    worst = max(point.violation(cut) for cut in all_borders(CONTOUR_OF))
    pairs = np.column_stack(np.triu_indices(len(SIZES), 1))
    found = minimum_cuts(point, pairs)
    assert bool(found) == (worst > 1e-4)
    if found:
        assert point.violation(found[0]) == pytest.approx(worst, abs=1e-9)
        assert all(point.violation(cut) > 1e-4 for cut in found)


def test_edges_within_rounding_find_their_ends():
    """Nodes 0 and 6 carry an edge so weak that their y counts as none."""
    edges = {(1, 2): 1.0, (2, 5): 1.0, (5, 7): 1.0, (1, 7): 1.0, (0, 6): 2e-6}
    point = point_of(CONTOUR_OF, edges)
    weak = replace(point, y=np.where(point.y > 1e-5, point.y, 0.0))
    pairs = np.column_stack(np.triu_indices(len(SIZES), 1))
    assert not minimum_cuts(weak, np.tile(pairs, (50, 1)))


def test_tours_need_no_cuts():
    pairs = np.column_stack(np.triu_indices(len(SIZES), 1))
    for point in list(tours(CONTOUR_OF))[::7]:
        assert not quick_cuts(point)
        assert not minimum_cuts(point, pairs)
        assert not combs(point, [], [], np.random.default_rng(0))


def test_components_are_cut_off():
    """Two triangles."""
    triangles = {(0, 1): 1, (1, 2): 1, (0, 2): 1, (3, 4): 1, (4, 5): 1, (3, 5): 1}
    point = point_of(np.arange(6), triangles)
    found = quick_cuts(point)
    assert {cut.sets[0] for cut in found} <= {frozenset([0, 1, 2]), frozenset([3, 4, 5])}
    assert point.violation(found[0]) == pytest.approx(1.0)


def test_fans_are_cut_off():
    """Node 0 has y = 1/2, yet weight 1 to the two nodes of contour 1; no set of whole contours sees that."""
    contour_of = np.array([0, 0, 1, 1, 2, 3, 4])
    edges = {(0, 2): 0.5, (0, 3): 0.5, (1, 4): 0.5, (1, 6): 0.5, (2, 4): 0.5, (3, 6): 0.5, (4, 5): 1, (5, 6): 1}
    point = point_of(contour_of, edges)
    assert point.y.tolist() == [0.5, 0.5, 0.5, 0.5, 1, 1, 1]
    cut = next(cut for cut in quick_cuts(point) if cut.sets[0] == frozenset([0, 2, 3]))
    assert cut.pairs == ((None, None),)
    assert point.violation(cut) == pytest.approx(0.5)


def test_combs_of_contours_are_cut_off():
    """Two triangles of halves joined by three edges, each contour a node twice over."""
    contour_of = np.repeat(np.arange(6), 2)
    halves = [(0, 1), (1, 2), (0, 2), (3, 4), (4, 5), (3, 5)]
    edges = {(2 * u + copy, 2 * v + copy): 0.25 for u, v in halves for copy in (0, 1)}
    edges |= {(2 * u + copy, 2 * u + 6 + copy): 0.5 for u in range(3) for copy in (0, 1)}
    point = point_of(contour_of, edges)
    assert np.allclose(point.y, 0.5)
    found = combs(point, [], [], np.random.default_rng(0))
    assert found
    assert any(set(cut.pairs) == {(None, None)} for cut in found)
    assert point.violation(found[0]) == pytest.approx(0.5)
    assert max(tour.violation(cut) for tour in list(tours(contour_of))[::97] for cut in found) <= 1e-9


def test_combs_of_nodes_are_cut_off():
    """Two triangles of halves joined by three edges of weight 1, but for one contour with an idle node."""
    contour_of = np.array([0, 0, 1, 2, 3, 4, 5])
    halves = [(0, 2), (2, 3), (0, 3), (4, 5), (5, 6), (4, 6)]
    point = point_of(contour_of, {edge: 0.5 for edge in halves} | {(0, 4): 1.0, (2, 5): 1.0, (3, 6): 1.0})
    assert point.y.tolist() == [1, 0, 1, 1, 1, 1, 1]
    found = combs(point, [], [], np.random.default_rng(0))
    split = [cut for cut in found if all(1 not in members for members in cut.sets)]
    assert split
    assert any(0 in pair for cut in split for pair in cut.pairs)
    assert max(tour.violation(cut) for tour in tours(contour_of) for cut in split) <= 1e-9


def test_combs_with_split_contours_keep_all_tours():
    """Teeth whose parts hold no whole contour: the terms are y alone, and some tour is met."""
    contour_of = np.array([0, 0, 1, 1, 2, 3, 4])
    sets = (frozenset([0, 2, 4]), frozenset([0, 1]), frozenset([2, 5]), frozenset([4, 6]))
    comb = GeneralizedCut(sets, ((0, 0), (1, None), (None, None)))
    assert max(point.violation(comb) for point in tours(contour_of)) == pytest.approx(0.0)
