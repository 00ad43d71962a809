r"""The value of a plan, from instance and plan alone; every figure that is reported comes from here.

    (1) L_a = sum of rapids of head a, from home and back to it (closed tour without a home),
              plus its links, K_a, as often as they are passed                                [mm]
    (2) T_a = (L_a - K_a) / v_jump + (K_a + sum(perimeter)) / v_cut + t_aux * pierces         [s]
    (3) makespan = max_a T_a,  imbalance = max_a T_a - min_a T_a                              [s]
    (4) F = min over neighbouring heads a < b of  min x in b - max x in a                     [mm]
    (5) B_a = sum over rapids between contours of max(0, x where it begins - x where it ends)  [mm]

Links are cut by the torch. Without them K_a = 0 and each contour has its pierce.

Source: Wang et al. (2025), equations (1), (2) and (9); (5) makes a price of the preference (7) of Li et al.
(2019); links are those of Chen, Li, Chu. A head without work has L_a = T_a = B_a = 0 and does not count in (4).
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cutgap.instances.arrays import Floats, difference
from cutgap.instances.free_entries import pinned
from cutgap.instances.heat import has_heat, peak_temperature
from cutgap.instances.instance import Instance
from cutgap.instances.links.strokes import Stroke, link_length, strokes
from cutgap.instances.plan import Plan, Visit
from cutgap.instances.rules import Rules
from cutgap.instances.simulate import smallest_separation


@dataclass(frozen=True, slots=True)
class Evaluation:
    """What a plan costs.

    Attributes
    ----------
    travel_mm
        Length of rapids and links, per head.
    time_s
        Time from leaving the home to being back, per head.
    partition_gap_mm
        F of equation (4); negative is an overlap of that depth; ``None`` with fewer than two working heads.
    separation_mm
        Smallest x distance (right minus left, signed) of neighbouring heads over time, all starting
        at once and cutting on the spot; ``None`` for one head, or where a head's position is not known.
    peak_temperature_c
        Highest start-point temperature (``heat``), deg C; ``None`` without a material, or where a contour
        has no curve.
    backward_mm
        B_a of equation (5), per head; 0 where there are no coordinates.
    link_mm
        K_a of equation (1), per head.
    pierces
        How often the torch is lit, per head.
    """

    travel_mm: tuple[float, ...]
    time_s: tuple[float, ...]
    partition_gap_mm: float | None
    separation_mm: float | None
    peak_temperature_c: float | None = None
    backward_mm: tuple[float, ...] = ()
    link_mm: tuple[float, ...] = ()
    pierces: tuple[int, ...] = ()

    @property
    def total_travel_mm(self) -> float:
        """Sum of rapids and links over the heads."""
        return float(sum(self.travel_mm))

    @property
    def makespan_s(self) -> float:
        """Time until the last head is done."""
        return max(self.time_s)

    @property
    def imbalance_s(self) -> float:
        """Time that the first head to finish waits for the last."""
        return max(self.time_s) - min(self.time_s)

    def objective(self, rules: Rules) -> float:
        """Return the value of the objective that the rules name, in ``rules.unit``."""
        if rules.objective == "makespan":
            return self.makespan_s
        if rules.objective == "peak":
            if self.peak_temperature_c is None:
                raise ValueError("objective peak: the instance has no material, or a contour has no geometry")
            return self.peak_temperature_c
        backward = rules.backward_price * sum(self.backward_mm)
        return self.total_travel_mm + rules.weight * self.imbalance_s + backward


def evaluate(instance: Instance, plan: Plan) -> Evaluation:
    """Evaluate a plan; it may break rules, but must name existing contours and entry points.

    Raises
    ------
    ValueError
        When the plan has another number of heads or names what the instance does not have.
    """
    require_known(instance, plan)
    instance, plan = pinned(instance, plan)
    travel, times, linked = [], [], []
    for head, (tour, made) in enumerate(zip(plan.tours, strokes(instance, plan), strict=True)):
        rapids, links = float(rapid_lengths(instance, head, made).sum()), links_mm(instance, made)
        service = instance.service_times[[visit.contour for visit in tour]] if tour else np.zeros(1)
        joined = [
            c for visit, stroke in zip(tour, made, strict=True) for c in stroke.contours if c != visit.contour
        ]
        extra = (float(instance.perimeters[joined].sum()) if joined else 0.0) + links
        linked.append(links)
        travel.append(rapids + links)
        times.append(float(rapids / instance.machine.v_jump + service.sum() + extra / instance.machine.v_cut))
    return Evaluation(
        travel_mm=tuple(travel),
        time_s=tuple(times),
        partition_gap_mm=partition_gap(instance, plan),
        separation_mm=smallest_separation(instance, plan),
        peak_temperature_c=peak_temperature(instance, plan) if has_heat(instance) and not plan.links else None,
        backward_mm=tuple(backward(instance, tour) for tour in plan.tours),
        link_mm=tuple(linked),
        pierces=tuple(map(len, plan.tours)),
    )


def require_known(instance: Instance, plan: Plan) -> None:
    """Raise ``ValueError`` when the plan names heads, contours or entry points that do not exist."""
    for contour, entry in (end for link in plan.links for end in (link[:2], link[2:4])):
        if not 0 <= contour < len(instance.contours):
            raise ValueError(f"plan, link: no contour {contour} among {len(instance.contours)}")
        if not 0 <= entry < len(instance.contours[contour].entry_points):
            raise ValueError(f"plan, link, contour {instance.contours[contour].id!r}: no entry point {entry}")
    if len(plan.tours) != len(instance.heads):
        raise ValueError(f"plan: expected {len(instance.heads)} tours, one a head, got {len(plan.tours)}")
    for head, tour in enumerate(plan.tours):
        for contour, entry, _ in tour:
            if not 0 <= contour < len(instance.contours):
                name, count = instance.heads[head].id, len(instance.contours)
                raise ValueError(f"plan, head {name!r}: no contour {contour} among {count}")
            if not 0 <= entry < len(instance.contours[contour].entry_points):
                raise ValueError(f"plan, contour {instance.contours[contour].id!r}: no entry point {entry}")


def rapid_lengths(instance: Instance, head: int, made: tuple[Stroke, ...]) -> Floats:
    """Return the rapid lengths of a head, from stroke to stroke, mm."""
    if not made:
        return np.zeros(0)
    home = instance.home_node(head)
    # Without a home the tour is closed: from the last stroke to the first.
    first, last = (made[-1].end, made[0].start) if home is None else (home, home)
    leave, reach = [first, *(stroke.end for stroke in made)], [*(stroke.start for stroke in made), last]
    legs = list(zip(leave, reach, strict=True))[1 if home is None else 0 :]
    return np.array([instance.rapid_length(a, b) for a, b in legs], dtype=np.float64)


def links_mm(instance: Instance, made: tuple[Stroke, ...]) -> float:
    """Return the length of all passes of the links in strokes, mm."""
    return sum(
        (link.passes * link_length(instance, link) for stroke in made for link in stroke.links), start=0.0
    )


def backward(instance: Instance, tour: tuple[Visit, ...]) -> float:
    """Return B of equation (5), mm."""
    xs = instance.points[[instance.node(*visit[:2]) for visit in tour], 0] if tour else np.zeros(0)
    return float(np.maximum(0.0, -np.diff(xs)).sum())


def partition_gap(instance: Instance, plan: Plan) -> float | None:
    """Return F of equation (4), mm."""
    if not instance.located:
        return None
    nodes = [[instance.node(*visit[:2]) for visit in tour] for tour in plan.tours if tour]
    xs = [instance.points[each, 0].tolist() for each in nodes]
    return min((difference(max(left), min(right)) for left, right in pairwise(xs)), default=None)
