"""How an ant makes its tour: candidates, choice, back-tracking (Li et al., 2019, sections 2.2 to 2.4).

The rules that a candidate keeps are dropped in turn where the ant is stuck:

    level 0    all rules                                  the set Allow
    level 1    without clear rapids (8)                   step 4 of the source
    level 2    without neighbours only (6) as well        where the source says nothing
    level 3    without parts in one go as well            likewise

Precedence is never dropped. A part whose contours wait for those of another part is not begun before these are
cut (level 0 to 2): in one go it could not be finished.
"""

from typing import Any, NamedTuple

import numba
import numpy as np
import numpy.typing as npt

from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.process import WORD, Bools, Words


class Sheet(NamedTuple):
    """What ants read; sets of contours are words as in ``process.crossings``.

    Parameters
    ----------
    lengths
        Rapids, shape (nodes + 1, nodes), mm; the last row is 0, for tours that begin anywhere.
    first_node
        As ``Instance.first_node``.
    owner, parts
        Contour of each entry point; part of each contour.
    before, outside
        Contours that precede each contour; of these, for each part, those of other parts.
    crossed
        Shape (points, points, words), no words unless rapids must be clear.
    adjacent
        Shape (parts, parts), all true unless a head must go to neighbours.
    in_one_go
        Whether a part must be finished.
    start
        Node at which tours begin: the home; the number of nodes when there is none.
    """

    lengths: Floats
    first_node: Ints
    owner: Ints
    parts: Ints
    before: Words
    outside: Words
    crossed: Words
    adjacent: Bools
    in_one_go: bool
    start: int


@numba.njit(cache=True)
def crosses(crossed: Words, cut: Words) -> bool:
    """Whether two sets of contours have a contour in common."""
    common = np.uint64(0)
    for word in range(len(crossed)):
        common |= crossed[word] & cut[word]
    return common != 0


class Ant(NamedTuple):
    """State of an ant: contours cut, contours left of each part, candidates, cities marked by step 3."""

    cut: Words
    left: Ints
    allow: Ints
    marked: npt.NDArray[np.bool_]


@numba.njit(cache=True)
def new_ant(sheet: Sheet) -> Ant:
    """Return an ant that has cut nothing."""
    left = np.zeros(len(sheet.adjacent), np.int64)
    for part in sheet.parts:
        left[part] += 1
    points = len(sheet.owner)
    return Ant(
        np.zeros(sheet.before.shape[1], np.uint64), left, np.empty(points, np.int64), np.zeros(points, np.bool_)
    )


@numba.njit(cache=True)
def cut_contour(sheet: Sheet, ant: Ant, city: int) -> None:
    """Cut the contour of an entry point, or take the cut back: the set flips."""
    contour = sheet.owner[city]
    bit = np.uint64(1) << np.uint64(contour % WORD)
    ant.cut[contour // WORD] ^= bit
    ant.left[sheet.parts[contour]] += -1 if ant.cut[contour // WORD] & bit else 1


@numba.njit(cache=True)
def lacks(needed: Words, cut: Words) -> bool:
    """Whether a needed contour is not cut."""
    lacking = np.uint64(0)
    for word in range(len(needed)):
        lacking |= needed[word] & ~cut[word]
    return lacking != 0


@numba.njit(cache=True)
def open_contour(sheet: Sheet, ant: Ant, part: int, contour: int, level: int) -> bool:
    """Whether a contour may be cut next, coming from ``part`` (-1: the start), at whichever entry point."""
    if ant.cut[contour // WORD] >> np.uint64(contour % WORD) & np.uint64(1):
        return False
    if lacks(sheet.before[contour], ant.cut):
        return False
    other = sheet.parts[contour]
    if other == part:
        return True
    unfinished = part >= 0 and ant.left[part] > 0
    if sheet.in_one_go and level < 3 and (unfinished or lacks(sheet.outside[other], ant.cut)):
        return False
    return part < 0 or level > 1 or sheet.adjacent[part, other]


@numba.njit(cache=True)
def candidates(sheet: Sheet, ant: Ant, city: int, level: int) -> int:
    """Fill ``ant.allow`` with the cities that may follow, and return their number."""
    points = len(sheet.owner)
    part = sheet.parts[sheet.owner[city]] if city < points else -1
    count = 0
    for contour in range(len(sheet.parts)):
        if not open_contour(sheet, ant, part, contour, level):
            continue
        for other in range(sheet.first_node[contour], sheet.first_node[contour + 1]):
            if level == 0 and city < points and crosses(sheet.crossed[city, other], ant.cut):
                continue
            ant.allow[count] = other
            count += 1
    return count


@numba.njit(cache=True)
def choose(weights: Floats, cities: Ints, rng: Any) -> int:
    """Return one of the cities, each with a chance in proportion to its weight."""
    total = 0.0
    for city in cities:
        total += weights[city]
    turn = rng.random() * total
    for city in cities:
        turn -= weights[city]
        if turn < 0.0:
            return city
    return cities[-1]


@numba.njit(cache=True)
def nearest(lengths: Floats, cities: Ints) -> int:
    """Return the city with the least length."""
    best = cities[0]
    for city in cities:
        if lengths[city] < lengths[best]:
            best = city
    return best


@numba.njit(cache=True)
def replace_city(sheet: Sheet, ant: Ant, weights: Floats, previous: int, city: int, rng: Any) -> int:
    """Step 3: go to an unmarked candidate of the previous city instead of ``city``; -1 when there is none."""
    ant.marked[city] = True
    cut_contour(sheet, ant, city)
    unmarked = 0
    for k in range(candidates(sheet, ant, previous, 0)):
        if not ant.marked[ant.allow[k]]:
            ant.allow[unmarked] = ant.allow[k]
            unmarked += 1
    other = choose(weights[previous], ant.allow[:unmarked], rng) if unmarked else -1
    cut_contour(sheet, ant, city if other < 0 else other)
    return other


@numba.njit(cache=True)
def forced_city(sheet: Sheet, ant: Ant, city: int) -> int:
    """Step 4: return the nearest candidate on the lowest level that has one."""
    level, count = 0, 0
    while count == 0:  # ends on level 3 at the latest: precedence is acyclic
        level += 1
        count = candidates(sheet, ant, city, level)
    return nearest(sheet.lengths[city], ant.allow[:count])


@numba.njit(cache=True)
def make_tour(sheet: Sheet, weights: Floats, tour: Ints, rng: Any) -> int:
    """Fill ``tour`` with cities, steps 1 to 4, and return how often a rule was dropped.

    Parameters
    ----------
    weights
        Numerators of (9), shape (nodes + 1, nodes); the last row is for tours that begin anywhere.
    tour
        Shape (contours,).
    """
    ant = new_ant(sheet)
    city, turn, dropped = sheet.start, -1, 0
    while turn + 1 < len(tour):
        count = candidates(sheet, ant, city, 0)
        if count:
            following = choose(weights[city], ant.allow[:count], rng)
        else:
            if turn >= 0:
                previous = sheet.start if turn == 0 else tour[turn - 1]
                other = replace_city(sheet, ant, weights, previous, city, rng)
                if other >= 0:
                    city = other
                    tour[turn] = other
                    continue
            following = forced_city(sheet, ant, city)
            dropped += 1
        cut_contour(sheet, ant, following)
        ant.marked[:] = False
        turn += 1
        tour[turn] = following
        city = following
    return dropped


@numba.njit(cache=True)
def make_tours(sheet: Sheet, weights: Floats, tours: Ints, dropped: Ints, rng: Any) -> None:
    """Fill the tour of each ant, shape (ants, contours), and how often it dropped a rule."""
    for k in range(len(tours)):
        dropped[k] = make_tour(sheet, weights, tours[k], rng)
