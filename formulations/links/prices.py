"""Reduced costs of edges without a column, from multipliers of the rows of ``cuts``."""

from collections.abc import Hashable
from itertools import permutations

import numpy as np
from numba import njit

from cutgap.formulations.links.cuts import DOUBLE, HOME, RAPID, Bundle, Group, Parity, Partition, Rank, Triangle
from cutgap.formulations.links.graph import LinkGraph
from cutgap.instances.arrays import Floats, Ints

NEGATIVE = 1e-7
"""Reduced costs below minus this, in mm, ask for a column."""


class Prices:
    """Multipliers of rows, summed up by what they mean for edges without a column."""

    def __init__(self, graph: LinkGraph, names: list[Hashable], multipliers: Floats) -> None:
        self.graph = graph
        self.node = np.zeros(graph.nodes)  # of parities and bundles
        self.toward = np.zeros((graph.nodes, graph.places))  # of nodes with a place, in bundles
        self.single, self.double = np.zeros((2, graph.places, graph.places))
        self.end = np.zeros(graph.places)  # of rapids at a place
        self.rapid = 0.0  # of rapids between contours
        sets, prices = [], []
        for name, price in zip(names, multipliers.tolist(), strict=True):
            if price == 0.0:
                continue
            if isinstance(name, Partition):
                label = name.labels(graph.places)
                across = price * (label[:, None] != label)
                self.single += across
                self.double += name.count / (name.count - 1) * across
            elif isinstance(name, Parity):
                self.node[list(name.nodes)] += price
                if len(name.nodes) > 1:
                    sets.append(name.nodes)
                    prices.append(price)
            elif isinstance(name, Group):
                members = list(name.contours)
                self.end[members] -= price
                self.double[members, graph.home] -= 2.0 * price
                self.double[graph.home, members] -= 2.0 * price
            elif isinstance(name, Rank):
                label = name.partition.labels(graph.places)
                across = price * (label[:, None] != label)
                self.single += across
                self.double += across
            elif isinstance(name, Triangle):
                self._add_triangle(name, price)
            elif isinstance(name, Bundle):
                self._add_bundle(name, price)
            elif name == HOME:
                self.single[graph.home] += price
                self.single[:, graph.home] += price
                self.double[graph.home] += 2.0 * price
                self.double[:, graph.home] += 2.0 * price
            else:
                self.rapid -= price
        self.masks = np.zeros((graph.nodes, len(sets)), dtype=np.bool_)
        for index, nodes in enumerate(sets):
            self.masks[list(nodes), index] = True
        self.sets = np.array(prices)

    def _add_triangle(self, triangle: Triangle, price: float) -> None:
        for one, other in permutations(triangle.triple, 2):
            self.single[one, other] += price
        for members, place in zip(map(list, triangle.nodes), reversed(triangle.pair), strict=True):
            self.node[members] += price
            self.toward[members, place] -= 2.0 * price
            self.toward[members, triangle.third] -= 2.0 * price

    def _add_bundle(self, bundle: Bundle, price: float) -> None:
        if bundle.nodes is None:
            self.single[bundle.place, bundle.other] -= price
            self.single[bundle.other, bundle.place] -= price
            return
        members = list(bundle.nodes)
        self.node[members] += price
        self.toward[members, bundle.other] -= 2.0 * price

    def negative(
        self, kind: int, priced: np.ndarray, scale: float, below: float = -NEGATIVE
    ) -> tuple[Floats, Ints, Ints]:
        """Return reduced costs, tails and heads of the edges of a kind whose reduced costs are below a number.

        Parameters
        ----------
        priced
            Edges that are left out.
        scale
            What costs count: 0 for a ray of an infeasible program.
        """
        graph = self.graph
        if kind == DOUBLE:
            least = 2.0 * graph.least
            for contour in range(graph.home):
                least[contour, graph.home] = 2.0 * graph.rapids[graph.nearest_rapid(contour)]
            with np.errstate(invalid="ignore"):
                reduced = np.where(np.isfinite(least), scale * least - self.double, np.inf)
            reduced[priced[: graph.places, : graph.places]] = np.inf
            tails, heads = np.nonzero(np.triu(reduced < below, 1))
            return reduced[tails, heads], tails, heads
        costs, single = graph.links, self.single
        if kind == RAPID:
            costs = graph.rapids
            single = single + self.end[:, None] + self.end
            single[: graph.home, : graph.home] += self.rapid
        return _negative(
            costs,
            graph.place_of,
            graph.first,
            priced,
            self.node,
            self.toward,
            single,
            self.masks,
            self.sets,
            scale,
            below,
        )

    def blocked_links(self, graph: LinkGraph) -> tuple[Ints, Ints]:
        """Return the blocked links that would have negative reduced costs, single or double."""
        costs = np.where(graph.blocked, graph.lengths, np.inf)
        single = np.maximum(self.single, 0.0)
        none = np.zeros_like(graph.blocked)
        _, tails, heads = _negative(
            costs,
            graph.place_of,
            graph.first,
            none,
            self.node,
            self.toward,
            single,
            self.masks,
            self.sets,
            1.0,
            0.0,
        )
        p, q = np.nonzero(np.triu(graph.blocked, 1))
        cheap = 2.0 * graph.lengths[p, q] < self.double[graph.place_of[p], graph.place_of[q]]
        return np.append(tails, p[cheap]), np.append(heads, q[cheap])


@njit(cache=True)
def _negative(
    costs: Floats,
    place_of: Ints,
    first: Ints,
    priced: np.ndarray,
    node: Floats,
    toward: Floats,
    single: Floats,
    masks: np.ndarray,
    sets: Floats,
    scale: float,
    below: float,
) -> tuple:
    nodes = len(place_of)
    tails, heads, values = [0][:0], [0][:0], [0.0][:0]
    for p in range(nodes):
        for q in range(first[place_of[p] + 1], nodes):
            reduced = scale * costs[p, q] - node[p] - node[q] - single[place_of[p], place_of[q]]
            if reduced < below and not priced[p, q] and costs[p, q] < np.inf:
                reduced -= toward[p, place_of[q]] + toward[q, place_of[p]]
                for k in range(len(sets)):
                    if masks[p, k] and masks[q, k]:
                        reduced += 2.0 * sets[k]
                if reduced < below:
                    tails.append(p)
                    heads.append(q)
                    values.append(reduced)
    return np.array(values), np.array(tails), np.array(heads)
