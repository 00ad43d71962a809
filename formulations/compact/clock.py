"""When contours are cut, for rules between two heads: precedence and clear rapids.

Variable s[i] in 0 .. M: when contour i begins to be cut, s; the heads do not wait (``instances.simulate``).
M is a bound on all starts, M' = M + w_i.

    (clock-first j least)    s[j] - sum_h sum_v (l_home,v / v) x[h,home,v] >= 0
    (clock-first j most)     -s[j] + sum_h sum_v (l_home,v / v) x[h,home,v] - M sum_h y[h,-1,j] >= -M
    (clock i j least)        s[j] - s[i] - sum_h sum_uv (w_i + l_uv / v) x[h,u,v] - M sum_h y[h,i,j] >= -M
    (clock i j most)         s[i] - s[j] + sum_h sum_uv (w_i + l_uv / v) x[h,u,v] - M sum_h y[h,i,j] >= -M
    (late i j)               s[j] - s[i] >= w_i - e                  for a pair; e = what ``check`` forgives
    (late-clear h u v k)     s[k] - s[i] - M' x[h,u,v] >= w_i - w_k - M',   i = C(u), k crossed from u to v

Both kinds of lateness hold within one head too, where p decides (``rules``). (late-clear) lets a contour be
crossed at the very moment at which it is done, which ``check`` does not: the models are a relaxation by such
ties. With a margin on the right sides of both, plans are safe from ties and tolerances, but some are lost.
Big-M rows bound little; they are here to be exact.
"""

from collections.abc import Sequence

import cvxpy as cp
import numpy as np

from cutgap.formulations.compact.family import Family, family
from cutgap.formulations.compact.network import DEPOT, crossed
from cutgap.formulations.compact.variables import HeadVariables
from cutgap.instances import Instance
from cutgap.instances.check import TOLERANCE

Heads = Sequence[HeadVariables]


def latest_time(heads: Heads) -> float:
    """Return a bound on the time of any head, s: all work, and the longest leg out of each contour."""
    instance = heads[0].network.instance
    slowest = 0.0
    for head in heads:
        network = head.network
        tails = np.where(network.closing, DEPOT, network.contour_of[network.tails])
        longest = np.zeros(len(instance.contours) + 1)
        np.maximum.at(longest, tails, network.lengths)
        slowest = max(slowest, float(longest.sum()))
    return slowest / instance.machine.v_jump + float(instance.service_times.sum())


def clock(instance: Instance, start: cp.Variable, heads: Heads, latest_s: float) -> list[Family]:
    """A contour begins to be cut as soon as the head is there from the one before; M is ``latest_s``."""
    pairs = heads[0].way.pairs
    taken = sum(_taken(instance, head) for head in heads)
    goes = sum(head.way.y for head in heads)
    i, j = pairs.tails[pairs.inner], pairs.heads[pairs.inner]
    found = []
    if len(i):
        waits, slack = start[j] - start[i] - taken[pairs.inner], latest_s * (1 - goes[pairs.inner])
        found += _both_sides("clock", pairs.names[pairs.inner], waits + slack, slack - waits)
    first = start - taken[pairs.begin]
    most = latest_s * (1 - goes[pairs.begin]) - first
    names = [(j,) for j in range(len(instance.contours))]
    return found + _both_sides("clock-first", names, first, most)


def _taken(instance: Instance, head: HeadVariables) -> cp.Expression:
    """Return the time from the start of i, or from 0, to that of j if the head goes there; shape (pairs,)."""
    network = head.network
    tails = network.contour_of[network.tails]
    seconds = network.lengths / instance.machine.v_jump
    seconds = seconds + np.where(tails == DEPOT, 0.0, instance.service_times[tails])
    return (network.to_pairs * np.where(network.closing, 0.0, seconds)) @ head.x


def _both_sides(
    name: str, rows: Sequence[tuple[int, ...]], least: cp.Expression, most: cp.Expression
) -> list[Family]:
    return [
        family(name, (), [(*row, side) for row in rows], left >= 0)
        for side, left in (("least", least), ("most", most))
    ]


def late(instance: Instance, start: cp.Variable, latest_s: float, margin_s: float) -> list[Family]:
    """The second contour of a pair begins when the first is done, or ``margin_s`` later."""
    pairs = sorted(set(instance.precedence))
    i, j = np.transpose(pairs)
    least = instance.service_times[i] - TOLERANCE * max(1.0, latest_s) + margin_s
    return [family("late", (), pairs, start[j] - start[i] >= least)]


def late_clear(
    instance: Instance, start: cp.Variable, head: HeadVariables, latest_s: float, margin_s: float
) -> list[Family]:
    """What a rapid crosses is not done when the rapid begins, and not in the next ``margin_s``.

    Without a margin plans with a tie pass, and plans that break the rule by a solver's tolerance.
    """
    names, legs, k, i = crossed(head.network)
    if not names:
        return []
    work = np.array(instance.service_times)
    slack = cp.multiply(latest_s + work[i], 1 - head.x[legs])
    left = start[k] + work[k] - start[i] - work[i] + slack
    return [family("late-clear", (head.way.head,), names, left >= margin_s)]
