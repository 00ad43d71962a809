"""Contours that may be entered anywhere in a region, and plans that say where.

Such a plan has a point of its own for each visit. ``pinned`` makes it a plan of an instance whose entry points
are these points, so that every figure and rule is computed as ever.
"""

from dataclasses import replace

import numpy as np
import shapely

from cutgap.instances.arrays import Floats
from cutgap.instances.instance import Contour, Instance
from cutgap.instances.plan import Plan, Visit
from cutgap.instances.region import Hull, Region, point_region
from cutgap.instances.rules import Rules
from cutgap.instances.violation import Violation

TOLERANCE = 1e-9
"""How far a point may be outside its region, relative to its largest coordinate and at least 1 mm."""

FLATNESS = 1e-9
"""Relative area that a polyline may lack to its hull and still count as convex: rounding of its points."""


def region_of(instance: Instance, contour: int, *, hull: bool = False) -> Region:
    """Return the region in which a contour may be entered.

    It is the one that the contour has; else what its polyline encloses, at the height z of its entry points;
    else its only entry point.

    Parameters
    ----------
    contour
        Index within the instance.
    hull
        Whether to take the convex hull of a polyline that is not convex: bounds stay valid but become weaker.

    Raises
    ------
    ValueError
        When there is no such region: the polyline is not convex, its entry points differ in z, or there are
        several entry points and no curve.
    """
    given = instance.contours[contour]
    name = f"instance {instance.name!r}, contour {given.id!r}"
    if given.region is not None:
        return given.region
    if given.geometry is None:
        if len(given.entry_points) > 1:
            count = len(given.entry_points)
            raise ValueError(f"{name}: {count} entry points and no region; give it a region or a geometry")
        return point_region(given.entry_points[0])
    heights = given.entry_points[:, 2]
    if (heights != heights[0]).any():
        raise ValueError(
            f"{name}: its entry points differ in z, from {heights.min():g} to {heights.max():g} mm"
        )
    if not hull and not is_convex(given.geometry):
        raise ValueError(f"{name}: not convex: take its hull with hull=True, a weaker but valid bound")
    return Hull(np.column_stack((given.geometry, np.full(len(given.geometry), heights[0]))))


def is_convex(curve: Floats) -> bool:
    """Whether a closed polyline, shape (k, 2), bounds a convex area (or a segment), but for rounding."""
    polygon = shapely.Polygon(curve)
    around = polygon.convex_hull.area
    if around == 0.0:
        return True
    return bool(polygon.exterior.is_simple and polygon.area >= (1.0 - FLATNESS) * around)


def pinned(instance: Instance, plan: Plan) -> tuple[Instance, Plan]:
    """Return instance and plan with the plan's own points as the entry points of the contours that it visits.

    Without such points both are returned as they are.

    Raises
    ------
    ValueError
        When the plan has points, and the instance has a matrix, which holds no lengths to them.
    """
    if all(visit.point is None for tour in plan.tours for visit in tour):
        return instance, plan
    if instance.matrix is not None:
        raise ValueError(
            f"instance {instance.name!r} has a matrix, which holds no lengths to a plan's own points"
        )
    if plan.links:
        raise ValueError("plan: has links and points of its own; links join entry points of the instance")
    places: dict[int, list[Floats]] = {}
    tours = []
    for tour in plan.tours:
        visits = []
        for visit in tour:
            stops = places.setdefault(visit.contour, [])
            stops.append(place_of(instance, visit))
            visits.append(Visit(visit.contour, len(stops) - 1))
        tours.append(tuple(visits))
    contours = tuple(_moved(contour, places.get(index)) for index, contour in enumerate(instance.contours))
    return replace(instance, contours=contours), Plan(tuple(tours))


def _moved(contour: Contour, places: list[Floats] | None) -> Contour:
    return contour if places is None else replace(contour, entry_points=np.array(places))


def place_of(instance: Instance, visit: Visit) -> Floats:
    """Return where a visit is: its point, else its entry point; shape (3,), mm."""
    if visit.point is not None:
        return np.array(visit.point)
    place: Floats = instance.contours[visit.contour].entry_points[visit.entry]
    return place


def entries_in_regions(instance: Instance, rules: Rules, plan: Plan) -> list[Violation]:
    """With free entries each visit is in its contour's region; without, no visit has a point of its own."""
    broken = []
    for visit in (visit for tour in plan.tours for visit in tour):
        name = f"contour {instance.contours[visit.contour].id!r}"
        if not rules.free_entries:
            if visit.point is not None:
                broken.append(Violation("entry points", f"{name} has a point of its own", 1, "points"))
            continue
        place = place_of(instance, visit)
        region = region_of(instance, visit.contour)
        if not region.contains(place, TOLERANCE * max(1.0, float(np.abs(place).max()))):
            away = float(np.linalg.norm(place - region.nearest(place)))
            broken.append(Violation("entry in region", f"{name} is entered outside its region", away, "mm"))
    return broken
