r"""The two passes of the relaxed dynamic programme, position by position (numba).

    k          position in the walk, 0..n-1;  P_k  the points allowed at it
    p_a        price of a visit to contour a; a walk that visits each contour once pays sum p        [mm]
    (1) B_k(v) = min over w in P_(k+1), step not closed, of  c_vw + p_(contour of w) + B_(k+1)(w);  B_(n-1) = t
    (2) F_k(v, M) = least s + sum c + sum p of a walk to v at position k that remembers M there
    (3) a state is dropped when F_k(v, M) + B_k(v) >= limit: no walk below the limit goes through it

Walks of n visits without memory (1), or with it (2), contain all walks that visit each contour once, so
min F_(n-1) + t - sum p is a lower bound on these, whatever the prices.

Source: Christofides, Mingozzi, Toth (1981), state-space relaxation; prices by Lagrange.
"""

import numpy as np
from numba import njit

from cutgap.instances.arrays import Floats, Ints


@njit(cache=True)
def backward_pass(
    costs: Floats, end: Floats, prices: Floats, first: Ints, closed: np.ndarray, allowed: np.ndarray
) -> Floats:
    """Return B of (1), shape (n, points); infinite where a point is not allowed at a position."""
    count, points = len(prices), len(end)
    value = np.full((count, points), np.inf)
    for v in range(points):
        if allowed[count - 1, v]:
            value[count - 1, v] = end[v]
    onward = np.empty(points)
    for k in range(count - 2, -1, -1):
        for b in range(count):
            for w in range(first[b], first[b + 1]):
                onward[w] = value[k + 1, w] + prices[b]
        for a in range(count):
            for b in range(count):
                if closed[a, b]:
                    continue
                for v in range(first[a], first[a + 1]):
                    if not allowed[k, v]:
                        continue
                    least = value[k, v]
                    for w in range(first[b], first[b + 1]):
                        least = min(least, costs[v, w] + onward[w])
                    value[k, v] = least
    return value


@njit(cache=True)
def forward_pass(
    costs: Floats,
    start: Floats,
    prices: Floats,
    first: Ints,
    following: Ints,
    offset: Ints,
    crossed: Ints,
    completion: Floats,
    limit: float,
) -> Floats:
    """Return F of (2) with (3) at each position, shape (n, states); dropped states are infinite.

    The state of point v of contour a with memory M is number offset[a] + M * points of a + place of v in a.
    """
    count = len(prices)
    value = np.full((count, offset[-1]), np.inf)
    for a in range(count):
        for v in range(first[a], first[a + 1]):
            value[0, offset[a] + v - first[a]] = start[v] + prices[a]
    _drop(value[0], first, offset, completion[0], limit)
    for k in range(count - 1):
        for a in range(count):
            size = first[a + 1] - first[a]
            for memory in range((offset[a + 1] - offset[a]) // size):
                low = offset[a] + memory * size
                row = value[k, low : low + size]
                if row.min() < np.inf:
                    _extend(costs, prices, first, following, offset, crossed, row, a, memory, value[k + 1])
        _drop(value[k + 1], first, offset, completion[k + 1], limit)
    return value


@njit(cache=True)
def _extend(
    costs: Floats,
    prices: Floats,
    first: Ints,
    following: Ints,
    offset: Ints,
    crossed: Ints,
    row: Floats,
    a: int,
    memory: int,
    layer: Floats,
) -> None:
    """Take all steps from the points of contour ``a`` with one memory into the next layer."""
    for b in range(len(prices)):
        after = following[a, b, memory]
        if after < 0:
            continue
        size = first[b + 1] - first[b]
        low = offset[b] + after * size
        target = layer[low : low + size]
        for i in range(len(row)):
            here = row[i] + prices[b]
            if here == np.inf:
                continue
            v = first[a] + i
            leg = costs[v, first[b] : first[b + 1]]
            if len(crossed) == 0:
                for j in range(size):
                    target[j] = min(target[j], here + leg[j])
            else:
                barred = crossed[v, first[b] : first[b + 1]]
                for j in range(size):
                    if barred[j] & memory == 0:
                        target[j] = min(target[j], here + leg[j])


@njit(cache=True)
def _drop(layer: Floats, first: Ints, offset: Ints, completion: Floats, limit: float) -> None:
    """Drop states by (3)."""
    for a in range(len(first) - 1):
        size = first[a + 1] - first[a]
        for low in range(offset[a], offset[a + 1], size):
            for i in range(size):
                if not layer[low + i] + completion[first[a] + i] < limit:
                    layer[low + i] = np.inf


@njit(cache=True)
def best_walk(
    costs: Floats,
    end: Floats,
    prices: Floats,
    first: Ints,
    following: Ints,
    offset: Ints,
    crossed: Ints,
    value: Floats,
) -> tuple[float, Ints]:
    """Return the least F_(n-1) + t and the points of a walk that has it; infinite when no state is left."""
    count = len(prices)
    walk = np.zeros(count, dtype=np.int64)
    best, a, memory = np.inf, -1, 0
    for b in range(count):
        size = first[b + 1] - first[b]
        for state in range((offset[b + 1] - offset[b]) // size):
            for i in range(size):
                total = value[count - 1, offset[b] + state * size + i] + end[first[b] + i]
                if total < best:
                    best, a, memory, walk[count - 1] = total, b, state, first[b] + i
    if a < 0:
        return best, walk
    for k in range(count - 2, -1, -1):
        a, memory = _step_back(costs, prices, first, following, offset, crossed, value, walk, k, a, memory)
    return best, walk


@njit(cache=True)
def _step_back(
    costs: Floats,
    prices: Floats,
    first: Ints,
    following: Ints,
    offset: Ints,
    crossed: Ints,
    value: Floats,
    walk: Ints,
    k: int,
    b: int,
    after: int,
) -> tuple[int, int]:
    """Set ``walk[k]`` to where the state at position k + 1 was reached from; return its contour and memory."""
    w = walk[k + 1]
    best, a, memory = np.inf, -1, 0
    for c in range(len(prices)):
        size = first[c + 1] - first[c]
        for state in range((offset[c + 1] - offset[c]) // size):
            if following[c, b, state] != after:
                continue
            for i in range(size):
                v = first[c] + i
                if len(crossed) > 0 and crossed[v, w] & state != 0:
                    continue
                total = value[k, offset[c] + state * size + i] + prices[b] + costs[v, w]
                if total < best:
                    best, a, memory, walk[k] = total, c, state, v
    return a, memory
