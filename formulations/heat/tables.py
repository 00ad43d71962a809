r"""What is at least still to come, for each set of contours done and each last point: by dynamic programming.

    S          contours that are done, v in S the last point, w outside S the next one
    (1) warm(v, w, X) <= rise at w from X and v's contour a, in whatever order X was cut before a:
        T(L_wa, d_vw) + g(X),   g(0) = 0,   g(Y + j) = min over j of g(Y) + min of T(L_wj, t) over t in I(j, Y),
        I(j, Y) = d_vw + s_a + sum of s over Y + [lo, hi],   j was cut just before the set Y, Y just before a
        lo, hi = sums over Y and a of the shortest and of the longest way into each of them
    (2) R(S, v) = min over steps v -> w with warm(v, w, S - a) <= cap of  c_vw + R(S + w, w);   R(all, v) = b_v
    (3) C(S, v) = min over such steps of  max(warm(v, w, S - a), C(S + w, w));                  C(all, v) = 0

Proofs. (1): the lag of j at w is the way v -> w, the work on a and on what was cut between, Y, and the ways
into these; so it lies in I(j, Y), where the kernel is least at an end of the interval. The order of X that the
plan has is one of those over which g takes the least. With a limit on travel, hi is also at most what the limit
leaves for ways: limit - c_vw - the least R'(S' + w, w), R' being (2) without cap, over all S' that contain Y, j
and a, since g(Y + j) serves all X that contain Y and j; when that is below lo no plan within the limit cuts so,
and the term is infinite. (2), (3): induction over S; a plan within the cap only makes such steps. So R bounds
the travel and C the peak rise of what is left of any plan within cap and limit. Without heat R is exact (Held
and Karp).

warm is stored with a relative 10^-6 less than computed, more than its rounding.
"""

import numpy as np
from numba import njit

from cutgap.formulations.heat.plates import Plate, least_warmth, may_come, warmth
from cutgap.instances.arrays import Floats, Ints

SAFE = np.float32(1.0 - 1e-6)


@njit(cache=True)
def without(number: int, low: int, high: int) -> int:
    """Return a set without two bits, which are taken out of the word; ``low < high``."""
    number = (number >> (high + 1)) << high | number & (1 << high) - 1
    return (number >> (low + 1)) << low | number & (1 << low) - 1


@njit(cache=True)
def _with(number: int, low: int, high: int) -> int:
    """Undo ``without``, with both bits 0."""
    number = (number >> low) << (low + 1) | number & (1 << low) - 1
    return (number >> high) << (high + 1) | number & (1 << high) - 1


@njit(cache=True)
def warm_of(warm: np.ndarray, plate: Plate, v: int, w: int, cut: int) -> float:
    """Return (1) for the set S = ``cut``, which holds v's contour."""
    a, b = plate.contour_of[v], plate.contour_of[w]
    return float(warm[v, w, without(cut, min(a, b), max(a, b))])


@njit(cache=True)
def ways_into(plate: Plate) -> tuple[Floats, Floats]:
    """Return the shortest and the longest way into each contour from another one, s."""
    count = len(plate.service)
    least, most = np.zeros(count), np.zeros(count)
    for b in range(count):
        least[b] = np.inf if count > 1 else 0.0
        for w in range(plate.first[b], plate.first[b + 1]):
            for v in range(len(plate.contour_of)):
                if plate.contour_of[v] != b and plate.cost[v, w] < np.inf:
                    least[b] = min(least[b], plate.time[v, w])
                    most[b] = max(most[b], plate.time[v, w])
        if least[b] == np.inf:
            least[b] = 0.0
    return least, most


@njit(cache=True)
def warm_table(plate: Plate, room: Floats) -> np.ndarray:
    """Return (1), shape (points, points, 2^(n - 2)), where the set is numbered by ``without``.

    Parameters
    ----------
    room
        Longest time for ways before and at the step into w, given the set done after it and w, s; shape
        (2^n, points). Infinite without a limit on travel.
    """
    count, points = len(plate.service), len(plate.contour_of)
    subsets = 1 << max(0, count - 2)
    warm = np.full((points, points, subsets), np.inf, dtype=np.float32)
    least, most = ways_into(plate)
    lengths = np.zeros((3, 1 << count))
    for cut in range(1, 1 << count):
        low = 0
        while not cut >> low & 1:
            low += 1
        rest = cut & (cut - 1)
        lengths[0, cut] = lengths[0, rest] + plate.service[low]
        lengths[1, cut] = lengths[1, rest] + least[low]
        lengths[2, cut] = lengths[2, rest] + most[low]
    for v in range(points):
        for w in range(points):
            a, b = plate.contour_of[v], plate.contour_of[w]
            if a != b and plate.cost[v, w] < np.inf:
                _fill(plate, room, lengths, v, w, warm[v, w])
    return warm


@njit(cache=True)
def _fill(plate: Plate, room: Floats, lengths: Floats, v: int, w: int, row: np.ndarray) -> None:
    """Fill (1) for one step, over all sets X."""
    a, b = plate.contour_of[v], plate.contour_of[w]
    low, high, way = min(a, b), max(a, b), plate.time[v, w]
    total = np.empty(len(row))
    for number in range(len(row)):
        done = _with(number, low, high)
        after = done | 1 << a | 1 << b
        left = room[after, w] - way
        best = 0.0 if done == 0 else np.inf
        for j in range(len(plate.service)):
            if done >> j & 1:
                between = done ^ 1 << j
                behind = between | 1 << a
                soonest, latest = lengths[1, behind], min(left, lengths[2, behind])
                if latest >= soonest * (1.0 - 1e-9) - 1e-12:
                    fixed = way + lengths[0, behind]
                    latest = max(soonest, latest)
                    term = least_warmth(
                        plate.constant, plate.spread, plate.distance[w, j], fixed + soonest, fixed + latest
                    )
                    best = min(best, total[without(between, low, high)] + term)
        total[number] = best
    near = warmth(plate.constant, plate.spread, plate.distance[w, a], way)
    for number in range(len(row)):
        row[number] = np.float32(total[number] + near) * SAFE


@njit(cache=True)
def travel_table(plate: Plate, end: Floats, warm: np.ndarray, cap: float) -> Floats:
    """Return R of (2), shape (2^n, points), mm; infinite where no plan within the cap goes on.

    Parameters
    ----------
    end
        b, or the ways back to where a closed tour begins.
    warm
        (1); of shape (0, 0, 0) the cap is left out of account.
    """
    count, points = len(plate.service), len(plate.contour_of)
    table = np.full((1 << count, points), np.inf)
    table[-1] = end
    for cut in range((1 << count) - 2, 0, -1):
        for v in range(points):
            if not cut >> plate.contour_of[v] & 1:
                continue
            best = np.inf
            for w in range(points):
                b = plate.contour_of[w]
                if not cut >> b & 1 and may_come(plate, cut, v, w):
                    onward = plate.cost[v, w] + table[cut | 1 << b, w]
                    if onward < best and (len(warm) == 0 or warm_of(warm, plate, v, w, cut) <= cap):
                        best = onward
            table[cut, v] = best
    return table


@njit(cache=True)
def peak_table(plate: Plate, warm: np.ndarray, cap: float) -> Floats:
    """Return C of (3), shape (2^n, points), K; infinite where no plan within the cap goes on."""
    count, points = len(plate.service), len(plate.contour_of)
    table = np.full((1 << count, points), np.inf)
    table[-1] = 0.0
    for cut in range((1 << count) - 2, 0, -1):
        for v in range(points):
            if not cut >> plate.contour_of[v] & 1:
                continue
            best = np.inf
            for w in range(points):
                b = plate.contour_of[w]
                if not cut >> b & 1 and table[cut | 1 << b, w] < best and may_come(plate, cut, v, w):
                    here = warm_of(warm, plate, v, w, cut)
                    if here <= cap:
                        best = min(best, max(here, table[cut | 1 << b, w]))
            table[cut, v] = best
    return table


def no_warmth() -> np.ndarray:
    """Return the empty table that leaves the cap out of account."""
    return np.zeros((0, 0, 0), dtype=np.float32)


def rooms(plate: Plate, bare: Floats, limit: float, speed: float) -> Floats:
    """Return the ``room`` of ``warm_table`` for a limit on travel, mm: the most that R' of S or more leaves.

    A way counts at least its length in travel, so ``(limit - R') / speed`` bounds the time of the ways.
    """
    if not np.isfinite(limit):
        return np.full_like(bare, np.inf)
    room: Floats = (limit + 1e-9 * max(1.0, abs(limit)) - bare) / speed
    for contour in range(len(plate.service)):
        small = np.flatnonzero(np.arange(len(room)) >> contour & 1 == 0)
        room[small] = np.maximum(room[small], room[small | 1 << contour])
    return room


def subset_cells(first: Ints) -> int:
    """Return how many numbers (1) takes."""
    count = len(first) - 1
    return int(first[-1]) ** 2 << max(0, count - 2)
