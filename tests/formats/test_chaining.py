"""Pieces in any order and direction become the contours that they were cut from."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cutgap.instances.formats.drawings.chaining import chain
from cutgap.instances.formats.drawings.curves import Strand, polygon_line
from cutgap.instances.formats.drawings.outlines import outline
from formats.drawing_samples import same_ring, star

TOLERANCE = 0.05
SEEDS = st.integers(0, 2**32 - 1)


def strand(points):
    return Strand(tuple(polygon_line(points)), "0", "LINE")


def cut_up(rng, ring, shift=0.0):
    """Cut a closed polyline at random corners; ends may be off by ``shift`` (mm) in a random direction."""
    closed = np.vstack((ring, ring[:1]))
    inner = np.flatnonzero(rng.random(len(ring) - 1) < 0.5) + 1
    cuts = [0, *inner, len(ring)]
    pieces = []
    for first, last in pairwise(cuts):
        piece = closed[first : last + 1].copy()
        for end in (0, -1):
            angle = rng.uniform(0, 2 * np.pi)
            piece[end] += shift * np.array((np.cos(angle), np.sin(angle)))
        pieces.append(piece[::-1] if rng.random() < 0.5 else piece)
    return pieces


def rings(strands, tolerance=TOLERANCE):
    chains = chain(strands, tolerance)
    assert all(each.closed for each in chains)
    return [outline(each).points for each in chains]


@given(SEEDS, st.integers(1, 4), st.integers(3, 9))
def test_shuffled_and_reversed_pieces_give_back_their_polygons(seed, polygons, corners):
    rng = np.random.default_rng(seed)
    asked = [star(rng, corners) + np.array((300.0 * number, 0)) for number in range(polygons)]
    pieces = [piece for ring in asked for piece in cut_up(rng, ring)]
    rng.shuffle(pieces)
    found = rings([strand(piece) for piece in pieces])
    assert len(found) == polygons
    assert all(any(same_ring(ring, other) for other in found) for ring in asked)


@given(SEEDS, st.integers(3, 9))
def test_gaps_within_the_tolerance_are_closed_and_wider_ones_are_not(seed, corners):
    rng = np.random.default_rng(seed)
    ring = star(rng, corners)
    # Both ends at a joint move, so that they are at most twice as far apart.
    pieces = cut_up(rng, ring, shift=0.49 * TOLERANCE)
    (found,) = rings([strand(piece) for piece in pieces])
    assert found.shape == ring.shape
    away = np.linalg.norm(found[:, None] - ring, axis=2).min(axis=1)
    assert away.max() <= 0.5 * TOLERANCE
    closed = np.vstack((ring, ring[:1]))
    open_end = closed[-1] + np.array((1.01 * TOLERANCE, 0))
    (single,) = chain([strand(np.vstack((closed[:-1], open_end)))], TOLERANCE)
    assert not single.closed


@given(SEEDS, st.integers(1, 4), st.integers(1, 4))
def test_parts_that_share_edges_are_told_apart_by_the_order_of_the_file(seed, rows, columns):
    rng = np.random.default_rng(seed)
    unit = np.array([(0, 0), (1, 0), (1, 1), (0, 1)]) * 10.0
    asked = [unit + 10.0 * np.array((column, row)) for row in range(rows) for column in range(columns)]
    strands = []
    for number in rng.permutation(len(asked)):
        ring = np.roll(asked[number][:: rng.choice((1, -1))], rng.integers(4), axis=0)
        closed = np.vstack((ring, ring[:1]))
        for edge in range(4):
            ends = closed[edge : edge + 2]
            strands.append(strand(ends[::-1] if rng.random() < 0.5 else ends))
    found = rings(strands)
    assert len(found) == len(asked)
    assert all(any(same_ring(ring, other) for other in found) for ring in asked)


@given(SEEDS)
def test_contours_that_touch_in_a_corner_are_two_whatever_the_order(seed):
    rng = np.random.default_rng(seed)
    asked = [np.array([(0, 0), (9, 1), (8, 7)], float), np.array([(0, 0), (-9, 2), (-8, -7)], float)]
    pieces = [piece for ring in asked for piece in np.stack((ring, np.roll(ring, -1, axis=0)), axis=1)]
    rng.shuffle(pieces)
    found = rings([strand(piece) for piece in pieces])
    assert len(found) == 2
    assert all(any(same_ring(ring, other) for other in found) for ring in asked)


def test_a_stray_line_at_a_corner_stays_open_and_the_contour_closed():
    corners = np.array([(0, 0), (10, 0), (10, 10), (0, 10), (0, 0)], float)
    strands = [strand(((-3, -5), (0, 0)))]
    strands += [strand(corners[k : k + 2]) for k in range(4)]
    chains = chain(strands, TOLERANCE)
    assert [each.closed for each in chains] == [False, True]
    assert [len(each.strands) for each in chains] == [1, 4]


def test_pieces_shorter_than_the_tolerance_stay_in_their_contour():
    # A circle of 4000 chords, each shorter than the tolerance.
    angles = np.linspace(0, 2 * np.pi, 4001)
    ring = 10 * np.column_stack((np.cos(angles), np.sin(angles)))
    ring[-1] = ring[0]
    assert np.linalg.norm(ring[1] - ring[0]) < TOLERANCE
    (found,) = rings([strand(ring[k : k + 2]) for k in range(4000)])
    assert same_ring(found, ring[:-1])


def test_perimeter_is_that_of_the_pieces():
    rng = np.random.default_rng(4)
    ring = star(rng, 7)
    (loop,) = chain([strand(piece) for piece in cut_up(rng, ring)], TOLERANCE)
    sides = np.linalg.norm(ring - np.roll(ring, -1, axis=0), axis=1)
    assert outline(loop).perimeter == pytest.approx(sides.sum(), rel=1e-12)
