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
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from cutgap.formulations.branch_and_cut.flows import build_graph, cut_tree, cuts_below_demand
from cutgap.instances.arrays import Floats, Ints

VIOLATION = 1e-4
"""Least violation of a cut that is worth adding."""

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


def separate_subtours(support: Support, root: int = 0, demand: Floats | None = None) -> list[Cut]:
    """Return violated cuts (S) by minimum cuts from the root; exact up to ``VIOLATION``.

    With a ``demand`` d (default 2 everywhere) the sets S avoid the root and violate
    x(delta(S)) >= max over v in S of d[v].
    """
    demand = np.full(support.nodes, 2.0) if demand is None else demand
    label = support.components()
    parts = [np.flatnonzero(label == c) for c in range(label.max() + 1) if c != label[root]]
    masks = [part for part in parts if demand[part].max() > VIOLATION]
    if not masks:
        graph = build_graph(support.nodes, support.tails, support.heads)
        found = cuts_below_demand(graph, support.x, root, demand, VIOLATION)
        masks = [np.flatnonzero(mask) for mask in found]
    return list(dict.fromkeys(Cut.subtour(mask.tolist()) for mask in masks))


def separate_combs(
    support: Support, tight_sets: Iterable[frozenset[int]], rng: np.random.Generator
) -> list[Cut]:
    """Return violated cuts (C): exact blossoms on the graph, then on graphs with tight sets shrunk.

    The point must satisfy all cuts (S). Shrinking a set S with x(delta(S)) = 2 keeps the point inside the
    degree equations, and a blossom of the shrunk graph is a comb of the original one.
    """
    found = dict.fromkeys(_blossoms(support, np.arange(support.nodes)))
    labels = _shrinkings(support, [s for s in tight_sets if 2 <= len(s) <= support.nodes // 2], rng)
    for label in labels:
        found |= dict.fromkeys(_blossoms(support, label))
    return list(found)


def _shrinkings(support: Support, tight: list[frozenset[int]], rng: np.random.Generator) -> Iterator[Ints]:
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
    count = int(label.max()) + 1
    small = support.shrink(label, count)
    if count < 6:
        return
    weight = np.minimum(small.x, np.maximum(1.0 - small.x, 0.0))
    fractional = weight > 1e-9
    graph = build_graph(count, small.tails[fractional], small.heads[fractional])
    _, weights, sides = cut_tree(graph, weight[fractional])
    members = [frozenset(np.flatnonzero(label == c).tolist()) for c in range(count)]
    for node in range(1, count):
        if weights[node] >= 1.0 - VIOLATION:
            continue
        blossom = _odd_cut(small, sides[node])
        if blossom is None:
            continue
        handle, teeth = blossom
        nodes = frozenset().union(*(members[v] for v in handle))
        cut = Cut.comb(nodes, [members[u] | members[v] for u, v in teeth])
        if sum(support.cut_value(s) for s in cut.sets) < cut.least - VIOLATION:
            yield cut


def _odd_cut(small: Support, side: np.ndarray) -> Blossom | None:
    """Choose the teeth of the handle ``side``: an odd number of disjoint edges of its boundary."""
    crossing = np.flatnonzero(side[small.tails] != side[small.heads])
    if len(crossing) == 0:
        return None
    chosen = small.x[crossing] > 0.5
    if chosen.sum() % 2 == 0:
        cheapest = int(np.argmin(np.abs(1.0 - 2.0 * small.x[crossing])))
        chosen[cheapest] = not chosen[cheapest]
    if (np.where(chosen, 1.0 - small.x[crossing], small.x[crossing])).sum() >= 1.0 - VIOLATION:
        return None
    handle = set(np.flatnonzero(side).tolist())
    edges = crossing[chosen]
    teeth = list(zip(small.tails[edges].tolist(), small.heads[edges].tolist(), strict=True))
    return _disjoint(handle, teeth)


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
