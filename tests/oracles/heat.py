"""Every plan of one head with travel and peak temperature: the best and the front, up to 5 contours x 3 points.

    T(L, t) = q / (v h sqrt(4 pi lambda c rho t)) exp(-L^2 / (4 a t)),  a = lambda / (c rho)           [K]
    R_i     = sum over j before i of T(L_ij, t_ij),  peak = ambient + max over i of R_i             [deg C]
    L_ij    from the start point of i to the nearest edge of the closed polyline of j                   [m]
    t_ij    from the end of j to the start of i: rapids, and all of the contours between them           [s]

Without a peak, on one contour, a plan is as warm as its surroundings. Precedence holds in every plan; rapids
between contours are clear if asked for. Shares no code with the package. Source: Yang, Liu, Ju (2012).
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise, permutations, product

from cutgap.instances import Instance, Plan, Visit
from oracles.exact_sheet import sheet_of
from oracles.problem import Problem, Tour, plain_problem, tour_length

SLACK = 1e-9
"""Slack of a cap, relative to its own rise, as sums differ by rounding."""

MM = 1e-3


@dataclass(frozen=True)
class HotPlan:
    """A plan's tour, its travel in mm and its peak in deg C."""

    travel: float
    peak: float
    tour: Tour

    @property
    def plan(self) -> Plan:
        return Plan((tuple(Visit(*visit) for visit in self.tour),))


@dataclass(frozen=True)
class HotPlans:
    """All plans that are allowed."""

    plans: tuple[HotPlan, ...]
    ambient: float

    def least_travel(self, cap: float = math.inf) -> HotPlan | None:
        """A shortest plan, and of these a coolest; with a cap (deg C) among those that keep it."""
        most = cap + SLACK * max(1.0, abs(cap - self.ambient))
        kept = [plan for plan in self.plans if plan.peak <= most]
        return min(kept, key=lambda plan: (plan.travel, plan.peak), default=None)

    def least_peak(self) -> HotPlan | None:
        """A coolest plan, and of these a shortest."""
        return min(self.plans, key=lambda plan: (plan.peak, plan.travel), default=None)

    def front(self) -> list[HotPlan]:
        """The plans that no other beats in travel and peak: travel rises, peak falls."""
        found: list[HotPlan] = []
        for plan in sorted(self.plans, key=lambda plan: (plan.travel, plan.peak)):
            if not found or plan.peak < found[-1].peak:
                found.append(plan)
        return found


def hot_plans(instance: Instance, *, clear_rapids: bool = False) -> HotPlans:
    """List the plans of one head over an instance with a material and a curve for each contour."""
    if len(instance.heads) != 1 or len(instance.contours) > 6:
        raise ValueError("lists plans of one head and at most 6 contours")
    assert instance.material is not None
    problem, table = plain_problem(instance), distances(instance)
    plans = tuple(
        HotPlan(tour_length(problem, 0, tour), peak_of(instance, problem, table, tour), tour)
        for tour in tours(instance, problem, clear_rapids)
    )
    return HotPlans(plans, instance.material.ambient_c)


def tours(instance: Instance, problem: Problem, clear_rapids: bool) -> Iterator[Tour]:
    """Every order with every choice of start points that is allowed."""
    crossed = sheet_of(instance).crossed if clear_rapids else {}
    for order in permutations(range(len(problem.entries))):
        if any(order.index(a) > order.index(b) for a, b in problem.precedence):
            continue
        for entries in product(*(range(len(problem.entries[contour])) for contour in order)):
            visits = tuple(zip(order, entries, strict=True))
            if not any(
                crossed.get((*visits[k], *visits[k + 1]), frozenset()) & set(order[: k + 1])
                for k in range(len(order) - 1)
            ):
                yield visits


def peak_of(
    instance: Instance, problem: Problem, table: dict[tuple[int, int, int], float], tour: Tour
) -> float:
    """The highest temperature of a start point, deg C."""
    material, nodes = instance.material, [problem.node(*visit) for visit in tour]
    assert material is not None
    rapids = [problem.lengths[a][b] / problem.v_jump for a, b in pairwise(nodes)]
    warmest = 0.0
    for i in range(1, len(tour)):
        lag, warmth = 0.0, 0.0
        for j in range(i - 1, -1, -1):
            lag += rapids[j]
            warmth += kernel(instance, table[(*tour[i], tour[j][0])], lag)
            lag += problem.work([tour[j][0]])
        warmest = max(warmest, warmth)
    return material.ambient_c + warmest


def kernel(instance: Instance, distance_mm: float, lag_s: float) -> float:
    """T(L, t), K; without time nothing has spread, but on the curve itself it is infinitely hot."""
    material = instance.material
    assert material is not None
    if lag_s == 0.0:
        return math.inf if distance_mm == 0.0 else 0.0
    conductivity, capacity = (
        material.conductivity_w_per_m_k,
        material.specific_heat_j_per_kg_k * material.density_kg_per_m3,
    )
    line = material.power_w / (instance.machine.v_cut * MM * material.thickness_mm * MM)
    spread = math.exp(-((distance_mm * MM) ** 2) * capacity / (4 * conductivity * lag_s))
    return line * spread / math.sqrt(4 * math.pi * conductivity * capacity * lag_s)


def distances(instance: Instance) -> dict[tuple[int, int, int], float]:
    """L in mm from start point (contour, entry) to the curve of another contour."""
    table = {}
    for i, contour in enumerate(instance.contours):
        for e, point in enumerate(contour.entry_points):
            place = (float(point[0]), float(point[1]))
            for j, other in enumerate(instance.contours):
                assert other.geometry is not None
                corners = [(float(x), float(y)) for x, y in other.geometry]
                edges = zip(corners, corners[1:] + corners[:1], strict=True)
                table[i, e, j] = min(_to_edge(place, p, q) for p, q in edges)
    return table


def _to_edge(place: tuple[float, float], p: tuple[float, float], q: tuple[float, float]) -> float:
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = dx * dx + dy * dy
    share = 0.0 if length == 0.0 else ((place[0] - p[0]) * dx + (place[1] - p[1]) * dy) / length
    share = min(1.0, max(0.0, share))
    return math.hypot(place[0] - p[0] - share * dx, place[1] - p[1] - share * dy)
