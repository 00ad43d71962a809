"""The relaxation of a compact model: x in 0 .. 1 instead of 0 or 1. Its value bounds every plan.

``dfj-rounds`` goes on while the point enters a set of contours too little. Each round is a relaxation of the
model, so that its bound holds whenever the rounds stop.
"""

import time
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cutgap.formulations.compact.family import RowName
from cutgap.formulations.compact.heat import LAG_CELLS
from cutgap.formulations.compact.programme import Programme, Sets, assemble, least_objective, matrix_form
from cutgap.formulations.compact.solvers import AGREEMENT, Outcome, require_solver, run
from cutgap.formulations.compact.tours import ROUNDS
from cutgap.formulations.compact.tours.subtours import sets_not_entered
from cutgap.instances import Instance, Rules

LegName = tuple[str, int, int, int]
"""``x`` or ``c``, head, node, node."""


class Size(NamedTuple):
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
        Whether the solver claims that there is no point, and so no plan.
    point
        The legs that are not 0.
    multipliers
        One a row, signed as ``family`` says; empty when the solver gives none.
    size
        Of the programme that was solved last.
    sets
        What the rounds of ``dfj-rounds`` have found.
    rounds
        How many programmes were solved.
    seconds
        Wall time, compilation included.
    reason
        Why there is no value.
    """

    value: float | None
    lower_bound: float | None
    infeasible: bool
    point: dict[LegName, float]
    multipliers: dict[RowName, float]
    size: Size
    sets: Sets
    rounds: int
    seconds: float
    reason: str | None = None


def relax(
    instance: Instance,
    rules: Rules,
    formulation: str,
    solver: str,
    time_limit: float | None,
    with_clock: bool = True,
    lag_cells: int = LAG_CELLS,
) -> Relaxation:
    """Solve a relaxation; see ``CompactModel.relax``."""
    begun = time.perf_counter()
    require_solver(solver, integer=False)
    sets: Sets = frozenset()
    bound, rounds = None, 0
    while True:
        programme = assemble(
            instance,
            rules,
            formulation,
            integer=False,
            sets=sets,
            with_clock=with_clock,
            lag_cells=lag_cells,
        )
        outcome = run(programme.problem(), solver, seconds_left(begun, time_limit), integer=False)
        rounds += 1
        bound = larger(bound, outcome.safe_bound(least_objective(instance, rules)))
        found = outcome.state == "optimal" and formulation == ROUNDS
        new = sets_of_point(programme) - sets if found else frozenset()
        if not new:
            break
        sets |= new
    solved, infeasible = outcome.state == "optimal", outcome.state == "infeasible"
    return Relaxation(
        value=outcome.value if solved else None,
        lower_bound=None if infeasible else bound,
        infeasible=infeasible,
        point=_point(programme) if solved else {},
        multipliers=programme.multipliers() if solved else {},
        size=size_of(programme),
        sets=sets,
        rounds=rounds,
        seconds=time.perf_counter() - begun,
        reason=None if solved else reason_of(outcome, solver),
    )


def size_of(programme: Programme) -> Size:
    """Return the size of a relaxation."""
    form = matrix_form(programme)
    return Size(form.matrix.shape[1], form.matrix.shape[0], form.matrix.nnz)


def sets_of_point(programme: Programme) -> Sets:
    """Return sets of contours that the point of a solved programme enters too little."""
    found: set[tuple[int, ...]] = set()
    for head in programme.heads:
        y, z = np.asarray(head.way.y.value), np.asarray(head.way.z.value)
        found |= {tuple(members) for members in sets_not_entered(head.way.pairs, y, z)}
    return frozenset(found)


def _point(programme: Programme) -> dict[LegName, float]:
    found = {}
    for head in programme.heads:
        network, x = head.network, np.asarray(head.x.value)
        for leg in np.flatnonzero(np.abs(x) > AGREEMENT).tolist():
            kind = "c" if network.closing[leg] else "x"
            found[kind, network.head, int(network.tails[leg]), int(network.heads[leg])] = float(x[leg])
    return found


def larger(one: float | None, other: float | None) -> float | None:
    """Return the larger of two bounds that may be missing."""
    return max((each for each in (one, other) if each is not None), default=None)


def seconds_left(begun: float, time_limit: float | None) -> float | None:
    """Return what is left of a time limit, s."""
    return None if time_limit is None else max(0.0, time_limit - (time.perf_counter() - begun))


def reason_of(outcome: Outcome, solver: str) -> str:
    """Return why a run has no optimum."""
    if outcome.state == "infeasible":
        return f"{solver} claims that there is no plan"
    if outcome.state == "stopped":
        return "stopped by the time limit" + ("" if outcome.value is not None else " without a plan")
    return f"{solver} failed: {outcome.message}"
