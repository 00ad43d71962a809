"""The method ``heat``: order and start points of one head under the temperature model, with proven bounds.

Small plates (``exact.fits``) are closed by branch and bound. On larger ones the cap is enforced by forbidden runs
of visits (``runs``), and the peak is bounded by ``pairwise``. The bound on travel without heat, which the
certificate proves when one is asked for, holds for every cap: a cap only forbids plans.
"""

from dataclasses import replace

import numpy as np

from cutgap.formulations.certify import Certificate
from cutgap.formulations.contour_dp.proof import contour_certificate
from cutgap.formulations.contour_dp.search import MOST_CONTOURS
from cutgap.formulations.contour_dp.solve import ContourSearch
from cutgap.formulations.heat.exact import ExactSearch, fits
from cutgap.formulations.heat.lazy import LazySearch
from cutgap.formulations.heat.run import Run
from cutgap.instances import Instance, Plan, Result, Rules, check, conclude, evaluate
from cutgap.instances.check import require_coordinates
from cutgap.instances.heat import require_heat
from cutgap.instances.progress import Watch, nobody

NAME = "heat"


def solve_heat(
    instance: Instance,
    rules: Rules,
    *,
    time_limit: float | None = None,
    start: Plan | None = None,
    certify: bool = False,
    watch: Watch = nobody,
    most_travel: float = np.inf,
) -> Result:
    """Solve an instance with one head under a cap on temperatures, or for the least peak.

    Parameters
    ----------
    time_limit
        Seconds after which the best plan and the bound proved so far are returned; Ctrl-C does the same.
    start
        A plan to start from; one that breaks rules is ignored.
    certify
        Whether to add a verified certificate of the bound on travel without heat, which is at most the result's.
    most_travel
        A limit on travel, backward price included, besides the rules, mm.

    Raises
    ------
    ValueError
        When there are several heads or more than 62 contours, via points are asked for, or there is no material
        or a contour without a curve.
    """
    _require_scope(instance, rules)
    run = Run(instance, rules, watch, time_limit, most_travel)
    if not instance.contours:
        return _nothing(instance, rules)
    complete, doubt = False, False
    try:
        if start is not None and not check(instance, rules, start):
            run.offer(start)
        first = run.first_path()
        if fits(instance.first_node):
            search = ExactSearch(run, first)
            complete = search.run_roots()
            doubt = bool(np.isfinite(search.refused))
        else:
            lazy = LazySearch(run, first)
            complete = lazy.search()
    except KeyboardInterrupt:
        run.report()
    return _conclude(run, complete, doubt)


def _conclude(run: Run, complete: bool, doubt: bool) -> Result:
    infeasible = complete and run.best is None and not doubt
    reason = None if complete else "stopped early"
    if infeasible:
        reason = _why_infeasible(run)
    return conclude(
        run.instance,
        run.rules,
        run.best,
        method=NAME,
        seconds=run.seconds,
        lower_bound=run.bound,
        infeasible=infeasible,
        reason=reason,
    )


def _why_infeasible(run: Run) -> str:
    cap = run.rules.temperature_cap
    if cap is None:
        return "no order keeps the rules"
    return f"every plan has a peak above the cap of {cap:g} deg C, as branch and bound shows"


def _nothing(instance: Instance, rules: Rules) -> Result:
    """Return the plan without work, whose peak is the ambient temperature."""
    plan = Plan(((),))
    if check(instance, rules, plan):
        reason = f"even the ambient temperature is above the cap of {rules.temperature_cap:g} deg C"
        return conclude(instance, rules, None, method=NAME, seconds=0.0, infeasible=True, reason=reason)
    value = evaluate(instance, plan).objective(rules)
    return conclude(instance, rules, plan, method=NAME, seconds=0.0, lower_bound=value)


def _require_scope(instance: Instance, rules: Rules) -> None:
    name = f"instance {instance.name!r}, method {NAME}"
    if len(instance.heads) != 1:
        raise ValueError(f"{name}: needs one head, got {len(instance.heads)}")
    if rules.via_points:
        raise ValueError(f"{name}: does not take via points")
    if len(instance.contours) > MOST_CONTOURS:
        raise ValueError(f"{name}: at most {MOST_CONTOURS} contours, got {len(instance.contours)}")
    require_coordinates(instance, rules)
    require_heat(instance)
