r"""A tour's algebraic connectivity as a semidefinite relaxation.

    Data       l_uv          symmetric lengths, n >= 4 nodes                               [mm]
               V             via nodes next to node 0, or none
               beta = 2 - 2 cos(2 pi / n)
    Variables  X_uv          symmetric; whether u and v are neighbours in the tour         [-]

    min 1/2 <L, X>
    (1) X e = 2 e,  diag X = 0
    (2) 0 <= X <= 1
    (3) 2 I - X + alpha J - beta I  positive semidefinite
    (4) sum over v in V of X_0v >= 1

2 I - X is the Laplacian matrix of the tour, with the eigenvalues 2 - 2 cos(2 pi k / n). The source leaves
alpha >= beta / n free; as e is an eigenvector of (3), with eigenvalue alpha n - beta, every such alpha says the
same, and alpha = beta / n + 1 leaves an interior.

Strength: at most the Held-Karp bound, and at most that of ``cycle_distances``. The certificate carries the dual
of (3) as a few rows "connectivity" (``TourRelaxation`` of the checker), one for each eigenvector.

Source: Cvetkovic, Cangalovic, Kovacevic-Vujcic (1999).
"""

import cvxpy as cp
import numpy as np

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

MOST_NODES = 80
"""Time grows with the sixth power: 60 nodes take about 8 s, 80 nodes a minute."""


def connectivity(instance: Instance, rules: Rules, *, time_limit: float | None = None) -> RelaxationBound:
    """Return the bound of algebraic connectivity; see ``bound_of_tours`` for two heads and for errors."""
    return bound_of_tours(instance, rules, "connectivity", connectivity_of_tour, time_limit=time_limit)


def connectivity_of_tour(lengths: Floats, via: Ints) -> TourProof:
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
    beta = 2.0 - 2.0 * np.cos(2.0 * np.pi / nodes)
    x = cp.Variable(nodes * (nodes - 1) // 2)
    degree = incidence(nodes) @ x == 2
    shift = (2.0 - beta) * np.eye(nodes) + (beta / nodes + 1.0) * np.ones((nodes, nodes))
    connected = shift - as_matrix(adjacency(nodes) @ x, nodes) >> 0
    constraints = [degree, connected, x >= 0, x <= 1]
    if len(via):
        constraints.append(np.ones(len(via)) @ x[via - 1] >= 1)  # edges at node 0 come first
    problem = cp.Problem(cp.Minimize(lengths[edges_of(nodes)] / unit @ x), constraints)
    size = solve(problem)
    factors, weight = integer_factors(connected.dual_value)
    # A row's square takes f_v^2 x(delta(v)) = 2 f_v^2 along, which the degrees give back.
    squares = weight * np.square(np.array(factors, dtype=float).reshape(-1, nodes)).sum(axis=0)
    rows = [(["degree", v], each) for v, each in enumerate(-degree.dual_value - squares)]
    rows += [(["connectivity", f], weight) for f in factors]
    if len(via):
        rows.append((["via"], float(constraints[-1].dual_value)))
    return TourProof(float(problem.value) * unit, size, tuple((row, float(y) * unit) for row, y in rows))
