"""Tours by position in time: the way is a path through layers, one a position.

Variable w[h,t,i,j] in 0 .. 1: head h goes from contour i at position t to contour j at position t + 1,
t = 1 .. n - 1; w[h,0,-1,j] begins the tour, w[h,t,i,-1] ends it after position t (a single head: t = n only).

    (step h t i)      sum_j w[h,t-1,j,i] - sum_j w[h,t,i,j] = 0            t = 1 .. n, depot included
    (timed h i j)     sum_t w[h,t,i,j] - y[h,i,j] = 0                      depot included

A path through layers may come back to a contour, but not in whole numbers, as each is entered once.

Strength: above the single-commodity flow, and not comparable with subtour elimination in general.

Source: Picard, Queyranne (1978).
"""

import cvxpy as cp
import numpy as np
from scipy.sparse import csr_array

from cutgap.formulations.compact.family import Family, family
from cutgap.formulations.compact.network import DEPOT
from cutgap.formulations.compact.variables import Way
from cutgap.instances.arrays import Ints


def time_indexed(way: Way) -> list[Family]:
    """The way is a path through the positions 1 .. n."""
    pairs, n, head = way.pairs, way.contours, way.head
    times, at = _arcs(way)
    arcs = len(times)
    path = cp.Variable(arcs, name=f"w{head}", bounds=[0, 1])
    i, j = pairs.tails[at], pairs.heads[at]
    # Row (t - 1) n + i of ``step``: what arrives at position t, and what leaves it.
    arrives, leaves = np.flatnonzero(j != DEPOT), np.flatnonzero(i != DEPOT)
    rows = np.concatenate((times[arrives] * n + j[arrives], (times[leaves] - 1) * n + i[leaves]))
    signs = np.concatenate((np.ones(len(arrives)), -np.ones(len(leaves))))
    step = csr_array((signs, (rows, np.concatenate((arrives, leaves)))), shape=(n * n, arcs))
    timed = csr_array((np.ones(arcs), (at, np.arange(arcs))), shape=(len(pairs.tails), arcs))
    layers = [(t, contour) for t in range(1, n + 1) for contour in range(n)]
    return [
        family("step", (head,), layers, step @ path == 0),
        family("timed", (head,), pairs.names, timed @ path - way.y == 0),
    ]


def _arcs(way: Way) -> tuple[Ints, Ints]:
    """Return t and the pair of each w."""
    pairs, n = way.pairs, way.contours
    each = np.arange(len(pairs.tails))
    inner, begin, end = each[pairs.inner], each[pairs.begin], each[pairs.end]
    ends = [n] if way.alone else range(1, n + 1)
    parts = [(0, begin), *((t, inner) for t in range(1, n)), *((t, end) for t in ends)]
    times = np.concatenate([np.full(len(at), t) for t, at in parts])
    return times.astype(np.int64), np.concatenate([at for _, at in parts]).astype(np.int64)
