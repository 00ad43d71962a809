"""Good closed tours over a matrix of lengths, fast: iterated local search for heuristics and warm starts.

Local search by 2-opt and Or-opt (segments of 1 to 3 nodes, either way round) on neighbour lists with a queue
of nodes to look at (Bentley, 1992); asymmetric lengths use the swap of two neighbouring segments instead
(or-3opt), which keeps the direction of travel. A kick swaps two short neighbouring segments at a random place
and repairs around it; one that ends worse is undone, at a cost that does not grow with the rest of the tour.

Lengths may be negative: an edge of -1e6 is an edge that stays, once the tour has it.
"""

import numba
import numpy as np

from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.tour_moves import Edges, Queue, State, iterate

NEIGHBOURS = 8
"""Candidates per node; more cost time and gain little on points in the plane or in space."""

MOST_REVERSALS = 4096
"""Reversals remembered per kick; a repair that needs more is cut short (tens are usual)."""


def tour_length(lengths: Floats, tour: Ints) -> float:
    """Return the length of the closed tour: the sum of ``lengths[tour[i], tour[i + 1]]``, cyclic."""
    if len(tour) < 2:
        return 0.0
    return float(lengths[tour, np.roll(tour, -1)].sum())


def nearest_neighbour_tour(lengths: Floats, start: int = 0) -> Ints:
    """Return the tour that always goes on to the nearest node left, shape (n,); ties by lowest number."""
    n = len(lengths)
    if n == 0:
        return np.empty(0, dtype=np.int64)
    if not 0 <= start < n:
        raise ValueError(f"start: expected a node of 0..{n - 1}, got {start}")
    return _nearest_neighbour(np.ascontiguousarray(lengths, dtype=np.float64), start)


def improve_tour(lengths: Floats, tour: Ints, kicks: int, seed: int) -> Ints:
    """Return a tour at most as long as ``tour``, by local search and then ``kicks`` perturbations.

    Parameters
    ----------
    lengths
        Shape (n, n), any finite numbers; the diagonal is ignored.
    tour
        Shape (n,): each node 0..n-1 once; it is not changed.
    kicks
        Number of perturbations, 0 for local search alone. One costs microseconds.
    seed
        The same seed gives the same tour.

    Raises
    ------
    ValueError
        When the tour is no permutation of the nodes or a length is not finite.
    """
    lengths = np.ascontiguousarray(lengths, dtype=np.float64)
    tour = np.array(tour, dtype=np.int64)
    n = len(lengths)
    if lengths.shape != (n, n):
        raise ValueError(f"lengths: expected a square matrix, got shape {lengths.shape}")
    if not np.isfinite(lengths).all():
        raise ValueError("lengths: expected finite numbers")
    if tour.shape != (n,) or not np.array_equal(np.sort(tour), np.arange(n)):
        raise ValueError(f"tour: expected each of {n} nodes once")
    if n <= 3:
        return _best_of_both_ways(lengths, tour)
    scale = float(np.abs(lengths).max())
    symmetric = bool(np.abs(lengths - lengths.T).max() <= 1e-12 * scale)
    outward = neighbour_lists(lengths)
    inward = outward if symmetric else neighbour_lists(lengths.T)
    # Far above the rounding of a gain, which is a sum of at most six lengths, and far below any real gain.
    least_gain = 1e-13 * scale
    state = State(tour, np.argsort(tour), np.zeros((MOST_REVERSALS, 2), dtype=np.int64))
    queue = Queue(np.empty(n + 1, dtype=np.int64), np.zeros(n, dtype=np.bool_), np.zeros(2, dtype=np.int64))
    edges = Edges(lengths, outward, inward, symmetric, least_gain)
    iterate(edges, state, queue, kicks, np.random.default_rng(seed))
    return tour


def _best_of_both_ways(lengths: Floats, tour: Ints) -> Ints:
    back = tour[::-1].copy()
    return back if tour_length(lengths, back) < tour_length(lengths, tour) else tour


def neighbour_lists(lengths: Floats, size: int = NEIGHBOURS) -> Ints:
    """Return the ``size`` nearest other nodes of each node by row, nearest first, shape (n, size)."""
    n = len(lengths)
    size = min(size, n - 1)
    others = np.array(lengths)
    np.fill_diagonal(others, np.inf)
    if size == n - 1:
        return np.argsort(others, axis=1, kind="stable")[:, :size].astype(np.int64)
    nearest = np.argpartition(others, size, axis=1)[:, :size]
    order = np.argsort(np.take_along_axis(others, nearest, axis=1), axis=1, kind="stable")
    return np.ascontiguousarray(np.take_along_axis(nearest, order, axis=1), dtype=np.int64)


@numba.njit(cache=True)
def _nearest_neighbour(lengths: Floats, start: int) -> Ints:
    n = len(lengths)
    tour = np.empty(n, np.int64)
    left = np.ones(n, np.bool_)
    here = start
    for step in range(n):
        tour[step] = here
        left[here] = False
        nearest = -1
        for node in range(n):
            if left[node] and (nearest < 0 or lengths[here, node] < lengths[here, nearest]):
                nearest = node
        here = nearest
    return tour
