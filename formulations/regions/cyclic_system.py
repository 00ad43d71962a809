"""Kernel: the linear system of a closed chain, in time linear in its length."""

import numba
import numpy as np

from cutgap.instances.arrays import Floats

LEAST_PIVOT = 1e-13
"""Least pivot, relative to the diagonal."""


@numba.njit(cache=True, error_model="numpy")
def solve_cyclic(diagonal: Floats, following: Floats, last: Floats, right: Floats) -> None:
    """Solve a symmetric positive definite, cyclic block tridiagonal system in place, by block elimination.

    Parameters
    ----------
    diagonal, following, last
        Shape (n, D, D): the blocks (k, k), (k, k + 1) for k < n - 2, and (n - 1, k); they are overwritten.
    right
        Shape (n, D): the right side, then the solution.
    """
    end = len(right) - 1
    for k in range(end):
        _eliminate(k, diagonal, following, last, right)
    _factor(diagonal[end])
    _substitute(diagonal[end], right[end])
    _substitute_back(diagonal[end], right[end])
    for k in range(end - 1, -1, -1):
        for d in range(right.shape[1]):
            for g in range(right.shape[1]):
                right[k, d] -= last[k, g, d] * right[end, g]
                if k + 1 < end:
                    right[k, d] -= following[k, d, g] * right[k + 1, g]
        _substitute_back(diagonal[k], right[k])


@numba.njit(cache=True, error_model="numpy")
def _eliminate(k: int, diagonal: Floats, following: Floats, last: Floats, right: Floats) -> None:
    """Take block k out of the rows after it."""
    n, size = right.shape
    end = n - 1
    _factor(diagonal[k])
    for f in range(size):
        _substitute(diagonal[k], following[k, :, f])
        _substitute(diagonal[k], last[k, f])
    _substitute(diagonal[k], right[k])
    for d in range(size):
        for g in range(size):
            right[end, d] -= last[k, d, g] * right[k, g]
            for f in range(size):
                diagonal[end, d, f] -= last[k, d, g] * last[k, f, g]
            if k + 1 < end:
                right[k + 1, d] -= following[k, g, d] * right[k, g]
                for f in range(size):
                    diagonal[k + 1, d, f] -= following[k, g, d] * following[k, g, f]
                    last[k + 1, d, f] -= last[k, d, g] * following[k, g, f]


@numba.njit(cache=True, error_model="numpy")
def _factor(block: Floats) -> None:
    """Cholesky, in the lower triangle."""
    for d in range(len(block)):
        for f in range(d + 1):
            rest = block[d, f]
            for g in range(f):
                rest -= block[d, g] * block[f, g]
            if f < d:
                block[d, f] = rest / block[f, f]
            else:
                # Where touch points are not unique a pivot ends as rounding; this keeps them from moving far.
                block[d, d] = np.sqrt(max(rest, LEAST_PIVOT * abs(block[d, d]) + 1e-300))


@numba.njit(cache=True, error_model="numpy")
def _substitute(block: Floats, column: Floats) -> None:
    for d in range(len(column)):
        for f in range(d):
            column[d] -= block[d, f] * column[f]
        column[d] /= block[d, d]


@numba.njit(cache=True, error_model="numpy")
def _substitute_back(block: Floats, column: Floats) -> None:
    for d in range(len(column) - 1, -1, -1):
        for f in range(d + 1, len(column)):
            column[d] -= block[f, d] * column[f]
        column[d] /= block[d, d]
