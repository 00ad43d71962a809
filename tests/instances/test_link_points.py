"""Link points: few, on their curves, enough for a shortest tree; clear and blocked links by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import nearest

from cutgap.instances import Contour, Head, Instance, Link, Plan, Rules, Visit, check
from cutgap.instances.arrays import Floats, closed_length
from cutgap.instances.links.clearance import blocked, blocked_segments, require_shapes
from cutgap.instances.links.near import CORNERS, link_regions, near_pairs, thinned, unreachable
from cutgap.instances.links.points import MOST, with_link_points
from cutgap.instances.links.sharing import between, chains, triangle_points

HOME = (Head("head", np.zeros(3)),)
SEEDS = st.integers(0, 2**32 - 1)


def contour(name: str, curve: object) -> Contour:
    points = np.array(curve, dtype=float)
    return Contour(name, np.append(points[0], 0.0)[None], closed_length(points), geometry=points)


def box(name: str, x: float, y: float, width: float = 10.0, height: float | None = None) -> Contour:
    height = width if height is None else height
    return contour(name, [(x, y), (x + width, y), (x + width, y + height), (x, y + height)])


def sheet(*contours: Contour) -> Instance:
    return Instance("sheet", contours, HOME)


def disc(name: str, x: float, y: float, radius: float, corners: int, turn: float = 0.0) -> Contour:
    angles = turn + math.tau * np.arange(corners) / corners
    return contour(name, np.array([x, y]) + radius * np.column_stack((np.cos(angles), np.sin(angles))))


def random_sheet(seed: int, count: int) -> Instance:
    """Polygons of 3 to 40 corners, of which some are stars, in cells of 20 mm."""
    rng = np.random.default_rng(seed)
    made = []
    for number, cell in enumerate(rng.permutation(9)[:count].tolist()):
        corners = int(rng.integers(3, 41))
        shares = np.arange(corners) + rng.uniform(0.0, 0.6, corners)
        angles = rng.uniform(0.0, math.tau) + math.tau * shares / corners
        reach = rng.uniform(4.0, 9.9, (corners if rng.random() < 0.5 else 1, 1))
        middle = 20.0 * np.array([cell % 3, cell // 3])
        points = reach * np.column_stack((np.cos(angles), np.sin(angles)))
        made.append(contour(str(number), middle + points))
    return sheet(*made)


def curves_of(instance: Instance) -> list[list[nearest.Place]]:
    curves = [each.geometry for each in instance.contours if each.geometry is not None]
    return [[(x, y) for x, y in curve.tolist()] for curve in curves]


def entries(instance: Instance) -> list[Floats]:
    return [each.entry_points[:, :2] for each in instance.contours]


def node_distance(instance: Instance, a: int, b: int) -> float:
    """Length of the shortest clear link between the entry points of two contours."""
    one, other = (instance.first_node[c] + np.arange(len(instance.contours[c].entry_points)) for c in (a, b))
    starts, ends = np.repeat(one, len(other)), np.tile(other, len(one))
    lengths = np.linalg.norm(instance.points[starts] - instance.points[ends], axis=1)
    return float(np.where(blocked(instance, starts, ends), np.inf, lengths).min())


@settings(max_examples=8, deadline=None)
@given(seed=SEEDS, count=st.integers(2, 9))
def test_link_points_hold_a_shortest_tree_and_lie_on_their_curves(seed: int, count: int) -> None:
    linked = with_link_points(random_sheet(seed, count))
    require_shapes(linked)
    curves = curves_of(linked)
    tree = nearest.spanning_length(count, lambda a, b: nearest.distance(curves[a], curves[b]))
    assert nearest.spanning_length(count, lambda a, b: node_distance(linked, a, b)) == pytest.approx(tree)
    for points in entries(linked):
        assert 1 <= len(points) <= MOST
        assert len(np.unique(points, axis=0)) == len(points)


@settings(max_examples=5, deadline=None)
@given(seed=SEEDS)
def test_near_pairs_that_are_not_blocked_are_the_nearest(seed: int) -> None:
    instance = random_sheet(seed, 7)
    curves = curves_of(instance)
    pairs = near_pairs(instance)
    for pair in pairs:
        a, b = pair.contours
        shortest = nearest.distance(curves[a], curves[b])
        assert pair.length >= shortest - 1e-9
        assert not pair.spanning or pair.length == pytest.approx(shortest)
        assert not blocked_segments(instance, pair.ends[:1], pair.ends[1:]).any()
        for end, curve in zip(pair.ends.tolist(), (curves[a], curves[b]), strict=True):
            assert math.dist(end, nearest.foot_on(tuple(end), curve)) < 1e-9
    assert sum(pair.spanning for pair in pairs) == 6


@settings(max_examples=5, deadline=None)
@given(seed=SEEDS)
def test_points_move_with_the_sheet_and_do_not_depend_on_the_order(seed: int) -> None:
    instance = random_sheet(seed, 6)
    rng = np.random.default_rng(seed)
    points = entries(with_link_points(instance))
    shift = rng.integers(-400, 400, 2).astype(float)
    moved = sheet(*(contour(c.id, c.geometry + shift) for c in instance.contours if c.geometry is not None))
    moved = replace(moved, heads=(Head("head", np.append(shift, 0.0)),))
    order = rng.permutation(6)
    mixed = replace(instance, contours=tuple(instance.contours[k] for k in order))
    for place, other in ((np.arange(6), moved), (order, mixed)):
        for k, each in zip(place.tolist(), entries(with_link_points(other)), strict=True):
            expected = points[k] + (shift if other is moved else 0.0)
            # A triangle is found by its length, which is flat at its corners: they vary by the root of 1e-9.
            np.testing.assert_allclose(each, expected, atol=1e-3)


def test_points_are_the_same_whatever_the_entry_points_were() -> None:
    linked = with_link_points(random_sheet(3, 8))
    for again, first in zip(entries(with_link_points(linked)), entries(linked), strict=True):
        np.testing.assert_array_equal(again, first)


def test_two_squares_are_linked_where_they_are_nearest() -> None:
    linked = with_link_points(sheet(box("a", 5, 5), contour("b", [(18, 10), (28, 0), (28, 20)])))
    assert [15.0, 10.0] in entries(linked)[0].tolist()  # inside an edge
    assert [18.0, 10.0] in entries(linked)[1].tolist()
    assert [5.0, 5.0] in entries(linked)[0].tolist()  # nearest to the home
    assert node_distance(linked, 0, 1) == 3.0


def test_a_blocked_nearest_pair_gives_way_to_the_best_clear_link() -> None:
    a, c = disc("a", 0, 0, 5, 4), disc("c", 20, 0, 5, 4)
    instance = sheet(a, c, box("b", 9, -1, 2, 4))
    one, other, _ = curves_of(instance)
    (pair,) = [each for each in near_pairs(instance) if each.contours == (0, 1)]
    tries = [(p, q) for p in one for q in other]
    tries += [(p, nearest.foot_on(p, other)) for p in one] + [(nearest.foot_on(q, one), q) for q in other]

    def clear(p: nearest.Place, q: nearest.Place) -> bool:
        way = np.linspace(p, q, 4001)
        shapes = [np.abs(way - [x, 0]).sum(axis=1) < 5 - 1e-6 for x in (0, 20)]
        inside = ((way > [9, -1]) & (way < [11, 3])).all(axis=1)
        return not (inside.any() or shapes[0].any() or shapes[1].any())

    assert pair.length == pytest.approx(min(math.dist(p, q) for p, q in tries if clear(p, q)))
    assert pair.length > 10.0
    assert not pair.spanning


def test_a_wall_leaves_no_link_between_its_sides() -> None:
    instance = sheet(box("a", 0, 10), box("wall", 14, 0, 2, 30), box("c", 20, 10))
    assert {pair.contours for pair in near_pairs(instance)} == {(0, 1), (1, 2)}
    assert unreachable(instance) == []


def test_a_u_around_another_shape() -> None:
    u = contour("u", [(0, 0), (40, 0), (40, 40), (30, 40), (30, 10), (10, 10), (10, 40), (0, 40)])
    instance = with_link_points(sheet(u, box("inner", 15, 12, 10), box("outer", 15, -16, 10)))
    assert node_distance(instance, 0, 1) == 2.0
    assert node_distance(instance, 0, 2) == 6.0
    assert {pair.contours for pair in near_pairs(instance)} == {(0, 1), (0, 2)}
    assert unreachable(instance) == []


def test_touching_shapes_are_linked_by_nothing() -> None:
    linked = with_link_points(sheet(box("a", 0, 0), box("b", 10, 5), box("c", 20, 15)))
    assert [node_distance(linked, 0, 1), node_distance(linked, 1, 2)] == [0.0, 0.0]
    links = []
    for a, b in ((0, 1), (1, 2)):
        one, other = (entries(linked)[c] for c in (a, b))
        lengths = np.linalg.norm(one[:, None] - other[None], axis=2)
        p, q = np.unravel_index(int(lengths.argmin()), lengths.shape)
        links.append(Link(a, int(p), b, int(q)))
    plan = Plan(((Visit(0, 0),),), tuple(links))
    assert check(linked, Rules("travel", links=True, pierces=1), plan) == []


def test_holes_and_what_lies_in_them_are_regions_of_their_own() -> None:
    nested = sheet(box("outline", 0, 0, 40), box("hole", 5, 5, 30), box("in", 8, 8, 5), box("beside", 50, 0))
    assert link_regions(nested) == [-1, 1, 1, -1]
    assert unreachable(nested) == ["hole", "in"]
    assert unreachable(sheet(*nested.contours, box("on", 20, 8, 5))) == ["outline", "beside"]
    linked = with_link_points(nested)
    assert node_distance(linked, 1, 2) == 3.0
    assert node_distance(linked, 0, 3) == 10.0
    assert node_distance(linked, 0, 1) == math.inf


def test_a_hole_that_touches_is_reached() -> None:
    nested = sheet(
        box("outline", 0, 0, 40), box("hole", 0, 10, 10), box("next", 10, 15, 10), box("in", 2, 12, 4)
    )
    assert link_regions(nested) == [-1, -1, -1, -1]
    assert unreachable(nested) == []
    linked = with_link_points(nested)
    assert [node_distance(linked, *pair) for pair in ((0, 1), (1, 2), (1, 3))] == [0.0, 0.0, 2.0]


def test_one_shape_and_none() -> None:
    assert with_link_points(sheet()).contours == ()
    assert unreachable(sheet()) == []
    assert near_pairs(sheet()) == []
    (points,) = entries(with_link_points(sheet(box("a", 5, 5))))
    assert sorted(points.tolist()) == [[5, 5], [5, 15], [15, 5], [15, 15]]
    assert check(sheet(), Rules("travel", links=True, pierces=1), Plan(((),))) == []


def test_bad_shapes_are_named() -> None:
    with pytest.raises(ValueError, match="'bow', geometry: links need a simple closed curve: Self-inter"):
        with_link_points(sheet(contour("bow", [(0, 0), (4, 4), (4, 0), (0, 4)])))
    with pytest.raises(ValueError, match="'flat', geometry: links need a simple closed curve"):
        with_link_points(sheet(contour("flat", [(0, 0), (4, 0), (8, 0)])))
    with pytest.raises(ValueError, match="'a' and 'b' overlap"):
        with_link_points(sheet(box("a", 0, 0), box("b", 5, 5)))
    with pytest.raises(ValueError, match="'point': no geometry, which links needs"):
        with_link_points(sheet(Contour("point", np.zeros((1, 3)), 0.0)))
    with pytest.raises(ValueError, match="expected at least 1 a contour, got 0"):
        with_link_points(sheet(), 0)


def test_points_keep_the_height_of_the_sheet() -> None:
    high = replace(box("a", 5, 5), entry_points=np.array([[5.0, 5.0, 7.0]]))
    assert set(with_link_points(sheet(high)).contours[0].entry_points[:, 2].tolist()) == {7.0}


def test_needed_points_are_in_even_beyond_the_limit() -> None:
    teeth = [box(str(k), 12 * k, 22) for k in range(6)]
    linked = with_link_points(sheet(box("rail", 0, 0, 82, 20), *teeth), most=1)
    distances = [node_distance(linked, 0, tooth) for tooth in range(1, 7)]
    assert min(distances) == 2.0
    assert nearest.spanning_length(7, lambda a, b: node_distance(linked, a, b)) == 12.0
    assert {len(points) for points in entries(linked)[1:]} <= {1, 2}


def test_thinned_keeps_few_corners_of_the_curve() -> None:
    curve = disc("d", 0, 0, 50, 200).geometry
    assert curve is not None
    kept = thinned(curve)
    assert 4 <= len(kept) <= CORNERS
    assert {tuple(point) for point in kept.tolist()} <= {tuple(point) for point in curve.tolist()}
    np.testing.assert_array_equal(thinned(curve[:CORNERS]), curve[:CORNERS])


@given(seed=SEEDS)
def test_the_point_between_two_is_the_best_of_its_curve(seed: int) -> None:
    rng = np.random.default_rng(seed)
    curve, one, other = rng.uniform(0, 10, (6, 2)), rng.uniform(-5, 15, 2), rng.uniform(-5, 15, 2)
    best = between(curve, one, other)
    assert math.dist(best, nearest.foot_on(tuple(best), curve.tolist())) < 1e-9
    ahead = np.roll(curve, -1, axis=0)
    places = (curve[:, None] + np.linspace(0, 1, 400)[:, None] * (ahead - curve)[:, None]).reshape(-1, 2)
    sums = np.linalg.norm(places - one, axis=1) + np.linalg.norm(places - other, axis=1)
    length = math.dist(best, one) + math.dist(best, other)
    assert length <= sums.min() + 1e-9
    assert length >= sums.min() - 0.1  # places are at most 15 / 400 apart


def test_three_discs_share_the_shortest_triangle() -> None:
    rng = np.random.default_rng(5)
    for _ in range(5):
        radii = rng.uniform(2.0, 5.0, 3)
        middles = [(0, 0), (20, 0), (10, 17)]
        names = zip("abc", middles, radii, strict=True)
        discs = sheet(*(disc(name, *middle, radius, 60, rng.uniform(0, 1)) for name, middle, radius in names))
        pairs = near_pairs(discs)
        (found,) = triangle_points(discs, pairs, chains(discs, pairs))
        a, b, c = (np.array(curve) for curve in curves_of(discs))
        ab, bc, ca = (np.linalg.norm(p[:, None] - q[None], axis=2) for p, q in ((a, b), (b, c), (c, a)))
        corners = min(float((ab[i][:, None] + bc + ca[:, i][None]).min()) for i in range(60))
        assert found.length <= corners + 1e-3
        assert found.length >= corners - 6 * 5.0 * math.tau / 60  # no more than both ends of six moves
        linked = entries(with_link_points(discs))
        for which, point in zip(found.contours, found.points, strict=True):
            assert np.linalg.norm(linked[which] - point, axis=1).min() <= 0.01 * found.length
