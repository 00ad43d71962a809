"""The problem, whatever keeps a tour in one piece: who cuts what, where it is entered, and what it costs.

    min  makespan,   or   sum d_uv x[h,u,v] + sum l_uv c[h,u,v]  (+ weight * imbalance)
    (cut-once i)             sum_h z[h,i] = 1
    (continuity h u)         entering u - leaving u = 0
    (leave-once h)           -sum_j y[h,-1,j] >= -1,   or  sum_j y[h,-1,j] = 1 when every head has work
    (makespan h)             makespan - T[h] >= 0
    (imbalance h other)      imbalance - T[h] + T[other] >= 0
    (balance h other)        T[other] - T[h] >= -(balance + e),   e = what ``check`` forgives
    (apart u v)              -q[0,u] - q[1,v] >= -1               where x_v - x_u < F, C(u) != C(v)
    (via h u v)              -first[h,u] - q[h,v] >= -1           where x_v < x_u, C(u) != C(v)

Source: the 2TSP of Wang et al. (2025); (via) is their way to begin at the leftmost hole, for entry points.
"""

from collections.abc import Sequence

import cvxpy as cp
import numpy as np

from cutgap.formulations.compact.family import Family, family
from cutgap.formulations.compact.network import contours_of_nodes
from cutgap.formulations.compact.variables import HeadVariables
from cutgap.instances import Instance, Rules
from cutgap.instances.arrays import Ints, difference
from cutgap.instances.check import TOLERANCE

Heads = Sequence[HeadVariables]


def cut_once(heads: Heads) -> list[Family]:
    """Each contour is cut once."""
    total = sum(head.way.z for head in heads)
    return [family("cut-once", (), range(heads[0].way.contours), total == 1)]


def continuity(head: HeadVariables) -> list[Family]:
    """A head leaves an entry point as often as it enters it."""
    balance = (head.network.into - head.network.out_of) @ head.x
    return [family("continuity", (head.way.head,), range(balance.size), balance == 0)]


def leave_once(instance: Instance, rules: Rules, heads: Heads) -> list[Family]:
    """A head begins one tour at most, or exactly one when it must have work."""
    begun = cp.hstack([cp.sum(head.way.y[head.way.pairs.begin]) for head in heads])
    may_rest = rules.empty_heads or len(instance.contours) < len(heads)
    return [family("leave-once", (), range(len(heads)), -begun >= -1 if may_rest else begun == 1)]


def makespan(latest: cp.Variable, heads: Heads) -> list[Family]:
    """The makespan is no less than any head's time."""
    times = cp.hstack([head.time for head in heads])
    return [family("makespan", (), range(len(heads)), latest - times >= 0)]


def imbalance(apart: cp.Variable, heads: Heads) -> list[Family]:
    """The imbalance is no less than either difference of times."""
    one, other = heads[0].time, heads[1].time
    left = apart + cp.hstack([other - one, one - other])
    return [family("imbalance", (), [(0, 1), (1, 0)], left >= 0)]


def balance(limit: float, heads: Heads, latest_s: float) -> list[Family]:
    """The heads' times differ by no more than the limit; ``latest_s`` is a bound on the makespan."""
    one, other = heads[0].time, heads[1].time
    forgiven = TOLERANCE * max(1.0, latest_s)
    left = cp.hstack([other - one, one - other])
    return [family("balance", (), [(0, 1), (1, 0)], left >= -(limit + forgiven))]


def apart(instance: Instance, gap: float, heads: Heads) -> list[Family]:
    """Entry points of the left head lie at least the gap to the left of the right head's."""
    of, xs = _of_and_x(instance)
    # Floats settle all but pairs whose distance is the gap to the last digits.
    near = (xs - xs[:, None] < gap + 1e-6 * max(1.0, gap, float(np.abs(xs).max()))) & (of != of[:, None])
    pairs = [(u, v) for u, v in np.argwhere(near).tolist() if difference(xs[u], xs[v]) < gap]
    if not pairs:
        return []
    u, v = np.transpose(pairs)
    return [family("apart", (), pairs, -heads[0].q[u] - heads[1].q[v] >= -1)]


def via(instance: Instance, head: HeadVariables) -> list[Family]:
    """A head that begins at an entry point has none to the left of it."""
    of, xs = _of_and_x(instance)
    pairs = np.argwhere((xs < xs[:, None]) & (of != of[:, None]))
    if not len(pairs):
        return []
    left = -head.first[pairs[:, 0]] - head.q[pairs[:, 1]]
    return [family("via", (head.way.head,), map(tuple, pairs.tolist()), left >= -1)]


def _of_and_x(instance: Instance) -> tuple[Ints, np.ndarray]:
    """Return contour and x of each entry point."""
    points = int(instance.first_node[-1])
    return contours_of_nodes(instance)[:points], instance.points[:points, 0]
