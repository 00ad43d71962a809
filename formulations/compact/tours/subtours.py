"""Tours by subtour elimination: every set of contours is entered from outside.

    (enter h S k)     sum of y[h,i,j], i outside S (depot included), j in S - z[h,k] >= 0     k in S, |S| >= 2
    (enter h S)       one head: the same sum >= 1

``dfj`` lists all sets. ``dfj-rounds`` begins with none and adds those that cut off a point: by minimum cuts
from the depot in the relaxation (Padberg, Rinaldi, 1990), by the cycles of a whole solution.

Strength: the strongest of the compact models but for time-indexed, equal to multi-commodity.

Source: Dantzig, Fulkerson, Johnson (1954).
"""

from collections.abc import Iterable

import numpy as np
from scipy.sparse import csr_array

from cutgap.formulations.branch_and_cut.flows import build_graph, cuts_below_demand
from cutgap.formulations.branch_and_cut.separation import Support
from cutgap.formulations.compact.family import Family, family
from cutgap.formulations.compact.network import DEPOT, Pairs
from cutgap.formulations.compact.variables import Way
from cutgap.instances.arrays import Floats

VIOLATION = 1e-6
"""Least violation of a row that is worth adding."""

EnterName = tuple[tuple[int, ...]] | tuple[tuple[int, ...], int]
"""S, and k where there are two heads."""


def dfj(way: Way) -> list[Family]:
    """All sets of two contours or more are entered."""
    n = way.contours
    numbers = np.arange(1, 1 << n)
    members = (numbers[:, None] >> np.arange(n) & 1).astype(np.bool_)
    members = members[members.sum(axis=1) >= 2]
    names = [name for row in members for name in names_of_set(way, np.flatnonzero(row).tolist())]
    return enter(way, names)


def no_sets(way: Way) -> list[Family]:
    """No set yet: ``dfj-rounds`` adds them."""
    return []


def names_of_set(way: Way, contours: Iterable[int]) -> list[EnterName]:
    """Return the rows of one set: one for each k in it, or a single one on one head."""
    members = tuple(sorted(contours))
    return [(members,)] if way.alone else [(members, k) for k in members]


def enter(way: Way, names: list[EnterName]) -> list[Family]:
    """Each set S is entered, or is when k is cut."""
    if not names:
        return []
    inside = np.zeros((len(names), way.contours + 1), dtype=np.bool_)
    for row, name in enumerate(names):
        inside[row, list(name[0])] = True
    # The last column stands for the depot, which DEPOT = -1 picks.
    entering = csr_array(inside[:, way.pairs.heads] & ~inside[:, way.pairs.tails], dtype=np.float64) @ way.y
    if way.alone:
        return [family("enter", (way.head,), names, entering >= 1)]
    cut = np.array([name[1] for name in names])  # type: ignore[misc]
    return [family("enter", (way.head,), names, entering - way.z[cut] >= 0)]


def sets_not_entered(pairs: Pairs, y: Floats, z: Floats) -> list[list[int]]:
    """Return sets of two contours or more that a point enters too little, by minimum cuts.

    As much goes into a set as comes out of it, so half of what crosses its border enters it.
    """
    depot = pairs.contours
    used = np.flatnonzero(y > VIOLATION / 100)
    tails, heads = (np.where(ends == DEPOT, depot, ends)[used] for ends in (pairs.tails, pairs.heads))
    support = Support(depot + 1, tails, heads, y[used])
    cut = np.append(z, 0.0)
    label = support.components()
    parts = [label == part for part in range(label.max() + 1) if part != label[depot]]
    masks = [part for part in parts if cut[part].max() > VIOLATION]
    if not masks:
        graph = build_graph(depot + 1, tails, heads)
        masks = list(cuts_below_demand(graph, support.x, depot, 2.0 * cut, 2.0 * VIOLATION))
    sets = {tuple(np.flatnonzero(mask).tolist()) for mask in masks}
    return [list(members) for members in sorted(sets) if len(members) >= 2]
