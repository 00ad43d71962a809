r"""How compact two sides of equal work can be: a semidefinite bound on the spread of a balanced bisection.

    Data       q_ij    squared straight distance of the entry points of contours i, j        [mm^2]
               w_i     work: perimeter / v_cut + t_aux                                       [s]
               delta   largest difference of the work of the two sides                       [s]
    Variables  S_ij    s_i s_j, which is 1 when i and j are on one side and -1 otherwise     [-]

    (P) min 1/4 sum_ij q_ij (1 + S_ij)                  the sum of q_ij over the pairs on one side
    (1) diag S = 1
    (2) sum_ij w_i w_j S_ij <= delta^2
    (3) S positive semidefinite

This is the partition alone: its bound compares divisions (by clustering, say) in their own terms and says
nothing about tours. Squares are taken because they are exact for exact coordinates, and because the spread of
one side is then its number of contours times the squared distances from its centre, as k-means counts it.

The dual is  max 1/4 (sum_ij q_ij + sum y - t delta^2)  with  P = Q - Diag y + t w w'  positive semidefinite.
The certificate carries t and a factor of P in integers; ``certificate/bisection.py`` repairs what P misses.

Source: Goemans and Williamson (1995); Frieze and Jerrum (1997) for bisection.
"""

import time
from dataclasses import dataclass
from math import floor
from typing import Any

import cvxpy as cp
import numpy as np

from cutgap.formulations.certificate import Problem, Refused, problem_of
from cutgap.formulations.certificate.bisection import FORMAT, spread_value, squared_distances, verify_bisection
from cutgap.formulations.certificate.reading import number
from cutgap.formulations.relaxations.bound import Size, float_below
from cutgap.formulations.relaxations.semidefinite import LARGEST, adjacency, as_matrix, edges_of, solve
from cutgap.instances import Instance
from cutgap.instances.arrays import Floats, finite_number
from cutgap.instances.formats.json_format import format_instance

MOST_CONTOURS = 80
"""Time grows with the sixth power: 60 contours take about 8 s, 80 contours a minute."""

INTERIOR = 1e-5
"""Share of all work to which smaller limits are widened for the solver: at 0 (2) leaves no interior."""


NO_PROGRAM = Size(0, 0, 0)


@dataclass(frozen=True, slots=True)
class SpreadBound:
    """A lower bound on the spread of every division within the limit; never one on a plan.

    Attributes
    ----------
    bound
        mm^2; ``None``: the certificate proves that no division keeps the limit.
    variables, constraints, nonzeros
        Size of the program, see ``Size``.
    certificate
        For ``verify_bisection``, which has accepted it.
    """

    bound: float | None
    variables: int
    constraints: int
    nonzeros: int
    seconds: float
    certificate: dict[str, Any]


@dataclass(frozen=True, slots=True)
class Proof:
    """Size of the program, and scale m, price p and factors f of the certificate."""

    size: Size = NO_PROGRAM
    scale: int = 1
    price: int = 0
    factors: tuple[tuple[int, ...], ...] = ()


def bisection(instance: Instance, limit_s: float) -> SpreadBound:
    """Return a bound on the spread of all divisions whose work differs by at most ``limit_s`` seconds.

    Raises
    ------
    ValueError
        Without coordinates, with several entry points a contour, or with more than ``MOST_CONTOURS`` contours.
    """
    started = time.perf_counter()
    where = f"instance {instance.name!r}, relaxation bisection"
    limit_s = finite_number(limit_s, f"{where}, limit_s", least=0.0)
    count = len(instance.contours)
    if count > MOST_CONTOURS:
        raise ValueError(f"{where}: {count} contours are too many, the most is {MOST_CONTOURS}")
    document = format_instance(instance)
    problem = problem_of(document)
    try:
        squares = np.array(squared_distances(problem), dtype=float) / problem.denominator**2
    except Refused as refusal:
        raise ValueError(f"{where}: {refusal}") from None
    bound, proof = _proved(problem, squares, instance.service_times, limit_s)
    certificate = {
        "format": FORMAT,
        "version": 1,
        "instance": problem.digest,
        "limit": limit_s,
        "scale": proof.scale,
        "bound": bound,
        "price": proof.price,
        "factors": [list(each) for each in proof.factors],
    }
    verdict = verify_bisection(certificate, document)
    proved = None if verdict.bound is None else float_below(verdict.bound)
    size, seconds = proof.size, time.perf_counter() - started
    return SpreadBound(proved, size.variables, size.constraints, size.nonzeros, seconds, certificate)


def _proved(problem: Problem, squares: Floats, work: Floats, limit_s: float) -> tuple[int | None, Proof]:
    """Return the integer bound, ``None`` when no division keeps the limit, and its proof."""
    limit = number(limit_s, "limit_s")
    if 2.0 * work.max(initial=0.0) - work.sum() > limit_s:
        # One contour outweighs all others together, and the least of (2) is the square of the left side.
        proof = _heavy(work)
        if spread_value(problem, limit, 0, proof.price, proof.factors)[1] > 0:
            return None, proof
    if len(work) < 2:
        return 0, Proof()
    proof = _spread(squares, work, limit_s)
    total, value = spread_value(problem, limit, proof.scale, proof.price, proof.factors)
    return max(0, floor((total + value) / 4)), proof


def _spread(squares: Floats, work: Floats, limit_s: float) -> Proof:
    """Solve (P); when it has no solution within the solver's tolerance, nothing is proved."""
    unit, heaviest = float(squares.max()) or 1.0, float(work.max()) or 1.0
    wide = max(limit_s, INTERIOR * float(work.sum())) / heaviest
    size, diagonal, price = _solve(squares / unit, work / heaviest, wide)
    scale, factors = _whole(squares / unit + price * np.outer(work, work) / heaviest**2, diagonal, unit)
    return Proof(size, scale, round(scale * unit * price / heaviest**2), factors)


def _heavy(work: Floats) -> Proof:
    """Minimise the left side of (2) instead."""
    heaviest = float(work.max())
    product = np.outer(work, work) / heaviest**2
    size, diagonal, _ = _solve(product, work, None)
    price, factors = _whole(product, diagonal, heaviest**2)
    return Proof(size, 1, price, factors)


def _solve(costs: Floats, work: Floats, limit: float | None) -> tuple[Size, Floats, float]:
    """Minimise the product of costs and S under (1) to (3), (2) if there is a limit.

    Returns the diagonal of P, zeros if the solver finds no solution, and t.
    """
    count = len(costs)
    pairs = edges_of(count)
    x = cp.Variable(len(pairs[0]))
    positive = as_matrix(adjacency(count) @ x, count) + np.eye(count) >> 0
    constraints = [positive]
    if limit is not None:
        products = np.outer(work, work)
        constraints.append(2.0 * products[pairs] @ x <= limit**2 - float(work @ work))
    problem = cp.Problem(cp.Minimize(2.0 * costs[pairs] @ x), constraints)
    size = solve(problem)
    if problem.status == cp.INFEASIBLE:
        return size, np.zeros(count), 0.0
    price = 0.0 if limit is None else max(0.0, float(constraints[1].dual_value))
    return size, np.diag(positive.dual_value), price


def _whole(matrix: Floats, diagonal: Floats, unit: float) -> tuple[int, tuple[tuple[int, ...], ...]]:
    """Return m and integer vectors f with sum f f' near m * unit * the matrix with that diagonal."""
    positive = matrix.copy()
    np.fill_diagonal(positive, diagonal)
    values, vectors = np.linalg.eigh(positive)
    columns = vectors * np.sqrt(np.maximum(values, 0.0))
    largest = float(np.abs(columns).max()) or 1.0
    scale = max(1, floor(LARGEST**2 / (unit * largest**2)))
    whole = np.rint(columns.T * np.sqrt(scale * unit)).astype(np.int64)
    return scale, tuple(tuple(row) for row in whole[whole.any(axis=1)].tolist())
