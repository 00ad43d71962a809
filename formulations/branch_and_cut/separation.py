r"""Separation of subtour, blossom and comb inequalities, all in one form: sums of cuts.

    (S)  x(delta(S)) >= 2                                        S a proper subset of the nodes
    (C)  x(delta(H)) + sum_i x(delta(T_i)) >= 3 k + 1            k odd, k >= 3, the T_i disjoint,
                                                                 each T_i meets H and leaves it

A blossom is (C) with teeth of two nodes. In this form the coefficient of an edge is the number of sets that
it crosses, so rows, pricing and certificates need the sets alone.

Sources: Dantzig, Fulkerson, Johnson (1954) for (S); Edmonds (1965) and Chvatal (1973), Groetschel and Padberg
(1979) for (C); exact blossom separation by cut trees after Letchford, Reinelt, Theis (2004).
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from cutgap.formulations.branch_and_cut.flows import build_graph, cut_tree, cuts_below_demand
from cutgap.instances.arrays import Floats, Ints

VIOLATION = 1e-4
"""Least violation of a cut that is worth adding."""

Mask = npt.NDArray[np.bool_]

Members = frozenset[int]

Blossom = tuple[set[int], list[tuple[int, int]]]
"""A handle and its teeth, edges of its boundary."""


@dataclass(frozen=True, slots=True)
class Cut:
    """The inequality sum over ``sets`` of x(delta(set)) >= ``least``."""

    sets: tuple[frozenset[int], ...]
    least: int

    @classmethod
    def subtour(cls, nodes: Iterable[int]) -> "Cut":
        """Build (S)."""
        return cls((frozenset(nodes),), 2)

    @classmethod
    def comb(cls, handle: Iterable[int], teeth: Iterable[frozenset[int]]) -> "Cut":
        """Build (C); the handle is the first set."""
        sets = (frozenset(handle), *teeth)
        return cls(sets, 3 * (len(sets) - 1) + 1)

    def coefficients(self, tails: Ints, heads: Ints, nodes: int) -> Floats:
        """Return the coefficient of each edge ``tails[e] - heads[e]``."""
        total = np.zeros(len(tails))
        for members in self.sets:
            mask = np.zeros(nodes, dtype=bool)
            mask[list(members)] = True
            total += mask[tails] != mask[heads]
        return total


@dataclass(frozen=True, slots=True)
class Support:
    """The edges of a fractional solution that carry weight: ``tails[e] - heads[e]`` with ``x[e] > 0``."""

    nodes: int
    tails: Ints
    heads: Ints
    x: Floats

    def components(self) -> Ints:
        """Return the number of the connected component of each node."""
        shape = (self.nodes, self.nodes)
        adjacency = coo_array((np.ones(len(self.x)), (self.tails, self.heads)), shape=shape)
        return connected_components(adjacency, directed=False)[1].astype(np.int64)

    def cut_value(self, members: Iterable[int]) -> float:
        """Return x(delta(S))."""
        mask = np.zeros(self.nodes, dtype=bool)
        mask[list(members)] = True
        return float(self.x[mask[self.tails] != mask[self.heads]].sum())

    def shrink(self, label: Ints, count: int) -> "Support":
        """Merge the nodes of equal label, sum parallel edges and drop loops."""
        tails, heads = label[self.tails], label[self.heads]
        low, high = np.minimum(tails, heads), np.maximum(tails, heads)
        keep = low < high
        keys, inverse = np.unique(low[keep] * count + high[keep], return_inverse=True)
        x = np.bincount(inverse, weights=self.x[keep], minlength=len(keys)).astype(np.float64)
        return Support(count, keys // count, keys % count, x)


def separate_subtours(support: Support) -> list[Cut]:
    """Return violated cuts (S) by minimum cuts, exact up to ``VIOLATION``, each by its smaller side."""
    cuts = []
    for mask in connectivity_violations(support, 0, np.full(support.nodes, 2.0)):
        smaller = mask if 2 * mask.sum() <= support.nodes else ~mask
        cuts.append(Cut.subtour(np.flatnonzero(smaller).tolist()))
    return list(dict.fromkeys(cuts))


def connectivity_violations(support: Support, root: int, demand: Floats) -> list[Mask]:
    """Return masks of sets S without the root that violate x(delta(S)) >= max of the demands in S."""
    label = support.components()
    apart = [label == c for c in range(label.max() + 1) if c != label[root]]
    masks = [part for part in apart if demand[part].max() > VIOLATION]
    if masks:
        return masks
    graph = build_graph(support.nodes, support.tails, support.heads)
    return list(cuts_below_demand(graph, support.x, root, demand, VIOLATION))


def separate_combs(
    support: Support, tight_sets: Iterable[frozenset[int]], rng: np.random.Generator
) -> list[Cut]:
    """Return violated cuts (C): exact blossoms on the graph, then on graphs with tight sets shrunk.

    The point must satisfy all cuts (S). Shrinking a set S with x(delta(S)) = 2 keeps the point inside the
    degree equations, and a blossom of the shrunk graph is a comb of the original one.
    """
    found = dict.fromkeys(_blossoms(support, np.arange(support.nodes)))
    labels = shrinkings(support, [s for s in tight_sets if 2 <= len(s) <= support.nodes // 2], rng)
    for label in labels:
        found |= dict.fromkeys(_blossoms(support, label))
    return list(found)


def shrinkings(support: Support, tight: list[frozenset[int]], rng: np.random.Generator) -> Iterator[Ints]:
    """Yield labellings that shrink paths of edges at 1, and families of disjoint tight sets."""
    whole = support.x > 1.0 - 1e-6
    paths = list(zip(support.tails[whole].tolist(), support.heads[whole].tolist(), strict=True))
    yield _labels(support.nodes, [frozenset(path) for path in paths])
    for _ in range(4):
        order = rng.permutation(len(tight))
        taken: set[int] = set()
        family = []
        for index in order:
            if taken.isdisjoint(tight[index]):
                taken |= tight[index]
                family.append(tight[index])
        yield _labels(support.nodes, family)


def _labels(nodes: int, family: list[frozenset[int]]) -> Ints:
    """Return consecutive labels, equal within each set of the family (sets that meet are joined)."""
    tails = [min(members) for members in family for _ in members]
    heads = [node for members in family for node in members]
    links = coo_array((np.ones(len(tails)), (tails, heads)), shape=(nodes, nodes))
    return connected_components(links, directed=False)[1].astype(np.int64)


def _blossoms(support: Support, label: Ints) -> Iterator[Cut]:
    """Yield violated blossoms of the shrunk graph as cuts of the original one."""
    for handle, teeth in odd_sets(support, label):
        cut = Cut.comb(handle, teeth)
        if sum(support.cut_value(s) for s in cut.sets) < cut.least - VIOLATION:
            yield cut


def odd_sets(support: Support, label: Ints) -> Iterator[tuple[Members, list[Members]]]:
    """Yield handles and teeth of the blossoms that minimum cuts of the shrunk graph suggest."""
    count = int(label.max()) + 1
    small = support.shrink(label, count)
    if count < 6:
        return
    weight = np.minimum(small.x, np.maximum(1.0 - small.x, 0.0))
    fractional = weight > 1e-9
    graph = build_graph(count, small.tails[fractional], small.heads[fractional])
    _, weights, sides = cut_tree(graph, weight[fractional])
    members = [frozenset(np.flatnonzero(label == c).tolist()) for c in range(count)]
    for handle, teeth in _odd_cuts(small, sides[1:][weights[1:] < 1.0 - VIOLATION]):
        nodes = frozenset[int]().union(*(members[v] for v in handle))
        yield nodes, [members[u] | members[v] for u, v in teeth]


def _odd_cuts(small: Support, sides: Mask) -> Iterator[Blossom]:
    """Yield handles among the rows of ``sides`` with an odd number of teeth that are violated.

    The teeth are the boundary edges above 1/2; where they are even in number, the edge nearest to 1/2
    changes its role.
    """
    crossing = sides[:, small.tails] != sides[:, small.heads]
    chosen = crossing & (small.x > 0.5)
    even = np.flatnonzero((chosen.sum(axis=1) % 2 == 0) & crossing.any(axis=1))
    doubt = np.where(crossing[even], np.abs(1.0 - 2.0 * small.x), np.inf)
    cheapest = np.argmin(doubt, axis=1)
    chosen[even, cheapest] = ~chosen[even, cheapest]
    slack = np.where(chosen, 1.0 - small.x, np.where(crossing, small.x, 0.0)).sum(axis=1)
    for row in np.flatnonzero((slack < 1.0 - VIOLATION) & (chosen.sum(axis=1) % 2 == 1)):
        edges = np.flatnonzero(chosen[row])
        teeth = list(zip(small.tails[edges].tolist(), small.heads[edges].tolist(), strict=True))
        blossom = _disjoint(set(np.flatnonzero(sides[row]).tolist()), teeth)
        if blossom is not None:
            yield blossom


def _disjoint(handle: set[int], teeth: list[tuple[int, int]]) -> Blossom | None:
    """Make teeth disjoint: a node of two teeth changes sides, so that both become inner or outer edges."""
    while True:
        counts: dict[int, list[tuple[int, int]]] = {}
        for tooth in teeth:
            for node in tooth:
                counts.setdefault(node, []).append(tooth)
        shared = next((node for node, its in counts.items() if len(its) > 1), None)
        if shared is None:
            break
        handle ^= {shared}
        teeth = [tooth for tooth in teeth if shared not in tooth]
        if len(teeth) % 2 == 0:
            return None
    return (handle, teeth) if len(teeth) >= 3 else None
