"""Which closed curves lie inside which: by this a sheet's curves become parts, rings and precedence."""

from collections.abc import Sequence

import numpy as np
import shapely

from cutgap.instances.arrays import Floats


def enclosures(curves: Sequence[Floats]) -> list[list[int]]:
    """Return for each curve the curves that enclose it, the innermost first.

    Parameters
    ----------
    curves
        Closed polylines of shape (k, 2), mm, first point not repeated, which do not cross each other.
        Of equal curves the later one counts as inside.
    """
    if not curves:
        return []
    areas = shapely.polygons([shapely.linearrings(curve) for curve in curves])
    sizes = shapely.area(areas)
    tree = shapely.STRtree(areas)
    around: list[list[int]] = [[] for _ in curves]
    # A point inside says where a curve lies; its own points may touch another curve.
    inside = shapely.point_on_surface(areas)
    for inner, outer in np.transpose(tree.query(inside, "within")).tolist():
        if inner != outer and (sizes[outer], -outer) > (sizes[inner], -inner):
            around[inner].append(outer)
    return [sorted(each, key=lambda outer: (sizes[outer], -outer)) for each in around]
