r"""The spanning-tree bound of problems with links, whatever the link points: for given ones and for any others.

    Data  d_ij    distance of the curves of i and j, or of a curve and the home, in the plane            [mm]
          c_ij    least cost of a way between them:
                  travel         d_ij
                  makespan       min(d_ij / v_cut, d_ij / v_jump + t_aux), the latter unless all is one stroke;
                                 to the home d_ij / v_jump + t_aux / 2                                   [s]
          W       makespan: sum(perimeter) / v_cut, travel: 0
          M, m    the minimum spanning tree of contours and home for c, and its dearest edge
          M', m'  that of the contours alone, and the cheapest way to the home

    (1) every plan           is worth at least  W + M + m
    (2) one with one stroke  is worth at least  W + M' + 2 m'
    (3) travel               the best plan is worth at most 2 M, for one stroke at most 2 (M' + m')

(3) holds for link points anywhere on the curves, contours outside one another, Euclidean rapids in the plane.

(1) The way of the head is closed, so it enters and leaves each set S of contours and home that is not all.
Its steps between them are passes of links and rapids; let a rapid pay half a pierce for each of its ends at a
contour, so that the steps make up the value but for W. At cost z let p(z) be the number of parts that edges
of cost at most z join. While p(z) > 1, at least two steps dearer than z leave each part, and each of them
belongs to two parts: at least p(z) steps are dearer than z. So the value is at least W plus the integral of
p(z) over z from 0 to m, beyond which all is joined. The integral of p(z) - 1 is M (Kruskal), that of 1 is m.
(2) One stroke joins all contours by links, which cost M' at least, and two rapids reach the home.
(3) In a minimum spanning tree of curves outside one another the shortest segment of an edge (i, j) is clear:
if a contour k were in its way, both d_ik and d_kj would be less than d_ij, as k is not flat, and (i, j) the
longest edge of a circle; and it touches i and j at its ends alone. Every edge passed twice makes an even
connected graph. Where several of them end at the home, a rapid from stroke to stroke is no longer than the
way by the home.

Distances are computed in floating point, and lowered by more than rounding, and by how far entry points lie off
their curves; the rest is exact. Source: derived from Chen, Li, Chu, who double the tree.
"""

import time
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import shapely

from cutgap.formulations.relaxations.bound import float_below
from cutgap.formulations.scope import require_euclidean_links
from cutgap.instances import Instance, Rules
from cutgap.instances.arrays import Floats
from cutgap.instances.links.clearance import require_shapes

ROUNDING = 1e-12
"""By how much of the largest coordinate distances are lowered: rounding is some thousandths of it."""


@dataclass(frozen=True, slots=True)
class TreeBound:
    """What the spanning tree says; a bound without a certificate.

    Attributes
    ----------
    bound
        Every allowed plan is worth at least this, in ``rules.unit``.
    doubled
        What (3) says that the best plan is worth at most when link points may be anywhere, mm, but for
        rounding; ``None`` where it does not apply.
    tree
        Edges of the tree whose double (3) is about: pairs of contours, -1 is the home.
    seconds
        Time taken.
    """

    bound: float
    doubled: float | None
    tree: tuple[tuple[int, int], ...]
    seconds: float


def spanning_tree(instance: Instance, rules: Rules) -> TreeBound:
    """Return (1), or for one stroke the larger of (1) and (2).

    Raises
    ------
    ValueError
        When the rules take no links or do not go with them, rapids are not Euclidean, or curves do not suit.
    """
    begun = time.perf_counter()
    require_euclidean_links(instance, rules, "spanning tree")
    count = len(instance.contours)
    if not count:
        return TreeBound(0.0, 0.0, (), time.perf_counter() - begun)
    distances = curve_distances(instance)
    costs = way_costs(instance, rules, distances)
    inner = tree_of(costs[:count, :count])
    nearest = (int(np.argmin(costs[:count, count])), count)
    tree, of_stroke = tree_of(costs), [*inner, nearest]
    bound = _total(costs, tree) + max(Fraction(float(costs[edge])) for edge in tree)
    if rules.pierces == 1:
        bound = max(bound, _total(costs, of_stroke) + Fraction(float(costs[nearest])))
    # Each edge at the home is a stroke of its own in (3).
    strokes = sum(edge[1] == count for edge in tree)
    doubled = tree if rules.pierces is None or strokes <= rules.pierces else of_stroke
    applies = rules.objective == "travel" and _apart(instance)
    return TreeBound(
        float_below(_fixed(instance, rules) + bound),
        2 * float(_total(distances, doubled)) if applies else None,
        tuple((i, -1 if j == count else j) for i, j in doubled),
        time.perf_counter() - begun,
    )


def curve_distances(instance: Instance) -> Floats:
    """Return d, safely from below, shape (contours + 1, contours + 1), mm; the home is last."""
    rings = [shapely.LinearRing(curve) for curve in require_shapes(instance)]
    home = instance.heads[0].home
    assert home is not None  # rules with links ask for it
    places = [*rings, shapely.Point(home[:2])]
    off = [
        float(shapely.distance(shapely.points(contour.entry_points[:, :2]), ring).max())
        for contour, ring in zip(instance.contours, rings, strict=True)
    ]
    shapely.prepare(places)
    apart = shapely.distance(np.array(places)[:, None], np.array(places))
    apart = np.minimum(apart, apart.T)
    farthest = max(float(np.abs(instance.points).max()), *(float(np.abs(ring.coords).max()) for ring in rings))
    slack = np.add.outer([*off, 0.0], [*off, 0.0]) + ROUNDING * farthest
    return np.maximum(0.0, apart - slack)


def way_costs(instance: Instance, rules: Rules, distances: Floats) -> Floats:
    """Return c, in ``rules.unit``, shape as ``distances``."""
    if rules.objective == "travel":
        return distances
    machine = instance.machine
    costs = distances / machine.v_cut
    rapids = distances / machine.v_jump
    if rules.pierces != 1:
        costs = np.minimum(costs, rapids + machine.t_aux)
    costs[-1], costs[:, -1] = rapids[-1] + machine.t_aux / 2, rapids[:, -1] + machine.t_aux / 2
    # Quotients and sums of floats may be rounded up.
    return costs * (1.0 - 1e-14)


def tree_of(costs: Floats) -> list[tuple[int, int]]:
    """Return the edges of a minimum spanning tree, by Prim's rule; zeros are costs like others."""
    count = len(costs)
    nearest, least, found = np.zeros(count, dtype=np.int64), costs[0].copy(), []
    outside = np.ones(count, dtype=np.bool_)
    outside[0] = False
    for _ in range(count - 1):
        new = int(np.argmin(np.where(outside, least, np.inf)))
        found.append((min(int(nearest[new]), new), max(int(nearest[new]), new)))
        outside[new] = False
        closer = costs[new] < least
        nearest[closer], least = new, np.minimum(least, costs[new])
    return found


def _total(costs: Floats, edges: list[tuple[int, int]]) -> Fraction:
    return sum((Fraction(float(costs[edge])) for edge in edges), Fraction(0))


def _fixed(instance: Instance, rules: Rules) -> Fraction:
    """Return W."""
    if rules.objective == "travel":
        return Fraction(0)
    perimeters = sum((Fraction(each) for each in instance.perimeters.tolist()), Fraction(0))
    return perimeters / Fraction(instance.machine.v_cut)


def _apart(instance: Instance) -> bool:
    """Whether all is in one plane and no contour inside another."""
    areas = shapely.polygons([shapely.linearrings(curve) for curve in require_shapes(instance)])
    inside = shapely.STRtree(areas).query(shapely.point_on_surface(areas), "within")[0]
    return len(inside) == len(areas) and not np.ptp(instance.points[:, 2])
