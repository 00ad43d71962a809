"""Which outlines are near each other, by what links, and which no link can reach.

A link leads through waste only (``clearance``). Curves that bound the same piece of waste make a *region*: the
outside of all curves, or the inside of one hole with the curves directly in it. Within a region every outline
can be linked to every other one over nearest pairs of points, none of which is blocked: what blocked it would
be nearer to both. Between regions there is no link; where two touch they are one.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import numpy.typing as npt
import shapely

from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.instance import Instance
from cutgap.instances.links.clearance import blocked_segments, depth, require_shapes
from cutgap.instances.nesting import enclosures

NEAREST = 6
"""How many nearest outlines count as near."""

CORNERS = 24
"""Most corners of a curve that the search for links looks at."""

BATCH = 64
"""How many links are tried at once where a nearest pair is blocked."""

Rings = npt.NDArray[np.object_]

OUTSIDE = -1
"""The region outside of all curves."""


@dataclass(frozen=True, slots=True)
class NearPair:
    """Two outlines and their shortest clear link that was found.

    Attributes
    ----------
    contours
        Indices of the outlines, ascending.
    ends
        Shape (2, 2), mm: the point on the first one, and on the other.
    spanning
        Whether it is needed to keep the outlines of a region connected.
    """

    contours: tuple[int, int]
    ends: Floats
    spanning: bool

    @property
    def length(self) -> float:
        """Length of the link, mm."""
        return float(np.linalg.norm(self.ends[1] - self.ends[0]))


def link_regions(instance: Instance) -> list[int]:
    """Return for each contour the region that its links lie in: the hole that bounds it, or ``OUTSIDE``.

    Raises
    ------
    ValueError
        As ``require_shapes`` does.
    """
    curves = require_shapes(instance)
    regions = np.array(
        [c if len(each) % 2 else each[0] if each else OUTSIDE for c, each in enumerate(enclosures(curves))],
        dtype=np.int64,
    )
    if len(regions):
        rings = np.array([closed_ring(curve) for curve in curves])
        # A web this thin hinders no link: it may run so deep in material from either side.
        touching = shapely.STRtree(rings).query(rings, "dwithin", 2.0 * depth(instance))
        for a, b in touching.T.tolist():
            one, other = sorted((int(regions[a]), int(regions[b])))
            regions[regions == other] = one
    return [int(region) for region in regions]


def unreachable(instance: Instance) -> list[str]:
    """Return the ids of the contours that no chain of links joins to the others, wherever links end.

    The others are the region with the most contours, of equal ones that of the first contour. One pierce is
    enough only if the list is empty; at least as many are needed as there are regions (``link_regions``).
    """
    regions = link_regions(instance)
    if not regions:
        return []
    largest = max(dict.fromkeys(regions), key=regions.count)
    return [contour.id for contour, region in zip(instance.contours, regions, strict=True) if region != largest]


def near_pairs(instance: Instance) -> list[NearPair]:
    """Return near outlines with clear links, those needed for connection first, then by length.

    Near are the ``NEAREST`` nearest of each outline in its region, and the pairs of a minimum spanning tree.
    Where the nearest pair of points is blocked the link is the shortest clear one among those from corner to
    corner and from a corner to the nearest point of the other curve, for corners as in ``thinned``.
    """
    curves = require_shapes(instance)
    rings = np.array([closed_ring(curve) for curve in curves])
    regions = np.array(link_regions(instance), dtype=np.int64)
    asked: dict[tuple[int, int], bool] = {}
    for region in np.unique(regions):
        members = np.flatnonzero(regions == region)
        for pairs, spanning in ((_spanning(rings[members]), True), (_nearest(rings[members]), False)):
            for a, b in members[pairs].tolist():
                asked.setdefault((min(a, b), max(a, b)), spanning)
    if not asked:
        return []
    one, other = np.array(list(asked), dtype=np.int64).T
    lines = shapely.get_coordinates(shapely.shortest_line(rings[one], rings[other])).reshape(-1, 2, 2)
    bad = blocked_segments(instance, lines[:, 0], lines[:, 1])
    corners = [thinned(curve) for curve in curves]
    found = []
    for (pair, spanning), line, is_blocked in zip(asked.items(), lines, bad.tolist(), strict=True):
        ends = _clear_link(instance, rings, corners, pair) if is_blocked else line
        if ends is not None:
            found.append(NearPair(pair, ends, spanning))
    return sorted(found, key=lambda each: (not each.spanning, each.length, each.contours))


def closed_ring(curve: Floats) -> shapely.LinearRing:
    """Return a curve as a ring, points that repeat the one before left out."""
    return shapely.LinearRing(shapely.remove_repeated_points(shapely.LinearRing(curve)))


def thinned(curve: Floats) -> Floats:
    """Return at most ``CORNERS`` corners of a curve, shape (k, 2).

    All of them where they are few enough, else those that Douglas-Peucker keeps at the first tolerance among
    1, 2, 4, ... ten-thousandths of the curve's extent that leaves few enough.
    """
    tolerance = 1e-4 * float(np.ptp(curve, axis=0).max())
    kept = curve
    while len(kept) > CORNERS:
        ring = shapely.LinearRing(curve).simplify(tolerance, preserve_topology=True)
        kept = shapely.get_coordinates(ring)[:-1]
        tolerance *= 2
    return kept


def _nearest(rings: Rings) -> Ints:
    """Return each outline with its ``NEAREST`` nearest ones, shape (k, 2)."""
    wanted = min(NEAREST, len(rings) - 1)
    if wanted < 1:
        return np.empty((0, 2), dtype=np.int64)
    tree = shapely.STRtree(rings)
    left, low, right, top = shapely.total_bounds(rings)
    radius = max(right - left, top - low) / np.sqrt(len(rings))
    waiting = np.arange(len(rings))
    found = []
    while len(waiting):
        place, other = tree.query(rings[waiting], "dwithin", radius)
        one = waiting[place]
        enough = np.bincount(one[one != other], minlength=len(rings)) >= wanted
        done = enough[one] & (one != other)
        found.append(np.column_stack((one[done], other[done])))
        waiting = waiting[~enough[waiting]]
        radius *= 2.0
    pairs = np.concatenate(found)
    distances = shapely.distance(rings[pairs[:, 0]], rings[pairs[:, 1]])
    order = np.lexsort((pairs[:, 1], distances, pairs[:, 0]))
    pairs = pairs[order]
    first = np.searchsorted(pairs[:, 0], np.arange(len(rings)))
    return pairs[(first[:, None] + np.arange(wanted)).ravel()]


def _spanning(rings: Rings) -> Ints:
    """Return a minimum spanning tree of the distances of outlines (Boruvka), shape (k, 2).

    Equal distances may close circles.
    """
    group = np.arange(len(rings))
    pairs: list[tuple[int, int]] = []
    while len(np.unique(group)) > 1:
        joins = list(_joins(rings, group))
        for a, b in joins:
            group[group == group[b]] = group[a]
        pairs += joins
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def _joins(rings: Rings, group: Ints) -> Iterator[tuple[int, int]]:
    """Yield for each group its nearest outline of another group, with the own one that it is nearest to."""
    for each in np.unique(group).tolist():
        inside, outside = np.flatnonzero(group == each), np.flatnonzero(group != each)
        tree = shapely.STRtree(rings[outside])
        (own, other), distance = tree.query_nearest(rings[inside], return_distance=True)
        best = min(range(len(distance)), key=lambda k: (distance[k], inside[own[k]], outside[other[k]]))
        yield int(inside[own[best]]), int(outside[other[best]])


def _clear_link(
    instance: Instance, rings: Rings, corners: list[Floats], pair: tuple[int, int]
) -> Floats | None:
    """Return the ends of the shortest clear link among those of ``near_pairs``, or ``None``."""
    one, other = (corners[contour] for contour in pair)
    lines = np.concatenate(
        (
            np.stack((np.repeat(one, len(other), axis=0), np.tile(other, (len(one), 1))), axis=1),
            np.stack((one, nearest_points(one, rings[pair[1]])), axis=1),
            np.stack((nearest_points(other, rings[pair[0]]), other), axis=1),
        )
    )
    lines = lines[np.argsort(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1), kind="stable")]
    for begin in range(0, len(lines), BATCH):
        batch = lines[begin : begin + BATCH]
        clear = np.flatnonzero(~blocked_segments(instance, batch[:, 0], batch[:, 1]))
        if len(clear):
            return np.array(batch[clear[0]])
    return None


def nearest_points(points: Floats, ring: shapely.Geometry) -> Floats:
    """Return the nearest point of a curve to each point, shape (k, 2), mm."""
    lines = shapely.shortest_line(shapely.points(points), ring)
    return np.array(shapely.get_coordinates(lines).reshape(-1, 2, 2)[:, 1])


def neighbours(pairs: list[NearPair], count: int) -> list[list[int]]:
    """Return for each of ``count`` contours those it is near to, ascending."""
    near: list[set[int]] = [set() for _ in range(count)]
    for a, b in (pair.contours for pair in pairs):
        near[a].add(b)
        near[b].add(a)
    return [sorted(each) for each in near]


def triangles(near: list[list[int]]) -> list[tuple[int, int, int]]:
    """Return the triples of contours that are near each other, ascending."""
    return [
        (a, b, c) for a, each in enumerate(near) for b, c in combinations(each, 2) if a < b and c in near[b]
    ]
