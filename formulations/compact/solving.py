"""A compact model solved: what a solver says, and what of it is believed.

    (1) a plan is decoded from x (``network``), evaluated and checked; zeros and cycles are no plan
    (2) value: of the plan, by ``evaluate``
    (3) lower bound: the plan's value, when the solver claims an optimum and its value is the plan's up to a
        relative ``AGREEMENT``; else the solver's own bound, lowered by ``AGREEMENT``; else the relaxation's
    (4) a plan that breaks a rule between two heads by a tie or a tolerance (``clock``), or the cap on
        temperatures within the cells of its lags (``heat``): the model is solved once more with a margin, or
        with the most heat of each cell, and the bound stays

Both kinds of bound are claims in floating point, without a certificate.
"""

import time

import numpy as np

from cutgap.formulations.compact.heat import LAG_CELLS
from cutgap.formulations.compact.network import plan_of
from cutgap.formulations.compact.programme import Programme, Sets, assemble, least_objective
from cutgap.formulations.compact.relaxing import larger, reason_of, relax, seconds_left, sets_of_point
from cutgap.formulations.compact.solvers import AGREEMENT, Outcome, require_solver, run
from cutgap.formulations.compact.tours import ROUNDS
from cutgap.instances import Instance, Plan, Result, Rules, check, conclude, evaluate

MARGIN_S = 1e-5
"""The margin of (4), above what tolerances of x let the clock be wrong by."""


class Solving:
    """One run: a solver, a time limit, and the bound so far."""

    def __init__(
        self,
        instance: Instance,
        rules: Rules,
        formulation: str,
        solver: str,
        time_limit: float | None,
        lag_cells: int = LAG_CELLS,
    ) -> None:
        self.begun = time.perf_counter()
        require_solver(solver, integer=True)
        self.instance, self.rules, self.formulation = instance, rules, formulation
        self.solver, self.time_limit, self.lag_cells = solver, time_limit, lag_cells
        self.bound: float | None = None

    def result(self) -> Result:
        """Solve and return what was found."""
        sets = self._root() if self.formulation == ROUNDS else frozenset()
        plan, outcome = self._search(sets, 0.0)
        reason = None if outcome.state == "optimal" else reason_of(outcome, self.solver)
        if plan is None and outcome.state == "optimal":
            reason = f"what {self.solver} calls optimal is no plan"
        broken = [] if plan is None else check(self.instance, self.rules, plan)
        if broken:
            reason = (
                f"the plan of {self.solver} breaks a rule by a tie, a cell of lags or its tolerance: "
                f"{broken[0].constraint}"
            )
            plan = self._safe_plan(sets) or plan
        elif plan is not None:
            self._confirm(evaluate(self.instance, plan).objective(self.rules), outcome)
        infeasible = outcome.state == "infeasible"
        return conclude(
            self.instance,
            self.rules,
            plan,
            method=f"compact {self.formulation}",
            seconds=time.perf_counter() - self.begun,
            lower_bound=None if infeasible else self.bound,
            infeasible=infeasible,
            reason=reason,
        )

    def _root(self) -> Sets:
        """Return the sets that the relaxation finds, and keep its bound."""
        left = seconds_left(self.begun, self.time_limit)
        relaxation = relax(self.instance, self.rules, self.formulation, self.solver, left)
        self.bound = relaxation.lower_bound
        return relaxation.sets

    def _search(self, sets: Sets, margin_s: float) -> tuple[Plan | None, Outcome]:
        """Solve the model, in rounds for as long as it finds cycles; without a margin its bound counts."""
        while True:
            programme = assemble(
                self.instance,
                self.rules,
                self.formulation,
                integer=True,
                sets=sets,
                margin_s=margin_s,
                lag_cells=self.lag_cells,
            )
            left = seconds_left(self.begun, self.time_limit)
            outcome = run(programme.problem(), self.solver, left, integer=True)
            if margin_s == 0.0:
                self.bound = larger(self.bound, outcome.safe_bound(least_objective(self.instance, self.rules)))
            plan = _plan(programme) if outcome.value is not None else None
            if plan is not None or outcome.state != "optimal" or self.formulation != ROUNDS:
                return plan, outcome
            new = sets_of_point(programme) - sets
            if not new:
                return None, outcome
            sets |= new

    def _safe_plan(self, sets: Sets) -> Plan | None:
        """Return an allowed plan of (4), if there is one."""
        plan, _ = self._search(sets, MARGIN_S)
        return None if plan is None or check(self.instance, self.rules, plan) else plan

    def _confirm(self, value: float, outcome: Outcome) -> None:
        """Apply (3) to an allowed plan."""
        claimed = outcome.value
        agrees = claimed is not None and abs(value - claimed) <= AGREEMENT * max(1.0, abs(value))
        if not np.isfinite(value):
            self.bound = None  # an infinite peak has no gap
        elif outcome.state == "optimal" and agrees:
            self.bound = value
        elif self.bound is not None:
            self.bound = min(self.bound, value)


def _plan(programme: Programme) -> Plan | None:
    values = [head.x.value for head in programme.heads]
    points = [np.asarray(x) for x in values if x is not None]
    return plan_of(programme.networks, points) if len(points) == len(values) else None
