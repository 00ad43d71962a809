r"""What a relaxed walk remembers of the contours that it has cut, and which steps that rules out.

    N_a    contours that a walk standing at contour a may remember, a itself not among them
    M      what it does remember, a subset of N_a, as bits: bit i is the i-th member of N_a
    (1)    the step a -> b is forbidden when b or a contour that must come after b is in M, when it is closed,
           or when it leaves a part of which some contour is not in M
    (2)    after the step it remembers M' = (M + {a}) restricted to N_b

With N_a = all contours a walk remembers everything and the relaxation is exact. Members of a's own part are
always remembered where parts are cut in one go: (1) needs them.

Source: Baldacci, Mingozzi, Roberti (2011), ng-routes.
"""

from dataclasses import dataclass

import numpy as np

from cutgap.formulations.contour_dp.walks import Walks
from cutgap.instances.arrays import Ints
from cutgap.instances.process import WORD

MOST_MEMBERS = 14
"""Most members of a memory in a dense table."""

Members = tuple[tuple[int, ...], ...]
"""N_a of each contour a, ascending."""


@dataclass(frozen=True, eq=False)
class Memory:
    """Memories N and their tables.

    Attributes
    ----------
    members
        N.
    following
        ``following[a, b, M]`` is M' of (2), or -1 where (1) forbids the step; shape (n, n, 2^most).
    offset
        Where the states of each contour begin in a flat table of (M, point), then its size; shape (n + 1,).
    crossed
        ``crossed[v, w]``: bits of N_(contour of v) that the rapid v -> w crosses; shape (0, 0) where rapids
        need not be clear.
    """

    members: Members
    following: Ints
    offset: Ints
    crossed: Ints


def start_members(walks: Walks, size: int) -> Members:
    """Return memories of the ``size`` nearest contours, and of a contour's own part."""
    first, count = walks.first, walks.count
    apart = np.full((count, count), np.inf)
    for a in range(count):
        to_all = walks.costs[first[a] : first[a + 1]].min(axis=0)
        apart[a] = np.minimum.reduceat(to_all, first[:-1])
    np.fill_diagonal(apart, np.inf)
    apart = np.minimum(apart, apart.T)
    near = np.argsort(apart, axis=1, kind="stable")[:, : min(size, count - 1)]
    return tuple(tuple(sorted({*near[a].tolist(), *mates(walks, a)})) for a in range(count))


def mates(walks: Walks, contour: int) -> set[int]:
    """Return the other contours of the same part, where parts are cut in one go."""
    if walks.parts is None:
        return set()
    return set(np.flatnonzero(walks.parts == walks.parts[contour]).tolist()) - {contour}


def build_memory(walks: Walks, members: Members) -> Memory:
    """Return the tables of memories."""
    count, sizes = walks.count, [len(each) for each in members]
    following = np.full((count, count, 1 << max(sizes, default=0)), -1, dtype=np.int32)
    for a in range(count):
        states = np.arange(1 << sizes[a])
        own = _bits(members[a], mates(walks, a))
        for b in np.flatnonzero(~walks.closed[a]).tolist():
            after = np.zeros(len(states), dtype=np.int32)
            place = {contour: bit for bit, contour in enumerate(members[b])}
            for bit, contour in enumerate(members[a]):
                if contour in place:
                    after |= ((states >> bit & 1) << place[contour]).astype(np.int32)
            if a in place:
                after |= np.int32(1 << place[a])
            conflict = _bits(members[a], {b, *np.flatnonzero(walks.before[b]).tolist()})
            allowed = states & conflict == 0
            if b not in mates(walks, a):
                allowed &= states & own == own
            following[a, b, : len(states)] = np.where(allowed, after, -1)
    tables = np.array([(1 << size) * points for size, points in zip(sizes, np.diff(walks.first), strict=True)])
    offset = np.concatenate(([0], np.cumsum(tables))).astype(np.int64)
    return Memory(members, following.astype(np.int64), offset, _crossed_bits(walks, members))


def _bits(members: tuple[int, ...], wanted: set[int]) -> int:
    return sum(1 << bit for bit, contour in enumerate(members) if contour in wanted)


def _crossed_bits(walks: Walks, members: Members) -> Ints:
    if walks.crossed is None:
        return np.zeros((0, 0), dtype=np.int64)
    bits = np.zeros(walks.costs.shape, dtype=np.int64)
    for a in range(walks.count):
        rows = slice(walks.first[a], walks.first[a + 1])
        for bit, contour in enumerate(members[a]):
            crossed = walks.crossed[rows, :, contour // WORD] >> np.uint64(contour % WORD) & np.uint64(1)
            bits[rows] |= crossed.astype(np.int64) << bit
    return bits
