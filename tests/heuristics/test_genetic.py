import numpy as np
import pytest
from heuristics_parts import random_part
from hypothesis import given, settings
from hypothesis import strategies as st

from cutgap.heuristics.genetic import (
    GeneticParameters,
    evolve,
    genetic_tour,
    initial_population,
    order_crossover,
    path_length,
    roulette_wheel,
    swap_mutation,
)
from cutgap.instances import Rules

SEEDS = st.integers(0, 2**32 - 1)
QUICK = GeneticParameters(population=6, generations=40)


def crossed(parent, other, start, stop):
    child = np.full(len(parent), -1)
    order_crossover(np.array(parent), np.array(other), start, stop, child, np.empty(len(parent), dtype=bool))
    return child


def test_crossover_gives_the_printed_example():
    # {1,2,3,4,5} and {1,3,5,4,2}: gene 1 is the fixed via point; {2,3} of the one, {5,4} of the other.
    names = np.array([2, 3, 4, 5])
    parent, other = [0, 1, 2, 3], [1, 3, 2, 0]
    assert names[crossed(parent, other, 0, 2)].tolist() == [2, 3, 5, 4]


@given(SEEDS, st.integers(1, 12), st.data())
def test_crossover_keeps_the_segment_and_the_order_of_the_others(seed, n, data):
    rng = np.random.default_rng(seed)
    parent, other = rng.permutation(n), rng.permutation(n)
    start = data.draw(st.integers(0, n - 1))
    stop = data.draw(st.integers(start + 1, n))
    child = crossed(parent, other, start, stop)
    segment = parent[start:stop]
    assert np.array_equal(child[start:stop], segment)
    rest = np.concatenate((child[:start], child[stop:]))
    assert rest.tolist() == [gene for gene in other if gene not in segment]


@given(SEEDS, st.integers(2, 12))
def test_mutation_swaps_exactly_two_genes(seed, n):
    rng = np.random.default_rng(seed)
    before = rng.permutation(n)
    after = before.copy()
    swap_mutation(after, rng)
    changed = np.flatnonzero(before != after)
    assert len(changed) == 2
    assert np.array_equal(after[changed], before[changed[::-1]])


def test_mutation_picks_every_pair_alike():
    rng, pairs = np.random.default_rng(2), {}
    for _ in range(6000):
        genes = np.arange(4)
        swap_mutation(genes, rng)
        pair = tuple(np.flatnonzero(genes != np.arange(4)))
        pairs[pair] = pairs.get(pair, 0) + 1
    assert len(pairs) == 6
    # Chi square with 5 degrees of freedom exceeds 25.7 once in 10 000 times.
    assert sum((count - 1000) ** 2 / 1000 for count in pairs.values()) < 25.7


def test_roulette_selects_in_inverse_proportion_to_length():
    lengths = np.array([100.0, 200.0, 400.0, 800.0])
    chances = np.array([8, 4, 2, 1]) / 15
    wheel = roulette_wheel(lengths)
    assert wheel == pytest.approx(np.cumsum(chances))
    turns = 15_000
    counts = np.bincount(np.searchsorted(wheel, np.random.default_rng(4).random(turns)), minlength=4)
    expected = turns * chances
    # Chi square with 3 degrees of freedom exceeds 21.1 once in 10 000 times.
    assert ((counts - expected) ** 2 / expected).sum() < 21.1


def test_roulette_takes_tours_of_length_zero():
    assert roulette_wheel(np.array([5.0, 0.0, 0.0, 7.0])) == pytest.approx([0.0, 0.5, 1.0, 1.0])


@given(SEEDS, st.integers(0, 8), st.integers(2, 30))
def test_initial_individuals_are_different_permutations(seed, genes, size):
    population = initial_population(genes, size, np.random.default_rng(seed))
    assert len(np.unique(population, axis=0)) == len(population) <= size
    assert (np.sort(population, axis=1) == np.arange(genes)).all()
    assert len(population) == size or genes < 5


@settings(deadline=None, max_examples=30)
@given(SEEDS, st.integers(1, 9))
def test_evolution_returns_the_best_it_saw(seed, n):
    rng = np.random.default_rng(seed)
    lengths, first, last = rng.uniform(0, 9, (n, n)), rng.uniform(0, 9, n), rng.uniform(0, 9, n)
    population = initial_population(n, 8, rng)
    start = min(path_length(lengths, first, last, genes) for genes in population)
    best = evolve(lengths, first, last, population, 30, 0.7, 0.3, rng)
    assert np.array_equal(np.sort(best), np.arange(n))
    assert path_length(lengths, first, last, best) <= start


def test_evolution_nears_the_optimum_of_points_on_a_line():
    xs = np.random.default_rng(8).permutation(10) * 10.0 + 10
    lengths = np.abs(np.subtract.outer(xs, xs))
    order = evolve(
        lengths,
        xs,
        xs,
        initial_population(10, 10, np.random.default_rng(0)),
        6000,
        0.7,
        0.3,
        np.random.default_rng(1),
    )
    assert path_length(lengths, xs, xs, order) == 2 * xs.max()


@settings(deadline=None, max_examples=40)
@given(SEEDS, st.integers(0, 9), st.booleans(), st.booleans())
def test_fixed_genes_never_move(seed, holes, tied, via_points):
    rng = np.random.default_rng(seed)
    part = random_part(rng, holes, tied=tied)
    tour = genetic_tour(part, Rules(via_points=via_points), 1, range(holes), rng=rng, parameters=QUICK)
    assert sorted(tour) == list(range(holes))
    if via_points and holes:
        xs = part.points[:holes, 0]
        assert tour[0] == int(np.argmin(xs))


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("population", 1),
        ("population", 2.5),
        ("generations", 0),
        ("crossover_probability", 1.5),
        ("mutation_probability", -0.1),
        ("mutation_probability", float("nan")),
    ],
)
def test_bad_parameters_are_named(field, value):
    with pytest.raises(ValueError, match=field):
        GeneticParameters(**{field: value})
