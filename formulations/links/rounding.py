"""A plan of one stroke near a fractional point: its cycles of single links, joined by doubled ones."""

from collections.abc import Iterator
from itertools import pairwise

import networkx
import numpy as np
from scipy.cluster.hierarchy import DisjointSet

from cutgap.formulations.links.cuts import DOUBLE, LINK, RAPID, Edge
from cutgap.formulations.links.graph import LinkGraph, Pair
from cutgap.formulations.links.separation import Point

LEAST = 0.05
"""Single links of less weight than this make no cycles."""


def rounded(graph: LinkGraph, tree: list[Pair], point: Point) -> list[Edge] | None:
    """Return single and doubled edges that are even and connect everything, ``None`` where links cannot.

    Cycles come by weight; each is kept if it joins places that are all apart, and more cheaply than the links
    of the cheapest ``tree`` that it replaces. What the cheapest tree needs after some joints is part of it.
    """
    if len(tree) < graph.home - 1:
        return None
    place_of = graph.place_of.tolist()
    near = min(range(graph.home), key=lambda contour: float(graph.rapids[graph.nearest_rapid(contour)]))
    doubles = sorted((2.0 * float(graph.links[p, q]), place_of[p], place_of[q]) for p, q in tree)
    doubles.append((2.0 * float(graph.rapids[graph.nearest_rapid(near)]), near, graph.home))
    kept: list[Edge] = []
    best, filled = _filled(graph, kept, doubles)
    for _, cycle in sorted(_cycles(point), key=lambda each: (-each[0], each[1])):
        cost, more = _filled(graph, [*kept, *cycle], doubles)
        if cost < best:
            kept, best, filled = [*kept, *cycle], cost, more
    return [*kept, *filled]


def _filled(
    graph: LinkGraph, single: list[Edge], doubles: list[tuple[float, int, int]]
) -> tuple[float, list[Edge]]:
    """Return the cost of single edges and the doubles that are needed beside them, and these doubles.

    Infinite when the home has more than two edges.
    """
    joints, filled, cost, at_home = DisjointSet(range(graph.places)), list[Edge](), 0.0, 0
    for kind, p, q in single:
        cost += float((graph.links if kind == LINK else graph.rapids)[p, q])
        joints.merge(int(graph.place_of[p]), int(graph.place_of[q]))
        at_home += q == graph.home_node
    for length, i, j in doubles:
        if joints.merge(i, j):
            cost += length
            filled.append((DOUBLE, i, j))
    return (np.inf if at_home > 2 else cost), filled


def _cycles(point: Point) -> Iterator[tuple[float, list[Edge]]]:
    """Yield cycles of the single edges, but for rapids between contours, with their least weight."""
    columns, support = point.columns, networkx.Graph()
    at_home = columns.others == point.places - 1
    for index in np.flatnonzero((columns.kinds < DOUBLE) & (point.x > LEAST)).tolist():
        if columns.kinds[index] != RAPID or at_home[index]:
            ends = int(columns.tails[index]), int(columns.heads[index])
            support.add_edge(*ends, kind=int(columns.kinds[index]), x=float(point.x[index]))
    for nodes in networkx.cycle_basis(support):
        pairs = list(pairwise([*nodes, nodes[0]]))
        weight = min(support.edges[pair]["x"] for pair in pairs)
        yield weight, sorted((support.edges[pair]["kind"], min(pair), max(pair)) for pair in pairs)
