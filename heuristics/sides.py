"""What the heuristics share: inputs they take, splits that the rules allow, the value of side tours."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from cutgap.instances import Instance, Plan, Rules
from cutgap.instances.arrays import Floats, Ints, difference
from cutgap.instances.check import require_coordinates


@dataclass(frozen=True, slots=True)
class Clock:
    """Time since the start of a run, against its limit in s (``None``: no limit)."""

    limit: float | None
    start: float = field(default_factory=time.perf_counter)

    @property
    def seconds(self) -> float:
        """Seconds since the start."""
        return time.perf_counter() - self.start

    @property
    def over(self) -> bool:
        """Whether the limit has passed."""
        return self.limit is not None and self.seconds >= self.limit


@dataclass(frozen=True, slots=True)
class SideTour:
    """One head's tour: contours in order, rapids in mm (homes included), time in s."""

    contours: tuple[int, ...]
    travel_mm: float
    time_s: float


Score = tuple[float, float]
"""By how much the limits are exceeded, then the objective in ``rules.unit``; less is better."""


def require_plain(instance: Instance, method: str) -> None:
    """Raise ``ValueError`` for what no heuristic here supports: entry points to choose from, precedence."""
    for contour in instance.contours:
        if len(contour.entry_points) != 1:
            raise ValueError(
                f"{method}: contour {contour.id!r} has {len(contour.entry_points)} entry points; "
                "the heuristics take one entry point per contour"
            )
    if instance.precedence:
        raise ValueError(f"{method}: the heuristics take no precedence, got {len(instance.precedence)} pairs")


def require_two_sides(instance: Instance, method: str) -> None:
    """Raise ``ValueError`` unless there are two heads and coordinates, which a partition in x needs."""
    require_plain(instance, method)
    if len(instance.heads) != 2:
        raise ValueError(
            f"{method}: expected two heads, got {len(instance.heads)}; "
            "local-search takes any number where overlap is allowed"
        )
    if not instance.located:
        raise ValueError(
            f"{method}: the partition needs coordinates, and instance {instance.name!r} has only a matrix; "
            "local-search takes it where overlap is allowed"
        )


def has_two_sides(instance: Instance, rules: Rules) -> bool:
    """Whether a partition in x of single entry points is asked for, under no process rule and without links."""
    try:
        require_two_sides(instance, "")
    except ValueError:
        return False
    return not rules.process and not rules.links


def has_tours(instance: Instance, rules: Rules) -> bool:
    """Whether tours through single entry points are asked for, under no process rule and without links."""
    if rules.links:
        return False
    if len(instance.heads) > 1 and rules.non_overlap is not None:
        return has_two_sides(instance, rules)
    try:
        require_plain(instance, "")
    except ValueError:
        return False
    return not rules.process and (instance.located or not rules.via_points)


def has_one_head(instance: Instance, rules: Rules) -> bool:
    """Whether one head is to choose order and entry points, heat aside, with the curves that the rules need.

    Where links are allowed a tour without them is still a plan, unless the pierces are limited.
    """
    if len(instance.heads) != 1 or not instance.contours or rules.via_points:
        return False
    if rules.speaks_of_heat or rules.pierces is not None:
        return False
    try:
        require_coordinates(instance, rules)
    except ValueError:
        return False
    return True


def on_curves(instance: Instance, rules: Rules) -> bool:
    """Whether one head has to mind curves on its way."""
    return (rules.neighbours_only or rules.clear_rapids) and has_one_head(instance, rules)


def has_single_tour(instance: Instance, rules: Rules) -> bool:
    """Whether one head is to choose order and entry points, without links."""
    return not rules.links and has_one_head(instance, rules)


def has_links(instance: Instance, rules: Rules) -> bool:
    """Whether contours may be joined by links."""
    try:
        require_coordinates(instance, rules)
    except ValueError:
        return False
    return rules.links


def contour_xs(instance: Instance) -> Floats:
    """Return x of each contour's entry point 0, mm."""
    return instance.points[instance.first_node[:-1], 0]


def allowed_splits(instance: Instance, rules: Rules, order: Ints) -> list[int]:
    """Return each k for which ``order[:k]`` on the left head and ``order[k:]`` on the right keep to the rules.

    ``order`` is ascending in x. Where the rules allow no split, all are returned: ``check`` then says what
    the plan breaks.
    """
    xs = contour_xs(instance)[order]
    n = len(order)
    least = -np.inf if rules.non_overlap is None else rules.non_overlap
    inner = [k for k in range(1, n) if difference(xs[k - 1], xs[k]) >= least]
    splits = sorted({0, *inner, n}) if rules.empty_heads or n < 2 else inner
    return splits or list(range(n + 1))


def side_tour(instance: Instance, head: int, contours: Sequence[int] | Ints) -> SideTour:
    """Return a head's tour with its travel and time, equations (1) and (2) of ``evaluate``."""
    if not len(contours):
        return SideTour((), 0.0, 0.0)
    order = np.asarray(contours, dtype=np.int64)
    nodes = instance.first_node[order]
    home = instance.home_node(head)
    stops = np.append(nodes, nodes[0]) if home is None else np.concatenate(([home], nodes, [home]))
    travel = float(instance.rapids[stops[:-1], stops[1:]].sum())
    seconds = travel / instance.machine.v_jump + float(instance.service_times[order].sum())
    return SideTour(tuple(int(c) for c in order), travel, seconds)


def score(instance: Instance, rules: Rules, sides: Sequence[SideTour]) -> Score:
    """Return the score of a plan; the excesses are summed as they come, whatever their units."""
    times = [side.time_s for side in sides]
    imbalance = max(times) - min(times)
    excess = 0.0 if rules.balance is None else max(0.0, imbalance - rules.balance)
    if not rules.empty_heads and len(instance.contours) >= len(sides):
        excess += sum(not side.contours for side in sides)
    if rules.non_overlap is not None and len(sides) > 1:
        xs = contour_xs(instance)
        ranges = [xs[list(side.contours)] for side in sides if side.contours]
        for left, right in pairwise(ranges):
            excess += max(0.0, rules.non_overlap - difference(left.max(), right.min()))
    if rules.objective == "makespan":
        return excess, max(times)
    return excess, sum(side.travel_mm for side in sides) + rules.weight * imbalance


def plan_of(sides: Sequence[SideTour]) -> Plan:
    """Return the plan that these tours make, head by head."""
    return Plan.of_contours(side.contours for side in sides)
