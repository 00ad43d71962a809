"""What rapids cross and which parts are neighbours, in exact arithmetic, from the definitions alone.

    crossing    the part of the rapid v w from v + t (w - v) to w - t (w - v), t = 10^-6, meets the curve
    neighbours  a rapid from an entry point of part A to one of B crosses no contour of another part;
                parts that enclose A or B are no other parts

Coordinates are whole numbers of a unit so small that all points, and the ends of all middle parts, are exact.
"""

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import combinations, pairwise

from cutgap.instances import Instance

SHARES = 10**6
"""1 / t."""

Point = tuple[int, int]
Curve = tuple[Point, ...]


@dataclass(frozen=True)
class Sheet:
    """Entry points and curves of each contour in whole units, and the name of the part of each contour."""

    entries: tuple[tuple[Point, ...], ...]
    curves: tuple[Curve, ...]
    parts: tuple[str, ...]

    @cached_property
    def crossed(self) -> dict[tuple[int, int, int, int], frozenset[int]]:
        """Contours that the rapid (contour, entry) to (contour, entry) crosses, for all pairs."""
        places = [(c, e, point) for c, points in enumerate(self.entries) for e, point in enumerate(points)]
        table = {}
        for (c, e, v), (d, f, w) in combinations(places, 2):
            met = frozenset(k for k, curve in enumerate(self.curves) if crosses(v, w, curve))
            table[c, e, d, f] = table[d, f, c, e] = met
        return table

    @cached_property
    def neighbours(self) -> frozenset[tuple[str, str]]:
        """Pairs of names of neighbouring parts, both ways round."""
        around = {part: self._enclosing(part) for part in self.parts}
        found = set()
        for (c, _, d, _), met in self.crossed.items():
            one, other = self.parts[c], self.parts[d]
            own = {one, other} | around[one] | around[other]
            if one != other and all(self.parts[k] in own for k in met):
                found |= {(one, other), (other, one)}
        return frozenset(found)

    def _enclosing(self, part: str) -> set[str]:
        own = [curve for curve, name in zip(self.curves, self.parts, strict=True) if name == part]
        return {
            name
            for curve, name in zip(self.curves, self.parts, strict=True)
            if name != part and any(inside(mine, curve) for mine in own)
        }


def sheet_of(instance: Instance) -> Sheet:
    """Copy the geometry of an instance; a contour without a part is a part of its own."""
    numbers = [
        Fraction(float(value))
        for contour in instance.contours
        for rows in (contour.entry_points, contour.geometry)
        for row in rows
        for value in row[:2]
    ]
    unit = SHARES * math.lcm(1, *(number.denominator for number in numbers))

    def whole(row: object) -> Point:
        x, y = (Fraction(float(value)) * unit for value in row[:2])  # type: ignore[index]
        return (int(x), int(y))

    return Sheet(
        tuple(tuple(whole(row) for row in contour.entry_points) for contour in instance.contours),
        tuple(tuple(whole(row) for row in contour.geometry) for contour in instance.contours),
        tuple(f"part {c.part}" if c.part is not None else f"contour {c.id}" for c in instance.contours),
    )


def crosses(v: Point, w: Point, curve: Curve) -> bool:
    """Whether the middle part of the rapid from v to w meets the curve."""
    if v == w:
        return False
    start, end = _towards(v, w), _towards(w, v)
    return any(_meet(start, end, p, q) for p, q in zip(curve, curve[1:] + curve[:1], strict=True))


def inside(inner: Curve, outer: Curve) -> bool:
    """Whether a curve lies in another, which it does not cross: its corners and the middles of its edges do."""
    middles = [((p[0] + q[0]) // 2, (p[1] + q[1]) // 2) for p, q in pairwise((*inner, inner[0]))]
    return _area(inner) < _area(outer) and all(_holds(outer, point) for point in (*inner, *middles))


def _towards(v: Point, w: Point) -> Point:
    return (v[0] + (w[0] - v[0]) // SHARES, v[1] + (w[1] - v[1]) // SHARES)


def _turn(a: Point, b: Point, c: Point) -> int:
    """Sign of the area of the triangle a b c."""
    area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return (area > 0) - (area < 0)


def _between(a: Point, b: Point, c: Point) -> bool:
    """Whether c, which is on the line a b, is on the segment."""
    return min(a[0], b[0]) <= c[0] <= max(a[0], b[0]) and min(a[1], b[1]) <= c[1] <= max(a[1], b[1])


def _meet(a: Point, b: Point, p: Point, q: Point) -> bool:
    """Whether the closed segments a b and p q have a point in common."""
    if any(max(a[i], b[i]) < min(p[i], q[i]) or max(p[i], q[i]) < min(a[i], b[i]) for i in (0, 1)):
        return False
    sides = (_turn(a, b, p), _turn(a, b, q), _turn(p, q, a), _turn(p, q, b))
    if sides[0] * sides[1] < 0 and sides[2] * sides[3] < 0:
        return True
    return (
        (sides[0] == 0 and _between(a, b, p))
        or (sides[1] == 0 and _between(a, b, q))
        or (sides[2] == 0 and _between(p, q, a))
        or (sides[3] == 0 and _between(p, q, b))
    )


def _area(curve: Curve) -> int:
    return abs(sum(p[0] * q[1] - p[1] * q[0] for p, q in zip(curve, curve[1:] + curve[:1], strict=True)))


def _holds(curve: Curve, point: Point) -> bool:
    """Whether a closed polygon holds a point: on an edge, or an odd number of edges to its right."""
    odd = False
    for p, q in zip(curve, curve[1:] + curve[:1], strict=True):
        if _turn(p, q, point) == 0 and _between(p, q, point):
            return True
        if (p[1] > point[1]) != (q[1] > point[1]):
            low, high = (p, q) if p[1] < q[1] else (q, p)
            odd ^= _turn(low, high, point) > 0
    return odd
