"""Shortest closed tour by dynamic programming over subsets (Bellman 1962, Held and Karp 1962)."""

from collections.abc import Sequence

import numpy as np


def shortest_tour(lengths: Sequence[Sequence[float]], first: int | None = None) -> tuple[float, list[int]]:
    """Return length and order of a shortest closed tour from node 0 through all others (up to 12).

    Parameters
    ----------
    lengths
        Rapid lengths, possibly asymmetric.
    first
        Node that must come right after node 0; ``None`` leaves it free.
    """
    matrix = np.asarray(lengths, dtype=np.float64)
    others = len(matrix) - 1
    if others <= 0:
        return 0.0, [0]
    inner = matrix[1:, 1:]
    shortest = np.full((1 << others, others), np.inf)
    for node in range(others):
        if first is None or node == first - 1:
            shortest[1 << node, node] = matrix[0, node + 1]
    for subset in range(1, 1 << others):
        reached = (shortest[subset][:, None] + inner).min(axis=0)
        for node in range(others):
            if not subset >> node & 1:
                shortest[subset | 1 << node, node] = reached[node]
    closed = shortest[-1] + matrix[1:, 0]
    last, subset, order = int(closed.argmin()), (1 << others) - 1, []
    length = float(closed[last])
    while subset:
        order.append(last + 1)
        smaller = subset & ~(1 << last)
        if smaller:
            subset, last = smaller, int((shortest[smaller] + inner[:, last]).argmin())
        else:
            subset = 0
    return length, [0, *reversed(order)]


def shortest_generalized_tour(lengths: Sequence[Sequence[float]], contours: Sequence[Sequence[int]]) -> float:
    """Return the length of a shortest closed tour through one node of each contour.

    The last contour is the start; best[subset, v] is the shortest way from it through the subset to v.
    """
    *others, start = contours
    everything = (1 << len(others)) - 1
    shortest = float("inf")
    for first in start:
        best = {(1 << h, v): lengths[first][v] for h, nodes in enumerate(others) for v in nodes}
        for subset in range(1, everything + 1):
            inside = [h for h in range(len(others)) if subset >> h & 1]
            for h in inside if len(inside) > 1 else []:
                before = subset & ~(1 << h)
                reach = [(best[before, u], u) for k in inside if k != h for u in others[k]]
                for v in others[h]:
                    best[subset, v] = min(length + lengths[u][v] for length, u in reach)
        ends = (best[everything, v] + lengths[v][first] for nodes in others for v in nodes)
        shortest = min(shortest, *ends)
    return shortest
