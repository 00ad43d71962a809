"""Tours through regions in a fixed order: against other solvers; bounds for any multipliers."""

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import region_tours
from oracles.random_regions import random_region

from cutgap.formulations.regions.interior_point import shortest
from cutgap.formulations.regions.shapes import shapes_of
from cutgap.formulations.relaxations.touring import dual_bound, exact_bound, shortest_in_order
from cutgap.instances.region import Ellipsoid, Hull, point_region

SEEDS = st.integers(0, 2**32 - 1)


def regions_of(rng, count):
    flat = bool(rng.integers(2))
    return [random_region(rng, flat=flat) for _ in range(count)]


@settings(max_examples=30)
@given(SEEDS, st.integers(1, 8))
def test_value_and_bound_meet(seed, count):
    """A flipped sign of the multipliers keeps the bound valid, but not tight."""
    regions = regions_of(np.random.default_rng(seed), count)
    tour = shortest_in_order(regions)
    assert float(tour.lower_bound) == pytest.approx(tour.value, rel=1e-6, abs=1e-6)
    assert tour.lower_bound <= tour.value + 1e-12
    assert dual_bound(regions, tour.multipliers) == pytest.approx(float(tour.lower_bound), rel=1e-9, abs=1e-9)
    assert all(region.contains(point, 1e-11) for region, point in zip(regions, tour.points, strict=True))


@settings(max_examples=30)
@given(SEEDS, st.integers(2, 8))
def test_any_multipliers_give_a_bound(seed, count):
    rng = np.random.default_rng(seed)
    regions = regions_of(rng, count)
    tour = shortest_in_order(regions)
    for spread in (0.01, 1.0, 10.0):
        u = tour.multipliers + spread * rng.normal(size=tour.multipliers.shape)
        assert exact_bound(regions, u) <= tour.value + 1e-12
        assert dual_bound(regions, u) == pytest.approx(float(exact_bound(regions, u)), abs=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_agrees_with_other_solvers(seed):
    rng = np.random.default_rng(seed)
    regions = regions_of(rng, 6)
    tour = shortest_in_order(regions)
    shapes = shapes_of(regions)
    p = np.empty((6, shapes.centres.shape[1]))
    _, value = shortest(shapes, np.arange(6), np.inf, 1e-10, 1e-10, p, np.empty_like(p))
    assert tour.value == pytest.approx(value, rel=1e-8, abs=1e-7)
    assert tour.value == pytest.approx(region_tours.shortest_in_order(regions)[0], rel=1e-6, abs=1e-6)


def test_simple_tours():
    ball = Ellipsoid(np.array([5.0, 0.0, 0.0]), np.eye(3))
    assert shortest_in_order([ball]).value == pytest.approx(0.0, abs=1e-9)
    assert shortest_in_order([ball, point_region(np.zeros(3))]).value == pytest.approx(8.0)
    bar = Hull(np.array([[-1.0, 3.0, 0.0], [1.0, 3.0, 0.0]]))
    assert shortest_in_order([bar, point_region(np.zeros(3))]).value == pytest.approx(6.0)
    with pytest.raises(ValueError, match="expected at least one"):
        shortest_in_order([])


def test_a_hundred_discs_within_a_second_and_a_millionth():
    rng = np.random.default_rng(1)
    places, radii = rng.uniform(0, 1000, (100, 2)), rng.uniform(5, 100, 100)
    discs = [Ellipsoid(np.append(c, 0.0), r * np.eye(3)[:2]) for c, r in zip(places, radii, strict=True)]
    shortest_in_order(discs[:3])
    begun = time.process_time()
    tour = shortest_in_order(discs)
    assert time.process_time() - begun < 1.0
    assert tour.gap < 1e-6
