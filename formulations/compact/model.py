"""Compact models: a problem and a tour formulation, as one programme that can be measured, relaxed and solved.

    (1) model = problem (``problem``, ``rules``, ``clock``) + tour formulation (``tours``)
    (2) relaxation: x in 0 .. 1 instead of 0 or 1; its value bounds every plan
    (3) ``dfj-rounds``: rows are added for what a point violates until none is left. Each round is a relaxation
        of the model, so that its bound holds whenever it stops

A solver is never believed: plans are decoded from x, evaluated and checked; see ``CompactModel.solve``.
"""

import time
from dataclasses import dataclass, replace

import numpy as np

from cutgap.formulations.compact.family import RowName
from cutgap.formulations.compact.network import plan_of
from cutgap.formulations.compact.programme import MatrixForm, Programme, assemble, matrix_form
from cutgap.formulations.compact.solvers import AGREEMENT, Outcome, require_solver, run
from cutgap.formulations.compact.tours import MOST_CONTOURS, TOUR_FORMULATIONS
from cutgap.formulations.compact.tours.subtours import enter, names_of_set, sets_not_entered
from cutgap.instances import Instance, Plan, Result, Rules, check, conclude, evaluate
from cutgap.instances.check import require_coordinates

MOST_LEGS = 400_000
"""Largest number of legs, all heads together: a variable each."""

ROUNDS = "dfj-rounds"
RELAXATIONS = ("assignment",)
"""Formulations that leave cycles: they bound, and are not solved."""

Sets = frozenset[tuple[int, ...]]


@dataclass(frozen=True, slots=True)
class Size:
    """Columns, rows and entries of a relaxation, as a solver gets it; bounds of variables are no rows."""

    variables: int
    constraints: int
    nonzeros: int


@dataclass(frozen=True, slots=True)
class Relaxation:
    """What a relaxation says.

    Attributes
    ----------
    value
        Its optimum in the rules' unit, by the solver's word; ``None`` when there is none.
    lower_bound
        The value lowered by the solver's tolerance; after an early stop, that of the last round that ended.
    infeasible
        Whether the solver found that there is no point, and so no plan.
    point
        ("x" or "c", head, u, v) -> value, where it is not 0.
    multipliers
        Row name -> multiplier (``family``); empty when the solver gives none.
    size
        Of the programme that was solved last.
    rounds
        How many programmes were solved.
    seconds
        Wall time, compilation included.
    reason
        Why there is no value, or no final one.
    """

    value: float | None
    lower_bound: float | None
    infeasible: bool
    point: dict[tuple[str, int, int, int], float]
    multipliers: dict[RowName, float]
    size: Size
    rounds: int
    seconds: float
    reason: str | None = None


@dataclass(frozen=True)
class CompactModel:
    """A problem with a tour formulation; build it with ``compact_model``."""

    instance: Instance
    rules: Rules
    formulation: str

    @property
    def method(self) -> str:
        """The name in results."""
        return f"compact {self.formulation}"

    def programme(self, *, integer: bool = False, sets: Sets = frozenset()) -> Programme:
        """Return the model in cvxpy, or its relaxation; ``sets`` are those that ``dfj-rounds`` has found."""
        found = assemble(self.instance, self.rules, self.formulation, integer=integer)
        for head in found.heads:
            names = [name for members in sorted(sets) for name in names_of_set(head.way, members)]
            found = replace(found, families=(*found.families, *enter(head.way, names)))
        return found

    def matrix_form(self) -> MatrixForm:
        """Return the relaxation as a matrix (of ``dfj-rounds``, the first round)."""
        return matrix_form(self.programme())

    def size(self) -> Size:
        """Return the size of the relaxation (of ``dfj-rounds``, of the first round)."""
        return _size(self.programme()) if self.instance.contours else Size(0, 0, 0)

    def relax(self, solver: str = "HIGHS", *, time_limit: float | None = None) -> Relaxation:
        """Solve the relaxation.

        Raises
        ------
        ValueError
            When the solver is not installed or takes no time limit.
        """
        return self._relax(solver, time_limit)[0]

    def _relax(self, solver: str, time_limit: float | None) -> tuple[Relaxation, Sets]:
        """Return the relaxation, and the sets that rounds have added."""
        begun = time.perf_counter()
        require_solver(solver, integer=False)
        if not self.instance.contours:
            return Relaxation(0.0, 0.0, False, {}, {}, Size(0, 0, 0), 0, 0.0), frozenset()
        sets: Sets = frozenset()
        bound, rounds = None, 0
        while True:
            programme = self.programme(sets=sets)
            outcome = run(programme.problem(), solver, _left(begun, time_limit), integer=False)
            rounds += 1
            bound = _larger(bound, outcome.safe_bound)
            new = self._new_sets(programme, sets) if outcome.state == "optimal" else frozenset()
            if not new:
                break
            sets |= new
        solved = outcome.state == "optimal"
        relaxation = Relaxation(
            value=outcome.value if solved else None,
            lower_bound=None if outcome.state == "infeasible" else bound,
            infeasible=outcome.state == "infeasible",
            point=_point(programme) if solved else {},
            multipliers=programme.multipliers() if solved else {},
            size=_size(programme),
            rounds=rounds,
            seconds=time.perf_counter() - begun,
            reason=None if solved else _reason(outcome, solver),
        )
        return relaxation, sets

    def solve(self, solver: str = "HIGHS", *, time_limit: float | None = None) -> Result:
        """Solve the model.

        The plan is decoded from x, evaluated and checked. When the solver claims an optimum and the plan's
        value is the solver's up to a relative ``AGREEMENT``, it becomes the lower bound: a claim in floating
        point, without a certificate. Else the bound is the solver's own, lowered by ``AGREEMENT``, where it
        tells one.

        Parameters
        ----------
        solver
            cvxpy's name of a mixed-integer solver.
        time_limit
            Seconds after which the best plan and bound so far are returned, compilation not counted.

        Raises
        ------
        ValueError
            When the formulation is a relaxation only, or the solver is not installed or takes no time limit.
        """
        begun = time.perf_counter()
        if self.formulation in RELAXATIONS:
            raise ValueError(f"formulation {self.formulation!r} leaves cycles: it can be relaxed, not solved")
        require_solver(solver, integer=True)
        if not self.instance.contours:
            nothing = Plan(tuple(() for _ in self.instance.heads))
            return conclude(
                self.instance, self.rules, nothing, method=self.method, seconds=0.0, lower_bound=0.0
            )
        sets, bound = self._root(solver, time_limit)
        while True:
            programme = self.programme(integer=True, sets=sets)
            outcome = run(programme.problem(), solver, _left(begun, time_limit), integer=True)
            bound = _larger(bound, outcome.safe_bound)
            plan = _plan(programme) if outcome.value is not None else None
            new = self._new_sets(programme, sets) if plan is None and outcome.state == "optimal" else None
            if not new:
                return self._result(plan, outcome, bound, solver, time.perf_counter() - begun)
            sets |= new

    def _root(self, solver: str, time_limit: float | None) -> tuple[Sets, float | None]:
        """Return what the relaxation of ``dfj-rounds`` finds: sets, and a bound."""
        if self.formulation != ROUNDS:
            return frozenset(), None
        relaxation, sets = self._relax(solver, time_limit)
        return sets, relaxation.lower_bound

    def _new_sets(self, programme: Programme, known: Sets) -> Sets:
        """Return sets that the point of a programme enters too little and that no row is there for yet."""
        if self.formulation != ROUNDS:
            return frozenset()
        found: set[tuple[int, ...]] = set()
        for head in programme.heads:
            y, z = np.asarray(head.way.y.value), np.asarray(head.way.z.value)
            found |= {tuple(members) for members in sets_not_entered(head.way.pairs, y, z)}
        return frozenset(found) - known

    def _result(
        self, plan: Plan | None, outcome: Outcome, bound: float | None, solver: str, seconds: float
    ) -> Result:
        """Conclude from a plan and what the solver says."""
        reason = None if outcome.state == "optimal" else _reason(outcome, solver)
        if plan is not None:
            value = evaluate(self.instance, plan).objective(self.rules)
            broken = check(self.instance, self.rules, plan)
            if broken:
                reason = f"the plan of {solver} breaks a rule by its tolerance or a tie: {broken[0].constraint}"
            elif outcome.state == "optimal" and _agree(value, outcome.value):
                bound = value
            elif bound is not None:
                bound = min(bound, value)
        elif outcome.state == "optimal":
            reason = f"what {solver} calls optimal is no plan"
        return conclude(
            self.instance,
            self.rules,
            plan,
            method=self.method,
            seconds=seconds,
            lower_bound=None if outcome.state == "infeasible" else bound,
            infeasible=outcome.state == "infeasible",
            reason=reason,
        )


def compact_model(instance: Instance, rules: Rules, formulation: str = "single-commodity") -> CompactModel:
    """Return the model of a problem with the tour formulation of that name.

    Raises
    ------
    ValueError
        When there are more than two heads, no such formulation, more contours or legs than it takes, or the
        rules need coordinates or curves that are not there.
    """
    name = f"instance {instance.name!r}, compact model"
    if formulation not in TOUR_FORMULATIONS:
        raise ValueError(f"formulation: expected one of {', '.join(TOUR_FORMULATIONS)}, got {formulation!r}")
    if len(instance.heads) > 2:
        raise ValueError(f"{name}: needs one or two heads, got {len(instance.heads)}")
    require_coordinates(instance, rules)
    contours, most = len(instance.contours), MOST_CONTOURS[formulation]
    if contours > most:
        raise ValueError(
            f"{name}: {contours} contours are too many for {formulation}, which takes up to {most}"
        )
    legs = len(instance.heads) * int(instance.first_node[-1]) ** 2
    if legs > MOST_LEGS:
        raise ValueError(f"{name}: {legs} legs between entry points are too many, the limit is {MOST_LEGS}")
    return CompactModel(instance, rules, formulation)


def _size(programme: Programme) -> Size:
    form = matrix_form(programme)
    return Size(form.matrix.shape[1], form.matrix.shape[0], form.matrix.nnz)


def _point(programme: Programme) -> dict[tuple[str, int, int, int], float]:
    found = {}
    for head in programme.heads:
        network, x = head.network, np.asarray(head.x.value)
        for leg in np.flatnonzero(np.abs(x) > AGREEMENT).tolist():
            kind = "c" if network.closing[leg] else "x"
            found[kind, network.head, int(network.tails[leg]), int(network.heads[leg])] = float(x[leg])
    return found


def _plan(programme: Programme) -> Plan | None:
    values = [head.x.value for head in programme.heads]
    points = [np.asarray(x) for x in values if x is not None]
    return plan_of(programme.networks, points) if len(points) == len(values) else None


def _agree(value: float, claimed: float | None) -> bool:
    return claimed is not None and abs(value - claimed) <= AGREEMENT * max(1.0, abs(value))


def _larger(one: float | None, other: float | None) -> float | None:
    return max((each for each in (one, other) if each is not None), default=None)


def _left(begun: float, time_limit: float | None) -> float | None:
    return None if time_limit is None else time_limit - (time.perf_counter() - begun)


def _reason(outcome: Outcome, solver: str) -> str:
    if outcome.state == "infeasible":
        return f"{solver} claims that there is no plan"
    if outcome.state == "stopped":
        return "stopped by the time limit" + ("" if outcome.value is not None else " without a plan")
    return f"{solver} failed: {outcome.message}"
