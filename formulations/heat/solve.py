"""The method ``heat``: order and start points of one head under the temperature model, with proven bounds.

Small plates (``exact.fits``) are closed by branch and bound. On larger ones the cap is enforced by forbidden
runs of visits (``runs``), and the peak is bounded by ``pairwise``. On small plates a certificate proves the
bound, by the checker's own search; on larger ones that on travel without heat, which holds for every cap: a cap
only forbids plans.
"""

import time
from dataclasses import replace

import numpy as np

from cutgap.formulations.certify import Certificate, proved_bound, proves
from cutgap.formulations.contour_dp.proof import contour_certificate
from cutgap.formulations.contour_dp.search import MOST_CONTOURS
from cutgap.formulations.contour_dp.solve import ContourSearch
from cutgap.formulations.heat.exact import ExactSearch, fits
from cutgap.formulations.heat.lazy import LazySearch, plain_search
from cutgap.formulations.heat.proof import heat_certificate
from cutgap.formulations.heat.run import Run
from cutgap.instances import Instance, Plan, Result, Rules, Status, check, conclude, evaluate
from cutgap.instances.arrays import Ints
from cutgap.instances.check import require_coordinates
from cutgap.instances.heat import require_heat
from cutgap.instances.progress import Watch, nobody

NAME = "heat"

ANNEAL_SHARE, ANNEAL_SECONDS = 0.4, 60.0
"""How much of the time for a larger plate's peak goes to plans: a share, or seconds where there is no limit."""

WHY_SECONDS = 10.0
"""Most seconds for the least peak, where no plan keeps the cap."""


def solve_heat(
    instance: Instance,
    rules: Rules,
    *,
    time_limit: float | None = None,
    start: Plan | None = None,
    certify: bool = False,
    watch: Watch = nobody,
    most_travel: float = np.inf,
    backward_price: float = 0.0,
) -> Result:
    """Solve an instance with one head under a cap on temperatures, or for the least peak.

    Parameters
    ----------
    time_limit
        Seconds after which the best plan and the bound proved so far are returned; Ctrl-C does the same.
    start
        A plan to start from; one that breaks rules is ignored.
    certify
        Whether to add a verified certificate. Where it proves less than the result's bound, which is the bound
        on travel without heat, the reason says what it proves. None speaks of ``most_travel``.
    most_travel, backward_price
        A limit on travel besides the rules, mm, and the price of going back that counts in it.

    Raises
    ------
    ValueError
        When there are several heads or more than 62 contours, via points are asked for, or there is no material
        or a contour without a curve.
    """
    _require_scope(instance, rules)
    if not instance.contours:
        return _nothing(instance, rules)
    run = Run(instance, rules, watch, time_limit, most_travel, backward_price)
    solving = _Solving(run)
    try:
        if start is not None:
            run.offer(start)
        solving.solve()
    except KeyboardInterrupt:
        # What the run holds is the result.
        pass
    result = solving.result()
    if not certify or np.isfinite(most_travel):
        return result
    return _with_certificate(result, run, _certificate(result, run, solving.plain))


class _Solving:
    """The part of a run that suits the size of the plate and the objective."""

    def __init__(self, run: Run) -> None:
        self.run = run
        self.plain: ContourSearch | None = None
        self.complete, self.how, self.reason = False, "branch and bound", "stopped early"

    def solve(self) -> None:
        """Search until the plate is closed or the time is over."""
        run = self.run
        first = run.first_path()
        if fits(run.instance.first_node):
            search = ExactSearch(run, first)
            self.complete = search.run_roots() and bool(np.isinf(search.refused))
        elif run.by_travel:
            lazy = LazySearch(run, first)
            self.plain, self.how = lazy.plain, "a search without forbidden runs of visits"
            self.complete = lazy.search()
            if run.instance.heads[0].home is None and not run.is_over:
                self.reason = "without a home the bound of a larger plate leaves heat out"
        else:
            self._bound_peak(first)

    def _bound_peak(self, first: Ints) -> None:
        """Anneal, then bound the peak by pairs."""
        run = self.run
        left = run.deadline - time.perf_counter()
        run.improve(run.annealing(first), ANNEAL_SHARE * left if np.isfinite(left) else ANNEAL_SECONDS)
        peak = run.value if run.value is not None and np.isfinite(run.value) else None
        if peak is None:
            return
        # CP-SAT takes a second to load.
        from cutgap.formulations.heat.pairwise import pairwise_bound

        left = run.deadline - time.perf_counter()
        pairs = pairwise_bound(
            run.instance, run.rules, warmest=peak, time_limit=left if np.isfinite(left) else None
        )
        run.bound = min(pairs.lower_bound, peak)
        run.report()
        self.reason = f"bound by pairs, claimed by CP-SAT on integers of {1.0 / pairs.scale:.3g} s"

    def result(self) -> Result:
        """Return what was found."""
        run = self.run
        infeasible = self.complete and run.best is None
        reason = None if self.complete else self.reason
        if infeasible:
            reason = self._why_infeasible()
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

    def _why_infeasible(self) -> str:
        cap = self.run.rules.temperature_cap
        if cap is None:
            return "no order keeps the rules"
        # The bound that proves it says by how much the cap is too low.
        rules = replace(self.run.rules, objective="peak", backward_price=0.0, temperature_cap=None)
        left = min(WHY_SECONDS, max(0.0, self.run.deadline - time.perf_counter()))
        coolest = solve_heat(self.run.instance, rules, time_limit=left)
        if coolest.lower_bound is None or coolest.lower_bound <= cap:
            return f"every plan has a peak above the cap of {cap:g} deg C, as {self.how} shows"
        least = "is" if coolest.status is Status.OPTIMAL else "is at least"
        return (
            f"the least possible peak {least} {coolest.lower_bound:.3f} deg C, above the cap of {cap:g} deg C"
        )


def _with_certificate(result: Result, run: Run, certificate: Certificate | None) -> Result:
    """Return the result with a certificate, and a reason that says where it proves less than the bound."""
    if certificate is None or result.lower_bound is None:
        return replace(result, certificate=certificate)
    proved = proved_bound(certificate, run.instance)
    if proved is None or proves(proved, result.lower_bound):
        return replace(result, certificate=certificate)
    text = f"the certificate proves {proved:.3f} {run.rules.unit}, the bound without heat"
    return replace(
        result, certificate=certificate, reason=f"{result.reason}; {text}" if result.reason else text
    )


def _certificate(result: Result, run: Run, plain: ContourSearch | None) -> Certificate | None:
    """Return the certificate of the result's bound, or else of that on travel without heat."""
    infeasible = result.status is Status.INFEASIBLE
    if infeasible or not run.by_travel:
        proved = infeasible or result.lower_bound is not None
        return heat_certificate(run.instance, run.rules, result.lower_bound, run.left) if proved else None
    cold = _cold_certificate(run, plain)
    if run.rules.temperature_cap is None or result.lower_bound is None:
        return cold
    if cold is not None and proves(proved_bound(cold, run.instance), result.lower_bound):
        return cold
    return heat_certificate(run.instance, run.rules, result.lower_bound, run.left) or cold


def _cold_certificate(run: Run, plain: ContourSearch | None) -> Certificate | None:
    """Return the certificate of the bound on travel without heat, which holds under every cap."""
    if len(run.instance.contours) == 1 and run.instance.heads[0].home is None:
        return contour_certificate(run.instance, run.rules, None, 0.0, 0.0, [])
    if plain is None:
        plain = plain_search(run, None if run.left is None else max(1.0, run.left))
        plain.run()
    if not np.isfinite(plain.bound):
        return None
    return contour_certificate(
        run.instance, run.rules, None, max(0.0, plain.bound), plain.incumbent.step, plain.closings
    )


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
