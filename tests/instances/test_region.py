"""Regions against a general solver, and against each other."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles.random_regions import random_region

from cutgap.instances.region import Ellipsoid, Hull

SEEDS = st.integers(0, 2**32 - 1)


@given(SEEDS)
def test_the_nearest_point_is_in_the_region_and_no_point_is_nearer(seed):
    rng = np.random.default_rng(seed)
    region, point = random_region(rng), rng.normal(size=3) * rng.choice([1.0, 5.0, 20.0])
    nearest = region.nearest(point)
    across = nearest - point
    # The region lies beyond the plane through its nearest point, square to the way there.
    assert region.support_minimum(across[None])[0] == pytest.approx(across @ nearest, abs=1e-9)
    directions = rng.normal(size=(50, 3))
    assert (region.support_minimum(directions) <= directions @ nearest + 1e-9).all()
    assert region.contains(nearest, 1e-9)
    away = float(np.linalg.norm(across))
    assert region.contains(point, away + 1e-9)
    assert away < 1e-6 or not region.contains(point, 0.99 * away)


@given(SEEDS)
def test_the_support_is_the_least_of_many_points(seed):
    rng = np.random.default_rng(seed)
    region, direction = random_region(rng), rng.normal(size=3)
    if isinstance(region, Hull):
        weights = rng.dirichlet(np.full(len(region.vertices), 0.3), 400)
        points = np.concatenate((weights @ region.vertices, region.vertices))
    else:
        u = rng.normal(size=(400, len(region.axes)))
        u[0] = -region.axes @ direction  # the way that goes down most steeply
        points = region.centre + u / np.maximum(1e-300, np.linalg.norm(u, axis=1, keepdims=True)) @ region.axes
    least = region.support_minimum(direction[None])[0]
    assert (points @ direction >= least - 1e-9).all()
    assert (points @ direction).min() == pytest.approx(least, abs=1e-6)


@pytest.mark.parametrize("count", [1, 2, 5, 40])
def test_points_on_the_curve_are_evenly_spaced(count):
    turn = np.array([[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0]])
    disc = Ellipsoid(np.array([3.0, 1.0, 2.0]), 5.0 * turn)
    ring = disc.boundary(count)
    assert np.linalg.norm(ring - disc.centre, axis=1) == pytest.approx(5.0)
    assert np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1) == pytest.approx(10 * np.sin(np.pi / count))
    square = Hull(np.array([[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [2.0, 2.0, 1.0], [0.0, 2.0, 1.0]]))
    assert square.boundary(8)[:4].tolist() == [[0, 0, 1], [1, 0, 1], [2, 0, 1], [2, 1, 1]]
    flat = Ellipsoid(np.zeros(3), np.array([[1.0, 2.0, 2.0]]))
    assert all(flat.contains(point, 1e-12) for point in flat.boundary(count))


def test_an_ellipse_is_divided_by_its_length():
    """Pieces near the tips are as long as those along the sides, unlike those of equal angles."""
    ring = Ellipsoid(np.zeros(3), np.diag([10.0, 1.0, 0.0])[:2]).boundary(200)
    steps = np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1)
    assert steps.max() < 1.05 * steps.min()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Ellipsoid(np.zeros(2), np.eye(3)), "ellipsoid, centre: expected 3 numbers"),
        (lambda: Ellipsoid(np.zeros((1, 3)), np.eye(3)), "ellipsoid, centre: expected x, y, z"),
        (lambda: Ellipsoid(np.zeros(3), np.zeros((4, 3))), "ellipsoid, axes: expected 1 to 3 rows"),
        (lambda: Ellipsoid(np.zeros(3), np.zeros((0, 3))), "ellipsoid, axes: expected 1 to 3 rows"),
        (lambda: Ellipsoid(np.zeros(3), np.full((1, 3), np.nan)), "ellipsoid, axes: expected finite"),
        (lambda: Hull(np.zeros((0, 3))), "hull, vertices: expected at least one"),
        (lambda: Hull(np.zeros((3, 2))), "hull, vertices: expected 3 numbers"),
    ],
)
def test_what_is_no_region_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()
