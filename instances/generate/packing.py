"""Boxes side by side on a sheet: the leftmost place first, in an order that a local search finds.

    Data       w_i, h_i   sides of box i, the gap to its neighbours included; it may be turned    [mm]
               W, H       sides of the sheet                                                      [mm]
    Decoding   boxes are placed one by one at the least x, then the least y, to the right of all that is
               placed so far (a skyline): what lies behind the skyline stays waste
    Search     swap two boxes of the order or turn one; keep what reaches no further in x

The search ends as soon as all boxes lie within W, and starts anew after a number of steps without success.
"""

from typing import Any

import numba
import numpy as np

from cutgap.instances.arrays import Ints

STEPS = 4_000
"""Steps until a new start: a search that has not come through by then is stuck."""

STARTS = 200


def pack(boxes: Ints, sheet: tuple[int, int], rng: np.random.Generator) -> tuple[Ints, Ints]:
    """Return places for boxes on a sheet.

    Parameters
    ----------
    boxes
        Shape (n, 2), mm: extent in x and y before turning, whole numbers above 0.
    sheet
        Extent in x and y, mm.

    Returns
    -------
    tuple[Ints, Ints]
        Least x and y of each box, shape (n, 2), and whether it is turned (0 or 1), shape (n,).

    Raises
    ------
    ValueError
        When no packing is found.
    """
    for _ in range(STARTS):
        order, turned = rng.permutation(len(boxes)), rng.integers(0, 2, len(boxes))
        if _search(boxes, sheet[0], sheet[1], order, turned, STEPS, rng) <= sheet[0]:
            places = np.empty((len(boxes), 2), dtype=np.int64)
            _decode(boxes, sheet[1], order, turned, places, np.empty((len(boxes) + 2, 2), dtype=np.int64))
            return places, turned
    raise ValueError(f"packing: found no way to put {len(boxes)} boxes on {sheet[0]} x {sheet[1]} mm")


@numba.njit(cache=True)
def _search(boxes: Ints, width: int, height: int, order: Ints, turned: Ints, steps: int, rng: Any) -> int:
    """Change ``order`` and ``turned`` until all boxes lie within ``width`` or the steps are used up."""
    n = len(boxes)
    places, skyline = np.empty((n, 2), np.int64), np.empty((n + 2, 2), np.int64)
    reach = _decode(boxes, height, order, turned, places, skyline)
    for _ in range(steps):
        if reach <= width:
            break
        i, j = int(rng.random() * n), int(rng.random() * n)
        if i == j:
            turned[i] ^= 1
        else:
            order[i], order[j] = order[j], order[i]
        changed = _decode(boxes, height, order, turned, places, skyline)
        if changed <= reach:
            reach = changed
        elif i == j:
            turned[i] ^= 1
        else:
            order[i], order[j] = order[j], order[i]
    return reach


@numba.njit(cache=True)
def _decode(boxes: Ints, height: int, order: Ints, turned: Ints, places: Ints, skyline: Ints) -> int:
    """Place the boxes in order and return how far they reach in x.

    Row k of ``skyline`` is the y where a stretch begins and the x up to which it is used; the last row in
    use begins at ``height``.
    """
    reach, stretches = 0, 1
    skyline[0, 0], skyline[0, 1] = 0, 0
    skyline[1, 0] = height
    for box in order:
        across, along = boxes[box, turned[box]], boxes[box, 1 - turned[box]]
        best, best_x = -1, 0
        for k in range(stretches):
            top = skyline[k, 0] + along
            if top > height:
                break
            x, last = 0, k
            while last < stretches and skyline[last, 0] < top:
                x = max(x, skyline[last, 1])
                last += 1
            if best < 0 or x < best_x:
                best, best_x = k, x
        if best < 0:
            return 1 << 40
        places[box, 0], places[box, 1] = best_x, skyline[best, 0]
        reach = max(reach, best_x + across)
        stretches = _raise(skyline, stretches, best, skyline[best, 0] + along, best_x + across)
    return reach


@numba.njit(cache=True)
def _raise(skyline: Ints, stretches: int, first: int, top: int, x: int) -> int:
    """Use the skyline from stretch ``first`` up to y = ``top`` up to ``x``; return the number of stretches."""
    last = first
    while skyline[last + 1, 0] <= top and last + 1 < stretches:
        last += 1
    end = skyline[last + 1, 0]
    rest = skyline[last, 1]
    removed = last - first
    added = 1 if end > top else 0
    shift = added - removed
    if shift > 0:
        for k in range(stretches, last, -1):
            skyline[k + shift] = skyline[k]
    elif shift < 0:
        for k in range(last + 1, stretches + 1):
            skyline[k + shift] = skyline[k]
    skyline[first, 1] = x
    if added:
        skyline[first + 1, 0], skyline[first + 1, 1] = top, rest
    return stretches + shift
