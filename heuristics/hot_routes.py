"""Routes of one head in two rows, as the dual-coded genetic algorithm has them: travel, heat, what they cross.

``order`` holds the contours as they are cut, ``starts`` the number of the entry point of each contour. Stored
by contour, a start stays with its contour wherever the order takes it.

Figures are those of ``instances.evaluate`` to rounding: all earlier contours count, none is dropped for being
far away.
"""

from typing import Any, NamedTuple

import numba
import numpy as np

from cutgap.heuristics.ant_paths import crosses, lacks
from cutgap.instances import Instance, Plan, Rules, Visit
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.heat import curve_distances, diffusivity, kernel_constant
from cutgap.instances.process import WORD, Words, crossings

RETRIES = 1000
"""Times that a random route may get stuck before it crosses what is cut."""


class Plate(NamedTuple):
    """What routes are measured by; sets of contours are words as in ``process.crossings``.

    Parameters
    ----------
    rapids
        Between all nodes, shape (nodes, nodes), mm.
    first_node
        As ``Instance.first_node``.
    owner
        Contour of each entry point.
    home
        Node of the home, -1 when there is none.
    speed
        Of rapids, mm/s.
    services
        Time to cut each contour, s.
    cooling
        L^2 / (4 a) from each entry point to each curve, shape (points, contours), s.
    warmth
        The rise on a curve after 1 s, K.
    crossed
        Shape (points, points, words), no words unless rapids must be clear.
    before
        Contours that precede each contour, shape (contours, words).
    """

    rapids: Floats
    first_node: Ints
    owner: Ints
    home: int
    speed: float
    services: Floats
    cooling: Floats
    warmth: float
    crossed: Words
    before: Words


def plate_of(instance: Instance, rules: Rules) -> Plate:
    """Return what the kernels read; raises ``ValueError`` without material or curves.

    Kernels are compiled anew for arrays that are read-only, hence the copy.
    """
    home, count = instance.home_node(0), len(instance.contours)
    places, words = int(instance.first_node[-1]), (count + WORD - 1) // WORD
    before: Words = np.zeros((count, words), dtype=np.uint64)
    for a, b in instance.precedence:
        before[b, a // WORD] |= np.uint64(1 << a % WORD)
    return Plate(
        rapids=instance.rapids,
        first_node=instance.first_node,
        owner=np.repeat(np.arange(count), np.diff(instance.first_node)),
        home=-1 if home is None else home,
        speed=instance.machine.v_jump,
        services=instance.service_times,
        cooling=curve_distances(instance) ** 2 / (4.0 * diffusivity(instance)),
        warmth=kernel_constant(instance),
        crossed=np.array(crossings(instance))
        if rules.clear_rapids
        else np.zeros((places, places, 0), np.uint64),
        before=before,
    )


def plan_of_route(order: Ints, starts: Ints) -> Plan:
    """Return the plan that a route makes."""
    return Plan((tuple(Visit(contour, int(starts[contour])) for contour in order.tolist()),))


@numba.njit(cache=True)
def travel_of(plate: Plate, order: Ints, starts: Ints) -> float:
    """Return the length of rapids, home or first contour to itself, mm."""
    last = plate.first_node[order[-1]] + starts[order[-1]]
    node = plate.home if plate.home >= 0 else last
    total = 0.0
    for contour in order:
        following = plate.first_node[contour] + starts[contour]
        total += plate.rapids[node, following]
        node = following
    return total + (plate.rapids[last, plate.home] if plate.home >= 0 else 0.0)


@numba.njit(cache=True)
def peak_rise(plate: Plate, order: Ints, starts: Ints, ends: Floats) -> float:
    """Return the highest rise of a start point above ambient, K; ``ends`` is room for a time per contour."""
    clock, node, highest = 0.0, plate.home, 0.0
    for turn in range(len(order)):
        contour = order[turn]
        following = plate.first_node[contour] + starts[contour]
        if node >= 0:
            clock += plate.rapids[node, following] / plate.speed
        node = following
        rise = 0.0
        for earlier in range(turn):
            other = order[earlier]
            lag = clock - ends[earlier]
            if lag > 0.0:
                rise += np.exp(-plate.cooling[node, other] / lag) / np.sqrt(lag)
            elif plate.cooling[node, other] == 0.0:
                rise = np.inf
        highest = max(highest, rise)
        clock += plate.services[contour]
        ends[turn] = clock
    return plate.warmth * highest


@numba.njit(cache=True)
def barred_steps(plate: Plate, order: Ints, starts: Ints, most: int) -> int:
    """Return how many contours are reached across what is cut or before their time; stops above ``most``."""
    cut = np.zeros(plate.before.shape[1], np.uint64)
    node, barred = -1, 0
    for contour in order:
        following = plate.first_node[contour] + starts[contour]
        crossing = node >= 0 and crosses(plate.crossed[node, following], cut)
        if crossing or lacks(plate.before[contour], cut):
            barred += 1
            if barred > most:
                break
        cut[contour // WORD] |= np.uint64(1) << np.uint64(contour % WORD)
        node = following
    return barred


@numba.njit(cache=True)
def nearest_neighbours(plate: Plate) -> tuple[Ints, Ints]:
    """Return the route that goes to the nearest start point each time, whatever it crosses.

    Without a home it begins at the first point of contour 0.
    """
    count = len(plate.before)
    order, starts = np.zeros(count, np.int64), np.zeros(count, np.int64)
    done = np.zeros(count, np.bool_)
    node = plate.home if plate.home >= 0 else 0
    for turn in range(count):
        nearest = -1
        for point in range(len(plate.owner)):
            if done[plate.owner[point]]:
                continue
            if nearest < 0 or plate.rapids[node, point] < plate.rapids[node, nearest]:
                nearest = point
        contour, node = plate.owner[nearest], nearest
        order[turn], starts[contour] = contour, nearest - plate.first_node[contour]
        done[contour] = True
    return order, starts


@numba.njit(cache=True)
def random_route(plate: Plate, order: Ints, starts: Ints, rng: Any) -> None:
    """Fill in a random route, each step drawn among the start points that can be reached.

    Where there is none, it takes back one step more than the time before; after ``RETRIES`` such times it
    goes across what is cut.
    """
    cut = np.zeros(plate.before.shape[1], np.uint64)
    done = np.zeros(len(order), np.bool_)
    turn, node, stuck = 0, -1, 0
    while turn < len(order):
        following = _random_step(plate, cut, done, node, stuck > RETRIES, rng)
        if following < 0:
            stuck += 1
            for _ in range(min(turn, stuck)):
                turn -= 1
                _flip(cut, done, order[turn])
            node = plate.first_node[order[turn - 1]] + starts[order[turn - 1]] if turn else -1
            continue
        contour, node = plate.owner[following], following
        order[turn], starts[contour] = contour, following - plate.first_node[contour]
        _flip(cut, done, contour)
        turn += 1


@numba.njit(cache=True)
def _flip(cut: Words, done: Any, contour: int) -> None:
    """Cut a contour, or take the cut back."""
    cut[contour // WORD] ^= np.uint64(1) << np.uint64(contour % WORD)
    done[contour] = not done[contour]


@numba.njit(cache=True)
def _random_step(plate: Plate, cut: Words, done: Any, node: int, across: bool, rng: Any) -> int:
    """Return an entry point that may follow, each with the same chance; -1 when there is none.

    ``across`` says whether one across what is cut does where there is no other.
    """
    clear, free, choice, fallback = 0, 0, -1, -1
    for contour in range(len(done)):
        if done[contour] or lacks(plate.before[contour], cut):
            continue
        for point in range(plate.first_node[contour], plate.first_node[contour + 1]):
            free += 1
            if across and rng.random() * free < 1.0:
                fallback = point
            if node >= 0 and crosses(plate.crossed[node, point], cut):
                continue
            clear += 1
            if rng.random() * clear < 1.0:
                choice = point
    return choice if clear > 0 else fallback
