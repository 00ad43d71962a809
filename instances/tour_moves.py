"""Kernels of the iterated local search over tours; ``tours`` is the door to them.

All changes of a tour are reversals of a run of positions, which are their own inverse: the log of a kick's
reversals, run backwards, undoes it.
"""

from typing import Any, NamedTuple

import numba
import numpy as np
import numpy.typing as npt

from cutgap.instances.arrays import Floats, Ints

LONGEST_KICK = 30
"""Most nodes in each of the two segments that a kick swaps: local kicks repair best."""


class Edges(NamedTuple):
    """What the kernels read: lengths, neighbour lists by row and by column, least gain that counts."""

    lengths: Floats
    outward: Ints
    inward: Ints
    symmetric: bool
    least: float


class State(NamedTuple):
    """The tour, the position of each node in it, and the reversals done since the last kick.

    ``log[0, 0]`` counts them; row r + 1 holds the first position and the number of nodes of reversal r.
    """

    tour: Ints
    position: Ints
    log: Ints


class Queue(NamedTuple):
    """Nodes around which to look for gains, first in first out: a ring with its two ends."""

    nodes: Ints
    waiting: npt.NDArray[np.bool_]
    ends: Ints


@numba.njit(cache=True)
def _push(queue: Queue, node: int) -> None:
    if not queue.waiting[node]:
        queue.waiting[node] = True
        queue.nodes[queue.ends[1]] = node
        queue.ends[1] = (queue.ends[1] + 1) % len(queue.nodes)


@numba.njit(cache=True)
def _pop(queue: Queue) -> int:
    node = queue.nodes[queue.ends[0]]
    queue.ends[0] = (queue.ends[0] + 1) % len(queue.nodes)
    queue.waiting[node] = False
    return node


@numba.njit(cache=True)
def _wrap(place: int, n: int) -> int:
    """Return a position from -n .. 2n - 1 brought into 0 .. n - 1, without the cost of a division."""
    if place >= n:
        return place - n
    return place if place >= 0 else place + n


@numba.njit(cache=True)
def _reverse(state: State, start: int, count: int) -> None:
    """Reverse ``count`` nodes from position ``start`` on (cyclic), and note it: doing it again undoes it."""
    tour, position, log = state
    n = len(tour)
    i, j = start, _wrap(start + count - 1, n)
    for _ in range(count // 2):
        a, b = tour[i], tour[j]
        tour[i], tour[j] = b, a
        position[b], position[a] = i, j
        i = i + 1 if i + 1 < n else 0
        j = j - 1 if j > 0 else n - 1
    if log[0, 0] + 1 < len(log):
        log[0, 0] += 1
        log[log[0, 0], 0], log[log[0, 0], 1] = start, count


@numba.njit(cache=True)
def _undo(state: State) -> None:
    """Take back all logged reversals, last first."""
    count = state.log[0, 0]
    for row in range(count, 0, -1):
        state.log[0, 0] = row  # what the reversal logs itself lands behind the rows still needed
        _reverse(state, state.log[row, 0], state.log[row, 1])
    state.log[0, 0] = 0


@numba.njit(cache=True)
def _exchange(state: State, a: int, b: int, c: int, d: int) -> None:
    """Replace the edges ab and cd by ac and bd, where b follows a and d follows c in one direction."""
    tour, position, _ = state
    n = len(tour)
    if tour[_wrap(position[a] + 1, n)] != b:
        a, b, c, d = b, a, d, c
    inside = _wrap(position[c] - position[b], n) + 1
    if 2 * inside <= n:
        _reverse(state, position[b], inside)
    else:
        _reverse(state, position[d], n - inside)


@numba.njit(cache=True)
def _swap_segments(state: State, start: int, first: int, second: int) -> None:
    """Swap the ``first`` nodes from position ``start`` on with the ``second`` nodes after them.

    Swapping any two of the three parts of a closed tour gives the same tour: leave the longest alone.
    """
    n = len(state.tour)
    third = n - first - second
    if first > second and first > third:
        start, first, second = _wrap(start + first, n), second, third
    elif second > third:
        start, first, second = _wrap(start + first + second, n), third, first
    _reverse(state, start, first)
    _reverse(state, _wrap(start + first, n), second)
    _reverse(state, start, first + second)


@numba.njit(cache=True)
def _try_two_opt(edges: Edges, state: State, queue: Queue, a: int) -> float:
    """Do the first improving 2-opt move that links ``a`` to a neighbour; return its gain, 0 without one."""
    lengths, (tour, position, _) = edges.lengths, state
    n = len(tour)
    for step in (1, n - 1):
        b = tour[_wrap(position[a] + step, n)]
        for rank in range(edges.outward.shape[1]):
            c = edges.outward[a, rank]
            partial = lengths[a, b] - lengths[a, c]
            if partial <= edges.least:
                break
            d = tour[_wrap(position[c] + step, n)]
            gain = partial + lengths[c, d] - lengths[b, d]
            if gain > edges.least and d != a:
                _exchange(state, a, b, c, d)
                for node in (a, b, c, d):
                    _push(queue, node)
                return gain
    return 0.0


@numba.njit(cache=True)
def _try_or_opt(edges: Edges, state: State, queue: Queue, a: int) -> float:
    """Do the first improving move of a segment of 1 to 3 nodes ending in ``a``; return its gain or 0."""
    for count in range(1, min(3, len(state.tour) - 3) + 1):
        gain = _try_segment(edges, state, queue, a, state.position[a], count)
        if gain == 0.0 and count > 1:
            gain = _try_segment(edges, state, queue, a, state.position[a] - count + 1, count)
        if gain > 0.0:
            return gain
    return 0.0


@numba.njit(cache=True)
def _try_segment(edges: Edges, state: State, queue: Queue, a: int, start: int, count: int) -> float:
    """Move the segment of ``count`` nodes from ``start`` on so that its end ``a`` meets a neighbour."""
    lengths, (tour, position, _) = edges.lengths, state
    n = len(tour)
    head, tail = tour[_wrap(start, n)], tour[_wrap(start + count - 1, n)]
    before, after = tour[_wrap(start - 1, n)], tour[_wrap(start + count, n)]
    other = tail if a == head else head
    freed = lengths[before, head] + lengths[tail, after] - lengths[before, after]
    for rank in range(edges.outward.shape[1]):
        b = edges.outward[a, rank]
        partial = freed - lengths[a, b]
        if partial <= edges.least:
            break
        for step in (1, n - 1):
            c = tour[_wrap(position[b] + step, n)]
            if _wrap(position[b] - start, n) < count or _wrap(position[c] - start, n) < count:
                continue
            gain = partial + lengths[b, c] - lengths[other, c]
            if gain > edges.least:
                # Walking on from the segment one meets left, then right, wherever the edge bc is.
                left, right = (b, c) if step == 1 else (c, b)
                _exchange(state, before, head, left, right)
                _exchange(state, before, left, after, tail)
                if (a == head) == (step == 1):  # the segment keeps its direction
                    _exchange(state, left, tail, head, right)
                for node in (before, after, b, c, a, other):
                    _push(queue, node)
                return gain
    return 0.0


@numba.njit(cache=True)
def _try_swap(edges: Edges, state: State, queue: Queue, a: int) -> float:
    """Do the first improving move a b..e c..f g -> a c..f b..e g (or-3opt); return its gain or 0."""
    lengths, (tour, position, _) = edges.lengths, state
    n = len(tour)
    b = tour[_wrap(position[a] + 1, n)]
    for c in edges.outward[a]:
        first_partial = lengths[a, b] - lengths[a, c]
        if first_partial <= edges.least:
            break
        first = _wrap(position[c] - position[b], n)
        e = tour[_wrap(position[c] - 1, n)]
        for f in edges.inward[b]:
            partial = first_partial + lengths[e, c] - lengths[f, b]
            if partial <= edges.least:
                break
            second = _wrap(position[f] - position[c], n) + 1
            if f == a or first + second >= n:
                continue
            g = tour[_wrap(position[f] + 1, n)]
            gain = partial + lengths[f, g] - lengths[e, g]
            if gain > edges.least:
                _swap_segments(state, position[b], first, second)
                for node in (a, b, c, e, f, g):
                    _push(queue, node)
                return gain
    return 0.0


@numba.njit(cache=True)
def _descend(edges: Edges, state: State, queue: Queue, logged: bool) -> float:
    """Improve around the queued nodes until none is left; return the total gain.

    With ``logged`` it stops early rather than lose a reversal from the log.
    """
    total = 0.0
    while queue.ends[0] != queue.ends[1]:
        a = _pop(queue)
        gain = 1.0
        while gain > 0.0 and not (logged and state.log[0, 0] + 4 >= len(state.log)):
            if edges.symmetric:
                gain = _try_two_opt(edges, state, queue, a)
                if gain == 0.0:
                    gain = _try_or_opt(edges, state, queue, a)
            else:
                gain = _try_swap(edges, state, queue, a)
            total += gain
    return total


@numba.njit(cache=True)
def _kick(edges: Edges, state: State, queue: Queue, rng: Any) -> float:
    """Swap two short neighbouring segments at a random place; return the (mostly negative) gain."""
    lengths, tour = edges.lengths, state.tour
    n = len(tour)
    longest = min(LONGEST_KICK, (n - 1) // 3)
    start = int(rng.random() * n)
    first, second = 1 + int(rng.random() * longest), 1 + int(rng.random() * longest)
    a, b = tour[_wrap(start - 1, n)], tour[start]
    e, c = tour[_wrap(start + first - 1, n)], tour[_wrap(start + first, n)]
    f, g = tour[_wrap(start + first + second - 1, n)], tour[_wrap(start + first + second, n)]
    _swap_segments(state, start, first, second)
    for node in (a, b, c, e, f, g):
        _push(queue, node)
    removed = lengths[a, b] + lengths[e, c] + lengths[f, g]
    return removed - lengths[a, c] - lengths[f, b] - lengths[e, g]


@numba.njit(cache=True)
def iterate(edges: Edges, state: State, queue: Queue, kicks: int, rng: Any) -> None:
    """Improve the tour in place: local search from every node, then kicks, each kept unless it ends worse."""
    for node in state.tour:
        _push(queue, node)
    _descend(edges, state, queue, False)
    for _ in range(kicks):
        state.log[0, 0] = 0
        gain = _kick(edges, state, queue, rng)
        gain += _descend(edges, state, queue, True)
        if gain < -edges.least:
            _undo(state)
