"""Which links are clear: a link must not lead through what remains of the sheet as a part.

Curves inside one another bound, from the outside in, a part, a hole in it, a part in the hole, and so on: what
lies inside an odd number of curves is material, the rest is waste. A link is blocked when some point of it lies
in the material, farther from its edge than ``DEPTH`` times the extent of all curves. The slack is needed since
the ends of links are rounded points of the curves; a link may touch a shape or lead along its edge.
"""

from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt
import shapely

from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.instance import Instance
from cutgap.instances.nesting import enclosures
from cutgap.instances.process import require_geometry

DEPTH = 1e-7
"""How deep a link may run in a part, relative to the extent of all curves: 1 um on a sheet of 10 m."""

Bools = npt.NDArray[np.bool_]


def depth(instance: Instance) -> float:
    """Return how deep a link may run in a part, mm."""
    curves = [contour.geometry for contour in instance.contours if contour.geometry is not None]
    if not curves:
        return 0.0
    points = np.concatenate(curves)
    return DEPTH * float(np.ptp(points, axis=0).max())


def require_shapes(instance: Instance) -> list[Floats]:
    """Return the curves of all contours, shape (k, 2) each.

    Raises
    ------
    ValueError
        When a contour has no curve or one that crosses itself or bounds no area, two curves cross or
        overlap, or an entry point is not on its curve; naming the contours.
    """
    require_geometry(instance, "links")
    curves = [contour.geometry for contour in instance.contours if contour.geometry is not None]
    slack = depth(instance)
    for contour, curve in zip(instance.contours, curves, strict=True):
        name = f"instance {instance.name!r}, contour {contour.id!r}"
        area = shapely.Polygon(curve)
        if not area.is_valid or area.area <= slack * area.length:
            reason = shapely.is_valid_reason(area) if not area.is_valid else "it bounds no area"
            raise ValueError(f"{name}, geometry: links need a simple closed curve: {reason}")
        away = shapely.distance(shapely.points(contour.entry_points[:, :2]), area.exterior)
        if (away > slack).any():
            worst = int(np.argmax(away))
            raise ValueError(
                f"{name}, entry_points[{worst}]: {away[worst]:g} mm off its curve, most {slack:g}; "
                "links need entry points on the curve"
            )
    if curves:
        _refuse_overlaps(instance, curves, slack)
    return curves


def _refuse_overlaps(instance: Instance, curves: list[Floats], slack: float) -> None:
    """Refuse areas that share more than their edges, where neither holds the other."""
    areas = shapely.polygons([shapely.linearrings(curve) for curve in curves])
    one, other = shapely.STRtree(areas).query(areas, "intersects")
    one, other = one[one < other], other[one < other]
    shared = shapely.area(shapely.intersection(areas[one], areas[other]))
    smaller = np.minimum(shapely.area(areas[one]), shapely.area(areas[other]))
    edge = slack * np.minimum(shapely.length(areas[one]), shapely.length(areas[other]))
    nested = np.abs(shared - smaller) <= edge
    same = nested & (np.abs(shapely.area(areas[one]) - shapely.area(areas[other])) <= edge)
    bad = np.flatnonzero(((shared > edge) & ~nested) | same)
    if len(bad):
        a, b = (instance.contours[int(which[bad[0]])].id for which in (one, other))
        raise ValueError(
            f"instance {instance.name!r}: contours {a!r} and {b!r} overlap by {shared[bad[0]]:g} mm2; "
            "links need curves that do not cross: move or drop one"
        )


@lru_cache(maxsize=16)
def _inner_material(instance: Instance) -> Any:
    """Return a search tree of the material, each piece without its edge of the allowed depth."""
    curves = require_shapes(instance)
    around = enclosures(curves)
    pieces: list[shapely.Polygon] = []
    for outer, curve in enumerate(curves):
        if len(around[outer]) % 2 == 0:
            holes = [curves[c] for c in range(len(curves)) if around[c][:1] == [outer]]
            pieces.append(shapely.Polygon(curve, holes))
    # A mitre keeps the edges straight, so that shrinking is exact but for rounding.
    shrunk = shapely.buffer(pieces, -depth(instance), join_style="mitre")
    shapely.prepare(shrunk)
    return shapely.STRtree(shrunk)


def blocked(instance: Instance, starts: npt.ArrayLike, ends: npt.ArrayLike) -> Bools:
    """Return which links lead through material, shape (links,).

    Parameters
    ----------
    starts, ends
        Nodes that the links join, shape (links,).

    Raises
    ------
    ValueError
        As ``require_shapes`` does.
    """
    first, last = (np.asarray(nodes, dtype=np.int64).reshape(-1) for nodes in (starts, ends))
    return blocked_segments(instance, instance.points[first, :2], instance.points[last, :2])


def blocked_segments(instance: Instance, starts: Floats, ends: Floats) -> Bools:
    """Return which links between given points, of shape (links, 2) in mm, lead through material."""
    found: Bools = np.zeros(len(starts), dtype=np.bool_)
    if len(starts):
        tree = _inner_material(instance)
        lines = shapely.linestrings(np.stack((starts, ends), axis=1))
        hit: Ints = tree.query(lines, "intersects")[0]
        found[hit] = True
    return found


def deepest_shares(instance: Instance, starts: Ints, ends: Ints) -> Floats:
    """Return for each link the share of its way at which it is well inside material, NaN where it is nowhere.

    That is the middle of its longest piece in a part without an edge of three times ``depth``.
    """
    tree = _inner_material(instance)
    inner = shapely.buffer(tree.geometries, -2 * depth(instance), join_style="mitre")
    a, b = instance.points[starts, :2], instance.points[ends, :2]
    lines = shapely.linestrings(np.stack((a, b), axis=1))
    best, found = np.zeros(len(lines)), np.full(len(lines), np.nan)
    for link, piece in np.transpose(tree.query(lines, "intersects")).tolist():
        for part in shapely.get_parts(shapely.intersection(lines[link], inner[piece])):
            if part.length > best[link]:
                middle = shapely.line_interpolate_point(part, 0.5, normalized=True)
                best[link] = part.length
                found[link] = shapely.line_locate_point(lines[link], middle, normalized=True)
    return found
