r"""How many steps apart two nodes are along the tour, as a semidefinite relaxation.

    Data       l_uv           symmetric lengths, n >= 4 nodes, d = floor(n / 2)                     [mm]
               V              via nodes next to node 0, or none
    Variables  X^k_uv >= 0    symmetric, k = 1..d; whether u and v are k steps apart                [-]

    min 1/2 <L, X^1>
    (1) sum_k X^k = J - I
    (2) X^k e = 2 e, or e for k = n / 2
    (3) I + sum_k cos(2 pi i k / n) X^k  positive semidefinite                   i = 1..d
    (4) sum over v in V of X^1_0v >= 1

(3) is the Gram matrix of the nodes laid out on a circle, i times around it. By (2), which follows from the
others, e is in its kernel, so the program adds J to (3) for an interior.

Strength: at least that of ``connectivity``; neither above nor below Held-Karp in general. The certificate
carries the duals of (3) as rows "cosine" (``DistancesRelaxation`` of the checker), one for each eigenvector.

Source: de Klerk, Pasechnik, Sotirov (2008).
"""

import cvxpy as cp
import numpy as np
from scipy.sparse import csr_array, eye_array, kron

from cutgap.formulations.relaxations.bound import RelaxationBound
from cutgap.formulations.relaxations.semidefinite import (
    adjacency,
    as_matrix,
    edges_of,
    incidence,
    integer_factors,
    solve,
)
from cutgap.formulations.relaxations.thresholds import bound_of_tours
from cutgap.formulations.relaxations.tour_proof import TourProof
from cutgap.instances import Instance, Rules
from cutgap.instances.arrays import Floats, Ints

MOST_NODES = 20
"""20 nodes take about 12 s, and time grows with the eighth power or faster."""


def cycle_distances(instance: Instance, rules: Rules, *, time_limit: float | None = None) -> RelaxationBound:
    """Return the bound of distances along the tour; see ``bound_of_tours`` for two heads and for errors."""
    return bound_of_tours(instance, rules, "cycle-distances", distances_of_tour, time_limit=time_limit)


def distances_of_tour(lengths: Floats, via: Ints) -> TourProof:
    """Solve the relaxation for one tour.

    Raises
    ------
    ValueError
        With more than ``MOST_NODES`` nodes.
    """
    nodes = len(lengths)
    if nodes > MOST_NODES:
        raise ValueError(f"a tour of {nodes} nodes is too large, the most is {MOST_NODES}")
    unit = float(lengths.max()) or 1.0
    most, pairs = nodes // 2, nodes * (nodes - 1) // 2
    steps = np.arange(1, most + 1)
    x = cp.Variable(most * pairs)
    pair = kron(np.ones((1, most)), eye_array(pairs), format="csr") @ x == 1
    totals = np.where(2 * steps == nodes, 1.0, 2.0)
    degree = kron(eye_array(most), incidence(nodes), format="csr") @ x == np.repeat(totals, nodes)
    shift = np.eye(nodes) + np.ones((nodes, nodes))
    cosines = np.cos(2.0 * np.pi * np.outer(steps, steps) / nodes)
    around = [_laid_out(row, x, nodes) + shift >> 0 for row in cosines]
    constraints = [pair, degree, x >= 0, *around]
    if len(via):
        constraints.append(np.ones(len(via)) @ x[via - 1] >= 1)
    costs = lengths[edges_of(nodes)] / unit
    problem = cp.Problem(cp.Minimize(costs @ x[:pairs]), constraints)
    size = solve(problem)
    rows = [
        (["degree", k, v], float(each))
        for k, row in enumerate(-degree.dual_value.reshape(most, nodes), 1)
        for v, each in enumerate(row)
    ]
    for i, constraint in enumerate(around, 1):
        factors, weight = integer_factors(constraint.dual_value)
        rows += [(["cosine", i, f], weight) for f in factors]
    if len(via):
        rows.append((["via"], float(constraints[-1].dual_value)))
    rows += _pairs(rows, costs, via, cosines)
    return TourProof(
        float(problem.value) * unit, size, tuple((row, y * unit) for row, y in rows), model="distances"
    )


def _laid_out(cosines: Floats, x: cp.Variable, nodes: int) -> cp.Expression:
    """Return the sum over k of cosine times X^k."""
    by_steps = csr_array(kron(cosines[None], adjacency(nodes)))
    return as_matrix(by_steps @ x, nodes)


Rows = list[tuple[list, float]]


def _pairs(rows: Rows, costs: Floats, via: Ints, cosines: Floats) -> Rows:
    """Return the best multipliers of (1) beside those of all other rows: the least reduced costs.

    So a residual that the solver leaves costs what it must and no more.
    """
    most, nodes = len(cosines), int(np.sqrt(2 * len(costs))) + 1
    tails, heads = edges_of(nodes)
    reduced = np.zeros((most, len(costs)))
    reduced[0] = costs
    for (family, *place), y in rows:
        if family == "degree":
            reduced[place[0] - 1] -= y * ((tails == place[1]) | (heads == place[1]))
        elif family == "via":
            reduced[0, via - 1] -= y
        else:
            f = np.array(place[1], dtype=float)
            reduced -= 2.0 * y * np.outer(cosines[place[0] - 1], f[tails] * f[heads])
    return [
        (["pair", int(u), int(v)], float(y)) for u, v, y in zip(tails, heads, reduced.min(axis=0), strict=True)
    ]
