"""Tours by flows: a contour that is cut takes up something that only the depot gives.

Indices i, j run over contours and the depot, n is the number of contours.

One commodity: f[h,i,j] in 0 .. n is what head h still has to leave on its way from i to j; nothing goes back.

    (flow-keep h j)           sum_i f[h,i,j] - sum_i f[h,j,i] - z[h,j] = 0
    (flow-most h i j)         (n - 1) y[h,i,j] - f[h,i,j] >= 0,   from the depot n y[h,-1,j] - f[h,-1,j] >= 0

Two commodities: f as above is the load, g[h,i,j] the space that was made; a single head leaves with all of the
one and none of the other, and comes back with the opposite.

    (load-keep h j)           sum_i f[h,i,j] - sum_i f[h,j,i] - z[h,j] = 0
    (space-keep h j)          sum_i g[h,j,i] - sum_i g[h,i,j] - z[h,j] = 0
    (load-and-space h i j)    f[h,i,j] + g[h,i,j] - n y[h,i,j] = 0          one head: f[i,-1] = 0, g[-1,j] = 0

A commodity for each contour k: f[h,k,i,j] in 0 .. 1, nothing goes back to the depot.

    (to-sink h k)             sum_i f[h,k,i,k] - sum_i f[h,k,k,i] - z[h,k] = 0
    (through h k j)           sum_i f[h,k,i,j] - sum_i f[h,k,j,i] = 0        j != k
    (flow-within h k i j)     y[h,i,j] - f[h,k,i,j] >= 0

Strength: multi-commodity = dfj, as a maximum flow is a minimum cut; single-commodity >= two-commodity >= mtz,
and the first two are equal with n in place of n - 1 in (flow-most).

Source: Gavish, Graves (1978); Finke, Claus, Gunn (1984); Claus (1984). Compared by Langevin, Soumis, Desrosiers
(1990) and by Padberg, Sung (1991).
"""

import cvxpy as cp
import numpy as np
from scipy.sparse import block_array, eye_array, kron

from cutgap.formulations.compact.family import Family, family
from cutgap.formulations.compact.network import Pairs
from cutgap.formulations.compact.variables import Way


def single_commodity(way: Way) -> list[Family]:
    """One flow from the depot, of which each contour keeps one unit."""
    pairs, n, head = way.pairs, way.contours, way.head
    outward = slice(0, pairs.end.start)
    flow = cp.Variable(outward.stop, name=f"f{head}", bounds=[0, n])
    most = np.full(outward.stop, n - 1.0)
    most[pairs.begin] = n
    return [
        family("flow-keep", (head,), range(n), _kept(pairs, outward) @ flow - way.z == 0),
        family("flow-most", (head,), pairs.names[outward], cp.multiply(most, way.y[outward]) - flow >= 0),
    ]


def two_commodity(way: Way) -> list[Family]:
    """A load that shrinks by one at each contour and a space that grows by one."""
    pairs, n, head = way.pairs, way.contours, way.head
    load_most, space_most = np.full(len(pairs.tails), float(n)), np.full(len(pairs.tails), float(n))
    if way.alone:
        load_most[pairs.end] = space_most[pairs.begin] = 0.0
    load = cp.Variable(len(load_most), name=f"f{head}", bounds=[np.zeros(len(load_most)), load_most])
    space = cp.Variable(len(load_most), name=f"g{head}", bounds=[np.zeros(len(load_most)), space_most])
    kept = _kept(pairs, slice(0, len(load_most)))
    return [
        family("load-keep", (head,), range(n), kept @ load - way.z == 0),
        family("space-keep", (head,), range(n), -(kept @ space) - way.z == 0),
        family("load-and-space", (head,), pairs.names, load + space - n * way.y == 0),
    ]


def multi_commodity(way: Way) -> list[Family]:
    """For each contour that is cut, a unit that goes there from the depot along the way."""
    pairs, n, head = way.pairs, way.contours, way.head
    outward = slice(0, pairs.end.start)
    flow = cp.Variable(n * outward.stop, name=f"f{head}", bounds=[0, 1])
    kept = kron(eye_array(n), _kept(pairs, outward)).tocsr() @ flow
    sink, at = np.divmod(np.arange(n * n), n)
    found = [family("to-sink", (head,), range(n), kept[np.flatnonzero(sink == at)] - way.z == 0)]
    passing = np.flatnonzero(sink != at)
    if len(passing):
        names = list(zip(sink[passing].tolist(), at[passing].tolist(), strict=True))
        found.append(family("through", (head,), names, kept[passing] == 0))
    copies = block_array([[eye_array(outward.stop)]] * n).tocsr() @ way.y[outward]
    within = [(k, *pair) for k in range(n) for pair in pairs.names[outward]]
    return [*found, family("flow-within", (head,), within, copies - flow >= 0)]


def _kept(pairs: Pairs, used: slice) -> np.ndarray:
    """Return the matrix of what stays of a flow on the pairs ``used``, shape (contours, used)."""
    return (pairs.into - pairs.out_of)[:, used]
