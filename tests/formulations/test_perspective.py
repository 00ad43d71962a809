"""The perspective relaxation: below every tour, proved by its multipliers, and tight where theory says so."""

from itertools import permutations

import numpy as np
import pytest
from oracles.random_regions import random_region
from oracles.region_orders import shortest_of_orders

from cutgap.formulations.relaxations.perspective import (
    MOST_REGIONS,
    PerspectiveModel,
    Prices,
    edge_ends,
    priced_lengths,
    relax_perspective,
    solve_relaxation,
)
from cutgap.instances.region import Ellipsoid, Hull, point_region


def discs(seed, count):
    rng = np.random.default_rng(seed)
    centres = np.column_stack((rng.uniform(0, 100, (count, 2)), np.zeros(count)))
    return [Ellipsoid(each, rng.uniform(5, 15) * np.eye(3)[:2]) for each in centres]


def mixed(seed, count):
    rng = np.random.default_rng(seed)
    return [random_region(rng) for _ in range(count)]


def square(lengths, count):
    """Lengths of edges as a symmetric matrix."""
    matrix = np.zeros((count, count))
    tails, heads = edge_ends(count)
    matrix[tails, heads] = matrix[heads, tails] = lengths
    return matrix


def shortest_tour(lengths):
    count = len(lengths)
    around = ((0, *order) for order in permutations(range(1, count)))
    return min(sum(lengths[order[i - 1], order[i]] for i in range(count)) for order in around)


def one_tree(lengths, potentials):
    """The bound of Held and Karp, with the least spanning tree by Kruskal's algorithm."""
    count = len(potentials)
    priced = lengths - potentials[:, None] - potentials
    group = list(range(count))
    total = 2 * potentials.sum() + np.sort(priced[0, 1:])[:2].sum()
    edges = sorted((priced[u, v], u, v) for u in range(1, count) for v in range(u + 1, count))
    for cost, u, v in edges:
        if group[u] != group[v]:
            total += cost
            group = [group[u] if each == group[v] else each for each in group]
    return total


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("kind", [discs, mixed])
def test_value_is_below_the_optimum_and_what_the_multipliers_prove(kind, seed):
    regions = kind(seed, 3 + seed % 3)
    relaxed = relax_perspective(regions)
    costs, constant = priced_lengths(regions, relaxed.prices)
    lengths = square(costs, len(regions))
    optimum = shortest_of_orders(regions)
    assert relaxed.value <= optimum + 1e-4
    assert one_tree(lengths, relaxed.prices.potentials) - constant == pytest.approx(relaxed.value, abs=1e-4)
    assert shortest_tour(lengths) - constant <= optimum + 1e-6
    if len(regions) == 3:  # there is one tour
        assert relaxed.value == pytest.approx(optimum, abs=1e-5)


@pytest.mark.parametrize("seed", range(10))
def test_any_multipliers_prove_a_bound(seed):
    rng = np.random.default_rng(seed)
    regions = mixed(seed, 4)
    steps, shifts = rng.normal(size=(6, 3)), 0.3 * rng.normal(size=(12, 3))
    costs, constant = priced_lengths(regions, Prices(steps, shifts, np.zeros(4)))
    assert shortest_tour(square(costs, 4)) - constant <= shortest_of_orders(regions) + 1e-6


@pytest.mark.parametrize("seed", range(3))
def test_points_up_to_five_leave_no_gap(seed):
    """The polytope of tours of five cities has degree and subtour constraints alone."""
    places = np.random.default_rng(seed).uniform(0, 100, (5, 3))
    regions = [point_region(place) for place in places]
    lengths = np.linalg.norm(places[:, None] - places, axis=2)
    assert relax_perspective(regions).value == pytest.approx(shortest_tour(lengths), abs=1e-5)


def test_one_point_cuts_off_what_the_distances_allow():
    """A long region between three small ones: each distance to it is short, but at another place."""
    small = [Ellipsoid(np.array([x, 0.0, 0.0]), np.eye(3)[:2]) for x in (0.0, 50.0, 100.0)]
    regions = [*small, Ellipsoid(np.array([50.0, 0.0, 0.0]), np.array([[50.0, 0, 0], [0, 1, 0]]))]
    model = PerspectiveModel(regions, whole=False)
    model.one_point, model.cones_of = [], [each[:1] for each in model.cones_of]  # without (5)
    solve_relaxation(model)
    distances = float(model.lengths.value.sum()) * model.size
    assert distances == pytest.approx(48 + 48, abs=1e-4)
    assert distances + 40 < relax_perspective(regions).value <= shortest_of_orders(regions) + 1e-4


def test_too_few_and_too_many_are_refused():
    for count in (2, MOST_REGIONS + 1):
        with pytest.raises(ValueError, match=f"3 to {MOST_REGIONS} regions.*got {count}"):
            relax_perspective([Hull(np.zeros((1, 3)))] * count)
