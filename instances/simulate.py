"""The heads in time: when each contour starts, where each head is, how near the heads come in x.

All heads leave their homes at time 0. A rapid moves x evenly (Euclidean, given matrix) or at full speed
until it is there (Chebyshev); while a contour is cut the head counts as standing at its entry point.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cutgap.instances.arrays import Floats
from cutgap.instances.free_entries import pinned
from cutgap.instances.instance import Instance
from cutgap.instances.plan import Plan, Visit


@dataclass(frozen=True, slots=True)
class Track:
    """One head in time: break ``times`` (s), ``xs`` (mm) there, and ``starts`` (s), one a visit."""

    times: Floats
    xs: Floats
    starts: tuple[float, ...]


def tour_nodes(instance: Instance, head: int, tour: tuple[Visit, ...]) -> list[int]:
    """Return the nodes of a closed tour in order, the first one repeated at the end; empty without work."""
    nodes = [instance.node(*visit[:2]) for visit in tour]
    if not nodes:
        return []
    home = instance.home_node(head)
    return [*nodes, nodes[0]] if home is None else [home, *nodes, home]


def track(instance: Instance, head: int, tour: tuple[Visit, ...]) -> Track:
    """Return a head in time; a head without work stays at home (with neither, the track is empty)."""
    home = instance.home_node(head)
    if not tour:
        stay = np.empty(0) if home is None else instance.points[[home], 0]
        return Track(np.zeros(len(stay)), stay, ())
    nodes = tour_nodes(instance, head, tour)
    services = [float(instance.service_times[visit.contour]) for visit in tour]
    # With a home the first leg leads to visit 0; without one the tour stands at visit 0 from the start.
    waits = [*services, 0.0] if home is not None else [*services[1:], 0.0]
    initial_wait = 0.0 if home is not None else services[0]
    times, xs = [0.0, initial_wait], [float(instance.points[nodes[0], 0])] * 2
    starts = [] if home is not None else [0.0]
    speed = instance.machine.v_jump
    for (a, b), wait in zip(pairwise(nodes), waits, strict=True):
        x, departure = float(instance.points[b, 0]), times[-1]
        arrival = departure + instance.rapid_length(a, b) / speed
        if instance.machine.metric == "chebyshev":
            times.append(departure + abs(x - xs[-1]) / speed)
            xs.append(x)
        starts.append(arrival)
        times += [arrival, arrival + wait]
        xs += [x, x]
    return Track(np.array(times), np.array(xs), tuple(starts[: len(tour)]))


def start_times(instance: Instance, plan: Plan) -> dict[int, float]:
    """Return when each contour of the plan starts to be cut (its last visit, if there are several), s."""
    starts: dict[int, float] = {}
    instance, plan = pinned(instance, plan)
    for head, tour in enumerate(plan.tours):
        times = track(instance, head, tour).starts
        starts.update({visit.contour: time for visit, time in zip(tour, times, strict=True)})
    return starts


def smallest_separation(instance: Instance, plan: Plan) -> float | None:
    """Return the smallest x distance (right minus left, signed) of neighbouring heads over time, mm.

    ``None`` for a single head, and where a head is nowhere. Positions are piecewise linear in time, so
    the extremes lie at break points; where a given matrix lets a head jump, both sides of it count.
    """
    instance, plan = pinned(instance, plan)
    tracks = [track(instance, head, tour) for head, tour in enumerate(plan.tours)]
    if not instance.located or len(tracks) < 2 or any(len(each.times) == 0 for each in tracks):
        return None
    smallest = np.inf
    for left, right in pairwise(tracks):
        times = np.union1d(left.times, right.times)
        apart = positions(right, times) - positions(left, times)
        smallest = min(smallest, float(apart.min()))
    return smallest


def positions(head: Track, times: Floats) -> Floats:
    """Return x of a head just after and just before ``times``, shape (2, times), mm."""
    after = np.interp(times, head.times, head.xs)
    before = np.interp(-times, -head.times[::-1], head.xs[::-1])
    return np.stack((after, before))
