"""Kernels that choose the entries of a tour whose order is known, by the tables of ``entry_steps``."""

import numba
import numpy as np

from cutgap.instances.entry_steps import Path, Task, begin_forward, fill_forward, is_barred, leg, note_cut


@numba.njit(cache=True)
def settle(task: Task, path: Path, size: int, price: float) -> tuple[float, int]:
    """Choose the entries by table (1), which is filled, and then the start; return cost and barred legs."""
    for _ in range(4):
        _trace(task, path, size, price)
        if task.anchored or size == 1 or not _improve_start(task, path, size, price):
            break
        begin_forward(task, path)
        fill_forward(task, path, 1, size, price)
    return _sum_up(task, path, size)


@numba.njit(cache=True)
def _sum_up(task: Task, path: Path, size: int) -> tuple[float, int]:
    """Return cost and barred legs of a path."""
    nodes = path.nodes
    cost, barred = task.closing[nodes[size - 1], nodes[0]], 0
    for place in range(size - 1):
        u, v = nodes[place], nodes[place + 1]
        cost += task.costs[u, v]
        if len(task.barred) and is_barred(task.barred[u, v], path.cut[path.clusters[place]]):
            barred += 1
    return cost, barred


@numba.njit(cache=True)
def _trace(task: Task, path: Path, size: int, price: float) -> None:
    """Choose the entries after the first, from the last to the second."""
    first, clusters, nodes = task.first, path.clusters, path.nodes
    for place in range(size - 1, 0, -1):
        k, least = clusters[place], np.inf
        chosen = first[k]
        for u in range(first[k], first[k + 1]):
            if place == size - 1:
                value = path.forward[u] + task.closing[u, nodes[0]]
            else:
                value = path.forward[u] + leg(task, u, nodes[place + 1], path.cut[k], price)
            if value < least:
                least, chosen = value, u
        nodes[place] = chosen


@numba.njit(cache=True)
def _improve_start(task: Task, path: Path, size: int, price: float) -> bool:
    """Choose the first entry anew, the others as they are; say whether it changed."""
    k, nodes = path.clusters[0], path.nodes
    chosen, after, last, cut = nodes[0], nodes[1], nodes[size - 1], path.cut[k]
    least = leg(task, chosen, after, cut, price) + task.closing[last, chosen]
    least -= 1e-12 * abs(least)
    for u in range(task.first[k], task.first[k + 1]):
        value = leg(task, u, after, cut, price) + task.closing[last, u]
        if value < least:
            least, chosen = value, u
    changed = chosen != nodes[0]
    nodes[0] = chosen
    return changed


@numba.njit(cache=True)
def choose_entries(task: Task, path: Path, price: float) -> int:
    """Choose the cheapest entries for the clusters of a path, from every start; return the barred legs."""
    size, k = len(path.clusters), path.clusters[0]
    if len(task.barred):
        note_cut(task, path, size, len(task.part))
    least, fewest, chosen = np.inf, 0, path.nodes.copy()
    for start in range(task.first[k], task.first[k + 1]):
        path.nodes[0] = start
        begin_forward(task, path)
        fill_forward(task, path, 1, size, price)
        _trace(task, path, size, price)
        cost, barred = _sum_up(task, path, size)
        if cost + price * barred < least:
            least, fewest = cost + price * barred, barred
            chosen[:] = path.nodes
    path.nodes[:] = chosen
    return fewest
