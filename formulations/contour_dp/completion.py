"""The least cost of going on from a point when some contours are cut: the relaxed programme run from the end.

    R_k(v, S)   least cost of a relaxed walk onward from v, at position k, that remembers no contour of S

A relaxed walk onward from v remembers a set M of what it cuts, a subset of N_a, which must not meet S. Clear
rapids are left out, which makes R no larger.
"""

from dataclasses import replace

import numpy as np
from numba import njit

from cutgap.formulations.contour_dp.memory import Memory, build_memory
from cutgap.formulations.contour_dp.passes import backward_pass, forward_pass
from cutgap.formulations.contour_dp.walks import Bools, Walks
from cutgap.instances.arrays import Floats


def completions(
    walks: Walks, memory: Memory, prices: Floats, allowed: Bools, limit: float
) -> tuple[Floats, int]:
    """Return R by position, and how many rows it took.

    R is a table over (M, point) like that of a forward pass: the entry for R(v, S) is at M = S and N_a.
    """
    back = replace(
        walks,
        costs=np.ascontiguousarray(walks.costs.T),
        start=walks.end,
        end=walks.start,
        closed=np.ascontiguousarray(walks.closed.T),
        before=np.ascontiguousarray(walks.before.T),
        crossed=None,
    )
    reverse = build_memory(back, memory.members)
    before = backward_pass(
        back.costs, back.end, prices, back.first, back.closed, np.ascontiguousarray(allowed[::-1])
    )
    tables = (reverse.following, reverse.offset, reverse.crossed)
    value = forward_pass(back.costs, back.start, prices, back.first, *tables, before, limit)[::-1].copy()
    rows = 0
    for a in range(walks.count):
        points = int(walks.first[a + 1] - walks.first[a])
        table = value[:, memory.offset[a] : memory.offset[a + 1]].reshape(walks.count, -1, points)
        rows += int(np.isfinite(table).any(axis=2).sum())
        _least_disjoint(value, int(memory.offset[a]), len(memory.members[a]), points)
    # F pays for the contour at v, and so does R.
    return value - np.repeat(prices, np.diff(memory.offset)), rows


@njit(cache=True)
def _least_disjoint(table: Floats, low: int, bits: int, points: int) -> None:
    """Replace the entry of each M by the least over all M' that do not meet M."""
    size = 1 << bits
    for k in range(len(table)):
        for bit in range(bits):
            for state in range(size):
                if state >> bit & 1:
                    for i in range(points):
                        here, other = low + state * points + i, low + (state ^ 1 << bit) * points + i
                        table[k, here] = min(table[k, here], table[k, other])
        for state in range(size // 2):
            mirror = size - 1 - state
            for i in range(points):
                here, other = low + state * points + i, low + mirror * points + i
                table[k, here], table[k, other] = table[k, other], table[k, here]
