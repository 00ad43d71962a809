r"""A bound for links between any points of the outlines, not only between given entry points.

    Data       c_ij   the least that a link or rapid between outlines i, j can cost: their distance      [mm]
               c_i0   likewise for rapids between outline i and the home                                  [mm]
    Variables  x_ij in [0, 2]   how often the way passes between i and j                                  [-]

    min  sum c_ij x_ij
    (1)  x(delta(home)) = 2
    (2)  x(delta(S)) >= 2             each set S of outlines, separated by minimum cuts

A plan with links, wherever they end, is an even connected multigraph, so it crosses each border twice;
clearance only takes links away. With one pierce no rapid leads from outline to outline. Costs are those of
``graph``. There is no certificate: distances between curves are floats.
"""

import numpy as np
import shapely

from cutgap.formulations.branch_and_cut.linear_program import INFINITY, LinearProgram
from cutgap.formulations.branch_and_cut.model import NO_COLUMNS, NO_VALUES
from cutgap.formulations.branch_and_cut.separation import Support, connectivity_violations
from cutgap.instances import Instance, Rules
from cutgap.instances.arrays import Floats
from cutgap.instances.links.clearance import require_shapes
from cutgap.instances.links.link_check import require_links

SAFETY = 1e-9
"""Relative part of a bound that is given up for rounding."""


def outline_bound(instance: Instance, rules: Rules) -> float:
    """Return a lower bound, in ``rules.unit``, on plans with links between any points of the outlines.

    Raises
    ------
    ValueError
        When the rules allow no links, the rapids are not Euclidean, or as ``require_links`` does.
    """
    if not rules.links:
        raise ValueError(f"instance {instance.name!r}, outline bound: the rules allow no links")
    if instance.machine.metric != "euclidean":
        raise ValueError(f"instance {instance.name!r}, outline bound: needs Euclidean rapids")
    require_links(instance, rules)
    timed, machine = rules.objective == "makespan", instance.machine
    length = _cut_programme(_least_costs(instance, rules)) if instance.contours else 0.0
    length *= 1.0 - SAFETY
    return length / machine.v_jump + float(instance.perimeters.sum()) / machine.v_cut if timed else length


def _least_costs(instance: Instance, rules: Rules) -> Floats:
    """Return c, shape (outlines + 1, outlines + 1), the home last."""
    machine, timed = instance.machine, rules.objective == "makespan"
    curves = np.array([shapely.linearrings(curve) for curve in require_shapes(instance)])
    home = instance.points[-1]
    heights = np.array([np.abs(contour.entry_points[:, 2] - home[2]).min() for contour in instance.contours])
    apart = shapely.distance(curves[:, None], curves)
    ways = np.hypot(shapely.distance(curves, shapely.Point(home[:2])), heights)
    pierce = machine.t_aux * machine.v_jump if timed else 0.0
    costs = np.zeros((len(curves) + 1, len(curves) + 1))
    links = apart * (machine.v_jump / machine.v_cut if timed else 1.0)
    costs[:-1, :-1] = links if rules.pierces == 1 else np.minimum(links, apart + pierce)
    costs[:-1, -1] = costs[-1, :-1] = ways + pierce / 2.0
    return costs


def _cut_programme(costs: Floats) -> float:
    """Return the value of the programme above."""
    places = len(costs)
    tails, heads = np.triu_indices(places, 1)
    programme, count = LinearProgram(), len(tails)
    zeros, nothing = np.zeros(count), np.zeros(count, dtype=np.int64)
    programme.add_columns(costs[tails, heads], zeros, zeros + 2.0, nothing, NO_COLUMNS, NO_VALUES)
    at_home = np.flatnonzero(heads == places - 1)
    programme.add_row(2.0, 2.0, at_home, np.ones(len(at_home)))
    masks = [np.arange(places) == each for each in range(places - 1)]
    while masks:
        for mask in masks:
            border = np.flatnonzero(mask[tails] != mask[heads])
            programme.add_row(2.0, INFINITY, border, np.ones(len(border)))
        solution = programme.solve()
        used = np.flatnonzero(solution.x > 1e-9)
        support = Support(places, tails[used], heads[used], solution.x[used])
        masks = connectivity_violations(support, places - 1, np.full(places, 2.0))
    # The dual value, whatever the solver's tolerances: reduced costs below zero count at the upper bound.
    duals = np.append(solution.duals[:1], np.maximum(solution.duals[1:], 0.0))
    reduced = costs[tails, heads] - programme.row_combination(duals)
    return float(2.0 * duals.sum() + 2.0 * np.minimum(reduced, 0.0).sum())
