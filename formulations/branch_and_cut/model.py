"""What the engine asks of a problem: a relaxation to be solved, cut, priced, rounded and branched on."""

from abc import ABC, abstractmethod
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from cutgap.formulations.branch_and_cut.linear_program import INFINITY, LinearProgram, Solution
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.scene import Decision, Inequality, Leg

RAY = 1e-7
"""An infeasible program's ray proves it when its value, against its largest entry, exceeds this."""

AGE = 4
"""A cut whose dual was zero this many times in a row leaves the linear program."""

NO_COLUMNS: Ints = np.empty(0, dtype=np.int64)
NO_VALUES: Floats = np.empty(0)


@dataclass(frozen=True, slots=True)
class Row:
    """A named row sum(a x) >= ``least``, or = ``least``; the name says all that rebuilding it needs."""

    name: Hashable
    least: float
    equal: bool = False


@dataclass(frozen=True, slots=True)
class Fixing:
    """A branching decision: new bounds of one variable of the model."""

    variable: int
    lower: float
    upper: float


Proof = tuple[tuple[Hashable, float], ...]
"""Names of rows with their multipliers: what proves a node's bound."""


class Model(ABC):
    """A mixed-integer problem over one growing linear program.

    The model numbers its variables; which of them have a column is its own affair. All rows are valid for
    the whole problem, so they stay when the engine moves to another node.
    """

    wording: ClassVar[Mapping[Any, tuple[str, str, str]]]
    """Tag, symbols and words of the permanent rows, by the first part of their names."""

    def __init__(self) -> None:
        self.lp = LinearProgram()
        self.rows: list[Row] = []
        self.ages: list[int] = []
        self.permanent = 0  # the first rows, which never leave
        self.solution: Solution

    def add_row(self, row: Row, columns: Ints = NO_COLUMNS, values: Floats = NO_VALUES) -> None:
        """Append a row to the linear program."""
        self.lp.add_row(row.least, row.least if row.equal else INFINITY, columns, values)
        self.rows.append(row)
        self.ages.append(0)

    def multipliers(self) -> Floats:
        """Return the row duals of the last solve, with the signs that weak duality needs."""
        duals = self.solution.duals.copy()
        for index, row in enumerate(self.rows):
            if duals[index] < 0.0 and not row.equal:
                duals[index] = 0.0
        return duals

    def bound(self) -> float:
        """Return a lower bound on the current node from the multipliers, by weak duality.

        Infinity when the node is infeasible: then the multipliers become a ray of value 1. A ray that proves
        nothing within rounding leaves minus infinity.
        """
        value = float(self.multipliers() @ np.array([row.least for row in self.rows])) + self.column_terms()
        if not self.solution.infeasible:
            return value
        if value <= RAY * max(1.0, float(np.abs(self.solution.duals).max())):
            return -np.inf
        self.solution = replace(self.solution, duals=self.solution.duals / value)
        return np.inf

    @abstractmethod
    def column_terms(self) -> float:
        """Return the sum over all variables of the least of reduced cost times bound."""

    def proof(self) -> Proof:
        """Return the multipliers by name, without zeros."""
        pairs = zip(self.rows, self.multipliers().tolist(), strict=True)
        return tuple((row.name, multiplier) for row, multiplier in pairs if multiplier != 0.0)

    def forget_slack_rows(self) -> None:
        """Delete the cuts that were not binding for some time."""
        for index in range(self.permanent, len(self.rows)):
            self.ages[index] = 0 if self.solution.duals[index] > 1e-9 else self.ages[index] + 1
        old = [i for i in range(self.permanent, len(self.rows)) if self.ages[i] > AGE]
        if not old:
            return
        self.lp.delete_rows(np.array(old))
        gone = set(old)
        self.rows = [row for index, row in enumerate(self.rows) if index not in gone]
        self.ages = [age for index, age in enumerate(self.ages) if index not in gone]
        self.solution = self.solution.without_rows(np.array(old))

    @abstractmethod
    def apply(self, fixings: Sequence[Fixing]) -> None:
        """Reset all bounds to the root's, then set the given ones."""

    @abstractmethod
    def solve(self, iteration_limit: int | None = None) -> None:
        """Solve the relaxation, pricing included unless a limit is given.

        An infeasible one leaves its proof, a ray, in the solution's duals.
        """

    @abstractmethod
    def separate(self, *, thorough: bool) -> int:
        """Add violated rows and return how many; without ``thorough`` only those that solutions need."""

    @abstractmethod
    def round(self) -> tuple[float, Any] | None:
        """Return a solution near the current point with its value; the point itself when it is one."""

    @abstractmethod
    def tighten(self, cutoff: float) -> bool:
        """At the root: drop variables that no solution below the cutoff uses, by reduced costs."""

    @abstractmethod
    def candidates(self, most: int) -> list[int]:
        """Return up to ``most`` fractional variables, the most promising first; none when integral."""

    @abstractmethod
    def children(self, variable: int) -> tuple[Fixing, Fixing]:
        """Return the two sides of branching on a fractional variable: at most its floor, at least the next."""

    # For who watches; nodes are numbers of the model

    @abstractmethod
    def legs(self) -> tuple[Leg, ...]:
        """Return the edges that carry weight in the current point."""

    @abstractmethod
    def inequality(self, row: Row) -> Inequality:
        """Return a cut in words, with its sides at the current point."""

    @abstractmethod
    def decision(self, fixing: Fixing) -> Decision:
        """Return a branching decision with its variable named."""

    @abstractmethod
    def tours(self, solution: Any) -> tuple[tuple[int, ...], ...]:
        """Return the nodes of each head of a solution, its home first."""
