"""Compact models: a problem and a tour formulation, as one programme that can be measured, relaxed and solved.

    (1) model = problem (``problem``, ``rules``, ``clock``, ``heat``) + tour formulation (``tours``)

docs/formulations.md writes it down; ``relaxing`` and ``solving`` say what its answers are worth.
"""

from dataclasses import dataclass, replace

from cutgap.formulations.compact.heat import LAG_CELLS
from cutgap.formulations.compact.programme import MatrixForm, Programme, assemble, least_objective, matrix_form
from cutgap.formulations.compact.relaxing import Relaxation, Size, relax, size_of
from cutgap.formulations.compact.solvers import require_solver
from cutgap.formulations.compact.solving import Solving
from cutgap.formulations.compact.tours import MOST_CONTOURS, RELAXATIONS, TOUR_FORMULATIONS
from cutgap.formulations.scope import require_given_entries, require_no_peak
from cutgap.instances import Instance, Plan, Result, Rules, check, conclude
from cutgap.instances.check import require_coordinates

MOST_LEGS = 400_000
"""Largest number of legs between entry points, all heads together: a variable each."""

NOTHING = Relaxation(0.0, 0.0, False, {}, {}, Size(0, 0, 0), frozenset(), 0, 0.0)
"""The relaxation of an instance without contours."""


@dataclass(frozen=True)
class CompactModel:
    """A problem with a tour formulation; build it with ``compact_model``."""

    instance: Instance
    rules: Rules
    formulation: str
    lag_cells: int = LAG_CELLS

    def programme(self, *, integer: bool = False) -> Programme:
        """Return the model in cvxpy, or its relaxation (of ``dfj-rounds``, without sets)."""
        return assemble(self.instance, self.rules, self.formulation, integer=integer, lag_cells=self.lag_cells)

    def matrix_form(self) -> MatrixForm:
        """Return the relaxation as a matrix (of ``dfj-rounds``, without sets)."""
        return matrix_form(self.programme())

    def size(self) -> Size:
        """Return the size of the relaxation; that of ``dfj-rounds`` grows by the sets that ``relax`` finds."""
        return size_of(self.programme()) if self.instance.contours else NOTHING.size

    def relax(
        self, solver: str = "HIGHS", *, time_limit: float | None = None, with_clock: bool = True
    ) -> Relaxation:
        """Solve the relaxation.

        Parameters
        ----------
        solver
            cvxpy's name of a solver of linear programmes.
        time_limit
            Seconds.
        with_clock
            Whether two heads under rules on order know the time, and a cap on temperatures is heeded;
            certificates know neither.

        Raises
        ------
        ValueError
            When the solver is not installed, or is not known to take a time limit.
        """
        if not self.instance.contours:
            require_solver(solver, integer=False)
            least = least_objective(self.instance, self.rules)
            return replace(NOTHING, value=least, lower_bound=least)
        return relax(
            self.instance, self.rules, self.formulation, solver, time_limit, with_clock, self.lag_cells
        )

    def solve(self, solver: str = "HIGHS", *, time_limit: float | None = None) -> Result:
        """Solve the model; the bound is the solver's claim, as far as ``solving`` says.

        Parameters
        ----------
        solver
            cvxpy's name of a solver of mixed-integer linear programmes.
        time_limit
            Seconds after which the best plan and bound so far are returned.

        Raises
        ------
        ValueError
            When the formulation is a relaxation only, there are two heads under a cap on temperatures, or the
            solver is not installed or not known to take a time limit.
        """
        if self.formulation in RELAXATIONS:
            raise ValueError(f"formulation {self.formulation!r} leaves cycles: it can be relaxed, not solved")
        if self.rules.speaks_of_heat and len(self.instance.heads) > 1:
            raise ValueError(
                f"instance {self.instance.name!r}, compact model: under a temperature cap two heads can be "
                "relaxed, not solved"
            )
        run = Solving(self.instance, self.rules, self.formulation, solver, time_limit, self.lag_cells)
        return run.result() if self.instance.contours else self._nothing()

    def _nothing(self) -> Result:
        """Return the plan without work, unless even the ambient temperature is above a cap."""
        nothing = Plan(tuple(() for _ in self.instance.heads))
        least, method = least_objective(self.instance, self.rules), f"compact {self.formulation}"
        broken = check(self.instance, self.rules, nothing)
        return conclude(
            self.instance,
            self.rules,
            None if broken else nothing,
            method=method,
            seconds=0.0,
            lower_bound=least,
            infeasible=bool(broken),
            reason=f"even no work breaks a rule: {broken[0].constraint}" if broken else None,
        )


def compact_model(
    instance: Instance, rules: Rules, formulation: str = "single-commodity", *, lag_cells: int = LAG_CELLS
) -> CompactModel:
    """Return the model of a problem with the tour formulation of that name.

    Parameters
    ----------
    lag_cells
        Cells of the lags between two positions, where temperatures are asked for: more of them make the model
        larger and its bound better (``heat``).

    Raises
    ------
    ValueError
        When there are more than two heads, no such formulation, more contours or legs than it takes, free
        entries are asked for, the peak is asked for on two heads, there is no cell of lags, or the rules need
        coordinates, curves or a material that are not there.
    """
    name = f"instance {instance.name!r}, compact model"
    if formulation not in TOUR_FORMULATIONS:
        known = ", ".join(TOUR_FORMULATIONS)
        raise ValueError(f"formulation: expected one of {known}, got {formulation!r}")
    if len(instance.heads) > 2:
        raise ValueError(f"{name}: needs one or two heads, got {len(instance.heads)}")
    require_given_entries(instance, rules, "compact model")
    if len(instance.heads) > 1:
        require_no_peak(instance, rules, "compact model of two heads")
    if lag_cells < 1:
        raise ValueError(f"lag_cells: expected at least 1, got {lag_cells}")
    require_coordinates(instance, rules)
    contours, most = len(instance.contours), MOST_CONTOURS[formulation]
    if contours > most:
        raise ValueError(f"{name}: {contours} contours are too many for {formulation}, the limit is {most}")
    legs = len(instance.heads) * int(instance.first_node[-1]) ** 2
    if legs > MOST_LEGS:
        raise ValueError(f"{name}: {legs} legs between entry points are too many, the limit is {MOST_LEGS}")
    return CompactModel(instance, rules, formulation, lag_cells)
