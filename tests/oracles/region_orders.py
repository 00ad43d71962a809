"""Shortest closed tours through convex regions, by trying all orders; each order is a convex problem."""

from collections.abc import Sequence
from itertools import permutations

import cvxpy as cp
import numpy as np

from cutgap.instances.region import Ellipsoid, Region


def length_of_order(regions: Sequence[Region], order: Sequence[int]) -> float:
    """Length of the shortest closed tour through the regions in this order."""
    count = len(order)
    points = cp.Variable((count, 3))
    constraints: list[cp.Constraint] = []
    for place, number in enumerate(order):
        region = regions[number]
        if isinstance(region, Ellipsoid):
            part = cp.Variable(len(region.axes))
            constraints += [points[place] == region.centre + region.axes.T @ part, cp.norm(part) <= 1]
        else:
            share = cp.Variable(len(region.vertices), nonneg=True)
            constraints += [points[place] == region.vertices.T @ share, cp.sum(share) == 1]
    legs = points - points[np.roll(np.arange(count), -1)]
    problem = cp.Problem(cp.Minimize(cp.sum(cp.norm(legs, axis=1))), constraints)
    return float(problem.solve(solver=cp.CLARABEL, tol_gap_abs=1e-10, tol_gap_rel=1e-10, tol_feas=1e-10))


def shortest_of_orders(regions: Sequence[Region]) -> float:
    """Length of the shortest closed tour through the regions in any order."""
    rest = [order for order in permutations(range(1, len(regions))) if order <= order[::-1]]
    return min(length_of_order(regions, (0, *order)) for order in rest)
