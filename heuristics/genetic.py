r"""The constrained genetic algorithm for the tour of one head (Wang et al., 2025, section 2.2).

    (5) f_i = (sum_n K_n) / K_i          fitness of individual i
    (6) K_i = u_i + sum of its jumps + v_i   rapids from home to home                          [mm]
    (7) p_i = f_i / sum_n f_n            chance to be selected
    (8) q_i = p_1 + ... + p_i            roulette wheel, turned M times

An individual is a permutation of the free contours. The home (first and last) and the via point (the leftmost
contour, cut first) are fixed: they are no genes, so that no operator can move them.

Two things that the source leaves open. Crossover: the child keeps a segment of one parent in its place and
takes the other genes in the order of the second parent from the left, which gives the printed example.
Survival: the source "finally saves" the fittest individual; here the best one found so far replaces the
worst of a generation that finds no better one. Without it p_i of (7) hardly tells good tours from bad ones,
and the search wanders: tours of 45 genes then end at more than twice the shortest length, with it at about
15 % above it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import factorial
from typing import Any

import numba
import numpy as np

from cutgap.heuristics.sides import contour_xs
from cutgap.instances import Instance, Rules
from cutgap.instances.arrays import Floats, Ints, finite_number


@dataclass(frozen=True, slots=True)
class GeneticParameters:
    """Parameters of the genetic algorithm; the source prints none.

    The defaults are the best found among settings with the same number of individuals in all, about 0.1 s a
    side of 45 genes, so that the whole method stays below 1 s: a small population and many generations beat
    the reverse, as selection by (7) is weak.

    Parameters
    ----------
    population
        M, individuals per generation, at least 2.
    generations
        C, at least 1.
    crossover_probability, mutation_probability
        p_s and p_b, per individual and generation.
    """

    population: int = 10
    generations: int = 15_000
    crossover_probability: float = 0.7
    mutation_probability: float = 0.3

    def __post_init__(self) -> None:
        for name, least in (("population", 2), ("generations", 1)):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or value < least:
                raise ValueError(f"genetic, {name}: expected a whole number of at least {least}, got {value!r}")
        for name in ("crossover_probability", "mutation_probability"):
            value = finite_number(getattr(self, name), f"genetic, {name}", least=0.0)
            if value > 1.0:
                raise ValueError(f"genetic, {name}: expected at most 1, got {value:g}")
            object.__setattr__(self, name, value)


def genetic_tour(
    instance: Instance,
    rules: Rules,
    head: int,
    contours: Sequence[int],
    *,
    rng: np.random.Generator,
    parameters: GeneticParameters,
) -> list[int]:
    """Return an order in which the head cuts the contours, each pierced at entry point 0.

    With ``rules.via_points`` the leftmost contour (the first listed of several) is fixed as the first. A head
    without a home makes a closed tour, which starts at a fixed contour in any case.
    """
    fixed, free = fixed_and_free(instance, rules, head, contours)
    if len(free) == 0:
        return fixed
    home = instance.home_node(head)
    genes = instance.first_node[free]
    start = instance.node(fixed[-1]) if fixed else home
    end = instance.node(fixed[0]) if home is None else home
    approach = 0.0 if home is None or not fixed else instance.rapids[home, start]
    order = evolve(
        np.ascontiguousarray(instance.rapids[np.ix_(genes, genes)]),
        np.ascontiguousarray(instance.rapids[start, genes]) + approach,
        np.ascontiguousarray(instance.rapids[genes, end]),
        initial_population(len(genes), parameters.population, rng),
        parameters.generations,
        parameters.crossover_probability,
        parameters.mutation_probability,
        rng,
    )
    return fixed + [int(free[gene]) for gene in order]


def fixed_and_free(
    instance: Instance, rules: Rules, head: int, contours: Sequence[int]
) -> tuple[list[int], list[int]]:
    """Return the contour that is fixed as the first, if any, and the others."""
    contours = [int(c) for c in contours]
    if not contours or not (rules.via_points or instance.home_node(head) is None):
        return [], contours
    xs = contour_xs(instance)
    via = min(contours, key=lambda c: xs[c]) if instance.located else contours[0]
    return [via], [c for c in contours if c != via]


def initial_population(genes: int, size: int, rng: np.random.Generator) -> Ints:
    """Return ``size`` different random permutations, or as many as there are; shape (size, genes)."""
    if genes < 12:
        size = min(size, factorial(genes))
    found: dict[bytes, Ints] = {}
    while len(found) < size:
        individual = rng.permutation(genes)
        found.setdefault(individual.tobytes(), individual)
    return np.array(list(found.values()), dtype=np.int64).reshape(size, genes)


@numba.njit(cache=True)
def path_length(lengths: Floats, first: Floats, last: Floats, genes: Ints) -> float:
    """Return K_i of (6): ``first`` leads to the first gene, ``last`` from the last gene home."""
    total = first[genes[0]] + last[genes[-1]]
    for i in range(len(genes) - 1):
        total += lengths[genes[i], genes[i + 1]]
    return total


@numba.njit(cache=True)
def roulette_wheel(path_lengths: Floats) -> Floats:
    """Return q of (8). A tour of length 0 is as good as can be: such tours share the wheel."""
    shortest = path_lengths.min()
    weights = path_lengths.sum() / path_lengths if shortest > 0.0 else np.where(path_lengths <= 0.0, 1.0, 0.0)
    wheel = np.cumsum(weights / weights.sum())
    wheel[-1] = 1.0
    return wheel


@numba.njit(cache=True)
def order_crossover(parent: Ints, other: Ints, start: int, stop: int, child: Ints, taken: Any) -> None:
    """Fill ``child`` with ``parent[start:stop]`` in place and the other genes in the order of ``other``."""
    taken[:] = False
    for i in range(start, stop):
        child[i] = parent[i]
        taken[parent[i]] = True
    i = 0 if start > 0 else stop
    for gene in other:
        if not taken[gene]:
            child[i] = gene
            i += 1
            if i == start:
                i = stop


@numba.njit(cache=True)
def swap_mutation(genes: Ints, rng: Any) -> None:
    """Swap two different genes."""
    i = int(rng.random() * len(genes))
    j = int(rng.random() * (len(genes) - 1))
    if j >= i:
        j += 1
    genes[i], genes[j] = genes[j], genes[i]


@numba.njit(cache=True)
def evolve(
    lengths: Floats,
    first: Floats,
    last: Floats,
    population: Ints,
    generations: int,
    crossover_probability: float,
    mutation_probability: float,
    rng: Any,
) -> Ints:
    """Return the best individual of all generations (steps 3 to 7)."""
    size, n = population.shape
    taken = np.empty(n, np.bool_)
    costs = np.empty(size)
    for i in range(size):
        costs[i] = path_length(lengths, first, last, population[i])
    best_cost = costs.min()
    best = population[costs.argmin()].copy()
    if n < 2:
        return best
    children = np.empty_like(population)
    for _ in range(generations):
        wheel = roulette_wheel(costs)
        chosen = np.searchsorted(wheel, rng.random(size), side="left")
        for i in range(size):
            parent = population[chosen[i]]
            if rng.random() < crossover_probability:
                other = population[chosen[int(rng.random() * size)]]
                a, b = int(rng.random() * n), int(rng.random() * n)
                order_crossover(parent, other, min(a, b), max(a, b) + 1, children[i], taken)
            else:
                children[i] = parent
            if rng.random() < mutation_probability:
                swap_mutation(children[i], rng)
            costs[i] = path_length(lengths, first, last, children[i])
        population, children = children, population
        if costs.min() < best_cost:
            best_cost, best = costs.min(), population[costs.argmin()].copy()
        else:
            worst = costs.argmax()
            population[worst], costs[worst] = best, best_cost
    return best
