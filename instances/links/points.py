"""Link points: the places on its curve at which a contour may be linked, pierced and left.

The entry points of each contour become, in this order, as long as there are fewer than ``MOST`` of them:

    1. ends of the clear links to near outlines (``near.near_pairs``), the shortest first; those that keep all
       outlines of a region connected are always in
    2. the point nearest to each home
    3. points of triangles of links (``sharing``), the shortest first
    4. points of chains: the shared point, then the ends of its two links, the shortest first
    5. at most ``FAR_CORNERS`` corners, each time the one farthest from the points that are there

A point is left out when one is there already within ``depth / 10`` (1e-8 of the extent of all curves); in 3 and
4 also when one is within ``SAME`` times the length of the triangle or chain that it belongs to.

Curves are polylines here: what was an arc is off it by up to the tolerance of the file's reader (``--chord``
for drawings). Bounds and optima hold for the link points, as they do for given entry points.
"""

from dataclasses import replace

import numpy as np
from scipy.spatial.distance import cdist

from cutgap.instances.arrays import Floats
from cutgap.instances.instance import Contour, Instance
from cutgap.instances.links.clearance import depth, require_shapes
from cutgap.instances.links.near import closed_ring, near_pairs, nearest_points
from cutgap.instances.links.sharing import chains, triangle_points

MOST = 16
"""Most link points of a contour, but for those without which outlines would not be connected."""

FAR_CORNERS = 4
"""Most corners that are there for no link."""

SAME = 0.01
"""Shared points this near to another one, relative to the length of their links, are left out."""


def with_link_points(instance: Instance, most: int = MOST) -> Instance:
    """Return the instance with the link points of its curves as entry points.

    Whatever its entry points were: they count for nothing but their height, which is that of the nearest one.
    Link points depend on the curves and homes alone, not on the order of the contours, but for ties.

    Parameters
    ----------
    most
        Most points of a contour, at least 1.

    Raises
    ------
    ValueError
        When the instance has a matrix, which holds no lengths to other points, or as ``require_shapes`` does,
        but for entry points off their curves.
    """
    if most < 1:
        raise ValueError(f"link points: expected at least 1 a contour, got {most}")
    if instance.matrix is not None:
        raise ValueError(f"instance {instance.name!r} has a matrix, which holds no lengths to link points")
    bare = replace(instance, contours=tuple(map(_without_entries, instance.contours)))
    return replace(
        instance,
        contours=tuple(
            replace(contour, entry_points=_with_height(points, contour))
            for contour, points in zip(instance.contours, _chosen(bare, most), strict=True)
        ),
    )


def _without_entries(contour: Contour) -> Contour:
    """Return a contour whose entry points are surely on its curve."""
    if contour.geometry is None:
        return contour
    return replace(contour, entry_points=np.append(contour.geometry[0], 0.0)[None])


def _with_height(points: Floats, contour: Contour) -> Floats:
    """Return points (k, 2) with the z of the nearest entry point, shape (k, 3)."""
    nearest = cdist(points, contour.entry_points[:, :2]).argmin(axis=1)
    return np.column_stack((points, contour.entry_points[nearest, 2]))


def _chosen(instance: Instance, most: int) -> list[Floats]:
    """Return the link points of each contour, shape (k, 2)."""
    curves = require_shapes(instance)
    same = depth(instance) / 10
    choices = [_Choice(most, same) for _ in curves]
    pairs = near_pairs(instance)
    for pair in pairs:
        for contour, end in zip(pair.contours, pair.ends, strict=True):
            choices[contour].add(end, needed=pair.spanning)
    for head in instance.heads:
        for choice, curve in zip(choices, curves, strict=True):
            if head.home is not None:
                choice.add(nearest_points(head.home[None, :2], closed_ring(curve))[0])
    made = chains(instance, pairs)
    for group in (triangle_points(instance, pairs, made), made):
        for shared in sorted(group, key=lambda each: (each.length, each.contours)):
            for contour, point in zip(shared.contours, shared.points, strict=True):
                choices[contour].add(point, apart=SAME * shared.length)
    for choice, curve in zip(choices, curves, strict=True):
        choice.add_far(curve)
    return [np.array(choice.points) for choice in choices]


class _Choice:
    """The link points of one contour while they are being chosen."""

    def __init__(self, most: int, same: float) -> None:
        self.points: list[Floats] = []
        self.most, self.same = most, same

    def add(self, point: Floats, *, apart: float = 0.0, needed: bool = False) -> None:
        """Take a point in, if there is room or it is needed, and none is there within ``apart``."""
        if len(self.points) >= self.most and not needed:
            return
        if self.points and self.away(point[None])[0] <= max(self.same, apart):
            return
        self.points.append(point)

    def away(self, points: Floats) -> Floats:
        """Return how far each of some points is from the chosen ones, mm."""
        return np.array(cdist(points, np.array(self.points)).min(axis=1))

    def add_far(self, curve: Floats) -> None:
        """Take in the corners of rule 5."""
        for _ in range(FAR_CORNERS):
            farthest = int(self.away(curve).argmax()) if self.points else 0
            self.add(curve[farthest])
