"""A model in cvxpy, put together from its families, and the same as one matrix."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import cvxpy as cp
import numpy as np
from scipy.sparse import csr_array

from cutgap.formulations.compact import clock, problem
from cutgap.formulations.compact import rules as order_rules
from cutgap.formulations.compact.family import Family, RowName
from cutgap.formulations.compact.heat import LAG_CELLS, heat
from cutgap.formulations.compact.network import Network, networks_of
from cutgap.formulations.compact.tours import POSITIONS, TOUR_FORMULATIONS
from cutgap.formulations.compact.tours.order import position
from cutgap.formulations.compact.tours.subtours import enter, names_of_set
from cutgap.formulations.compact.variables import HeadVariables, head_variables
from cutgap.instances import Instance, Rules
from cutgap.instances.arrays import Floats
from cutgap.instances.heat import require_heat

Sets = frozenset[tuple[int, ...]]
"""Sets of contours, ascending."""

REFERENCE = "HIGHS"
"""The solver for which ``matrix_form`` writes a programme: it takes bounds of variables apart from rows."""


@dataclass(frozen=True, eq=False)
class Programme:
    """Variables, families and objective."""

    heads: tuple[HeadVariables, ...]
    families: tuple[Family, ...]
    objective: cp.Expression

    @property
    def networks(self) -> tuple[Network, ...]:
        """The legs of the heads."""
        return tuple(head.network for head in self.heads)

    def multipliers(self) -> dict[RowName, float]:
        """Return the multipliers of all rows after a relaxation was solved."""
        return {name: value for each in self.families for name, value in each.multipliers().items()}

    def problem(self) -> cp.Problem:
        """Return what cvxpy solves."""
        definitions = [each for head in self.heads for each in head.definitions]
        rows = [each.constraint for each in self.families]
        return cp.Problem(cp.Minimize(self.objective), definitions + rows)


@dataclass(frozen=True, eq=False)
class MatrixForm:
    """``min costs x`` subject to ``matrix x >= right`` (or =), ``lower <= x <= upper``.

    Attributes
    ----------
    names
        One a row; rows that only define y are called ``("definition",)``.
    """

    names: tuple[RowName, ...]
    matrix: csr_array
    right: Floats
    is_equation: np.ndarray
    costs: Floats
    lower: Floats
    upper: Floats


# cvxpy adds up unset memory to learn the shape of a sum, which now and then is no number.
@np.errstate(invalid="ignore")
def assemble(
    instance: Instance,
    rules: Rules,
    formulation: str,
    *,
    integer: bool,
    sets: Sets = frozenset(),
    margin_s: float = 0.0,
    with_clock: bool = True,
    lag_cells: int = LAG_CELLS,
) -> Programme:
    """Build the model of a problem with a tour formulation, or its relaxation.

    ``sets`` are those of ``dfj-rounds``, ``margin_s`` is what ``clock.late_clear`` says; with one, heat is
    taken from above. Without the clock two heads do not know the time, and a cap on temperatures is left out:
    a relaxation, whose bound a certificate can show.
    """
    if not with_clock:
        rules = replace(rules, temperature_cap=None)
    heads = tuple(head_variables(network, integer=integer) for network in networks_of(instance, rules))
    families = [*problem.cut_once(heads), *problem.leave_once(instance, rules, heads)]
    for head in heads:
        families += problem.continuity(head)
        families += TOUR_FORMULATIONS[formulation](head.way)
        families += enter(head.way, [name for each in sorted(sets) for name in names_of_set(head.way, each)])
    families += _limits(instance, rules, heads)
    if instance.precedence or rules.clear_rapids:
        families += _order(instance, rules, formulation, heads)
        if len(heads) == 2 and with_clock:
            families += _times(instance, rules, heads, margin_s)
    if rules.speaks_of_heat and len(heads) == 1:
        peak = cp.Variable(name="peak", bounds=[require_heat(instance).ambient_c, np.inf])
        families += heat(heads[0], rules, peak, lag_cells, integer=integer, above=margin_s > 0.0)
        if rules.objective == "peak":
            return Programme(heads, tuple(families), peak)
    objective, rows = _objective(rules, heads)
    return Programme(heads, (*families, *rows), objective)


def least_objective(instance: Instance, rules: Rules) -> float:
    """Return what no plan's objective is below, in the rules' unit."""
    return require_heat(instance).ambient_c if rules.objective == "peak" else 0.0


def _limits(instance: Instance, rules: Rules, heads: tuple[HeadVariables, ...]) -> Iterator[Family]:
    """Rules on where and how long."""
    if len(heads) == 2 and rules.balance is not None:
        yield from problem.balance(rules.balance, heads, clock.latest_time(heads))
    if len(heads) == 2 and rules.non_overlap is not None:
        yield from problem.apart(instance, rules.non_overlap, heads)
    for head in heads:
        if rules.via_points:
            yield from problem.via(instance, head)
        if rules.parts_in_one_go:
            yield from order_rules.one_go(instance, head.way)


def _order(
    instance: Instance, rules: Rules, formulation: str, heads: tuple[HeadVariables, ...]
) -> Iterator[Family]:
    """Rules on what a head cuts before what."""
    for head in heads:
        if formulation not in POSITIONS:
            yield from position(head.way)
        if instance.precedence:
            yield from order_rules.precedence(instance, head.way)
        if rules.clear_rapids:
            yield from order_rules.clear(head)


def _times(
    instance: Instance, rules: Rules, heads: tuple[HeadVariables, ...], margin_s: float
) -> Iterator[Family]:
    """What two heads cut before what, which takes the times of both."""
    latest = clock.latest_time(heads)
    start = cp.Variable(len(instance.contours), name="s", bounds=[0, latest])
    yield from clock.clock(instance, start, heads, latest)
    if instance.precedence:
        yield from clock.late(instance, start, latest, margin_s)
    for head in heads if rules.clear_rapids else ():
        yield from clock.late_clear(instance, start, head, latest, margin_s)


def _objective(rules: Rules, heads: tuple[HeadVariables, ...]) -> tuple[cp.Expression, list[Family]]:
    """Return what is minimised, in the rules' unit, and the families that it needs."""
    if rules.objective == "makespan":
        makespan = cp.Variable(name="makespan", nonneg=True)
        return makespan, problem.makespan(makespan, heads)
    cost = sum(head.cost for head in heads)
    if rules.objective == "travel" or len(heads) == 1:
        return cost, []
    imbalance = cp.Variable(name="imbalance", nonneg=True)
    return cost + rules.weight * imbalance, problem.imbalance(imbalance, heads)


def matrix_form(programme: Programme) -> MatrixForm:
    """Return a relaxation as a matrix, rows as docs/formulations.md signs them."""
    data = programme.problem().get_problem_data(REFERENCE)[0]
    equations = [each for each in programme.families if each.is_equation]
    others = [each for each in programme.families if not each.is_equation]
    count = sum(each.size for head in programme.heads for each in head.definitions)
    names: list[RowName] = [("definition",)] * count
    names += [name for each in (*equations, *others) for name in each.names]
    # cvxpy writes A x = b for equations and A x <= b, in the order of the constraints.
    first_inequality = count + sum(len(each.rows) for each in equations)
    signs = np.where(np.arange(len(names)) < first_inequality, 1.0, -1.0)
    columns = len(data["c"])
    bounds = [data["lower_bounds"], data["upper_bounds"]]
    lower, upper = (
        np.full(columns, end) if given is None else np.asarray(given, dtype=np.float64)
        for given, end in zip(bounds, (-np.inf, np.inf), strict=True)
    )
    matrix = csr_array(data["A"].multiply(signs[:, None]))
    matrix.eliminate_zeros()
    return MatrixForm(
        names=tuple(names),
        matrix=matrix,
        right=signs * data["b"],
        is_equation=signs > 0,
        costs=np.asarray(data["c"], dtype=np.float64),
        lower=lower,
        upper=upper,
    )
