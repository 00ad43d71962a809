"""Semidefinite programs in cvxpy, solved by Clarabel, and what their duals are worth as integer rows."""

import warnings

import cvxpy as cp
import numpy as np
from scipy.sparse import csr_array

from cutgap.formulations.relaxations.bound import Size
from cutgap.instances.arrays import Floats, Ints

TOLERANCE = 1e-9
"""Of Clarabel, for gap and residuals; data are scaled to about 1."""

NEGLIGIBLE = 1e-11
"""Share of the largest eigenvalue below which an eigenvector is left out."""

LARGEST = 10**9
"""Size to which factors are scaled before they are rounded."""


def solve(problem: cp.Problem) -> Size:
    """Solve a program whose values and duals are then read from it; return its size.

    Raises
    ------
    RuntimeError
        When Clarabel gives no point.
    """
    rows = problem.get_problem_data(cp.CLARABEL)[0]["A"]
    tolerances = dict.fromkeys(("tol_gap_abs", "tol_gap_rel", "tol_feas"), TOLERANCE)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # an inaccurate dual is safe as well, it only proves less
        problem.solve(solver=cp.CLARABEL, max_threads=1, **tolerances)
    if problem.status not in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE, cp.INFEASIBLE):
        raise RuntimeError(f"semidefinite program: Clarabel stopped with status {problem.status}")
    return Size(rows.shape[1], rows.shape[0], rows.nnz)


def integer_factors(matrix: Floats) -> tuple[list[list[int]], float]:
    """Return integer vectors f and one weight y > 0 with y sum f f' near a positive semidefinite matrix."""
    values, vectors = np.linalg.eigh((matrix + matrix.T) / 2)
    kept = values > NEGLIGIBLE * max(float(values[-1]), 0.0)
    columns = vectors[:, kept] * np.sqrt(values[kept])
    unit = float(np.abs(columns).max(initial=0.0)) / LARGEST or 1.0
    return np.rint(columns.T / unit).astype(np.int64).tolist(), unit**2


def edges_of(nodes: int) -> tuple[Ints, Ints]:
    """Return tails and heads of the edges u < v of a complete graph, row by row."""
    tails, heads = np.triu_indices(nodes, 1)
    return tails, heads


def incidence(nodes: int) -> csr_array:
    """Return the matrix, shape (n, edges), that sums edges at nodes."""
    tails, heads = edges_of(nodes)
    edges = np.arange(len(tails))
    places = np.concatenate([tails, heads]), np.concatenate([edges, edges])
    return csr_array((np.ones(2 * len(edges)), places), shape=(nodes, len(edges)))


def adjacency(nodes: int) -> csr_array:
    """Return the matrix, shape (n^2, edges), that lays edges out as a symmetric matrix with zero diagonal."""
    tails, heads = edges_of(nodes)
    edges = np.arange(len(tails))
    places = np.concatenate([tails * nodes + heads, heads * nodes + tails]), np.concatenate([edges, edges])
    return csr_array((np.ones(2 * len(edges)), places), shape=(nodes * nodes, len(edges)))


def as_matrix(expression: cp.Expression, nodes: int) -> cp.Expression:
    """Return n^2 numbers, row by row, as a matrix."""
    return expression.reshape((nodes, nodes), order="C")
