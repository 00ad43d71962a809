"""The method ``contour-split``: two heads and any entry points, to proven optimality.

For makespan, for travel, and for a weight of at most ``v_jump``, all without a limit on imbalance, a finished
run is optimal. Above that weight or under such a limit a longer tour may pay: the bound stays valid, but may
stay below the best plan that is found, which is then ``feasible``, or no plan may be found at all. The method
gives no certificate: its bounds are claims.
"""

import time

import numpy as np

from cutgap.formulations.contour_dp.two_head_search import TwoHeadSearch
from cutgap.formulations.scope import require_any_order
from cutgap.instances import Instance, Plan, Result, Rules, conclude
from cutgap.instances.progress import Watch, nobody
from cutgap.instances.result import OPTIMALITY_TOLERANCE

NAME = "contour-split"
LOOSE = "longer tours than the shortest ones may pay (limit on imbalance, or weight above v_jump)"


def solve_contour_split(
    instance: Instance,
    rules: Rules,
    *,
    time_limit: float | None = None,
    start: Plan | None = None,
    certify: bool = False,
    watch: Watch = nobody,
) -> Result:
    """Solve an instance with two heads that have homes by dynamic programming over contours.

    Parameters
    ----------
    time_limit
        Seconds after which the best plan and the bound proved so far are returned; Ctrl-C does the same.
    start
        A plan to start from; one that breaks rules is ignored.
    certify
        Without effect: the result never has a certificate.

    Raises
    ------
    ValueError
        When there are not two heads with homes, or via points, precedence or process rules are asked for.
    """
    begun = time.perf_counter()
    _require_scope(instance, rules)
    search = TwoHeadSearch(instance, rules, time_limit, watch)
    if not instance.contours:
        return conclude(instance, rules, Plan(((), ())), method=NAME, seconds=0.0, lower_bound=0.0)
    reason = search.run(start)
    bound = search.lower_bound
    # Sides are proved to within half the tolerance, and so are regions that are closed.
    slack = 0.0 if search.best is None else OPTIMALITY_TOLERANCE * max(1.0, abs(search.value))
    if reason is None and search.closed_bound < search.value - slack:
        reason = LOOSE
    infeasible = reason is None and search.best is None
    return conclude(
        instance,
        rules,
        search.best,
        method=NAME,
        seconds=time.perf_counter() - begun,
        lower_bound=bound if np.isfinite(bound) else None,
        infeasible=infeasible,
        reason=_why_infeasible(rules) if infeasible else reason,
    )


def _why_infeasible(rules: Rules) -> str:
    gap = rules.non_overlap if rules.non_overlap is not None else 0.0
    return f"no threshold in x leaves a partition gap of {gap:g} mm with work for both heads"


def _require_scope(instance: Instance, rules: Rules) -> None:
    name = f"instance {instance.name!r}, method {NAME}"
    if len(instance.heads) != 2:
        raise ValueError(f"{name}: needs two heads, got {len(instance.heads)}")
    homeless = next((head.id for head in instance.heads if head.home is None), None)
    if homeless is not None:
        raise ValueError(f"{name}: head {homeless!r} has no home, needs one each")
    if rules.via_points:
        raise ValueError(f"{name}: does not take via points")
    require_any_order(instance, rules, NAME)
