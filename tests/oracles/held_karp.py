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
