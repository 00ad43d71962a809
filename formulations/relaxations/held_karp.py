r"""The Held-Karp bound, by subgradient steps on 1-trees and from the duals of the subtour linear program.

    Data  l_uv   symmetric lengths, n >= 4 nodes; V via nodes next to node 0, or none      [mm]

    (P) min sum l_uv x_uv   s.t.  x(delta(v)) = 2 each v,  x(delta(S)) >= 2 each S,  x(0 : V) >= 1,  0 <= x <= 1
    (D) max over pi of the least 1-tree, see ``one_tree``

Let lambda_v and y_S >= 0 be the duals of (P), each S taken without node 0 (its complement has the same cut).

    (1) pi_v = lambda_v + sum of y_S over the S with v

makes (D) at least (P): with costs l_uv - pi_u - pi_v an edge costs its reduced cost in (P) less 2 y_S for each
S that holds both ends, and a 1-tree has at most |S| - 1 edges inside S. So its value is at least 2 sum lambda +
2 sum |S| y_S - 2 sum (|S| - 1) y_S, plus what x <= 1 and V give, which 1-trees keep too: n integers prove (P).

Source: Dantzig, Fulkerson, Johnson (1954); Held and Karp (1970).
"""

import numpy as np

from cutgap.formulations.branch_and_cut.separation import Cut
from cutgap.formulations.branch_and_cut.tour import TourModel, best_tour
from cutgap.formulations.relaxations.bound import RelaxationBound, Size
from cutgap.formulations.relaxations.one_tree import held_karp_bound
from cutgap.formulations.relaxations.thresholds import bound_of_tours
from cutgap.formulations.relaxations.tour_proof import TourProof
from cutgap.instances import Instance, Rules
from cutgap.instances.arrays import Floats, Ints


def one_tree(instance: Instance, rules: Rules, *, time_limit: float | None = None) -> RelaxationBound:
    """Return the Held-Karp bound that subgradient steps reach; see ``bound_of_tours``."""
    return bound_of_tours(instance, rules, "one-tree", one_tree_of_tour, time_limit=time_limit)


def held_karp(instance: Instance, rules: Rules, *, time_limit: float | None = None) -> RelaxationBound:
    """Return the Held-Karp bound, from the subtour linear program; see ``bound_of_tours``."""
    return bound_of_tours(instance, rules, "held-karp", held_karp_of_tour, time_limit=time_limit)


def one_tree_of_tour(lengths: Floats, via: Ints) -> TourProof:
    """Improve (D) for one tour; its size is that of the 1-trees: an edge each, and one tree."""
    value, potentials = held_karp_bound(lengths, tuple(via.tolist()))
    nodes = len(lengths)
    return TourProof(value, Size(nodes, nodes, nodes * (nodes - 1)), potentials=potentials)


def held_karp_of_tour(lengths: Floats, via: Ints) -> TourProof:
    """Solve (P) for one tour, in rounds of cuts, and take (1)."""
    model = relaxed_tour(lengths, via, subtours=True)
    potentials = np.zeros(len(lengths))
    for name, multiplier in model.proof():
        if isinstance(name, Cut):
            members = set(name.sets[0])
            potentials[list(set(range(len(lengths))) - members if 0 in members else members)] += multiplier
        elif name != ("via",):
            potentials[name[1]] += multiplier  # type: ignore[index]
    return TourProof(model.bound(), model_size(model), potentials=potentials)


def relaxed_tour(lengths: Floats, via: Ints, *, subtours: bool) -> TourModel:
    """Return the solved linear program of one tour, with subtour rows or with degree rows alone."""
    model = TourModel(lengths, via, best_tour(lengths, via, lengths)[1])
    model.solve()
    while subtours and model.separate(thorough=False):
        model.solve()
    return model


def model_size(model: TourModel) -> Size:
    """Return the size of the linear program as it was last solved, without the edges that pricing keeps out."""
    return Size(len(model.lp.costs), model.lp.row_count, model.lp.nonzeros)
