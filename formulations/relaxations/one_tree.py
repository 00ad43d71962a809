r"""The Held-Karp bound by subgradient steps on 1-trees.

    Data       c_uv    symmetric lengths                                         [mm]
    Variables  pi_v    potentials, free                                          [mm]

    (1)  w(pi) = min over 1-trees T of  sum_{uv in T} (c_uv - pi_u - pi_v)  +  2 sum_v pi_v

A 1-tree is a spanning tree on the nodes but node 0, with two edges at node 0; when via nodes are given, one of
these two leads to a via node. Every tour is one, so w(pi) bounds the shortest tour from below for any
potentials (weak duality): the result is valid after any number of steps.

Source: Held and Karp (1970, 1971); step lengths in the manner of Volgenant and Jonker (1982).
"""

import numpy as np
from numba import njit

from cutgap.instances.arrays import Floats
from cutgap.instances.tours import tour_length


@njit(cache=True)
def _one_tree(lengths: Floats, potentials: Floats, is_via: np.ndarray, degree: np.ndarray) -> float:
    """Return w(pi) of the minimum 1-tree and write its node degrees."""
    nodes = len(lengths)
    degree[:] = 0
    distance = np.full(nodes, np.inf)
    parent = np.zeros(nodes, dtype=np.int64)
    done = np.zeros(nodes, dtype=np.bool_)
    total = 2.0 * potentials.sum()
    current = 1
    done[1] = True
    for _ in range(nodes - 2):
        nearest, least = -1, np.inf
        for v in range(1, nodes):
            if not done[v]:
                d = lengths[current, v] - potentials[current] - potentials[v]
                if d < distance[v]:
                    distance[v], parent[v] = d, current
                if distance[v] < least:
                    nearest, least = v, distance[v]
        done[nearest] = True
        degree[nearest] += 1
        degree[parent[nearest]] += 1
        total += least
        current = nearest
    first, second = -1, -1
    priced = lengths[0] - potentials - potentials[0]
    for v in range(1, nodes):
        if is_via[v] and (first < 0 or priced[v] < priced[first]):
            first = v
    for v in range(1, nodes):
        if v != first and (second < 0 or priced[v] < priced[second]):
            second = v
    for v in (first, second):
        total += priced[v]
        degree[v] += 1
        degree[0] += 1
    return total


@njit(cache=True)
def _ascend(
    lengths: Floats, potentials: Floats, is_via: np.ndarray, target: float, iterations: int
) -> tuple[float, Floats]:
    nodes = len(lengths)
    degree = np.zeros(nodes, dtype=np.int64)
    best, best_potentials = -np.inf, potentials.copy()
    step = 0.0
    previous = np.zeros(nodes)
    for i in range(iterations):
        bound = _one_tree(lengths, potentials, is_via, degree)
        if i == 0:
            step = 0.02 * max(bound, 0.0) / nodes
        if bound > best:
            best, best_potentials = bound, potentials.copy()
            if best >= target:
                break
        spread = 0
        for v in range(nodes):
            spread += (degree[v] - 2) ** 2
        if spread == 0:
            break
        for v in range(nodes):
            move = 0.7 * (2.0 - degree[v]) + 0.3 * previous[v]
            potentials[v] += step * move
            previous[v] = 2.0 - degree[v]
        step *= 1.0 - 3.5 / iterations
    return best, best_potentials


def held_karp_bound(
    lengths: Floats,
    via: tuple[int, ...] = (),
    *,
    target: float = np.inf,
    iterations: int = 150,
) -> tuple[float, Floats]:
    """Return a lower bound in mm on every closed tour, and the potentials that prove it.

    Parameters
    ----------
    lengths
        Shape (n, n), mm, symmetric; node 0 is the home. Up to 3 nodes have one tour, whose length is returned.
    via
        Nodes of which one comes next to node 0.
    target
        Stop as soon as the bound reaches it.
    iterations
        Most subgradient steps.
    """
    if len(lengths) <= 3:
        return tour_length(lengths, np.arange(len(lengths))), np.zeros(len(lengths))
    is_via = np.zeros(len(lengths), dtype=np.bool_)
    is_via[list(via) if via else slice(1, None)] = True
    bound, potentials = _ascend(
        np.ascontiguousarray(lengths), np.zeros(len(lengths)), is_via, target, iterations
    )
    return float(bound), potentials
