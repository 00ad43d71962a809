"""Crossover and mutation of two-row chromosomes (Yang, Liu, Ju, 2012, sections 2.3 and 2.4), and plain ones.

A chromosome is a route of ``hot_routes``: ``order``, and ``starts`` stored by contour.
"""

from typing import Any, NamedTuple

import numba
import numpy as np

from cutgap.heuristics.hot_routes import Plate, barred_steps
from cutgap.instances.arrays import Ints


class Operators(NamedTuple):
    """Chances of crossover and mutation, b of ``non_uniform``, tries for a clear child, and which operators."""

    crossover: float
    mutation: float
    shape: float
    tries: int
    plain: bool


@numba.njit(cache=True)
def interleave(orders: Ints, starts: Ints, child_orders: Ints, child_starts: Ints) -> None:
    """Order crossover: parents are taken gene by gene in turn, and dealt.

    Of the two copies of a contour the first goes to child 0 and the second to child 1, each with its start.

    Parameters
    ----------
    orders, starts
        Rows of the two parents, shape (2, contours).
    child_orders, child_starts
        Filled with those of the children, same shape.
    """
    count = orders.shape[1]
    dealt = np.zeros(count, np.bool_)
    filled = np.zeros(2, np.int64)
    for turn in range(count):
        for parent in range(2):
            contour = orders[parent, turn]
            child = 1 if dealt[contour] else 0
            dealt[contour] = True
            child_orders[child, filled[child]] = contour
            child_starts[child, contour] = starts[parent, contour]
            filled[child] += 1


@numba.njit(cache=True)
def blend(starts: Ints, share: float) -> None:
    """Start crossover: x' = share x + (1 - share) y and y' = share y + (1 - share) x, rounded, by contour."""
    for contour in range(starts.shape[1]):
        x, y = starts[0, contour], starts[1, contour]
        starts[0, contour] = int(np.floor(share * x + (1.0 - share) * y + 0.5))
        starts[1, contour] = int(np.floor(share * y + (1.0 - share) * x + 0.5))


@numba.njit(cache=True)
def shift(order: Ints, first: int, last: int, after: int) -> None:
    """Order mutation: take genes ``first`` to ``last`` out, put them after gene ``after`` of the rest."""
    segment = order[first : last + 1].copy()
    rest = np.concatenate((order[:first], order[last + 1 :]))
    order[: after + 1] = rest[: after + 1]
    order[after + 1 : after + 1 + len(segment)] = segment
    order[after + 1 + len(segment) :] = rest[after + 1 :]


@numba.njit(cache=True)
def random_shift(order: Ints, rng: Any) -> None:
    """Apply ``shift`` to genes drawn evenly, such that one at least is left to insert after."""
    count = len(order)
    if count < 2:
        return
    first, last = 0, count - 1
    while last - first == count - 1:
        one, other = int(rng.random() * count), int(rng.random() * count)
        first, last = min(one, other), max(one, other)
    shift(order, first, last, int(rng.random() * (count - 1 - (last - first))))


@numba.njit(cache=True)
def non_uniform(start: int, points: int, progress: float, shape: float, up: bool, draw: float) -> int:
    """Start mutation: go up or down by y (1 - draw^((1 - progress)^shape)), rounded; y is the room that way.

    Source: Z. Michalewicz, Genetic Algorithms + Data Structures = Evolution Programs.

    Parameters
    ----------
    start, points
        Number of the start, and how many the contour has.
    progress
        Generation / last generation.
    shape
        b; the greater, the sooner steps become small.
    up, draw
        Which way, and a random number in [0, 1).
    """
    share = 1.0 - draw ** ((1.0 - progress) ** shape)
    if up:
        return start + int(np.floor(share * (points - 1 - start) + 0.5))
    return start - int(np.floor(share * start + 0.5))


@numba.njit(cache=True)
def cross(orders: Ints, starts: Ints, child_orders: Ints, child_starts: Ints, rng: Any) -> None:
    """One of three at random: order, starts, both."""
    kind = int(rng.random() * 3)
    if kind == 1:
        child_orders[:] = orders
        child_starts[:] = starts
    else:
        interleave(orders, starts, child_orders, child_starts)
    if kind > 0:
        blend(child_starts, rng.random())


@numba.njit(cache=True)
def mutate(plate: Plate, order: Ints, starts: Ints, progress: float, shape: float, rng: Any) -> None:
    """One of three at random: order, the start of one contour, both."""
    kind = int(rng.random() * 3)
    if kind != 1:
        random_shift(order, rng)
    if kind > 0:
        contour = int(rng.random() * len(order))
        points = plate.first_node[contour + 1] - plate.first_node[contour]
        up, draw = rng.random() < 0.5, rng.random()
        starts[contour] = non_uniform(starts[contour], points, progress, shape, up, draw)


@numba.njit(cache=True)
def plain_cross(orders: Ints, starts: Ints, child_orders: Ints, child_starts: Ints, rng: Any) -> None:
    """Conventional crossover: a child keeps a segment in place, the rest is in the other parent's order (OX).

    Starts come with their contours.
    """
    count = orders.shape[1]
    one, other = int(rng.random() * count), int(rng.random() * count)
    first, last = min(one, other), max(one, other)
    for child in range(2):
        kept = np.zeros(count, np.bool_)
        for turn in range(first, last + 1):
            contour = orders[child, turn]
            kept[contour] = True
            child_orders[child, turn] = contour
            child_starts[child, contour] = starts[child, contour]
        turn = 0
        for contour in orders[1 - child]:
            if not kept[contour]:
                if turn == first:
                    turn = last + 1
                child_orders[child, turn] = contour
                child_starts[child, contour] = starts[1 - child, contour]
                turn += 1


@numba.njit(cache=True)
def plain_mutate(plate: Plate, order: Ints, starts: Ints, rng: Any) -> None:
    """Conventional mutation: two genes change places, and the start of one contour is drawn anew."""
    count = len(order)
    one, other = int(rng.random() * count), int(rng.random() * count)
    order[one], order[other] = order[other], order[one]
    contour = int(rng.random() * count)
    starts[contour] = int(rng.random() * (plate.first_node[contour + 1] - plate.first_node[contour]))


@numba.njit(cache=True)
def breed(
    plate: Plate, settings: Operators, orders: Ints, starts: Ints, chosen: Ints, progress: float, rng: Any
) -> tuple[Ints, Ints]:
    """Return the children of the chosen parents, pair by pair.

    A child that reaches more contours across what is cut than the better of its parents is made again, with the
    same parents, ``tries`` times at most; then a parent goes on as it is.

    Parameters
    ----------
    orders, starts
        Shape (population, contours).
    chosen
        Parents, one after the other, shape (population + 1,) at least.
    progress
        As for ``non_uniform``.
    """
    size, count = orders.shape
    new_orders, new_starts = np.empty_like(orders), np.empty_like(starts)
    children, child_starts = np.empty((2, count), np.int64), np.empty((2, count), np.int64)
    for k in range(0, size, 2):
        pair, pair_starts = orders[chosen[k : k + 2]], starts[chosen[k : k + 2]]
        most = barred_steps(plate, pair[0], pair_starts[0], count)
        most = min(most, barred_steps(plate, pair[1], pair_starts[1], count))
        filled, wanted = k, min(k + 2, size)
        for _ in range(settings.tries):
            make_pair(plate, settings, pair, pair_starts, children, child_starts, progress, rng)
            for child in range(2):
                clear = barred_steps(plate, children[child], child_starts[child], most) <= most
                if clear and filled < wanted:
                    new_orders[filled], new_starts[filled] = children[child], child_starts[child]
                    filled += 1
            if filled == wanted:
                break
        for child in range(filled, wanted):
            new_orders[child], new_starts[child] = pair[child - k], pair_starts[child - k]
    return new_orders, new_starts


@numba.njit(cache=True)
def make_pair(
    plate: Plate,
    settings: Operators,
    orders: Ints,
    starts: Ints,
    children: Ints,
    child_starts: Ints,
    progress: float,
    rng: Any,
) -> None:
    """Fill in two children of two parents, crossed and mutated each with its chance."""
    if rng.random() >= settings.crossover:
        children[:] = orders
        child_starts[:] = starts
    elif settings.plain:
        plain_cross(orders, starts, children, child_starts, rng)
    else:
        cross(orders, starts, children, child_starts, rng)
    for child in range(2):
        if rng.random() < settings.mutation:
            if settings.plain:
                plain_mutate(plate, children[child], child_starts[child], rng)
            else:
                mutate(plate, children[child], child_starts[child], progress, settings.shape, rng)
