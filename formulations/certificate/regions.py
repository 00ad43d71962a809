r"""Shortest closed tours through convex regions in any order (kind ``regions``; one head, free entries).

A tour that has regions r_0, ..., r_{n-1} in this cyclic order is, for any u_k with |u_k| <= 1, at least

    (1) sum_k min over x in r_k of (u_{k-1} - u_k) . x        since |p_{k+1} - p_k| >= u_k . (p_{k+1} - p_k)

long. Over an ellipsoid the minimum is s.c - sqrt(sum_i (s.a_i)^2), over a hull the least s.v of its corners.

The proof is a tree over orders of some regions, in preorder. A number is the region that the children insert,
one child for each place behind which it may be; a list [K, ...] is a leaf, with x and y (and z) of all K u_k as
integers. The root is an order that all plans have, but for rotation and reversal: of any three regions; of two
where precedence gives a direction. There the home is the first, and precedence limits the places.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import isqrt, lcm
from typing import Any

from cutgap.formulations.certificate.problem import Point, Problem
from cutgap.formulations.certificate.proof import Budget
from cutgap.formulations.certificate.reading import Refused, entries, fields, integer, require

FINE = 10**6
"""Square roots are rounded to 1 / FINE of the integers' unit."""

Vector = tuple[int, int, int]


@dataclass(frozen=True)
class Shape:
    """A region in integers: an ellipsoid's centre and axes, or the corners of a hull (then no axes)."""

    points: tuple[Vector, ...]
    axes: tuple[Vector, ...]

    def least(self, direction: Sequence[int]) -> int:
        """Return a lower bound on the least direction.x, less than 1 below it."""
        a, b, c = direction
        middle = min(a * x + b * y + c * z for x, y, z in self.points)
        square = sum((a * x + b * y + c * z) ** 2 for x, y, z in self.axes)
        # The ceiling of a root: isqrt(q - 1) + 1, and 0 of 0.
        return middle - (isqrt(square - 1) + 1 if square else 0)


Region = tuple[Sequence[Point], Sequence[Point]]
"""Points and axes in mm: an ellipsoid around the only point, or without axes the hull of the points."""


class Regions:
    """Regions as integers in 1 / ``unit`` mm; ``home`` is the number of the one that is, if any.

    ``before`` holds the pairs of regions of which the first comes before the second, all that follow included.
    """

    def __init__(
        self, given: Sequence[Region], home: int | None = None, before: frozenset[tuple[int, int]] = frozenset()
    ) -> None:
        self.home, self.before = home, before
        rows = [row for points, axes in given for row in (*points, *axes)]
        self.unit = lcm(*{value.denominator for row in rows for value in row})
        self.shapes = [Shape(self._vectors(points), self._vectors(axes)) for points, axes in given]

    def _vectors(self, rows: Sequence[Point]) -> tuple[Vector, ...]:
        return tuple((int(x * self.unit), int(y * self.unit), int(z * self.unit)) for x, y, z in rows)

    def places(self, order: Sequence[int], region: int) -> range:
        """Return the places of an order behind which a region may be."""
        earlier = [place for place, each in enumerate(order) if (each, region) in self.before]
        later = [place for place, each in enumerate(order) if (region, each) in self.before]
        return range(max(earlier, default=0), min(later, default=len(order)))

    def bound(self, order: Sequence[int], multipliers: Sequence[int], budget: Budget) -> Fraction:
        """Return (1) in mm, rounded down; refuses multipliers outside the unit ball."""
        scale, *numbers = multipliers
        axes = 3 if len(numbers) == 3 * len(order) else 2
        require(
            scale >= 1 and len(numbers) == axes * len(order), "leaf: expected 2 or 3 numbers for each region"
        )
        u = [(*numbers[at : at + axes], 0)[:3] for at in range(0, len(numbers), axes)]
        require(all(x * x + y * y + z * z <= scale * scale for x, y, z in u), "leaf: a multiplier is above 1")
        total = 0
        for k, region in enumerate(order):
            shape, (x, y, z), (a, b, c) = self.shapes[region], u[k - 1], u[k]
            x, y, z = x - a, y - b, z - c
            budget.spend(4 * (len(shape.points) + len(shape.axes)))
            total += FINE * min(x * d + y * e + z * f for d, e, f in shape.points)
            if shape.axes:
                square = FINE * FINE * sum((x * d + y * e + z * f) ** 2 for d, e, f in shape.axes)
                root = isqrt(square)
                total -= root + (root * root < square)
        return Fraction(total, FINE * self.unit * scale)


def regions_of(problem: Problem) -> Regions:
    """Return the regions of a problem with one head, in order of its contours, and then its home."""
    require(len(problem.homes) == 1, "regions: needs one head")
    require(problem.metric == "euclidean", "regions: takes Euclidean lengths")
    given: list[Region] = [problem.region(contour) for contour in range(len(problem.ids))]
    (home,) = problem.homes
    if home is None:
        return Regions(given, before=_closure(problem))
    place = tuple(Fraction(each, problem.denominator) for each in problem.places[home])
    return Regions([*given, ((place,), ())], len(given), _closure(problem))


def _closure(problem: Problem) -> frozenset[tuple[int, int]]:
    """Return the pairs of precedence, also those that follow from others."""
    pairs = set(problem.precedence)
    for middle in range(len(problem.ids)):
        first = [a for a, b in pairs if b == middle]
        last = [b for a, b in pairs if a == middle]
        pairs |= {(a, b) for a in first for b in last}
    return frozenset(pairs)


def check_regions(regions: Regions, proof: Any, length: Fraction, budget: Budget) -> None:
    """Refuse unless the proof shows that each tour through all regions is at least ``length`` mm long."""
    table = fields(proof, "proof", "kind root nodes")
    root = [integer(each, "root", least=0) for each in entries(table["root"], "root")]
    _check_root(regions, root)
    waiting = [tuple(root)]
    for number, node in enumerate(entries(table["nodes"], "nodes")):
        require(waiting != [], f"node {number}: the tree has ended before it")
        order = waiting.pop()
        budget.spend(10 + len(order) ** 2)
        try:
            if isinstance(node, list):
                require(node != [], "leaf: empty")
                bound = regions.bound(order, [integer(each, "leaf") for each in node], budget)
                require(
                    bound >= length, f"the leaf is worth {float(bound):.9g} mm, less than {float(length):.9g}"
                )
                continue
            region = integer(node, "insert", least=0)
            require(region < len(regions.shapes), f"there is no region {region}")
            require(region not in order, f"region {region} is in the order already")
            places = regions.places(order, region)
        except Refused as error:
            raise Refused(f"node {number}: {error}") from None
        budget.spend(len(order) * len(places))
        waiting += [(*order[: place + 1], region, *order[place + 1 :]) for place in reversed(places)]
    require(waiting == [], f"nodes: {len(waiting)} orders are left without one")


def _check_root(regions: Regions, root: list[int]) -> None:
    require(all(each < len(regions.shapes) for each in root), "root: no such region")
    require(len(set(root)) == len(root), "root: a region is there twice")
    require(1 <= len(root) <= (2 if regions.before else 3), "root: expected one to three regions")
    if regions.before:
        require(regions.home is not None, "regions: takes precedence with a home alone")
        require(root[0] == regions.home, "root: with precedence it begins with the home")
