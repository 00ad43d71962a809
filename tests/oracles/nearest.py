"""Nearest pairs of closed polylines and their spanning trees by brute force, in plain Python."""

import math
from collections.abc import Callable, Sequence

Place = tuple[float, float]
Curve = Sequence[Place]


def edges(curve: Curve) -> list[tuple[Place, Place]]:
    """Return the edges of a closed polyline."""
    return [(curve[i - 1], curve[i]) for i in range(len(curve))]


def foot(point: Place, edge: tuple[Place, Place]) -> Place:
    """Return the point of an edge nearest to a point."""
    (x, y), (u, v) = edge
    along = (u - x, v - y)
    square = along[0] ** 2 + along[1] ** 2
    share = ((point[0] - x) * along[0] + (point[1] - y) * along[1]) / square
    share = min(1.0, max(0.0, share))
    return (x + share * along[0], y + share * along[1])


def foot_on(point: Place, curve: Curve) -> Place:
    """Return the point of a curve nearest to a point."""
    return min((foot(point, edge) for edge in edges(curve)), key=lambda each: math.dist(point, each))


def distance(one: Curve, other: Curve) -> float:
    """Return the least distance of two curves that do not cross: one end of it is a corner."""
    from_one = min(math.dist(point, foot_on(point, other)) for point in one)
    return min(from_one, *(math.dist(point, foot_on(point, one)) for point in other))


def spanning_length(count: int, length: Callable[[int, int], float]) -> float:
    """Return the length of a minimum spanning tree (Prim)."""
    inside, total = {0}, 0.0
    while len(inside) < count:
        step, new = min((length(a, b), b) for a in inside for b in range(count) if b not in inside)
        inside.add(new)
        total += step
    return total
