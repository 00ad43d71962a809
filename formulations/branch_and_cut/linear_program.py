"""A linear program over HiGHS that grows by rows and columns and restarts from its last basis.

The numbers that leave it are safe to build on: ``safe_bound`` recomputes the dual bound from the row duals
by weak duality, so it holds within float rounding whatever the solver's tolerances did.
"""

from dataclasses import dataclass

import highspy
import numpy as np

from cutgap.instances.arrays import Floats, Ints

INFINITY = highspy.kHighsInf


@dataclass(frozen=True, slots=True)
class Solution:
    """Point of a linear program: objective, columns ``x`` and row ``duals``."""

    objective: float
    x: Floats
    duals: Floats


class LinearProgram:
    """min c x subject to row and column bounds, solved by the dual simplex method."""

    def __init__(self) -> None:
        self._highs = highspy.Highs()
        for option, value in (
            ("output_flag", False),
            ("threads", 1),
            ("presolve", "off"),
            ("solver", "simplex"),
            ("simplex_strategy", 1),
            ("primal_feasibility_tolerance", 1e-9),
            ("dual_feasibility_tolerance", 1e-9),
        ):
            self._highs.setOptionValue(option, value)
        self.costs: Floats = np.empty(0)
        self.lower: Floats = np.empty(0)
        self.upper: Floats = np.empty(0)
        self.row_count = 0

    def add_columns(
        self,
        costs: Floats,
        lower: Floats,
        upper: Floats,
        starts: Ints,
        rows: Ints,
        values: Floats,
    ) -> None:
        """Append columns given by compressed columns ``starts``, ``rows``, ``values``."""
        self._highs.addCols(
            len(costs),
            np.asarray(costs, dtype=np.float64),
            np.asarray(lower, dtype=np.float64),
            np.asarray(upper, dtype=np.float64),
            len(values),
            np.asarray(starts, dtype=np.int32),
            np.asarray(rows, dtype=np.int32),
            np.asarray(values, dtype=np.float64),
        )
        self.costs = np.concatenate([self.costs, costs])
        self.lower = np.concatenate([self.lower, lower])
        self.upper = np.concatenate([self.upper, upper])

    def add_row(self, lower: float, upper: float, columns: Ints, values: Floats) -> int:
        """Append a row and return its index."""
        self._highs.addRow(
            lower,
            upper,
            len(columns),
            np.asarray(columns, dtype=np.int32),
            np.asarray(values, dtype=np.float64),
        )
        self.row_count += 1
        return self.row_count - 1

    def delete_rows(self, rows: Ints) -> None:
        """Delete rows; those behind move up."""
        if len(rows):
            self._highs.deleteRows(len(rows), np.asarray(rows, dtype=np.int32))
            self.row_count -= len(rows)

    def delete_columns(self, columns: Ints) -> None:
        """Delete columns; those behind move up."""
        if len(columns):
            self._highs.deleteCols(len(columns), np.asarray(columns, dtype=np.int32))
            self.costs, self.lower, self.upper = (
                np.delete(values, columns) for values in (self.costs, self.lower, self.upper)
            )

    def change_bounds(self, columns: Ints, lower: Floats, upper: Floats) -> None:
        """Set the bounds of some columns."""
        if len(columns):
            self._highs.changeColsBounds(
                len(columns),
                np.asarray(columns, dtype=np.int32),
                np.asarray(lower, dtype=np.float64),
                np.asarray(upper, dtype=np.float64),
            )
            self.lower[columns] = lower
            self.upper[columns] = upper

    def solve(self, iteration_limit: int | None = None) -> Solution | None:
        """Solve and return the last point; ``None`` when the program is infeasible.

        With an iteration limit the point may lie short of the optimum: its duals still give a bound.

        Raises
        ------
        RuntimeError
            When the solver fails even from scratch.
        """
        limit = iteration_limit if iteration_limit is not None else 2_000_000
        self._highs.setOptionValue("simplex_iteration_limit", limit)
        self._highs.run()
        status = self._highs.getModelStatus()
        statuses = highspy.HighsModelStatus
        known = (statuses.kOptimal, statuses.kIterationLimit, statuses.kInfeasible)
        if status not in known or (status == statuses.kIterationLimit and iteration_limit is None):
            self._highs.clearSolver()
            self._highs.run()
            status = self._highs.getModelStatus()
        if status == statuses.kInfeasible:
            return None
        if status not in known:
            raise RuntimeError(f"linear program: HiGHS stopped with status {status}")
        point = self._highs.getSolution()
        return Solution(
            self._highs.getInfo().objective_function_value,
            np.array(point.col_value),
            np.array(point.row_dual),
        )

    def save_basis(self) -> object:
        """Return the current basis."""
        return self._highs.getBasis()

    def restore_basis(self, basis: object) -> None:
        """Start the next solve from a saved basis of the same size."""
        self._highs.setBasis(basis)
