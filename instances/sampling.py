"""Curves of contours as closed polylines, and entry points sampled on them."""

from dataclasses import replace

import numpy as np

from cutgap.instances.arrays import Floats
from cutgap.instances.instance import Contour, Instance
from cutgap.instances.region import Ellipsoid, Hull

FINE = 256
"""Corners of the polyline that stands for the curve of an ellipsoid; they lie on it."""


def curve_of(contour: Contour) -> Floats:
    """Return the curve as a closed polyline, shape (k, 3), mm, first point not repeated.

    Of a region that is an ellipsoid it has ``FINE`` corners; a contour without curve has its entry point alone.

    Raises
    ------
    ValueError
        When there are several entry points and no curve, or they differ in height.
    """
    if contour.region is not None:
        return contour.region.boundary(FINE)
    if contour.geometry is None:
        if len(contour.entry_points) > 1:
            raise ValueError(f"contour {contour.id!r}: several entry points and no curve to sample")
        return contour.entry_points
    heights = contour.entry_points[:, 2]
    if (heights != heights[0]).any():
        raise ValueError(f"contour {contour.id!r}: its entry points differ in z, so its curve has no height")
    return np.column_stack((contour.geometry, np.full(len(contour.geometry), heights[0])))


def sampled(instance: Instance, count: int) -> Instance:
    """Return the instance with ``count`` entry points on each curve, evenly spaced along it.

    Twice as many points contain these ones. Contours without a curve keep their entry point.

    Raises
    ------
    ValueError
        When the count is below 1, the lengths are a matrix, or ``curve_of`` finds no curve.
    """
    if count < 1:
        raise ValueError(f"count: expected at least 1 entry point a contour, got {count}")
    if instance.matrix is not None:
        raise ValueError(f"instance {instance.name!r} has a matrix, which holds no lengths to sampled points")
    contours = [replace(contour, entry_points=_samples(contour, count)) for contour in instance.contours]
    return replace(instance, contours=tuple(contours))


def _samples(contour: Contour, count: int) -> Floats:
    if isinstance(contour.region, Ellipsoid):
        return contour.region.boundary(count)
    curve = curve_of(contour)
    return curve if len(curve) == 1 else Hull(curve).boundary(count)
