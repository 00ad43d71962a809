r"""One head's plans as orders of points that warm each other: the arrays that the kernels work on.

    Contours   0..n-1, each with consecutive points v, w; a plan visits each contour once, at one of its points
    Data       c_vw   what the rapid from v to w counts in the objective, infinite where it is forbidden  [mm]
               d_vw   how long it takes                                                              [s]
               o_v, b_v   what the ways from the home to v and from v back to it count               [mm]
               s_a    time to pierce and cut contour a                                               [s]
               L_va   distance from v to the curve of contour a                                      [mm]
               T(L, t) = k exp(-L^2 / (4 a t)) / sqrt(t)                                             [K]
    Plan       v_1 .. v_n, starts t_1 = 0, t_(i+1) = t_i + s_i + d_(v_i, v_(i+1)), ends e_i = t_i + s_i
    (1) rise   R_i = sum over j < i of T(L_(v_i, j), t_i - e_j)                                      [K]
    (2) travel o_(v_1) + sum c + b_(v_n); a closed tour without a home has o = 0, and b_v leads to v_1

Times count from the first start, since only their differences matter. Sets of contours are bits of a word.

Sources: Yang, Liu, Ju (2012) for the model; Li et al. (2019) for the process rules.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from cutgap.formulations.contour_dp.walks import Bools, closed_arcs, precedes
from cutgap.instances import Instance, Plan, Rules, Visit
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.check import TOLERANCE
from cutgap.instances.heat import curve_distances, diffusivity, kernel_constant, require_heat
from cutgap.instances.process import adjacent_parts, crossings, part_of, rapid_costs


class Plate(NamedTuple):
    """The data above, and which steps there are.

    Attributes
    ----------
    first
        Point 0 of each contour, then the number of points; shape (n + 1,).
    contour_of
        Contour of each point, shape (points,).
    cost, time, out
        c, d and o.
    back
        ``back[v, 0]`` is b_v; without a home ``back[v, f]`` is b_v of a tour that begins at point f.
    service, distance
        s and L; shapes (n,) and (points, n).
    constant, spread
        k, K s^(1/2), and 4 a, mm^2/s.
    before
        Set of contours that must be cut before each contour.
    mates
        Set of contours that must be cut before contours outside it come after each contour; 0 without rule.
    crossed
        Set of contours that each rapid crosses: forbidden once one of them is cut; shape (0, 0) without rule.
    """

    first: Ints
    contour_of: Ints
    cost: Floats
    time: Floats
    out: Floats
    back: Floats
    service: Floats
    distance: Floats
    constant: float
    spread: float
    before: Ints
    mates: Ints
    crossed: Ints


def plate_of(instance: Instance, rules: Rules) -> Plate:
    """Return the arrays of an instance with one head and at most 62 contours."""
    count, places = len(instance.contours), int(instance.first_node[-1])
    sizes = np.diff(instance.first_node)
    contour_of = np.repeat(np.arange(count), sizes).astype(np.int64)
    costs, home = rapid_costs(instance, rules), instance.home_node(0)
    cost = np.array(costs[:places, :places])
    cost[_closed(instance, rules)[np.ix_(contour_of, contour_of)]] = np.inf
    crossed = np.zeros((0, 0), dtype=np.int64)
    if rules.clear_rapids and count > 0:
        crossed = crossings(instance)[:, :, 0].astype(np.int64)
    alone = np.left_shift(np.int64(1), np.arange(count, dtype=np.int64))
    parts = part_of(instance)
    mates = alone @ (parts[:, None] == parts).astype(np.int64) if rules.parts_in_one_go else 0 * alone
    return Plate(
        first=instance.first_node,
        contour_of=contour_of,
        cost=cost,
        time=instance.rapids[:places, :places] / instance.machine.v_jump,
        out=np.zeros(places) if home is None else np.array(costs[home, :places]),
        back=np.array(instance.rapids[:places, :places] if home is None else costs[:places, [home]]),
        service=np.array(instance.service_times),
        distance=np.array(curve_distances(instance)),
        constant=kernel_constant(instance),
        spread=4.0 * diffusivity(instance),
        before=(alone @ precedes(instance, rules).astype(np.int64)).astype(np.int64),
        mates=mates,
        crossed=crossed,
    )


def _closed(instance: Instance, rules: Rules) -> Bools:
    """Return whether contour b may never come right after contour a."""
    parts = part_of(instance)
    closed = closed_arcs(precedes(instance, rules), parts if rules.parts_in_one_go else None)
    if rules.neighbours_only:
        near = adjacent_parts(instance) | np.eye(len(adjacent_parts(instance)), dtype=np.bool_)
        closed |= ~near[np.ix_(parts, parts)]
    return closed


def rise_limit(instance: Instance, rules: Rules) -> float:
    """Return the largest rise that may pass for within the cap, K: what ``check`` lets pass, and rounding.

    A plan with a larger rise breaks the cap; whether one with a smaller rise keeps it is for ``check`` to say.
    """
    material = require_heat(instance)
    if rules.temperature_cap is None:
        return np.inf
    rise = rules.temperature_cap - material.ambient_c
    return rise + 1.01 * TOLERANCE * max(1.0, abs(rise)) + 1e-15 * abs(material.ambient_c)


def plan_of(plate: Plate, points: Ints) -> Plan:
    """Return the plan that visits these points in order."""
    contours = plate.contour_of[points]
    entries = points - plate.first[contours]
    return Plan((tuple(Visit(int(c), int(e)) for c, e in zip(contours, entries, strict=True)),))


def points_of(plate: Plate, plan: Plan) -> Ints:
    """Return the points of a plan's only tour, in order."""
    return np.array([plate.first[c] + e for c, e, *_ in plan.tours[0]], dtype=np.int64)


@njit(cache=True)
def warmth(constant: float, spread: float, distance: float, lag: float) -> float:
    """Return T, K; infinite where distance and lag are 0, and 0 for lag 0 at a distance."""
    if lag <= 0.0:
        return 0.0 if distance > 0.0 else np.inf
    return constant * np.exp(-distance * distance / (spread * lag)) / np.sqrt(lag)


@njit(cache=True)
def least_warmth(constant: float, spread: float, distance: float, soonest: float, latest: float) -> float:
    """Return the least T over lags from ``soonest`` to ``latest``, which may be infinite.

    T rises up to t = L^2 / (2 a) and falls after it, so its least value on an interval is at an end.
    """
    late = 0.0 if latest == np.inf else warmth(constant, spread, distance, latest)
    return min(late, warmth(constant, spread, distance, soonest))


@njit(cache=True)
def may_come(plate: Plate, cut: int, v: int, w: int) -> bool:
    """Whether the step from point v to point w is allowed once ``cut``, with v's contour, is done."""
    b = plate.contour_of[w]
    if cut >> b & 1 or plate.before[b] & ~cut or plate.cost[v, w] == np.inf:
        return False
    mates = plate.mates[plate.contour_of[v]]
    if not mates >> b & 1 and mates & ~cut:
        return False
    return len(plate.crossed) == 0 or plate.crossed[v, w] & cut == 0
