r"""Closed curves of lines and arcs: polygons with rounded corners, and the points at which they may be entered.

    (1) tangent length of a corner with turning angle a and radius r:  r tan(|a| / 2);  its arc: r |a|
    (2) a circle of diameter d is a square of side d with radius d / 2, a slot a rectangle likewise

Feature points are the joints of the basic elements (lines and arcs) and the 1/2, 1/4 or 1/6 points of some of
them, as in Li et al. (2019), section 1.1. Lengths in mm.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cutgap.instances.arrays import Floats, Ints

SAGITTA = 0.05
"""Largest distance between an arc and its chords."""

LEAST = 1e-6
"""Elements no longer than this are none."""

DIVISIONS = (1, 2, 4, 6)
"""Numbers of pieces into which feature points may divide an element."""

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Ring:
    """A polygon, counter-clockwise, and the radius of each of its corners (0: sharp)."""

    corners: tuple[Point, ...]
    radii: tuple[float, ...]

    def elements(self) -> "list[Element]":
        """Return lines and arcs in order, those without length left out."""
        count = len(self.corners)
        arcs = [
            _rounded(self.corners[i - 1], self.corners[i], self.corners[(i + 1) % count], self.radii[i])
            for i in range(count)
        ]
        found: list[Element] = []
        for arc, following in pairwise([*arcs, arcs[0]]):
            found += [arc, Element(arc.end, following.start)]
        return [element for element in found if element.length > LEAST]

    @property
    def length(self) -> float:
        """Perimeter, arcs taken as such."""
        return math.fsum(element.length for element in self.elements())

    def polyline(self, entries: int) -> tuple[Floats, Ints]:
        """Return the curve as points, shape (k, 2), and which of them are feature points.

        Elements are divided, the widest spacing first, as long as there are at most ``entries`` feature
        points; the joints are feature points in any case.
        """
        elements = self.elements()
        divisions = _divisions([element.length for element in elements], entries)
        points: list[Point] = []
        features = []
        for element, pieces in zip(elements, divisions, strict=True):
            steps = pieces * -(-element.least_steps() // pieces)
            for step in range(steps):
                if step % (steps // pieces) == 0:
                    features.append(len(points))
                points.append(element.at(step / steps))
        return np.array(points), np.array(features, dtype=np.int64)


@dataclass(frozen=True, slots=True)
class Element:
    """A line, or an arc that turns by ``turn`` radians (left positive) with ``radius``."""

    start: Point
    end: Point
    radius: float = 0.0
    turn: float = 0.0

    @property
    def length(self) -> float:
        """Length along the element."""
        return self.radius * abs(self.turn) if self.turn else math.dist(self.start, self.end)

    def least_steps(self) -> int:
        """Return the least number of chords that stay within ``SAGITTA``; 1 for a line."""
        if not self.turn:
            return 1
        widest = 2.0 * math.acos(max(0.0, 1.0 - SAGITTA / self.radius))
        return max(1, math.ceil(abs(self.turn) / widest))

    def at(self, share: float) -> Point:
        """Return the point at a share of the length."""
        chord = (self.end[0] - self.start[0], self.end[1] - self.start[1])
        if not self.turn:
            return (self.start[0] + share * chord[0], self.start[1] + share * chord[1])
        # Chords of the same circle: their lengths go with the sine of half the angle.
        half = self.turn / 2
        scale, angle = math.sin(share * half) / math.sin(half), (share - 1.0) * half
        cos, sin = scale * math.cos(angle), scale * math.sin(angle)
        return (
            self.start[0] + cos * chord[0] - sin * chord[1],
            self.start[1] + sin * chord[0] + cos * chord[1],
        )


def _rounded(before: Point, corner: Point, after: Point, radius: float) -> Element:
    """Return the arc at a corner by (1); at a sharp corner an element without length."""
    inward = math.atan2(corner[1] - before[1], corner[0] - before[0])
    outward = math.atan2(after[1] - corner[1], after[0] - corner[0])
    turn = math.remainder(outward - inward, math.tau)
    reach = radius * math.tan(abs(turn) / 2)
    if reach == 0.0:
        return Element(corner, corner)
    start = (corner[0] - reach * math.cos(inward), corner[1] - reach * math.sin(inward))
    end = (corner[0] + reach * math.cos(outward), corner[1] + reach * math.sin(outward))
    return Element(start, end, radius, turn)


def _divisions(lengths: list[float], entries: int) -> list[int]:
    """Return into how many pieces each element is divided."""
    levels = [0] * len(lengths)
    while True:
        spacing = [
            length / DIVISIONS[level] if level + 1 < len(DIVISIONS) else 0.0
            for length, level in zip(lengths, levels, strict=True)
        ]
        widest = max(range(len(lengths)), key=spacing.__getitem__)
        levels[widest] += spacing[widest] > 0
        divided = [DIVISIONS[level] for level in levels]
        if spacing[widest] == 0.0 or sum(divided) > entries:
            levels[widest] -= spacing[widest] > 0
            return [DIVISIONS[level] for level in levels]


def rectangle(centre: Point, width: float, height: float, radius: float) -> Ring:
    """Return a rectangle with rounded corners; by (2) also a slot."""
    (x, y), a, b = centre, width / 2, height / 2
    return Ring(((x - a, y - b), (x + a, y - b), (x + a, y + b), (x - a, y + b)), (radius,) * 4)


def circle(centre: Point, diameter: float) -> Ring:
    """Return a circle by (2): four arcs, joined at the quarter points."""
    return rectangle(centre, diameter, diameter, diameter / 2)
