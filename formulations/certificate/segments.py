"""Points, segments and closed polylines in the plane, exactly."""

from collections.abc import Iterable
from fractions import Fraction

Corner = tuple[int, int]
Edge = tuple[Corner, Corner]
Place = tuple[int | Fraction, int | Fraction]


def meet(p: Corner, q: Corner, a: Corner, b: Corner) -> bool:
    """Whether the closed segments p q and a b have a point in common."""
    one, two = turn(p, q, a), turn(p, q, b)
    if one * two > 0:
        return False
    three, four = turn(a, b, p), turn(a, b, q)
    if three * four > 0:
        return False
    if one or two or three or four:
        return True
    return between(p, q, a) or between(p, q, b) or between(a, b, p)


def turn(a: Place, b: Place, c: Place) -> int:
    """Return 1, 0, -1 for a turn to the left, none, to the right."""
    area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return (area > 0) - (area < 0)


def between(a: Place, b: Place, c: Place) -> bool:
    """Whether c, on the line through a and b, lies in their box."""
    return min(a[0], b[0]) <= c[0] <= max(a[0], b[0]) and min(a[1], b[1]) <= c[1] <= max(a[1], b[1])


def inside(point: Place, edges: Iterable[tuple[Place, Place]]) -> bool:
    """Whether a ray to the right leaves the curve an odd number of times; the point is not on it."""
    x, y = point
    odd = False
    for (ax, ay), (bx, by) in edges:
        if (ay > y) != (by > y):
            # The edge meets the ray when the point is on the left of it, seen upwards.
            left = (bx - ax) * (y - ay) - (by - ay) * (x - ax)
            odd ^= (left > 0) == (by > ay)
    return odd


def doubled_area(edges: list[Edge]) -> int:
    """Return twice the area that a closed polyline has around it."""
    return abs(sum(a[0] * b[1] - a[1] * b[0] for a, b in edges))


def box(points: list[Corner]) -> tuple[int, int, int, int]:
    """Return the least x and y and the largest."""
    xs, ys = [x for x, _ in points], [y for _, y in points]
    return min(xs), min(ys), max(xs), max(ys)
