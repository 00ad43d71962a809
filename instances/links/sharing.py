r"""Points at which a contour shares its links with two others.

Each node has an even number of passes. A link that is passed once therefore meets another one at both ends, and
what an optimum passes once are circles of links through shared points.

    (1) triangle   p in A, q in B, r in C  with least  |p - q| + |q - r| + |r - p|
    (2) chain      p in A                  with least  d(p, B) + d(p, C), links to the nearest points

(2) is searched among the corners of A, the ends of its links, and the nearest points of A to the corners of B
and C: between these places the nearest features of polygons seldom change. (1) starts from the best chain of
its three and moves one point at a time to its best place on its curve, which is exact for each edge:

    (3) least |p - u| + |p - v| on a line is where the line to v, mirrored to the other side, meets it
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import shapely

from cutgap.instances.arrays import Floats
from cutgap.instances.instance import Instance
from cutgap.instances.links.clearance import blocked_segments, require_shapes
from cutgap.instances.links.near import (
    NearPair,
    Rings,
    closed_ring,
    nearest_points,
    neighbours,
    thinned,
    triangles,
)

ROUNDS = 8
"""How often each point of a triangle is moved."""


@dataclass(frozen=True, slots=True)
class Shared:
    """Contours, a point on each, shape (k, 2), and the length of the links between them, mm."""

    contours: tuple[int, ...]
    points: Floats
    length: float


def chains(instance: Instance, pairs: list[NearPair]) -> list[Shared]:
    """Return the best chain found by (2) for each contour and each two near ones, shared point first."""
    curves = require_shapes(instance)
    near = neighbours(pairs, len(curves))
    rings = np.array([closed_ring(curve) for curve in curves])
    corners = [thinned(curve) for curve in curves]
    ends: list[list[Floats]] = [[] for _ in curves]
    for pair in pairs:
        for contour, end in zip(pair.contours, pair.ends, strict=True):
            ends[contour].append(end[None])
    found: list[Shared] = []
    for contour, others in enumerate(near):
        if len(others) < 2:
            continue
        feet = nearest_points(np.concatenate([corners[each] for each in others]), rings[contour])
        pool = np.unique(np.concatenate((corners[contour], *ends[contour], feet)), axis=0)
        found += _chains_at(instance, contour, others, pool, rings)
    return found


def _chains_at(
    instance: Instance, contour: int, others: list[int], pool: Floats, rings: Rings
) -> Iterator[Shared]:
    """Yield the best chain over the points of a pool for each two other contours."""
    lines = shapely.shortest_line(shapely.points(pool)[:, None], rings[others][None])
    feet = shapely.get_coordinates(lines.ravel()).reshape(len(pool), len(others), 2, 2)[:, :, 1]
    starts = np.repeat(pool, len(others), axis=0)
    closed = blocked_segments(instance, starts, feet.reshape(-1, 2)).reshape(len(pool), len(others))
    lengths = np.where(closed, np.inf, np.linalg.norm(feet - pool[:, None], axis=2))
    for i, j in combinations(range(len(others)), 2):
        sums = lengths[:, i] + lengths[:, j]
        best = int(np.argmin(sums))
        if np.isfinite(sums[best]):
            points = np.stack((pool[best], feet[best, i], feet[best, j]))
            yield Shared((contour, others[i], others[j]), points, float(sums[best]))


def triangle_points(instance: Instance, pairs: list[NearPair], made: list[Shared]) -> list[Shared]:
    """Return by (1) the triangles that are clear and shorter than their two shortest links, passed twice.

    Parameters
    ----------
    pairs
        Near outlines.
    made
        Chains, from which the search starts.
    """
    curves = [shapely.get_coordinates(closed_ring(curve))[:-1] for curve in require_shapes(instance)]
    links = {pair.contours: pair.length for pair in pairs}
    starts: dict[tuple[int, ...], Shared] = {}
    for chain in made:
        key = tuple(sorted(chain.contours))
        if key not in starts or chain.length < starts[key].length:
            starts[key] = chain
    found = []
    for a, b, c in triangles(neighbours(pairs, len(curves))):
        short, middle, long = sorted((links[a, b], links[a, c], links[b, c]))
        # No side is shorter than the link of its two contours.
        if (a, b, c) in starts and long < short + middle:
            shared = _tightened(starts[a, b, c], curves)
            if shared.length < 2.0 * (short + middle):
                found.append(shared)
    if not found:
        return []
    points = np.stack([shared.points for shared in found])
    closed = blocked_segments(instance, points.reshape(-1, 2), np.roll(points, -1, axis=1).reshape(-1, 2))
    return [shared for shared, bad in zip(found, closed.reshape(-1, 3), strict=True) if not bad.any()]


def _tightened(chain: Shared, curves: list[Floats]) -> Shared:
    """Return the triangle that a chain becomes when its points move in turn by (3)."""
    points = chain.points.copy()
    for step in range(3 * ROUNDS):
        corner = (step + 1) % 3  # the shared point is the best one already
        points[corner] = between(curves[chain.contours[corner]], points[corner - 1], points[corner - 2])
    sides = points - np.roll(points, 1, axis=0)
    return Shared(chain.contours, points, float(np.linalg.norm(sides, axis=1).sum()))


def between(curve: Floats, one: Floats, other: Floats) -> Floats:
    """Return the point of a closed curve with the least sum of distances to two points, by (3)."""
    along = np.roll(curve, -1, axis=0) - curve
    lengths = np.linalg.norm(along, axis=1)
    along = along / lengths[:, None]
    (t, h), (u, k) = ((_along(curve, along, point)) for point in (one, other))
    total = h + k
    place = np.where(total > 0, (t * k + u * h) / np.where(total > 0, total, 1.0), t)
    points = curve + np.clip(place, 0.0, lengths)[:, None] * along
    sums = np.linalg.norm(points - one, axis=1) + np.linalg.norm(points - other, axis=1)
    return np.array(points[int(np.argmin(sums))])


def _along(curve: Floats, along: Floats, point: Floats) -> tuple[Floats, Floats]:
    """Return where a point stands along the line of each edge, and how far from it."""
    away = point - curve
    return (away * along).sum(axis=1), np.abs(away[:, 0] * along[:, 1] - away[:, 1] * along[:, 0])
