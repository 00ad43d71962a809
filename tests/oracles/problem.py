"""An instance as plain numbers, and the value of a plan, straight from the reference formulas.

    L_a = sum of rapids of head a, home to first contour and last contour to home included       [mm]
    T_a = L_a / v_jump + sum(perimeter) / v_cut + t_aux * count                                  [s]
    F   = smallest x on the right head - largest x on the left head                              [mm]

Reads the fields of an ``Instance`` and calls none of its methods. Source: Wang et al. (2025), (1), (2), (9).
"""

import math
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from cutgap.instances import Instance, Rules

Point = tuple[float, float, float]
Tour = tuple[tuple[int, int], ...]
"""Visits of one head in order: (contour, entry point)."""


@dataclass(frozen=True)
class Problem:
    """Plain numbers of an instance; nodes are the entry points in order, then the homes that exist."""

    entries: tuple[tuple[Point, ...], ...]
    perimeters: tuple[float, ...]
    homes: tuple[Point | None, ...]
    v_jump: float
    v_cut: float
    t_aux: float
    lengths: tuple[tuple[float, ...], ...]
    precedence: tuple[tuple[int, int], ...]

    def node(self, contour: int, entry: int) -> int:
        return sum(len(points) for points in self.entries[:contour]) + entry

    def home_node(self, head: int) -> int | None:
        if self.homes[head] is None:
            return None
        points = sum(len(points) for points in self.entries)
        return points + sum(home is not None for home in self.homes[:head])

    def work(self, contours: list[int]) -> float:
        """Seconds that a head stands still: cutting and auxiliary time."""
        cutting = math.fsum(self.perimeters[contour] for contour in contours)
        return cutting / self.v_cut + self.t_aux * len(contours)


@dataclass(frozen=True)
class Figures:
    """Travel (mm) and time (s) of each head; F (mm), ``None`` with fewer than two working heads."""

    travel: tuple[float, ...]
    time: tuple[float, ...]
    partition_gap: float | None

    @property
    def makespan(self) -> float:
        return max(self.time)

    @property
    def imbalance(self) -> float:
        return max(self.time) - min(self.time)

    def objective(self, rules: Rules) -> float:
        if rules.objective == "makespan":
            return self.makespan
        price = rules.weight if rules.objective == "weighted" else 0.0
        return math.fsum(self.travel) + price * self.imbalance


def plain_problem(instance: Instance) -> Problem:
    """Copy the numbers of an instance; rapid lengths come from this module's own distances."""
    entries = tuple(tuple(_point(row) for row in contour.entry_points) for contour in instance.contours)
    homes = tuple(None if head.home is None else _point(head.home) for head in instance.heads)
    machine = instance.machine
    places = [point for points in entries for point in points] + [home for home in homes if home is not None]
    if instance.matrix is None:
        distance = {"euclidean": _euclidean, "chebyshev": _chebyshev}[machine.metric]
        lengths = tuple(tuple(distance(a, b) for b in places) for a in places)
    else:
        given = [[float(length) for length in row] for row in instance.matrix]
        lengths = tuple(
            tuple(0.0 if a == b else length for b, length in enumerate(row)) for a, row in enumerate(given)
        )
    perimeters = tuple(float(contour.perimeter) for contour in instance.contours)
    return Problem(
        entries, perimeters, homes, machine.v_jump, machine.v_cut, machine.t_aux, lengths, instance.precedence
    )


def figures(problem: Problem, tours: tuple[Tour, ...]) -> Figures:
    """Apply the reference formulas to a plan."""
    travel, time, ranges = [], [], []
    for head, tour in enumerate(tours):
        length = tour_length(problem, head, tour)
        travel.append(length)
        time.append(length / problem.v_jump + problem.work([contour for contour, *_ in tour]))
        ranges.append([problem.entries[contour][entry][0] for contour, entry, *_ in tour])
    working = [xs for xs in ranges if xs]
    gaps = [Fraction(repr(min(right))) - Fraction(repr(max(left))) for left, right in pairwise(working)]
    return Figures(tuple(travel), tuple(time), float(min(gaps)) if gaps else None)


def tour_length(problem: Problem, head: int, tour: Tour) -> float:
    """Length of rapids, mm: from home and back, or around when there is no home."""
    if not tour:
        return 0.0
    stops = [problem.node(contour, entry) for contour, entry, *_ in tour]
    home = problem.home_node(head)
    around = [*stops, stops[0]] if home is None else [home, *stops, home]
    return math.fsum(problem.lengths[a][b] for a, b in pairwise(around))


def _point(row: object) -> Point:
    x, y, z = (float(value) for value in row)  # type: ignore[attr-defined]
    return (x, y, z)


def _euclidean(a: Point, b: Point) -> float:
    return math.sqrt(math.fsum((a[axis] - b[axis]) ** 2 for axis in range(3)))


def _chebyshev(a: Point, b: Point) -> float:
    return max(abs(a[axis] - b[axis]) for axis in range(3))
