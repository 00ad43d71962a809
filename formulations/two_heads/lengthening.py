"""Tours made longer on purpose, for a hard limit on imbalance that shortest tours break.

A plan may keep |T_1 - T_2| <= limit by a detour of the head that is done first. Waiting would do as well on the
machine, but the model has no waiting: its time is travel, cutting and auxiliary time.
"""

import numpy as np

from cutgap.instances import Instance, Plan, Rules, evaluate
from cutgap.instances.arrays import Floats


def balanced(instance: Instance, rules: Rules, plan: Plan) -> Plan:
    """Return a two-head plan with a detour of the faster head, if that mends a broken balance limit.

    The detour is the least one that one reversal of a part of the tour (2-opt) makes; without a fitting one
    the plan comes back as it was.
    """
    evaluation = evaluate(instance, plan)
    if rules.balance is None or len(plan.tours) != 2 or evaluation.imbalance_s <= rules.balance:
        return plan
    speed = instance.machine.v_jump
    # A hair more than needed, so that rounding does not break the limit again.
    least = (evaluation.imbalance_s - rules.balance) * speed + 1e-9 * evaluation.total_travel_mm
    most = (evaluation.imbalance_s + rules.balance) * speed
    faster = int(np.argmin(evaluation.time_s))
    order = [visit.contour for visit in plan.tours[faster]]
    longer = _with_detour(instance, faster, order, (least, most), keep_first=rules.via_points)
    orders = [[visit.contour for visit in tour] for tour in plan.tours]
    if longer is not None:
        orders[faster] = longer
    return Plan.of_contours(orders)


def _with_detour(
    instance: Instance, head: int, order: list[int], limits: tuple[float, float], *, keep_first: bool
) -> list[int] | None:
    """Return the order with the reversal that adds least within the limits (mm)."""
    home = instance.home_node(head)
    if home is None or len(order) < 2:
        return None
    nodes = np.array([home, *(instance.node(contour) for contour in order), home])
    added = _reversal_costs(instance.rapids, nodes)
    first = 1 if keep_first else 0
    added[:first] = np.inf
    added[(added < limits[0]) | (added > limits[1])] = np.inf
    i, j = np.unravel_index(np.argmin(added), added.shape)
    if not np.isfinite(added[i, j]):
        return None
    return [*order[:i], *order[i : j + 1][::-1], *order[j + 1 :]]


def _reversal_costs(rapids: Floats, nodes: np.ndarray) -> Floats:
    """Return what reversing visits i..j adds, shape (visits, visits); infinity for j <= i."""
    before, here = nodes[:-2], nodes[1:-1]
    after = nodes[2:]
    added = rapids[before[:, None], here[None, :]] + rapids[here[:, None], after[None, :]]
    added = added - rapids[before, here][:, None] - rapids[here, after][None, :]
    added[np.tril_indices(len(here))] = np.inf
    return added
