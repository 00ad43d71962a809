"""Kernels of the search over links and rapids: ruin and recreate of trees of cycles (door: ``link_search``).

A round breaks slots of some neighbouring contours, so that the tree of ``link_rings`` falls apart, and joins
the pieces again one by one as costs least: by a doubled link, or by a node of the one that is put into an edge
of the other. A worse plan is kept by the rule of simulated annealing.
"""

from typing import Any

import numba
import numpy as np

from cutgap.heuristics.link_rings import Rings, Sheet, break_slot, copy, edge, insert, label, late, total
from cutgap.instances.arrays import Floats, Ints

Joint = tuple[float, int, int, int]
"""How to join two pieces: cost, node, and the other node of a doubled link or the slot that it goes behind."""

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
