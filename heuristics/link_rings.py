"""Plans with links as trees of cycles, in arrays that kernels work on (moves: ``link_moves``).

A plan with links is a set of cycles that hang together at contours, like beads on rings:

    (1) The main cycle leads from the home over rapids and links back to it.
    (2) Every other cycle is of links alone: a doubled link is one of two contours, others have single links.
    (3) A cycle meets a contour at one node, its slot there. Two cycles share at most one contour, and contours
        and cycles make a tree.

So all degrees are even, and everything hangs together. What hangs at the main cycle between two of its rapids
is one stroke; it ends elsewhere than it starts when links of the main cycle lie between.
"""

from typing import NamedTuple

import numba
import numpy as np
import numpy.typing as npt

from cutgap.instances.arrays import Floats, Ints

Bools = npt.NDArray[np.bool_]


class Sheet(NamedTuple):
    """What the kernels read; nodes are numbered by contour, the home last.

    Attributes
    ----------
    link, rapid
        Cost of one pass of a link (infinite where there is none), and of a rapid with its share of the
        pierces at its ends; shape (nodes, nodes), in the objective's unit.
    first
        First node of each contour, of the home (a contour of its own, the last), and the number of nodes.
    owner
        Contour of each node.
    near_first, near
        Nodes that a node is linked to, the nearest first: ``near[near_first[v] : near_first[v + 1]]``.
    around
        For each contour the others, nearest first.
    pairs
        Contours that are cut before others, shape (pairs, 2).
    pierces
        Most pierces.
    far
        Cost of the longest rapid.
    """

    link: Floats
    rapid: Floats
    first: Ints
    owner: Ints
    near_first: Ints
    near: Ints
    around: Ints
    pairs: Ints
    pierces: int
    far: float


class Rings(NamedTuple):
    """Cycles: slots with their node (-1: unused), the slots before and after, whether they lie in the main one.

    ``head`` and ``more`` list the slots of each contour; slot 0 is the home.
    """

    node: Ints
    after: Ints
    before: Ints
    main: Bools
    head: Ints
    more: Ints


def new_rings(sheet: Sheet) -> Rings:
    """Return the main cycle of the home alone; each contour is a piece of its own."""
    contours = len(sheet.first) - 2
    size = 2 * contours + 2  # a tree: contours and cycles are joined by fewer slots than there are of both
    node, after, before, more = (np.full(size, -1, dtype=np.int64) for _ in range(4))
    head = np.full(contours + 1, -1, dtype=np.int64)
    main = np.zeros(size, dtype=np.bool_)
    node[0], after[0], before[0], main[0], head[contours] = sheet.first[contours], 0, 0, True, 0
    return Rings(node, after, before, main, head, more)


@numba.njit(cache=True)
def copy(source: Rings, target: Rings) -> None:
    """Copy the one to the other."""
    target.node[:], target.after[:], target.before[:] = source.node, source.after, source.before
    target.main[:], target.head[:], target.more[:] = source.main, source.head, source.more


@numba.njit(cache=True)
def edge(sheet: Sheet, u: int, v: int, main: bool, price: float) -> float:
    """Return the cost of an edge; in the main cycle a rapid may take a link's place."""
    link = sheet.link[u, v]
    return min(link, rapid(sheet, u, v, price)) if main else link


@numba.njit(cache=True)
def rapid(sheet: Sheet, u: int, v: int, price: float) -> float:
    """Return the cost of a rapid with the price of its pierce; the one from home has none, as it must be."""
    home = len(sheet.owner) - 1
    return sheet.rapid[u, v] + (0.0 if u == home or v == home else price)


@numba.njit(cache=True)
def total(sheet: Sheet, rings: Rings, price: float) -> tuple[float, int]:
    """Return the cost of all edges, and the number of pierces."""
    cost, rapids = 0.0, 0
    for slot in range(len(rings.node)):
        if rings.node[slot] >= 0:
            u, v = rings.node[slot], rings.node[rings.after[slot]]
            value = edge(sheet, u, v, rings.main[slot], price)
            cost += value
            if rings.main[slot] and value < sheet.link[u, v]:
                rapids += 1
    return cost, max(0, rapids - 1)


@numba.njit(cache=True)
def insert(sheet: Sheet, rings: Rings, v: int, slot: int) -> int:
    """Give the contour of ``v`` a slot behind another one, or a cycle of its own with -1; return the slot."""
    new = 1
    while rings.node[new] >= 0:
        new += 1
    rings.node[new] = v
    rings.more[new] = rings.head[sheet.owner[v]]
    rings.head[sheet.owner[v]] = new
    follower = new if slot < 0 else rings.after[slot]
    leader = new if slot < 0 else slot
    rings.main[new] = slot >= 0 and rings.main[slot]
    rings.after[new], rings.before[new] = follower, leader
    rings.after[leader], rings.before[follower] = new, new
    return new


@numba.njit(cache=True)
def _drop(sheet: Sheet, rings: Rings, slot: int) -> None:
    """Take a slot out of its cycle."""
    contour = sheet.owner[rings.node[slot]]
    rings.after[rings.before[slot]], rings.before[rings.after[slot]] = rings.after[slot], rings.before[slot]
    if rings.head[contour] == slot:
        rings.head[contour] = rings.more[slot]
    else:
        each = rings.head[contour]
        while rings.more[each] != slot:
            each = rings.more[each]
        rings.more[each] = rings.more[slot]
    rings.node[slot] = -1


@numba.njit(cache=True)
def break_slot(sheet: Sheet, rings: Rings, slot: int) -> None:
    """Take a slot out; where what is left of its cycle has no link to close it, the cycle goes with it."""
    after, before, main = rings.after[slot], rings.before[slot], rings.main[slot]
    _drop(sheet, rings, slot)
    if main:
        return
    if after == before or not np.isfinite(sheet.link[rings.node[before], rings.node[after]]):
        while rings.after[after] != after:
            _drop(sheet, rings, rings.after[after])
        _drop(sheet, rings, after)


@numba.njit(cache=True)
def label(sheet: Sheet, rings: Rings, pieces: Ints, stack: Ints) -> int:
    """Number the pieces that hang together, by contour; that with the home is 0. Return their number."""
    pieces[:] = -1
    count = 0
    for turn in range(len(pieces)):
        start = len(pieces) - 1 - turn
        if pieces[start] >= 0:
            continue
        pieces[start], stack[0], filled = count, start, 1
        while filled:
            filled -= 1
            filled = spread(sheet, rings, pieces, stack, stack[filled], filled, True)
        count += 1
    return count


@numba.njit(cache=True)
def spread(
    sheet: Sheet, rings: Rings, pieces: Ints, stack: Ints, contour: int, filled: int, over_main: bool
) -> int:
    """Give a contour's label to those in its cycles, and put them on the stack; return its height."""
    slot = rings.head[contour]
    while slot >= 0:
        each = rings.after[slot]
        while each != slot and (over_main or not rings.main[slot]):
            other = sheet.owner[rings.node[each]]
            if pieces[other] >= 0:
                break  # the cycle is labelled already
            pieces[other] = pieces[contour]
            stack[filled] = other
            filled += 1
            each = rings.after[each]
        slot = rings.more[slot]
    return filled


@numba.njit(cache=True)
def late(sheet: Sheet, rings: Rings, price: float, pieces: Ints, stack: Ints) -> int:
    """Count the pairs whose first contour is not in an earlier stroke than the second."""
    if len(sheet.pairs) == 0:
        return 0
    pieces[:] = -1
    slot, stroke = rings.after[0], 0
    pieces[-1] = 0
    while slot != 0:
        u, v = rings.node[rings.before[slot]], rings.node[slot]
        stroke += rapid(sheet, u, v, price) < sheet.link[u, v]
        contour = sheet.owner[v]
        pieces[contour], stack[0], filled = stroke, contour, 1
        while filled:
            filled -= 1
            filled = spread(sheet, rings, pieces, stack, stack[filled], filled, False)
        slot = rings.after[slot]
    count = 0
    for pair in range(len(sheet.pairs)):
        count += pieces[sheet.pairs[pair, 0]] >= pieces[sheet.pairs[pair, 1]]
    return count
