"""Shortest tours through convex regions: all orders, each as a conic model of cvxpy; it shares no code."""

from itertools import permutations

import cvxpy as cp
import numpy as np

from cutgap.instances.region import Ellipsoid, Region


def shortest_in_order(regions: list[Region]) -> tuple[float, np.ndarray]:
    """Length and touch points, shape (n, 3), of the shortest closed tour in this order."""
    points, limits = [], []
    for region in regions:
        if isinstance(region, Ellipsoid):
            u = cp.Variable(len(region.axes))
            limits.append(cp.norm(u) <= 1)
            points.append(region.centre + region.axes.T @ u)
        else:
            weights = cp.Variable(len(region.vertices), nonneg=True)
            limits.append(cp.sum(weights) == 1)
            points.append(region.vertices.T @ weights)
    legs = [cp.norm(points[k] - points[k - 1]) for k in range(len(points))]
    problem = cp.Problem(cp.Minimize(cp.sum(cp.hstack(legs))), limits)
    problem.solve(solver=cp.CLARABEL)
    return float(problem.value), np.array([point.value for point in points])


def shortest_in_any_order(regions: list[Region], pairs: tuple[tuple[int, int], ...] = ()) -> float:
    """Length of the shortest tour; the last region comes first (a home), and in each pair a before b."""
    *others, first = range(len(regions))
    best = np.inf
    for order in permutations(others):
        backward = not pairs and len(order) > 1 and order[0] > order[-1]
        if backward or any(order.index(a) > order.index(b) for a, b in pairs):
            continue
        best = min(best, shortest_in_order([regions[first], *(regions[k] for k in order)])[0])
    return best
