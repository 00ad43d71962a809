"""Kernels of the search over links and rapids: ruin and recreate of trees of cycles (door: ``link_search``).

A plan with links is a set of cycles that hang together at contours, like beads on rings:

    (1) The main cycle leads from the home over rapids and links back to it.
    (2) Every other cycle is of links alone: a doubled link is one of two contours, others have single links.
    (3) A cycle meets a contour at one node, its slot there. Two cycles share at most one contour, and contours
        and cycles make a tree.

So all degrees are even, and everything hangs together. What hangs at the main cycle between two of its rapids
is one stroke; it ends elsewhere than it starts when links of the main cycle lie between. A round breaks slots
of some neighbouring contours, so that the tree falls apart, and joins the pieces again one by one as costs
least: by a doubled link, or by a node of the one that is put into an edge of the other. A worse plan is kept by
the rule of simulated annealing.
"""

from typing import Any, NamedTuple

import numba
import numpy as np
import numpy.typing as npt

from cutgap.instances.arrays import Floats, Ints

Joint = tuple[float, int, int, int]
"""How to join two pieces: cost, node, and the other node of a doubled link or the slot that it goes behind."""

Bools = npt.NDArray[np.bool_]

SKIPPED = 0.03
"""Share of joints that are overlooked when pieces are joined, for variety."""

MOST_BROKEN = 6
"""Most contours whose slots are broken in a round."""

HOT, COLD = 0.5, 0.002
"""First and last temperature, in ``figures[SCALE]``."""

PATIENCE = 30
"""Rounds with the same answer after which the price of a pierce changes."""

# Places in ``figures``.
COST, BEST, PRICE, BEST_PRICE, SCALE, STREAK = 0, 1, 2, 3, 4, 5


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
            filled = _spread(sheet, rings, pieces, stack, stack[filled], filled, True)
        count += 1
    return count


@numba.njit(cache=True)
def _spread(
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
            filled = _spread(sheet, rings, pieces, stack, stack[filled], filled, False)
        slot = rings.after[slot]
    count = 0
    for pair in range(len(sheet.pairs)):
        count += pieces[sheet.pairs[pair, 0]] >= pieces[sheet.pairs[pair, 1]]
    return count


@numba.njit(cache=True)
def _note(joint: Joint, cost: float, node: int, linked: int, slot: int, rng: Any) -> Joint:
    """Return the cheaper of the joint so far and another, which may be overlooked."""
    if cost < joint[0] and rng.random() >= SKIPPED:
        return cost, node, linked, slot
    return joint


@numba.njit(cache=True)
def _to_links(sheet: Sheet, rings: Rings, pieces: Ints, v: int, joint: Joint, rng: Any) -> Joint:
    """Join a node's piece by a doubled link, or by putting the node into an edge of a cycle of links."""
    link, piece = sheet.link, pieces[sheet.owner[v]]
    for at in range(sheet.near_first[v], sheet.near_first[v + 1]):
        u = sheet.near[at]
        if pieces[sheet.owner[u]] == piece:
            continue
        joint = _note(joint, 2.0 * link[v, u], v, u, -1, rng)
        slot = rings.head[sheet.owner[u]]
        while slot >= 0:
            if rings.node[slot] == u and not rings.main[slot]:
                w = rings.node[rings.after[slot]]
                joint = _note(joint, link[u, v] + link[v, w] - link[u, w], v, -1, slot, rng)
            slot = rings.more[slot]
    return joint


@numba.njit(cache=True)
def _to_main(sheet: Sheet, rings: Rings, v: int, price: float, joint: Joint, rng: Any) -> Joint:
    """Join a node's piece by putting the node into an edge of the main cycle."""
    slot = 0
    while True:
        u, w = rings.node[slot], rings.node[rings.after[slot]]
        cost = edge(sheet, u, v, True, price) + edge(sheet, v, w, True, price)
        if u != w:
            cost -= edge(sheet, u, w, True, price)
        joint = _note(joint, cost, v, -1, slot, rng)
        slot = rings.after[slot]
        if slot == 0:
            return joint


@numba.njit(cache=True)
def _from_edges(sheet: Sheet, rings: Rings, pieces: Ints, contour: int, joint: Joint, rng: Any) -> Joint:
    """Join a contour's piece by putting nodes of others into the edges that leave its slots."""
    link, slot = sheet.link, rings.head[contour]
    while slot >= 0:
        a, b = rings.node[slot], rings.node[rings.after[slot]]
        for at in range(sheet.near_first[a], sheet.near_first[a + 1]):
            u = sheet.near[at]
            if pieces[sheet.owner[u]] != pieces[contour]:
                joint = _note(joint, link[a, u] + link[u, b] - link[a, b], u, -1, slot, rng)
        slot = rings.more[slot]
    return joint


@numba.njit(cache=True)
def _cheapest(sheet: Sheet, rings: Rings, pieces: Ints, piece: int, price: float, rng: Any) -> Joint:
    """Return the cheapest joint of a piece without the home with another piece.

    What is not in the main cycle is the same from both sides: a large piece is seen from the others.
    """
    joint = (np.inf, -1, -1, -1)
    large = 2 * (pieces == piece).sum() > len(pieces)
    for contour in range(len(pieces) - 1):
        own = pieces[contour] == piece
        for v in range(sheet.first[contour], sheet.first[contour + 1]):
            if own != large:
                joint = _to_links(sheet, rings, pieces, v, joint, rng)
            if own:
                joint = _to_main(sheet, rings, v, price, joint, rng)
        if own != large:
            joint = _from_edges(sheet, rings, pieces, contour, joint, rng)
    return joint


@numba.njit(cache=True)
def recreate(sheet: Sheet, rings: Rings, price: float, pieces: Ints, stack: Ints, rng: Any) -> None:
    """Join all pieces, in a random order."""
    count = label(sheet, rings, pieces, stack)
    while count > 1:
        piece = 1 + int(rng.random() * (count - 1))
        _, chosen, linked, place = _cheapest(sheet, rings, pieces, piece, price, rng)
        if chosen < 0:
            continue  # all were overlooked
        if linked >= 0:
            insert(sheet, rings, linked, insert(sheet, rings, chosen, -1))
        else:
            insert(sheet, rings, chosen, place)
        count = label(sheet, rings, pieces, stack)


@numba.njit(cache=True)
def _ruin(sheet: Sheet, rings: Rings, rng: Any) -> None:
    """Break slots of a contour and of some of its neighbours: all of them, or one each."""
    contours = len(sheet.first) - 2
    middle = int(rng.random() * contours)
    count = 1 + int(rng.random() * min(MOST_BROKEN, contours))
    whole = rng.random() < 0.5
    for turn in range(count):
        contour = middle if turn == 0 else sheet.around[middle, turn - 1]
        slots = 0
        slot = rings.head[contour]
        while slot >= 0:
            slots += 1
            slot = rings.more[slot]
        if whole:
            while rings.head[contour] >= 0:
                break_slot(sheet, rings, rings.head[contour])
        elif slots:
            slot = rings.head[contour]
            for _ in range(int(rng.random() * slots)):
                slot = rings.more[slot]
            break_slot(sheet, rings, slot)


@numba.njit(cache=True)
def score(sheet: Sheet, rings: Rings, price: float, pieces: Ints, stack: Ints) -> tuple[float, float, bool]:
    """Return the cost with prices, that without, and whether the plan keeps the rules."""
    priced, pierces = total(sheet, rings, price)
    behind = late(sheet, rings, price, pieces, stack)
    plain = priced - price * max(0, pierces - 1)
    return priced + behind * (price + sheet.far), plain, behind == 0 and pierces <= sheet.pierces


@numba.njit(cache=True)
def iterate(
    sheet: Sheet,
    now: Rings,
    trial: Rings,
    best: Rings,
    figures: Floats,
    since: int,
    until: int,
    rounds: int,
    rng: Any,
) -> None:
    """Do rounds ``since`` to ``until`` of a search of ``rounds``."""
    pieces, stack = np.zeros_like(now.head), np.zeros_like(now.head)
    contours = len(now.head) - 1
    for turn in range(since, until):
        price = figures[PRICE]
        copy(now, trial)
        _ruin(sheet, trial, rng)
        recreate(sheet, trial, price, pieces, stack, rng)
        cost, plain, fine = score(sheet, trial, price, pieces, stack)
        heat = HOT * (COLD / HOT) ** (turn / rounds) * figures[SCALE]
        if cost <= figures[COST] - heat * np.log(1.0 - rng.random()):
            copy(trial, now)
            figures[COST] = cost
        if fine and plain < figures[BEST]:
            copy(trial, best)
            figures[BEST], figures[BEST_PRICE] = plain, price
        if 1 < sheet.pierces < contours:
            _change_price(sheet, now, figures, pieces, stack)


@numba.njit(cache=True)
def _change_price(sheet: Sheet, now: Rings, figures: Floats, pieces: Ints, stack: Ints) -> None:
    """Raise the price of a pierce after many plans with too many, lower it after many without."""
    sign = 1.0 if total(sheet, now, figures[PRICE])[1] > sheet.pierces else -1.0
    figures[STREAK] = figures[STREAK] + sign if figures[STREAK] * sign > 0 else sign
    if abs(figures[STREAK]) >= PATIENCE:
        figures[STREAK] = 0.0
        figures[PRICE] *= 1.3 if sign > 0 else 0.8
        figures[COST] = score(sheet, now, figures[PRICE], pieces, stack)[0]
