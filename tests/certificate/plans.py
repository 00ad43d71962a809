"""All plans of a tiny instance, and what each means for the variables of a relaxation."""

from collections.abc import Iterator
from itertools import pairwise, permutations
from typing import Any

import numpy as np

from certificate.producer import coefficients
from cutgap.instances import Evaluation, Instance, Plan, Rules, check, evaluate
from cutgap.instances.arrays import Floats

SLACK = 1e-3
"""Units by which times, which are floats here, may be off."""


def all_plans(instance: Instance, rules: Rules) -> Iterator[tuple[Plan, Evaluation]]:
    """Every plan that the library allows, for one head or two."""
    contours = range(len(instance.contours))
    for order in permutations(contours):
        for cut in range(len(order) + 1) if len(instance.heads) == 2 else [len(order)]:
            orders = [order[:cut], order[cut:]][: len(instance.heads)]
            plan = Plan.of_contours(orders)
            if not check(instance, rules, plan):
                yield plan, evaluate(instance, plan)


def two_heads_point(relaxation: Any, plan: Plan, evaluation: Evaluation) -> Floats:
    """The value of each variable for a plan."""
    point = np.zeros(len(relaxation.costs))
    for head, tour in enumerate(plan.tours):
        stops = [-1, *(visit.contour for visit in tour), -1] if tour else []
        for u, v in pairwise(stops):
            point[relaxation.variable(["x", head, min(u, v), max(u, v)])] += 1
        if relaxation.e is not None:
            point[relaxation.variable(["e", head])] = bool(tour)
    for visit in plan.tours[0]:
        point[relaxation.variable(["z", visit.contour])] = 1
    unit = float(relaxation.problem.v_jump * relaxation.scale)
    if relaxation.m is not None:
        point[relaxation.m] = evaluation.makespan_s * unit
    if relaxation.d is not None:
        point[relaxation.d] = evaluation.imbalance_s * unit
    return point


def tour_points(relaxation: Any, count: int) -> tuple[list[tuple[int, ...]], Floats]:
    """Every order of nodes 1 .. count-1 after node 0, and the variables of these tours, one a row."""
    orders = list(permutations(range(1, count)))
    points = np.zeros((len(orders), len(relaxation.costs)))
    for order, point in zip(orders, points, strict=True):
        for u, v in pairwise((0, *order, 0)):
            point[relaxation.variable(["x", min(u, v), max(u, v)])] = 1
    return orders, points


def excess(relaxation: Any, rows: list[Any], points: Floats) -> Floats:
    """How far each row is from equality at each point; negative where it does not hold.

    Numbers stay below 2^53, so floats are exact but for the times.
    """
    matrix = np.array([coefficients(relaxation, row) for row in rows], dtype=float)
    over = matrix @ points.T - np.array([[row.rhs] for row in rows], dtype=float)
    equal = np.array([[row.equality] for row in rows])
    return np.where(equal, -abs(over), over)
