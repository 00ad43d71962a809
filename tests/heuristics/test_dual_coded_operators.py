"""The published examples of crossover and mutation, and what the operators keep."""

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles.random_plates import random_plate

from cutgap.heuristics.dual_coded_operators import (
    blend,
    cross,
    interleave,
    mutate,
    non_uniform,
    plain_cross,
    plain_mutate,
    shift,
)
from cutgap.heuristics.hot_routes import plate_of
from cutgap.instances import Rules

SEEDS = st.integers(0, 2**32 - 1)


class Rows(NamedTuple):
    """The two rows as printed, both counted from 1; a start stands below its contour."""

    order: str
    starts: str


def routes(*printed):
    """Orders and starts by contour of printed chromosomes, counted from 0."""
    orders = np.array([[int(gene) - 1 for gene in each.order.split()] for each in printed])
    below = np.array([[int(gene) - 1 for gene in each.starts.split()] for each in printed])
    starts = np.empty_like(below)
    np.put_along_axis(starts, orders, below, axis=1)
    return orders, starts


def printed(order, starts):
    return Rows(" ".join(str(c + 1) for c in order), " ".join(str(starts[c] + 1) for c in order))


def test_the_published_crossover():
    orders, starts = routes(Rows("1 4 2 6 5 3", "2 1 4 3 2 4"), Rows("1 2 3 5 6 4", "3 4 1 2 4 3"))
    children, child_starts = np.empty_like(orders), np.empty_like(starts)
    interleave(orders, starts, children, child_starts)
    assert printed(children[0], child_starts[0]) == Rows("1 4 2 3 6 5", "2 1 4 1 3 2")
    assert printed(children[1], child_starts[1]) == Rows("1 2 5 6 3 4", "3 4 2 4 4 3")


def test_the_published_mutation_but_for_its_misprint():
    orders, starts = routes(Rows("1 4 2 6 5 3 8 9 7", "2 3 3 1 4 5 4 6 2"))
    # Genes 2 to 3 are taken out and put after gene 9, which is number 3 of 1 4 8 9 7.
    shift(orders[0], 2, 5, 3)
    # The source prints 3 for the start of contour 3, which has 5 before: but starts stay with their contours.
    assert printed(orders[0], starts[0]) == Rows("1 4 8 9 2 6 5 3 7", "2 3 4 6 3 1 4 5 2")


def test_starts_are_blended_contour_by_contour():
    starts = np.array([[0, 6, 3], [4, 1, 3]])
    blend(starts, 0.25)
    # 0.25 * 0 + 0.75 * 4 = 3 and 1; 0.25 * 6 + 0.75 * 1 = 2.25 and 4.75.
    assert starts.tolist() == [[3, 2, 3], [1, 5, 3]]


def test_a_non_uniform_step_shrinks_to_nothing():
    # 1 - 0.25^1 of the room at the beginning, 1 - 0.25^(1/4) = 0.29 in the middle.
    assert non_uniform(1, 9, 0.0, 2.0, True, 0.25) == 1 + 5
    assert non_uniform(8, 9, 0.0, 2.0, False, 0.25) == 8 - 6
    assert non_uniform(1, 9, 0.5, 2.0, True, 0.25) == 1 + 2
    assert non_uniform(1, 9, 1.0, 2.0, True, 0.25) == 1
    assert non_uniform(2, 9, 0.0, 2.0, True, 0.0) == 8
    assert non_uniform(2, 9, 0.0, 2.0, False, 0.0) == 0


def random_routes(rng, instance, count):
    sizes = np.array([len(contour.entry_points) for contour in instance.contours])
    orders = np.array([rng.permutation(len(sizes)) for _ in range(count)], dtype=np.int64)
    return orders, rng.integers(0, sizes, (count, len(sizes)))


def require_routes(instance, orders, starts):
    count = len(instance.contours)
    sizes = [len(contour.entry_points) for contour in instance.contours]
    assert (np.sort(orders, axis=1) == np.arange(count)).all()
    assert (starts >= 0).all()
    assert (starts < sizes).all()


@pytest.mark.parametrize("crossing", [cross, plain_cross])
@given(seed=SEEDS, count=st.integers(1, 9))
def test_children_are_routes_with_starts_between_those_of_their_parents(crossing, seed, count):
    rng = np.random.default_rng(seed)
    instance = random_plate(rng, count, entries=4)
    orders, starts = random_routes(rng, instance, 2)
    children, child_starts = np.empty_like(orders), np.empty_like(starts)
    crossing(orders, starts, children, child_starts, rng)
    require_routes(instance, children, child_starts)
    assert (child_starts >= starts.min(axis=0)).all()
    assert (child_starts <= starts.max(axis=0)).all()
    if crossing is plain_cross:
        assert ((child_starts == starts[0]) | (child_starts == starts[1])).all()


@given(seed=SEEDS, count=st.integers(1, 9), progress=st.floats(0.0, 1.0))
def test_mutants_are_routes_and_change_one_start_at_most(seed, count, progress):
    rng = np.random.default_rng(seed)
    instance = random_plate(rng, count, entries=4)
    plate = plate_of(instance, Rules())
    for operator, extra in ((mutate, (progress, 2.0)), (plain_mutate, ())):
        orders, starts = random_routes(rng, instance, 1)
        before = starts.copy()
        operator(plate, orders[0], starts[0], *extra, rng)
        require_routes(instance, orders, starts)
        assert (starts != before).sum() <= 1


@given(SEEDS)
def test_each_third_of_the_crossovers_changes_what_it_should(seed):
    rng = np.random.default_rng(seed)
    orders = np.array([np.arange(6), np.arange(6)[::-1]])
    starts = np.array([[0] * 6, [9] * 6])
    seen = set()
    for _ in range(60):
        children, child_starts = np.empty_like(orders), np.empty_like(starts)
        cross(orders, starts, children, child_starts, rng)
        moved = not (children == orders).all()
        inner = bool(((child_starts > 0) & (child_starts < 9)).any())
        seen.add((moved, inner))
    assert {(True, False), (False, True), (True, True)} <= seen
