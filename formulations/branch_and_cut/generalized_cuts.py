r"""Cuts of tours that pass one node of each contour, and how violated ones are found.

    x(E(S))   weight of the edges with both ends in S
    y(S)      weight of the nodes in S;   x(delta(S)) = 2 y(S) - 2 x(E(S)) by the degree equations
    C_h       the nodes of contour h

    (G)  x(delta(S)) >= 2 (y(S & C_h) + y(C_k \ S) - 1)                            any S, any h, k
    (K)  x(delta(H)) + sum_i x(delta(T_i)) >= 3 t + 1 - 2 sum_i (2 - y(T_i & H & C_hi) - y((T_i \ H) & C_ki))
                                                    t odd, t >= 3, teeth T_i disjoint

(G) says: where the tour passes S and passes its outside, it crosses the border twice. A contour within S, or
outside it, makes its term 1: then all of the generalised subtour eliminations of Fischetti, Salazar, Toth
(1995) appear, with y_v in place of the sum the weaker ones; S = {v} + C_k gives their fan x(v : C_k) <= y_v.
(K) is their generalised comb: a tooth whose two parts both hold a contour has its last term 0. Proofs are in
``docs/certificates.md``.

In the linear program both stand divided by 2 and with x(E(.)), which is sparse for small sets:

    sum over sets of (y(S) - x(E(S))) - sum of y-terms >= least
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from cutgap.formulations.branch_and_cut.flows import Graph, build_graph, maximum_flow
from cutgap.formulations.branch_and_cut.separation import (
    Mask,
    Members,
    Support,
    connectivity_violations,
    odd_sets,
    shrinkings,
)
from cutgap.instances.arrays import Floats, Ints

VIOLATION = 1e-4
"""Least violation, in the form of the linear program, that is worth adding."""

Pair = tuple[int | None, int | None]
"""Contours h, k of a (G), or of a tooth; ``None`` where a whole contour makes the term 1."""


@dataclass(frozen=True, slots=True)
class GeneralizedCut:
    """(G) with one set and one pair, or (K) with handle and teeth, and a pair a tooth."""

    sets: tuple[Members, ...]
    pairs: tuple[Pair, ...]

    @property
    def least(self) -> float:
        """Right side in the form of the linear program."""
        teeth = len(self.sets) - 1
        whole = sum(contour is None for pair in self.pairs for contour in pair)
        return whole - 1.0 if teeth == 0 else (1 - teeth) / 2 + whole

    def masks(self, nodes: int) -> Mask:
        """Return the sets as masks, shape (sets, nodes)."""
        masks = np.zeros((len(self.sets), nodes), dtype=bool)
        for mask, members in zip(masks, self.sets, strict=True):
            mask[list(members)] = True
        return masks

    def node_coefficients(self, contour_of: Ints) -> Floats:
        """Return the coefficient of each y_v."""
        masks = self.masks(len(contour_of))
        total = masks.sum(axis=0).astype(np.float64)
        sides = [(masks[0], ~masks[0])]
        if len(masks) > 1:
            sides = [(tooth & masks[0], tooth & ~masks[0]) for tooth in masks[1:]]
        for parts, pair in zip(sides, self.pairs, strict=True):
            for part, contour in zip(parts, pair, strict=True):
                if contour is not None:
                    total -= part & (contour_of == contour)
        return total

    def edge_coefficients(self, tails: Ints, heads: Ints, nodes: int) -> Floats:
        """Return the coefficient of each edge ``tails[e] - heads[e]``."""
        masks = self.masks(nodes)
        return -(masks[:, tails] & masks[:, heads]).sum(axis=0).astype(np.float64)


@dataclass(frozen=True, slots=True)
class Point:
    """A fractional solution: y of all nodes, and the edges that carry weight."""

    contour_of: Ints
    y: Floats
    tails: Ints
    heads: Ints
    x: Floats

    @property
    def contours(self) -> int:
        """Number of contours."""
        return int(self.contour_of[-1]) + 1

    def violation(self, cut: GeneralizedCut) -> float:
        """Return by how much the point misses a cut."""
        nodes = float(cut.node_coefficients(self.contour_of) @ self.y)
        edges = float(cut.edge_coefficients(self.tails, self.heads, len(self.y)) @ self.x)
        return cut.least - nodes - edges

    def crossing(self, mask: Mask) -> float:
        """Return x(delta(S))."""
        return float(self.x[mask[self.tails] != mask[self.heads]].sum())

    def contracted(self) -> Support:
        """Return the graph whose nodes are the contours."""
        nodes = Support(len(self.y), self.tails, self.heads, self.x)
        return nodes.shrink(self.contour_of, self.contours)

    def strongest(self, mask: Mask) -> GeneralizedCut:
        """Return (G) of a set with the contours that ask most of it, by its smaller side."""
        if 2 * mask.sum() > len(mask):
            mask = ~mask
        pair = (self._most(mask), self._most(~mask))
        return GeneralizedCut((frozenset(np.flatnonzero(mask).tolist()),), (pair,))

    def comb(self, masks: Sequence[Mask]) -> GeneralizedCut:
        """Return (K) of a handle and teeth with the contours that ask most of them."""
        handle, teeth = masks[0], masks[1:]
        pairs = tuple((self._most(tooth & handle), self._most(tooth & ~handle)) for tooth in teeth)
        return GeneralizedCut(tuple(frozenset(np.flatnonzero(mask).tolist()) for mask in masks), pairs)

    def _most(self, mask: Mask) -> int | None:
        """Return the contour with most weight within a set, ``None`` when one lies in it."""
        if (np.bincount(self.contour_of[~mask], minlength=self.contours) == 0).any():
            return None
        weights = np.bincount(self.contour_of[mask], weights=self.y[mask], minlength=self.contours)
        return int(np.argmax(weights))


def quick_cuts(point: Point) -> list[GeneralizedCut]:
    """Return violated (G): of connected components, of contours as wholes (exact), and all fans."""
    masks = list(_components(point)) or [mask[point.contour_of] for mask in _contour_masks(point)]
    return violated(point, [point.strongest(mask) for mask in [*masks, *_fans(point)]])


def violated(point: Point, cuts: Iterable[GeneralizedCut]) -> list[GeneralizedCut]:
    """Return the cuts that the point misses, each once, the worst first."""
    amounts = {cut: point.violation(cut) for cut in dict.fromkeys(cuts)}
    return sorted((cut for cut in amounts if amounts[cut] > VIOLATION), key=lambda cut: -amounts[cut])


def _components(point: Point) -> Iterator[Mask]:
    """Yield connected components of the support, when there are several."""
    label = Support(len(point.y), point.tails, point.heads, point.x).components()
    used = np.unique(label[np.concatenate([point.tails, point.heads])])
    if len(used) > 1:
        yield from (label == each for each in used)


def _contour_masks(point: Point) -> list[Mask]:
    contracted = point.contracted()
    return connectivity_violations(contracted, 0, np.full(contracted.nodes, 2.0))


def _fans(point: Point) -> Iterator[Mask]:
    """Yield {v} + C_k for every violated x(v : C_k) <= y_v."""
    m = point.contours
    nodes = np.concatenate([point.tails, point.heads])
    others = point.contour_of[np.concatenate([point.heads, point.tails])]
    keys, inverse = np.unique(nodes * m + others, return_inverse=True)
    weight = np.bincount(inverse, weights=np.tile(point.x, 2))
    for key in keys[weight > point.y[keys // m] + VIOLATION]:
        mask = point.contour_of == key % m
        mask[key // m] = True
        yield mask


def minimum_cuts(point: Point, pairs: Ints) -> list[GeneralizedCut]:
    """Return violated (G) for pairs h, k of contours, shape (pairs, 2): one minimum cut each, exact."""
    # Not by y: an edge within rounding of zero must find its ends too.
    used = np.unique(np.concatenate([point.tails, point.heads]))
    place = np.zeros(len(point.y), dtype=np.int64)
    place[used] = np.arange(len(used))
    small = np.arange(len(used))
    tails = np.concatenate([place[point.tails], np.full(len(used), len(used)), small])
    heads = np.concatenate([place[point.heads], small, np.full(len(used), len(used) + 1)])
    graph = build_graph(len(used) + 2, tails, heads)
    found = _pair_cuts(graph, point.x, point.y[used], point.contour_of[used], pairs)
    masks = np.zeros((len(found), len(point.y)), dtype=bool)
    masks[:, used] = found
    different = {mask.tobytes(): mask for mask in masks}
    return violated(point, [point.strongest(mask) for mask in different.values()])


@njit(cache=True)
def _pair_cuts(graph: Graph, x: Floats, y: Floats, contour_of: Ints, pairs: Ints) -> np.ndarray:
    r"""Return masks of sets with x(delta(S)) + 2 y(C_h \ S) + 2 y(S & C_k) < 2, which violate (G).

    The source sends 2 y_v to each v of C_h, each v of C_k sends 2 y_v to the sink: this is a cut between them.
    """
    edges, nodes = len(x), len(y)
    found = np.zeros((len(pairs), nodes), dtype=np.bool_)
    count = 0
    is_source = np.zeros(nodes + 2, dtype=np.bool_)
    is_source[nodes] = True
    capacity = np.zeros(edges + 2 * nodes)
    capacity[:edges] = x
    limit = 2.0 - 2.0 * VIOLATION
    for i in range(len(pairs)):
        for v in range(nodes):
            capacity[edges + v] = 2.0 * y[v] if contour_of[v] == pairs[i, 0] else 0.0
            capacity[edges + nodes + v] = 2.0 * y[v] if contour_of[v] == pairs[i, 1] else 0.0
        flow, reached = maximum_flow(graph, capacity[graph.edge], is_source, nodes + 1, limit)
        if flow < limit:
            found[count] = reached[:nodes]
            count += 1
    return found[:count]


def combs(
    point: Point, tight: Sequence[Members], tight_contours: Sequence[Members], rng: np.random.Generator
) -> list[GeneralizedCut]:
    """Return violated (K): blossoms of the graph, of the graph of contours, and of both with sets shrunk.

    Parameters
    ----------
    tight, tight_contours
        Sets of nodes, and of contours, that the point crosses twice and with whole contours on both sides.
    """
    nodes = np.arange(len(point.y))
    members = [np.flatnonzero(point.contour_of == h).tolist() for h in range(point.contours)]
    found = []
    for handle, teeth in _odd_sets(point.contracted(), tight_contours, rng):
        sets = [[v for h in each for v in members[h]] for each in (handle, *teeth)]
        found.append(point.comb([np.isin(nodes, each) for each in sets]))
    used, ends = np.unique(np.concatenate([point.tails, point.heads]), return_inverse=True)
    support = Support(len(used), ends[: len(point.x)], ends[len(point.x) :], point.x)
    place = {v: i for i, v in enumerate(used.tolist())}
    small = [frozenset(place[v] for v in each if v in place) for each in tight]
    for handle, teeth in _odd_sets(support, small, rng):
        found.append(point.comb([np.isin(nodes, used[list(each)]) for each in (handle, *teeth)]))
    return violated(point, found)


def _odd_sets(
    support: Support, tight: Sequence[Members], rng: np.random.Generator
) -> Iterator[tuple[Members, list[Members]]]:
    """Yield handles and teeth that blossoms of the graph, as it is and shrunk, suggest."""
    yield from odd_sets(support, np.arange(support.nodes))
    for label in shrinkings(support, [each for each in tight if 2 <= len(each) <= support.nodes // 2], rng):
        yield from odd_sets(support, label)
