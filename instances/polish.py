r"""Entry points that move along their curves while the order stays: the shortest way that is near.

    (1) over all samples: the shortest way through a sample of each curve, by dynamic programming
    (2) one at a time: p_k = argmin over its curve of |a - p| + |p - b|, a and b the stops before and after

On a straight edge with a, b at distances g, h from its line and at places s, t along it, the least of (2) is at
(s h + t g) / (g + h), or at the nearer end where that is not on the edge: turned round the line, b comes to the
other side of a, and the way is straight. So (2) is exact on a polyline; repeated, it gives a local optimum.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from cutgap.instances.arrays import Floats
from cutgap.instances.instance import Instance
from cutgap.instances.plan import Plan, Visit
from cutgap.instances.region import Hull
from cutgap.instances.sampling import curve_of

SAMPLES = 64
MOST_SWEEPS = 1000
LEAST_GAIN = 1e-12
"""Relative gain of a sweep below which (2) ends."""


def polished(instance: Instance, plan: Plan) -> Plan:
    """Return a plan of one head in the same order, entered anywhere on the curves, and no longer.

    Raises
    ------
    ValueError
        When there are several heads, the metric is not euclidean, or a contour has no curve.
    """
    if len(plan.tours) != 1 or instance.machine.metric != "euclidean":
        raise ValueError(f"instance {instance.name!r}: needs one head and the metric euclidean")
    (tour,) = plan.tours
    if not tour:
        return plan
    curves = [curve_of(instance.contours[visit.contour]) for visit in tour]
    home = instance.heads[0].home
    given = np.array([_place(instance, visit) for visit in tour])
    starts = [given, _through_samples(curves, given, home)]
    ways = [_swept(curves, start, home) for start in starts]
    best = min(ways, key=lambda way: _length(way, home))
    visits = [Visit(visit.contour, 0, tuple(p)) for visit, p in zip(tour, best.tolist(), strict=True)]
    return Plan((tuple(visits),))


def _place(instance: Instance, visit: Visit) -> Floats:
    own = instance.contours[visit.contour].entry_points[visit.entry]
    return own if visit.point is None else np.array(visit.point)


def _length(way: Floats, home: Floats | None) -> float:
    closed = np.concatenate(
        (way[-1:] if home is None else home[None], way, *([] if home is None else [home[None]]))
    )
    return float(np.linalg.norm(np.diff(closed, axis=0), axis=1).sum())


def _through_samples(curves: Sequence[Floats], given: Floats, home: Floats | None) -> Floats:
    """Return (1), the given points among the samples."""
    layers = [np.vstack((p, Hull(c).boundary(SAMPLES))) for p, c in zip(given, curves, strict=True)]
    firsts = [layers[0][k : k + 1] for k in range(len(layers[0]))] if home is None else [home[None]]
    layers = layers[1:] if home is None else layers
    found = [_shortest_through([first, *layers, first]) for first in firsts]
    way = min(found, key=lambda each: each[0])[1]
    return way[:-1] if home is None else way[1:-1]


def _shortest_through(layers: Sequence[Floats]) -> tuple[float, Floats]:
    """Return the shortest way through a point of each layer, and its length."""
    length = np.zeros(len(layers[0]))
    choices = []
    for before, after in pairwise(layers):
        total = length[:, None] + np.linalg.norm(before[:, None] - after, axis=2)
        choices.append(total.argmin(axis=0))
        length = total.min(axis=0)
    place = int(length.argmin())
    least, way = float(length[place]), [layers[-1][place]]
    for layer, choice in zip(layers[-2::-1], reversed(choices), strict=True):
        place = int(choice[place])
        way.append(layer[place])
    return least, np.array(way[::-1])


def _swept(curves: Sequence[Floats], start: Floats, home: Floats | None) -> Floats:
    """Return (2), repeated until it gains no more."""
    way, length = start.copy(), _length(start, home)
    for _ in range(MOST_SWEEPS):
        for k, curve in enumerate(curves):
            before = way[k - 1] if k > 0 or home is None else home
            after = way[(k + 1) % len(way)] if k + 1 < len(way) or home is None else home
            moved = nearest_between(curve, before, after)
            if _detour(before, moved, after) < _detour(before, way[k], after):
                way[k] = moved
        gained = length - _length(way, home)
        length -= gained
        if gained <= LEAST_GAIN * length:
            break
    return way


def _detour(before: Floats, point: Floats, after: Floats) -> float:
    return float(np.linalg.norm(before - point) + np.linalg.norm(point - after))


def nearest_between(curve: Floats, before: Floats, after: Floats) -> Floats:
    """Return the point of a closed polyline with the least way from ``before`` over it to ``after``."""
    edges = np.roll(curve, -1, axis=0) - curve
    squares = np.maximum((edges**2).sum(axis=1), 1e-300)
    s, t = (((stop - curve) * edges).sum(axis=1) / squares for stop in (before, after))
    g, h = (
        np.linalg.norm(stop - curve - along[:, None] * edges, axis=1)
        for stop, along in ((before, s), (after, t))
    )
    apart = g + h
    share = np.where(apart > 0, (s * h + t * g) / np.where(apart > 0, apart, 1.0), s)
    points = curve + np.clip(share, 0.0, 1.0)[:, None] * edges
    ways = np.linalg.norm(points - before, axis=1) + np.linalg.norm(points - after, axis=1)
    return points[int(ways.argmin())]
