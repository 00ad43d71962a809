"""Entry points: where they lie, how many there are, and that each is a vertex of its contour."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cutgap.instances.formats.drawings.chaining import Chain
from cutgap.instances.formats.drawings.curves import Strand, bulge, ellipse, polygon_line
from cutgap.instances.formats.drawings.entry_points import with_entry_points
from cutgap.instances.formats.drawings.outlines import outline
from formats.drawing_samples import star

CHORD = 0.01


def of_elements(elements):
    return outline(Chain((Strand(tuple(elements), "0", "test"),), True))


def polygon(corners):
    corners = np.array(corners, dtype=float)
    return of_elements(polygon_line(np.vstack((corners, corners[:1]))))


def circle(radius, start=0.0):
    u, v = np.array((radius, 0.0)), np.array((0.0, radius))
    return of_elements(ellipse(np.zeros(2), u, v, start, start + 2 * math.pi, CHORD))


def slot():
    """Two straight edges of 30 mm and two half circles of radius 5 mm, one of them in two arcs."""
    tip = np.array((35.0, 5.0))
    return of_elements(
        [
            *polygon_line([(0, 0), (30, 0)]),
            *bulge(np.array((30.0, 0.0)), tip, math.tan(math.pi / 8), CHORD),
            *bulge(tip, np.array((30.0, 10.0)), math.tan(math.pi / 8), CHORD),
            *polygon_line([(30, 10), (0, 10)]),
            *bulge(np.array((0.0, 10.0)), np.array((0.0, 0.0)), 1.0, CHORD),
        ]
    )


def near(places, asked):
    """Whether two sets of points are the same to within the chord tolerance."""
    away = np.linalg.norm(np.array(places)[:, None] - np.array(asked), axis=2)
    return len(places) == len(asked) and away.min(axis=0).max() <= CHORD and away.min(axis=1).max() <= CHORD


def test_corners_of_a_polygon_and_quarter_points_of_a_circle():
    assert with_entry_points(polygon([(0, 0), (10, 0), (10, 10)]), None)[1].tolist() == [
        [0, 0],
        [10, 0],
        [10, 10],
    ]
    assert near(with_entry_points(circle(7), None)[1], [(7, 0), (0, 7), (-7, 0), (0, -7)])


def test_a_corner_is_where_the_direction_turns_or_a_curve_begins():
    in_line = polygon([(0, 0), (5, 0), (10, 0), (10, 10)])
    assert len(in_line.corners) == 3
    # The joint of the two arcs at (35, 5) is smooth, and the middle of one curve.
    diagonal = 5 * math.sqrt(0.5)
    asked = [(0, 0), (30, 0), (30, 10), (0, 10), (35, 5), (-5, 5)]
    asked += [(x, 5 + y) for x in (30 + diagonal, -diagonal) for y in (diagonal, -diagonal)]
    assert near(with_entry_points(slot(), None)[1], asked)


def test_as_many_as_asked_for():
    assert near(with_entry_points(circle(7), 2)[1], [(7, 0), (-7, 0)])
    assert near(with_entry_points(circle(7), 1)[1], [(7, 0)])
    square = polygon([(0, 0), (10, 0), (10, 10), (0, 10)])
    assert near(with_entry_points(square, 2)[1], [(0, 0), (10, 10)])
    halves = [(5, 0), (10, 5), (5, 10), (0, 5)]
    assert near(with_entry_points(square, 8)[1], [(0, 0), (10, 0), (10, 10), (0, 10), *halves])


def test_more_points_go_where_the_spacing_is_largest():
    # Straight edges of 30 mm take two points each before a half circle of 15.7 mm takes one.
    places = with_entry_points(slot(), 8)[1]
    asked = [(0, 0), (30, 0), (30, 10), (0, 10), (15, 0), (15, 10), (35, 5), (-5, 5)]
    assert near(places, asked)


@given(st.integers(0, 2**32 - 1), st.integers(3, 9), st.none() | st.integers(1, 30))
def test_entry_points_are_vertices_and_the_curve_stays(seed, corners, count):
    rng = np.random.default_rng(seed)
    ring = star(rng, corners)
    elements = [
        element
        for start, end in zip(ring, np.roll(ring, -1, axis=0), strict=True)
        for element in bulge(start, end, float(rng.choice((0.0, 0.2, -0.1))), CHORD)
    ]
    shape = of_elements(elements)
    points, places = with_entry_points(shape, count)
    vertices = {tuple(point) for point in points}
    assert all(tuple(place) in vertices for place in places)
    assert len({tuple(place) for place in places}) == len(places)
    assert {tuple(point) for point in shape.points} <= vertices
    lengths = [
        np.linalg.norm(np.diff(np.vstack((p, p[:1])), axis=0), axis=1).sum() for p in (points, shape.points)
    ]
    assert lengths[0] == pytest.approx(lengths[1], rel=1e-12)
    if count is not None:
        assert len(places) <= count
        if count > len(shape.corners):
            assert len(places) == count
            assert {tuple(shape.points[corner]) for corner in shape.corners} <= {tuple(p) for p in places}
