"""A linear program over HiGHS that grows by rows and columns and restarts from its last basis."""

from dataclasses import dataclass, replace

import highspy
import numpy as np

from cutgap.instances.arrays import Floats, Ints

INFINITY = highspy.kHighsInf
KNOWN = (
    highspy.HighsModelStatus.kOptimal,
    highspy.HighsModelStatus.kIterationLimit,
    highspy.HighsModelStatus.kInfeasible,
)


@dataclass(frozen=True, slots=True)
class Solution:
    """Point of a linear program: columns ``x``, their reduced costs and row ``duals``.

    When the program is ``infeasible``, the duals are a ray that proves it, and the rest means nothing.
    """

    x: Floats
    reduced_costs: Floats
    duals: Floats
    infeasible: bool = False

    def without_rows(self, rows: Ints) -> "Solution":
        """Return the point with some rows' duals left out."""
        return replace(self, duals=np.delete(self.duals, rows))

    def without_columns(self, columns: Ints) -> "Solution":
        """Return the point with some columns left out."""
        reduced_costs = np.delete(self.reduced_costs, columns)
        return replace(self, x=np.delete(self.x, columns), reduced_costs=reduced_costs)

    def with_columns(self, count: int) -> "Solution":
        """Return the point with new columns at zero."""
        x, reduced_costs = np.zeros(count), np.zeros(count)
        return replace(self, x=np.append(self.x, x), reduced_costs=np.append(self.reduced_costs, reduced_costs))


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

    @property
    def nonzeros(self) -> int:
        """Number of coefficients."""
        return int(self._highs.getNumNz())

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

    def solve(self, iteration_limit: int | None = None) -> Solution:
        """Solve and return the last point.

        With an iteration limit the point may lie short of the optimum: its duals still give a bound.

        Raises
        ------
        RuntimeError
            When the solver fails even from scratch.
        """
        limit = iteration_limit if iteration_limit is not None else 2_000_000
        self._highs.setOptionValue("simplex_iteration_limit", limit)
        self._highs.run()
        if self._highs.getModelStatus() not in KNOWN:
            self._highs.clearSolver()
            self._highs.run()
        status = self._highs.getModelStatus()
        if status == highspy.HighsModelStatus.kInfeasible:
            _, known, ray = self._highs.getDualRay()
            duals = np.array(ray) if known else np.zeros(self.row_count)
            return Solution(np.zeros(len(self.costs)), np.zeros(len(self.costs)), duals, infeasible=True)
        if status not in KNOWN:
            raise RuntimeError(f"linear program: HiGHS stopped with status {status}")
        point = self._highs.getSolution()
        return Solution(np.array(point.col_value), np.array(point.col_dual), np.array(point.row_dual))

    def row_combination(self, multipliers: Floats) -> Floats:
        """Return the coefficients of the columns in the sum of multiplier times row."""
        matrix = self._highs.getLp().a_matrix_
        starts, index, value = np.array(matrix.start_), np.array(matrix.index_), np.array(matrix.value_)
        major = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
        by_rows = matrix.format_ == highspy.MatrixFormat.kRowwise
        rows, columns = (major, index) if by_rows else (index, major)
        total = np.bincount(columns, weights=value * multipliers[rows], minlength=len(self.costs))
        return total.astype(np.float64)

    def save_basis(self) -> object:
        """Return the current basis."""
        return self._highs.getBasis()

    def restore_basis(self, basis: object) -> None:
        """Start the next solve from a saved basis of the same size."""
        self._highs.setBasis(basis)
