r"""Depth-first branch and bound over order and start points, kept in arrays so that it can pause (numba).

    node       points v_1 .. v_d with the exact times and rises of (1) in ``plates``; S what they cut
    (1) bound on travel  = travel so far + R(S, v_d)
    (2) bound on peak    = max(largest rise so far, C(S, v_d))
    (3) ahead  each contour c that is left is started at one of its points p, at a time t with
               now + reach(v_d, p) <= t <= now + work on all that is left but c + ways,
               so its rise is at least  min over p of  sum over j in S of the least T(L_pj, t - e_j)
    (4) last   some contour c that is left comes last, at p, so that some rise is at least the least, over c and
    p,
               of  sum over j in S of the least T(L_pj, t - e_j) + tail(left - c, p),
               now + work on all that is left but c + shortest ways in <= t <= the same with the longest ways in

R and C are those of ``tables``; tail(X, p) = min over v of warm(v, p, X - v's contour). reach is the closure of
the times of ways, which is at most the time of any chain of steps. In (3) and (4) ways take at most the sum of
the longest ways into the contours that are left, and at most what the limit on travel leaves. A node is cut off
when (1) exceeds the limit on travel, one of (2) to (4) exceeds the cap, or the objective's bound is not below
the best value. All are lower bounds on every plan below the node, so no better plan is lost. Limits carry a
slack, of more than rounding, in the direction that keeps plans.

Children are taken in the order of the objective's bound, so that the next child of each level on the stack
bounds all that is still open there.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from cutgap.formulations.heat.plates import Plate, least_warmth, may_come, warmth
from cutgap.formulations.heat.tables import warm_of, ways_into
from cutgap.instances.arrays import Floats, Ints

DONE, FOUND, PAUSED = 0, 1, 2
TRAVEL, PEAK = 0, 1
ROUNDING = 1e-9
"""Relative slack of times."""
ENDLESS = 1e300
"""Stands for an infinite rise where one is an objective, K: below no best value at all, which is infinite."""


class Bounds(NamedTuple):
    """Tables for (1) to (4): R, C, tail, reach, the shortest and the longest way into each contour."""

    travel: Floats
    peak: Floats
    tail: Floats
    reach: Floats
    least: Floats
    most: Floats


class Limits(NamedTuple):
    """Most travel and rise allowed (mm, K), v_jump (mm/s) and the objective, ``TRAVEL`` or ``PEAK``."""

    travel: float
    rise: float
    speed: float
    objective: int


class Stack(NamedTuple):
    """The path to the node at hand and the children left on it; n + 1 rows, ``depth`` has one entry."""

    depth: Ints
    order: Ints
    cut: Ints
    end: Floats
    travel: Floats
    peak: Floats
    kids: Ints
    keys: Floats
    kid_rise: Floats
    kid_count: Ints
    next_kid: Ints


def new_stack(count: int, points: int) -> Stack:
    """Return an empty stack for so many contours and points."""
    rows = count + 1
    return Stack(
        depth=np.zeros(1, dtype=np.int64),
        order=np.zeros(rows, dtype=np.int64),
        cut=np.zeros(rows, dtype=np.int64),
        end=np.zeros(rows),
        travel=np.zeros(rows),
        peak=np.zeros(rows),
        kids=np.zeros((rows, points), dtype=np.int64),
        keys=np.zeros((rows, points)),
        kid_rise=np.zeros((rows, points)),
        kid_count=np.zeros(rows, dtype=np.int64),
        next_kid=np.zeros(rows, dtype=np.int64),
    )


@njit(cache=True)
def tail_table(plate: Plate, warm: np.ndarray) -> Floats:
    """Return tail(X, p), shape (2^n, points); 0 for the empty set."""
    count, points = len(plate.service), len(plate.contour_of)
    table = np.full((1 << count, points), np.inf)
    table[0] = 0.0
    for cut in range(1, 1 << count):
        for w in range(points):
            if not cut >> plate.contour_of[w] & 1:
                for v in range(points):
                    if cut >> plate.contour_of[v] & 1 and plate.cost[v, w] < np.inf:
                        table[cut, w] = min(table[cut, w], warm_of(warm, plate, v, w, cut))
    return table


def bounds_of(plate: Plate, travel: Floats, peak: Floats, warm: np.ndarray) -> Bounds:
    """Return the tables that the search uses."""
    reach = np.array(plate.time)
    for middle in range(len(reach)):
        reach = np.minimum(reach, reach[:, middle, None] + reach[middle])
    least, most = ways_into(plate)
    return Bounds(travel, peak, tail_table(plate, warm), reach * (1.0 - ROUNDING), least, most)


@njit(cache=True)
def begin(plate: Plate, bounds: Bounds, limits: Limits, stack: Stack, first: int) -> None:
    """Put the first steps on the stack: to all points, or to ``first`` alone when it is not negative."""
    stack.depth[0] = 0
    stack.kid_count[:] = 0
    stack.next_kid[:] = 0
    for w in range(len(plate.contour_of)):
        if (first < 0 or w == first) and plate.before[plate.contour_of[w]] == 0:
            cut = 1 << plate.contour_of[w]
            travel, peak = plate.out[w] + bounds.travel[cut, w], bounds.peak[cut, w]
            if travel <= limits.travel and peak <= limits.rise:
                _insert(stack, 0, w, travel if limits.objective == TRAVEL else min(peak, ENDLESS), 0.0)


@njit(cache=True)
def _insert(stack: Stack, depth: int, w: int, key: float, rise: float) -> None:
    """Put a child into its place by ascending bound."""
    place = stack.kid_count[depth]
    keys, kids, rises = stack.keys[depth], stack.kids[depth], stack.kid_rise[depth]
    while place > 0 and keys[place - 1] > key:
        keys[place], kids[place], rises[place] = keys[place - 1], kids[place - 1], rises[place - 1]
        place -= 1
    keys[place], kids[place], rises[place] = key, w, rise
    stack.kid_count[depth] += 1


@njit(cache=True)
def advance(plate: Plate, bounds: Bounds, limits: Limits, stack: Stack, best: float, nodes: int) -> int:
    """Go on for so many nodes, looking for a plan whose objective is below ``best``.

    Returns
    -------
    int
        ``FOUND`` with such a plan in ``stack.order``, ``PAUSED``, or ``DONE`` when nothing is left.
    """
    count = len(plate.service)
    for _ in range(nodes):
        d = stack.depth[0]
        while stack.next_kid[d] >= stack.kid_count[d] or stack.keys[d, stack.next_kid[d]] >= best:
            stack.kid_count[d] = stack.next_kid[d] = 0
            if d == 0:
                return DONE
            d -= 1
        k = stack.next_kid[d]
        stack.next_kid[d] += 1
        _place(plate, stack, d, stack.kids[d, k], stack.kid_rise[d, k])
        stack.depth[0] = d + 1
        if d + 1 == count:
            return FOUND
        _expand(plate, bounds, limits, stack, d + 1, best)
    return PAUSED


@njit(cache=True)
def _place(plate: Plate, stack: Stack, d: int, w: int, rise: float) -> None:
    """Make point w number d of the path."""
    b = plate.contour_of[w]
    if d == 0:
        stack.cut[0] = 1 << b
        stack.end[0], stack.travel[0], stack.peak[0] = plate.service[b], plate.out[w], 0.0
    else:
        v = stack.order[d - 1]
        stack.cut[d] = stack.cut[d - 1] | 1 << b
        stack.end[d] = stack.end[d - 1] + plate.time[v, w] + plate.service[b]
        stack.travel[d] = stack.travel[d - 1] + plate.cost[v, w]
        stack.peak[d] = max(stack.peak[d - 1], rise)
    stack.order[d] = w
    stack.kid_count[d + 1] = stack.next_kid[d + 1] = 0


@njit(cache=True)
def _expand(plate: Plate, bounds: Bounds, limits: Limits, stack: Stack, d: int, best: float) -> None:
    """Put the children of the path of d points on the stack."""
    v, cut, now = stack.order[d - 1], stack.cut[d - 1], stack.end[d - 1]
    by_travel = limits.objective == TRAVEL
    rise_limit = limits.rise if by_travel else min(limits.rise, best)
    travel_limit = min(limits.travel, best) if by_travel else limits.travel
    if _is_hopeless(plate, bounds, stack, d, rise_limit, (travel_limit - stack.travel[d - 1]) / limits.speed):
        return
    for w in range(len(plate.contour_of)):
        if not may_come(plate, cut, v, w):
            continue
        after = cut | 1 << plate.contour_of[w]
        travel = stack.travel[d - 1] + plate.cost[v, w] + bounds.travel[after, w]
        peak = max(stack.peak[d - 1], bounds.peak[after, w])
        if travel > travel_limit or peak > rise_limit:
            continue
        start, rise = now + plate.time[v, w], 0.0
        for j in range(d):
            a = plate.contour_of[stack.order[j]]
            rise += warmth(plate.constant, plate.spread, plate.distance[w, a], start - stack.end[j])
        if rise <= rise_limit:
            _insert(stack, d, w, travel if by_travel else min(max(peak, rise), ENDLESS), rise)


@njit(cache=True)
def _is_hopeless(plate: Plate, bounds: Bounds, stack: Stack, d: int, limit: float, room: float) -> bool:
    """Whether (3) or (4) exceeds a limit, when ways may take ``room`` s more."""
    v, cut, now = stack.order[d - 1], stack.cut[d - 1], stack.end[d - 1]
    count = len(plate.service)
    work, short, long = 0.0, 0.0, 0.0
    for c in range(count):
        if not cut >> c & 1:
            work, short, long = work + plate.service[c], short + bounds.least[c], long + bounds.most[c]
    long = min(long, room) * (1.0 + ROUNDING)
    short *= 1.0 - ROUNDING
    full, someone_last = (1 << count) - 1, False
    for c in range(count):
        if cut >> c & 1:
            continue
        latest = now + work - plate.service[c] + long
        last = now + work - plate.service[c] + short
        can_start = False
        for p in range(plate.first[c], plate.first[c + 1]):
            soonest = now + bounds.reach[v, p]
            can_start = can_start or _least_rise(plate, stack, d, p, soonest, latest, limit) <= limit
            if not someone_last:
                tail = bounds.tail[full ^ cut ^ 1 << c, p]
                # Not less tail on the right: where both are infinite, the plan may be as hot as it likes.
                someone_last = _least_rise(plate, stack, d, p, last, latest, limit) + tail <= limit
            if can_start and someone_last:
                break
        if not can_start:
            return True
    return not someone_last


@njit(cache=True)
def _least_rise(
    plate: Plate, stack: Stack, d: int, p: int, soonest: float, latest: float, limit: float
) -> float:
    """Return a lower bound on the rise at p, from the path, between two times; only to beyond ``limit``."""
    rise, latest = 0.0, max(soonest, latest)
    for j in range(d - 1, -1, -1):
        a = plate.contour_of[stack.order[j]]
        soon, late = soonest - stack.end[j], latest - stack.end[j]
        rise += least_warmth(plate.constant, plate.spread, plate.distance[p, a], soon, late)
        if rise > limit:
            break
    return rise


@njit(cache=True)
def open_bound(stack: Stack) -> float:
    """Return a lower bound on the objective of all that is still open on the stack; infinite for nothing."""
    least = np.inf
    for d in range(stack.depth[0] + 1):
        if stack.next_kid[d] < stack.kid_count[d]:
            least = min(least, stack.keys[d, stack.next_kid[d]])
    return least
