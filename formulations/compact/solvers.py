"""cvxpy's solvers: which are there, with which options they run, and what their word is worth.

A solver ends a run in one of four states. With a limit reached cvxpy may hand over zeros for variables: whether
there is a point at all is asked of the solver, and a point counts once it is decoded and checked (``model``).
"""

import math
import warnings
from dataclasses import dataclass
from typing import Any, Literal

import cvxpy as cp
from cvxpy.reductions.solvers import defines

TOLERANCE = 1e-9
"""Feasibility and gap asked of solvers that take it."""

AGREEMENT = 1e-7
"""Relative tolerance of a solver's value: within it a plan confirms it, and bounds are lowered by it."""

State = Literal["optimal", "infeasible", "stopped", "failed"]

STATES: dict[str, State] = {
    cp.OPTIMAL: "optimal",
    cp.INFEASIBLE: "infeasible",
    # No model here is unbounded: all costs are at least 0, but for a constant.
    cp.settings.INFEASIBLE_OR_UNBOUNDED: "infeasible",
    cp.USER_LIMIT: "stopped",
}


_GAPS = {"GUROBI": "MIPGap", "HIGHS": "mip_rel_gap", "SCIP": "limits/gap", "SCIPY": "mip_rel_gap"}
_LIMITS = {"GUROBI": "TimeLimit", "HIGHS": "time_limit", "SCIP": "limits/time", "SCIPY": "time_limit"}
_NESTED = {"SCIP": "scip_params", "SCIPY": "scipy_options"}
"""Names of the gap to stop at and of the limit in s, and in which argument of cvxpy they go."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a run ended.

    Attributes
    ----------
    value
        The solver's value of its best point, ``None`` when it has none.
    bound
        What the solver claims that no point is below, ``None`` when it does not say.
    message
        What went wrong, for ``failed``.
    """

    state: State
    value: float | None = None
    bound: float | None = None
    message: str = ""

    def safe_bound(self, least: float) -> float | None:
        """Return the claimed bound, lowered by ``AGREEMENT``, but no less than every objective is."""
        if self.bound is None:
            return None
        return max(least, self.bound - AGREEMENT * max(1.0, abs(self.bound)))


def require_solver(solver: str, *, integer: bool) -> None:
    """Raise ``ValueError`` when a solver is not installed or solves no such programmes."""
    able = defines.INSTALLED_MI_SOLVERS if integer else defines.INSTALLED_CONIC_SOLVERS
    if solver not in able:
        what = "mixed-integer linear" if integer else "linear"
        state = "takes none" if solver in defines.INSTALLED_SOLVERS else "is not installed"
        names = ", ".join(sorted(able))
        raise ValueError(f"solver {solver!r} {state}; installed solvers of {what} programmes: {names}")


def solver_options(solver: str, time_limit: float | None, *, integer: bool) -> dict[str, Any]:
    """Return options for exact, repeatable runs.

    Raises
    ------
    ValueError
        When there is a time limit and it is not known how to tell the solver.
    """
    gap = {name: 0.0} if integer and (name := _GAPS.get(solver)) else {}
    limit = {}
    if time_limit is not None:
        if solver not in _LIMITS:
            names = ", ".join(_LIMITS)
            raise ValueError(f"solver {solver!r}: no time limit is known for it, only for {names}")
        limit = {_LIMITS[solver]: max(0.0, time_limit)}
    both = {**gap, **limit}
    if solver == "HIGHS":
        # With its presolve HiGHS 1.13.1 loses optimal plans of these models (3 of 6000 small ones), or returns
        # halves for whole numbers; without it none was found.
        exact = {"mip_abs_gap": TOLERANCE, "mip_feasibility_tolerance": TOLERANCE, "presolve": "off"}
        tolerances = {f"{kind}_feasibility_tolerance": TOLERANCE for kind in ("primal", "dual")}
        return {"threads": 1, "random_seed": 0, **tolerances, **(exact if integer else {}), **both}
    if solver in _NESTED:
        return {_NESTED[solver]: both}
    return both


def run(problem: cp.Problem, solver: str, time_limit: float | None, *, integer: bool) -> Outcome:
    """Solve a problem and say how it ended; its variables hold the point."""
    options = solver_options(solver, time_limit, integer=integer)
    with warnings.catch_warnings():
        # What cvxpy warns of, an inaccurate point, is looked at below and by whoever decodes it.
        warnings.filterwarnings("ignore", message="Solution may be inaccurate", category=UserWarning)
        try:
            problem.solve(solver=solver, **options)
        except cp.SolverError as error:
            return Outcome("failed", message=str(error))
    state = STATES.get(problem.status, "failed")
    if state in ("infeasible", "failed"):
        return Outcome(state, message=f"status {problem.status}")
    info = problem.solver_stats.extra_stats if solver == "HIGHS" else None
    value = _finite(problem.value)
    if info is not None and info.primal_solution_status != _FEASIBLE_POINT:
        value = None
    return Outcome(state, value, _bound(state, value, info, integer=integer))


_FEASIBLE_POINT = 2
"""HiGHS's word for a point that keeps all rows."""


def _bound(state: State, value: float | None, info: Any, *, integer: bool) -> float | None:
    """Return the solver's bound: HiGHS tells that of its tree; an optimal relaxation is its own."""
    if integer:
        return None if info is None else _finite(info.mip_dual_bound)
    return value if state == "optimal" else None


def _finite(number: Any) -> float | None:
    return float(number) if number is not None and math.isfinite(number) else None
