import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import cdist

from cutgap.instances.tours import improve_tour, nearest_neighbour_tour, neighbour_lists, tour_length

SEEDS = st.integers(0, 2**32 - 1)


def random_lengths(rng, n, symmetric):
    """Points on a coarse grid (coincident points, equal lengths), or arbitrary asymmetric lengths."""
    points = rng.integers(0, 12, (n, 2)).astype(float)
    return cdist(points, points) if symmetric else rng.uniform(0, 10, (n, n))


def shortest_length(lengths):
    n = len(lengths)
    return min(
        sum(lengths[a, b] for a, b in itertools.pairwise((0, *order, 0)))
        for order in itertools.permutations(range(1, n))
    )


@settings(deadline=None, max_examples=60)
@given(SEEDS, st.integers(0, 40), st.booleans(), st.integers(0, 60))
def test_improve_tour_permutes_and_never_lengthens(seed, n, symmetric, kicks):
    rng = np.random.default_rng(seed)
    lengths, tour = random_lengths(rng, n, symmetric), rng.permutation(n)
    before = tour.copy()
    improved = improve_tour(lengths, tour, kicks, seed)
    assert np.array_equal(tour, before)
    assert np.array_equal(np.sort(improved), np.arange(n))
    assert tour_length(lengths, improved) <= tour_length(lengths, tour) + 1e-9


@pytest.mark.parametrize("symmetric", [True, False])
@pytest.mark.parametrize("n", [2, 3, 4, 5, 6, 7])
def test_improve_tour_finds_the_optimum_of_tiny_tours(n, symmetric):
    for seed in range(12):
        rng = np.random.default_rng([seed, n])
        lengths = random_lengths(rng, n, symmetric)
        found = tour_length(lengths, improve_tour(lengths, np.arange(n), 100, seed))
        assert found == pytest.approx(shortest_length(lengths))


@pytest.mark.parametrize("symmetric", [True, False])
def test_forced_edges_stay_and_the_rest_is_optimised(symmetric):
    for seed in range(10):
        rng = np.random.default_rng(seed)
        lengths = random_lengths(rng, 7, symmetric)
        lengths[2, 5] -= 1e6
        lengths[5, 2] = lengths[2, 5] if symmetric else lengths[5, 2]
        tour = improve_tour(lengths, np.array([2, 5, 0, 1, 3, 4, 6]), 200, seed)
        assert tour_length(lengths, tour) == pytest.approx(shortest_length(lengths), abs=1e-6)


def test_kicks_lead_from_a_local_optimum_to_nearly_the_best():
    rng = np.random.default_rng(5)
    points = rng.uniform(0, 1000, (60, 3))
    lengths = cdist(points, points)
    start = nearest_neighbour_tour(lengths)
    best = min(tour_length(lengths, improve_tour(lengths, start, 20_000, seed)) for seed in range(2))
    for seed in range(5):
        assert tour_length(lengths, improve_tour(lengths, start, 3000, seed)) <= 1.003 * best


def test_same_seed_same_tour():
    lengths = random_lengths(np.random.default_rng(3), 35, symmetric=True)
    first, second = (improve_tour(lengths, np.arange(35), 50, 11) for _ in range(2))
    assert np.array_equal(first, second)


def test_nearest_neighbour_tour_by_hand():
    xs = np.array([0.0, 10.0, 1.0, 4.0])
    assert nearest_neighbour_tour(np.abs(np.subtract.outer(xs, xs)), 0).tolist() == [0, 2, 3, 1]
    assert nearest_neighbour_tour(np.empty((0, 0))).tolist() == []


@given(SEEDS, st.integers(1, 30), st.integers(1, 10))
def test_neighbour_lists_hold_the_nearest_in_order(seed, n, size):
    lengths = np.random.default_rng(seed).uniform(-1, 1, (n, n))
    lists = neighbour_lists(lengths, size)
    for node, listed in enumerate(lists):
        others = sorted((lengths[node, other], other) for other in range(n) if other != node)
        assert listed.tolist() == [other for _, other in others[:size]]


@pytest.mark.parametrize(
    ("lengths", "tour", "message"),
    [
        (np.zeros((4, 3)), [0, 1, 2, 3], "square"),
        (np.full((4, 4), np.nan), [0, 1, 2, 3], "finite"),
        (np.zeros((4, 4)), [0, 1, 2, 2], "once"),
        (np.zeros((4, 4)), [0, 1, 2], "once"),
    ],
)
def test_bad_input_is_named(lengths, tour, message):
    with pytest.raises(ValueError, match=message):
        improve_tour(lengths, np.array(tour), 0, 0)
