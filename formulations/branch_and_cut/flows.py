"""Maximum flows, minimum cuts and cut trees of sparse undirected graphs with real capacities (numba).

A graph is stored as arcs in compressed rows: the arcs of node v are ``first[v] : first[v + 1]``, arc k leads
to ``target[k]``, its reverse is ``reverse[k]`` and ``edge[k]`` is the index of its undirected edge.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from cutgap.instances.arrays import Floats, Ints

EPSILON = 1e-9
"""Residual capacities up to this count as none."""


class Graph(NamedTuple):
    """Arcs of an undirected graph in compressed rows (see the module)."""

    first: Ints
    target: Ints
    reverse: Ints
    edge: Ints


@njit(cache=True)
def build_graph(nodes: int, tails: Ints, heads: Ints) -> Graph:
    """Return the graph with undirected edges ``tails[e] - heads[e]``."""
    first = np.zeros(nodes + 1, dtype=np.int64)
    for e in range(len(tails)):
        first[tails[e] + 1] += 1
        first[heads[e] + 1] += 1
    for v in range(nodes):
        first[v + 1] += first[v]
    position = first[:-1].copy()
    target = np.empty(2 * len(tails), dtype=np.int64)
    reverse = np.empty(2 * len(tails), dtype=np.int64)
    edge = np.empty(2 * len(tails), dtype=np.int64)
    for e in range(len(tails)):
        there, back = position[tails[e]], position[heads[e]]
        position[tails[e]] += 1
        position[heads[e]] += 1
        target[there], target[back] = heads[e], tails[e]
        reverse[there], reverse[back] = back, there
        edge[there], edge[back] = e, e
    return Graph(first, target, reverse, edge)


@njit(cache=True)
def maximum_flow(graph: Graph, residual: Floats, is_source: np.ndarray, sink: int, limit: float) -> tuple:
    """Push flow from the set of sources to the sink along shortest paths until ``limit`` is reached.

    ``residual`` (one entry an arc) is changed. Returns the flow and, when it is below the limit, the mask
    of the sources' side of a minimum cut.
    """
    nodes = len(graph.first) - 1
    flow = 0.0
    queue = np.empty(nodes, dtype=np.int64)
    arrival = np.empty(nodes, dtype=np.int64)
    reached = np.empty(nodes, dtype=np.bool_)
    while flow < limit:
        size = 0
        for v in range(nodes):
            reached[v] = is_source[v]
            if is_source[v]:
                arrival[v] = -1
                queue[size] = v
                size += 1
        position = 0
        while position < size and not reached[sink]:
            v = queue[position]
            position += 1
            for k in range(graph.first[v], graph.first[v + 1]):
                w = graph.target[k]
                if not reached[w] and residual[k] > EPSILON:
                    reached[w] = True
                    arrival[w] = k
                    queue[size] = w
                    size += 1
        if not reached[sink]:
            return flow, reached
        push = limit
        v = sink
        while arrival[v] >= 0:
            push = min(push, residual[arrival[v]])
            v = graph.target[graph.reverse[arrival[v]]]
        v = sink
        while arrival[v] >= 0:
            residual[arrival[v]] -= push
            residual[graph.reverse[arrival[v]]] += push
            v = graph.target[graph.reverse[arrival[v]]]
        flow += push
    return flow, reached


@njit(cache=True)
def cuts_below_demand(graph: Graph, capacity: Floats, root: int, demand: Floats, slack: float) -> np.ndarray:
    """Return masks of sets S without the root, with cut(S) < demand[v] - slack for some v in S.

    A node whose minimum cut from the root meets the largest demand joins the sources: no wanted set can
    separate it from the root (Padberg and Rinaldi, 1990), and later flows get shorter.
    """
    nodes = len(graph.first) - 1
    largest = demand.max()
    is_source = np.zeros(nodes, dtype=np.bool_)
    is_source[root] = True
    found = np.zeros((nodes, nodes), dtype=np.bool_)
    count = 0
    for v in range(nodes):
        if is_source[v] or demand[v] <= slack:
            continue
        residual = capacity[graph.edge]
        flow, reached = maximum_flow(graph, residual, is_source, v, largest - slack)
        if flow >= largest - slack:
            is_source[v] = True
        elif flow < demand[v] - slack:
            found[count] = ~reached
            count += 1
    return found[:count]


@njit(cache=True)
def cut_tree(graph: Graph, capacity: Floats) -> tuple:
    """Return (parent, weight, side) of a Gomory-Hu cut tree, built by Gusfield's method (1990).

    Row v of ``side`` is the mask of the tree's component around v when the edge v - parent[v] is
    removed; its cut has capacity weight[v]. Node 0 is the root.
    """
    nodes = len(graph.first) - 1
    parent = np.zeros(nodes, dtype=np.int64)
    weight = np.zeros(nodes)
    is_source = np.zeros(nodes, dtype=np.bool_)
    infinite = capacity.sum() + 1.0
    for v in range(1, nodes):
        is_source[:] = False
        is_source[v] = True
        target = parent[v]
        flow, reached = maximum_flow(graph, capacity[graph.edge], is_source, target, infinite)
        weight[v] = flow
        for w in range(nodes):
            if w != v and reached[w] and parent[w] == target:
                parent[w] = v
        if reached[parent[target]] and target != 0:
            parent[v] = parent[target]
            parent[target] = v
            weight[v] = weight[target]
            weight[target] = flow
    side = np.zeros((nodes, nodes), dtype=np.bool_)
    for v in range(nodes):
        w = v
        steps = 0
        while steps <= nodes:
            side[w, v] = True
            if w == 0:
                break
            w = parent[w]
            steps += 1
    return parent, weight, side
