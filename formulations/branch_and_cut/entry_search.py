r"""Good tours through one point of each contour, fast: warm starts and roundings of the generalised tour.

    Data   l_uv >= 0  symmetric lengths between n nodes; contour h has the nodes first[h] .. first[h + 1] - 1

A tour is given by its nodes in order, one a contour. Some contours are taken out, near each other, in a row or
anywhere, and put back one by one where a point of theirs lengthens the tour least; then the points are chosen
anew, all at once, for the order as it is, and runs of the tour are turned round. A tour that is longer by a
share that shrinks over time may replace the current one.

Source: Smith and Imeson (2017), GLNS; choice of points by layered shortest paths, Fischetti, Salazar, Toth
(1997).
"""

import numpy as np
from numba import njit

from cutgap.instances.arrays import Floats, Ints

WARMEST = 0.02
"""Share by which a tour may be longer than the current one at first."""

MOST_OUT = 20
"""Contours taken out at once, at most."""


def good_tour(lengths: Floats, first: Ints, rounds: int, rng: np.random.Generator) -> tuple[float, Ints]:
    """Return the length and the nodes of a good tour through one node of each contour, at least one.

    Parameters
    ----------
    lengths
        Shape (n, n), symmetric, not negative.
    first
        Shape (contours + 1,).
    rounds
        How often contours are taken out and put back.
    """
    near = _nearest_contours(lengths, first)
    tour = _rebuilt(lengths, first, rng.permutation(len(first) - 1), np.empty(0, dtype=np.int64))
    return _search(lengths, first, near, tour, rounds, rng)


def improved_tour(
    lengths: Floats, first: Ints, tour: Ints, rounds: int, rng: np.random.Generator
) -> tuple[float, Ints]:
    """Return the length and the nodes of a tour that is at most as long as ``tour``."""
    return _search(lengths, first, _nearest_contours(lengths, first), tour, rounds, rng)


@njit(cache=True)
def _nearest_contours(lengths: Floats, first: Ints) -> Ints:
    """Return for each contour all contours, the nearest first (itself somewhere in front)."""
    m = len(first) - 1
    gaps = np.empty((m, m))
    for h in range(m):
        for k in range(m):
            gaps[h, k] = lengths[first[h] : first[h + 1], first[k] : first[k + 1]].min()
    near = np.empty((m, m), dtype=np.int64)
    for h in range(m):
        near[h] = np.argsort(gaps[h])
    return near


@njit(cache=True)
def _tour_length(lengths: Floats, tour: Ints) -> float:
    total = 0.0
    for i in range(len(tour)):
        total += lengths[tour[i - 1], tour[i]]
    return total


@njit(cache=True)
def _search(
    lengths: Floats, first: Ints, near: Ints, tour: Ints, rounds: int, rng: np.random.Generator
) -> tuple:
    m = len(tour)
    contour_of = np.empty(len(lengths), dtype=np.int64)
    for h in range(m):
        contour_of[first[h] : first[h + 1]] = h
    tour = _polished(lengths, first, contour_of, tour)
    length = _tour_length(lengths, tour)
    best, best_length = tour.copy(), length
    for turn in range(rounds if m > 3 else 0):
        out = _taken_out(near, contour_of, tour, rng)
        kept = np.array([v for v in tour if not out[contour_of[v]]], dtype=np.int64)
        missing = np.flatnonzero(out)
        rng.shuffle(missing)
        other = _rebuilt(lengths, first, missing, kept)
        _turn_runs(lengths, other)
        other_length = _tour_length(lengths, other)
        if other_length < 1.02 * length:
            other = _polished(lengths, first, contour_of, other)
            other_length = _tour_length(lengths, other)
        share = WARMEST * (1.0 - turn / rounds) ** 2 * rng.random()
        if other_length < length * (1.0 + share):
            tour, length = other, other_length
        if length < best_length * (1.0 - 1e-12):
            best, best_length = tour.copy(), length
    return best_length, best


@njit(cache=True)
def _taken_out(near: Ints, contour_of: Ints, tour: Ints, rng: np.random.Generator) -> np.ndarray:
    """Return the mask of contours to take out; at least one stays."""
    m = len(tour)
    count = 2 + int(rng.random() * min(MOST_OUT, m - 2))
    count = min(count, m - 1)
    out = np.zeros(m, dtype=np.bool_)
    place, kind = int(rng.random() * m), int(rng.random() * 3)
    if kind == 0:
        for i in range(count):
            out[contour_of[tour[(place + i) % m]]] = True
    elif kind == 1:
        for k in near[contour_of[tour[place]], :count]:
            out[k] = True
    else:
        for _ in range(count):
            out[int(rng.random() * m)] = True
    return out


@njit(cache=True)
def _rebuilt(lengths: Floats, first: Ints, missing: Ints, kept: Ints) -> Ints:
    """Return the tour with contours put in one by one, each where a node of it lengthens the tour least."""
    size = len(kept)
    tour = np.empty(size + len(missing), dtype=np.int64)
    tour[:size] = kept
    for h in missing:
        best, place, chosen = np.inf, 0, first[h]
        for i in range(size):
            u, w = tour[i - 1] if i > 0 else tour[size - 1], tour[i]
            here = lengths[u, w]
            for v in range(first[h], first[h + 1]):
                more = lengths[u, v] + lengths[v, w] - here
                if more < best:
                    best, place, chosen = more, i, v
        for i in range(size, place, -1):
            tour[i] = tour[i - 1]
        tour[place] = chosen
        size += 1
    return tour


@njit(cache=True)
def _polished(lengths: Floats, first: Ints, contour_of: Ints, tour: Ints) -> Ints:
    """Choose points for the order, and turn runs round, until neither gains."""
    length = _tour_length(lengths, tour)
    while True:
        tour = _best_points(lengths, first, contour_of, tour)
        _turn_runs(lengths, tour)
        now = _tour_length(lengths, tour)
        if now >= length * (1.0 - 1e-12):
            return tour
        length = now


@njit(cache=True)
def _turn_runs(lengths: Floats, tour: Ints) -> None:
    """Turn runs of the tour round while that gains (2-opt), in place."""
    m = len(tour)
    gained = True
    while gained:
        gained = False
        for i in range(m - 2):
            for j in range(i + 2, m if i > 0 else m - 1):
                a, b, c, d = tour[i], tour[i + 1], tour[j], tour[(j + 1) % m]
                old = lengths[a, b] + lengths[c, d]
                if lengths[a, c] + lengths[b, d] < old - 1e-12 * (1.0 + old):
                    tour[i + 1 : j + 1] = tour[i + 1 : j + 1][::-1].copy()
                    gained = True


@njit(cache=True)
def _best_points(lengths: Floats, first: Ints, contour_of: Ints, tour: Ints) -> Ints:
    """Return the shortest tour that passes the contours in the order of ``tour``: layered shortest paths."""
    m = len(tour)
    order = np.array([contour_of[v] for v in tour])
    sizes = first[order + 1] - first[order]
    order = np.roll(order, -np.argmin(sizes))
    best, result = np.inf, tour
    came = np.empty(len(lengths), dtype=np.int64)
    reach = np.empty(len(lengths))
    for start in range(first[order[0]], first[order[0] + 1]):
        for step in range(1, m):
            before, h = order[step - 1], order[step]
            low, high = (start, start + 1) if step == 1 else (first[before], first[before + 1])
            for v in range(first[h], first[h + 1]):
                reach[v] = np.inf
                for u in range(low, high):
                    here = lengths[u, v] + (0.0 if step == 1 else reach[u])
                    if here < reach[v]:
                        reach[v], came[v] = here, u
        total, last = (0.0, start) if m == 1 else (np.inf, start)
        for v in range(first[order[-1]], first[order[-1] + 1]) if m > 1 else range(0):
            if reach[v] + lengths[v, start] < total:
                total, last = reach[v] + lengths[v, start], v
        if total < best:
            best = total
            result = np.empty(m, dtype=np.int64)
            for step in range(m - 1, -1, -1):
                result[step] = last
                last = came[last] if step > 0 else start
    return result
