r"""Who follows whom, without asking for one tour: assignment, and the fractional 2-matching.

    Data       l_uv   symmetric lengths, n >= 4 nodes                                       [mm]
               V      via nodes next to node 0, or none

    (1) assignment    min sum l_uv z_uv,  z_uv >= 0 from u to v: one in, one out of each node; z_uu = 0
    (2)   its dual    max 2 sum_v pi_v    s.t.  pi_u + pi_v <= l_uv
    (3) two-matching  min sum l_uv x_uv   s.t.  x(delta(v)) = 2 each v,  0 <= x <= 1,  x(0 : V) >= 1

With symmetric lengths the two potentials of each node in the dual of (1) may be averaged, which gives (2). So
(1) is (3) without x <= 1 and V: it may go back and forth between two nodes. Both are proved by degree rows.

Strength: assignment <= two-matching <= Held-Karp.
"""

import numpy as np
from scipy.optimize import linear_sum_assignment

from cutgap.formulations.relaxations.bound import RelaxationBound, Size
from cutgap.formulations.relaxations.held_karp import model_size, relaxed_tour
from cutgap.formulations.relaxations.thresholds import bound_of_tours
from cutgap.formulations.relaxations.tour_proof import TourProof
from cutgap.instances import Instance, Rules
from cutgap.instances.arrays import Floats, Ints


def assignment(instance: Instance, rules: Rules, *, time_limit: float | None = None) -> RelaxationBound:
    """Return the bound (1); see ``bound_of_tours``."""
    return bound_of_tours(instance, rules, "assignment", assignment_of_tour, time_limit=time_limit)


def two_matching(instance: Instance, rules: Rules, *, time_limit: float | None = None) -> RelaxationBound:
    """Return the bound (3); see ``bound_of_tours``."""
    return bound_of_tours(instance, rules, "two-matching", two_matching_of_tour, time_limit=time_limit)


def assignment_of_tour(lengths: Floats, via: Ints) -> TourProof:
    """Solve (1) for one tour; via nodes are left out of account."""
    nodes = len(lengths)
    costs = lengths + np.diag(np.full(nodes, 1.0 + 2.0 * float(lengths.sum())))
    _, after = linear_sum_assignment(costs)
    potentials = _potentials(costs, after)
    rows = tuple((["degree", v], float(each)) for v, each in enumerate(potentials))
    arcs = nodes * (nodes - 1)
    return TourProof(float(costs[np.arange(nodes), after].sum()), Size(arcs, 2 * nodes, 2 * arcs), rows)


def _potentials(costs: Floats, after: Ints) -> Floats:
    """Return (2) from the best assignment.

    Let a_u + b_v <= l_uv be the dual of (1), with equality where v follows u. So b_v <= b_w + l_uv - l_uw for
    the w that follows u: shortest ways, with no cycle below 0 as the assignment is best, by Bellman's rounds.
    """
    followed = costs[np.arange(len(costs)), after]
    entering = np.zeros(len(costs))
    for _ in range(len(costs)):
        better = np.minimum(entering, (entering[after] + (costs.T - followed)).min(axis=1))
        if (better == entering).all():
            break
        entering = better
    leaving = followed - entering[after]
    return (leaving + entering) / 2


def two_matching_of_tour(lengths: Floats, via: Ints) -> TourProof:
    """Solve (3) for one tour."""
    model = relaxed_tour(lengths, via, subtours=False)
    rows = tuple((list(name), multiplier) for name, multiplier in model.proof())  # type: ignore[call-overload]
    return TourProof(model.bound(), model_size(model), rows)
