"""Plans with points of their own: each point is moved into its region, by next to nothing, and counts there.

A point of a file is a decimal, so it can be exactly on few segments and circles. The place that counts is a
rational point that is in the region for certain; a point farther than TOLERANCE away from it is refused.
"""

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from math import isqrt, lcm
from typing import Any

from cutgap.formulations.certificate.problem import Point, Problem
from cutgap.formulations.certificate.reading import entries, integer, number, require, show

TOLERANCE = Fraction(1, 10**9)
"""Of the largest coordinate, and of 1 mm."""
GRID = 10**24
"""Coordinates within an ellipsoid are rounded down to 1 / GRID."""


def pinned(problem: Problem, value: Any) -> tuple[Problem, list[list[list[Any]]]]:
    """Return the problem whose only entry points are those of the plan, and the plan in its terms.

    Visits are ``[id, entry]`` or ``[id, entry, [x, y, z]]``; contours without a visit keep their first point.
    """
    require(problem.metric != "matrix", "plan: a matrix holds no lengths to free entries")
    numbers = {name: contour for contour, name in enumerate(problem.ids)}
    points = [contour[1][0] for contour in problem.contours]
    tours: list[list[list[Any]]] = []
    for tour in entries(value, "plan"):
        tours.append([])
        for visit in entries(tour, "plan, tour"):
            name, entry, *own = entries(visit, "plan, visit")
            require(isinstance(name, str) and name in numbers, f"plan: no contour {show(name)}")
            contour = numbers[name]
            given = problem.contours[contour][1]
            known = integer(entry, "plan, entry", least=0) < len(given) and len(own) <= 1
            require(known, f"plan: contour {show(name)} has no entry point {show(entry)}")
            place = given[entry]
            if own:
                place = tuple(number(each, "plan, point") for each in entries(own[0], "plan, point", count=3))
            points[contour] = into(problem.region(contour), place, name)
            tours[-1].append([name, 0])
    homes = [problem.places[home] for home in problem.homes if home is not None]
    below = lcm(problem.denominator, *{each.denominator for point in points for each in point})
    places = [tuple(int(each * below) for each in point) for point in points]
    places += [tuple(each * (below // problem.denominator) for each in home) for home in homes]
    count = len(points)
    ends = iter(range(count, len(places)))
    return replace(
        problem,
        entries=tuple(range(contour, contour + 1) for contour in range(count)),
        homes=tuple(None if home is None else next(ends) for home in problem.homes),
        xs=tuple(point[0] for point in points),
        denominator=below,
        places=tuple(places),
    ), tours


def into(region: tuple[Sequence[Point], Sequence[Point]], place: Point, name: str) -> Point:
    """Return a point of a region near a place, or refuse."""
    points, axes = region
    inside = _in_ellipsoid(points[0], axes, place) if axes else _in_hull(points, place)
    away = sum(((a - b) ** 2 for a, b in zip(inside, place, strict=True)), Fraction(0))
    most = TOLERANCE * max(Fraction(1), *(abs(each) for each in place))
    require(away <= most * most, f"plan: contour {show(name)} is entered outside its region")
    return inside


def _in_ellipsoid(centre: Point, axes: Sequence[Point], place: Point) -> Point:
    """Return c + sum u_i a_i for nearly the best u of those with |u| <= 1.

    Least squares with a tiny weight on |u|^2, which makes axes that are not independent no exception.
    """
    offset = [a - b for a, b in zip(place, centre, strict=True)]
    gram = [[_dot(a, b) for b in axes] for a in axes]
    weight = sum((gram[i][i] for i in range(len(axes))), Fraction(1, 10**30)) / 10**30
    for i in range(len(axes)):
        gram[i][i] += weight
    u = _solved(gram, [_dot(axis, offset) for axis in axes])
    square = sum((each * each for each in u), Fraction(0))
    if square > 1:
        longer = Fraction(isqrt(square.numerator * GRID * GRID // square.denominator) + 1, GRID)
        u = [each / longer for each in u]
    u = [Fraction(int(each * GRID), GRID) for each in u]
    moved = [sum((each * axis[e] for each, axis in zip(u, axes, strict=True)), Fraction(0)) for e in range(3)]
    return tuple(a + b for a, b in zip(centre, moved, strict=True))


def _dot(a: Sequence[Fraction], b: Sequence[Fraction]) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def _solved(matrix: list[list[Fraction]], right: list[Fraction]) -> list[Fraction]:
    """Return the solution of a positive definite system, by elimination."""
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    for i in range(len(rows)):
        for j in range(len(rows)):
            if j != i:
                share = rows[j][i] / rows[i][i]
                rows[j] = [a - share * b for a, b in zip(rows[j], rows[i], strict=True)]
    return [row[-1] / row[i] for i, row in enumerate(rows)]


def _in_hull(points: Sequence[Point], place: Point) -> Point:
    """Return the nearest point of the hull of points at one height."""
    height = points[0][2]
    corners = _corners([(x, y) for x, y, _ in points])
    x, y, _ = place
    sides = list(pairwise([*corners, corners[0]]))
    if len(corners) > 2 and all(_turn(a, b, (x, y)) >= 0 for a, b in sides):
        return x, y, height
    best = min((_on_side(a, b, (x, y)) for a, b in sides), key=lambda at: (at[0] - x) ** 2 + (at[1] - y) ** 2)
    return *best, height


Place = tuple[Fraction, Fraction]


def _corners(places: list[Place]) -> list[Place]:
    """Return the corners of a convex hull counter-clockwise (Andrew's monotone chain)."""
    ordered = sorted(set(places))
    if len(ordered) < 3:
        return ordered
    halves = []
    for way in (ordered, ordered[::-1]):
        chain: list[Place] = []
        for place in way:
            while len(chain) > 1 and _turn(chain[-2], chain[-1], place) <= 0:
                chain.pop()
            chain.append(place)
        halves.append(chain[:-1])
    return halves[0] + halves[1]


def _turn(a: Place, b: Place, c: Place) -> Fraction:
    """Return twice the area of a triangle, positive when it turns left."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _on_side(a: Place, b: Place, place: Place) -> Place:
    """Return the point of the segment a b nearest to a place."""
    along = b[0] - a[0], b[1] - a[1]
    square = along[0] ** 2 + along[1] ** 2
    share = Fraction(0)
    if square > 0:
        share = ((place[0] - a[0]) * along[0] + (place[1] - a[1]) * along[1]) / square
    share = min(max(share, Fraction(0)), Fraction(1))
    return a[0] + share * along[0], a[1] + share * along[1]
