"""The layers of the sparse programme: rows of states (one set, one last contour), kept by hashing (numba)."""

from typing import NamedTuple

import numpy as np
from numba import njit

from cutgap.formulations.contour_dp.walks import Bools
from cutgap.instances.arrays import Floats, Ints

FIRST_CAPACITY = 1024


class Steps(NamedTuple):
    """Which steps there are and what they cost.

    ``conflicts[b]`` is the set that must not be cut before b, ``mates[a]`` the part of a, of which everything
    must be cut before another part; ``crossed[v, w]`` the contours that a rapid crosses, or empty.
    """

    costs: Floats
    prices: Floats
    first: Ints
    closed: Bools
    conflicts: Ints
    mates: Ints
    crossed: Ints


class Onward(NamedTuple):
    """Completion bounds of one position: ``bound[offset[a] + M * points of a + i]``, ``bits[a, b]`` of b."""

    bits: Ints
    offset: Ints
    bound: Floats
    limit: float


class Layer(NamedTuple):
    """Rows of one position: set, last contour, where the row begins in ``values``, and its least F + R."""

    sets: Ints
    lasts: Ints
    starts: Ints
    promise: Floats
    values: Floats


@njit(cache=True)
def extend_layer(steps: Steps, onward: Onward, layer: Layer) -> Layer:
    """Return the next layer: all steps from all rows, without the states that the completion bounds drop."""
    count = len(steps.prices)
    widest = np.diff(steps.first).max()
    table = np.full(2 * FIRST_CAPACITY, -1, dtype=np.int64)
    grown = _empty_layer(FIRST_CAPACITY, widest)
    rows, cells = 0, 0
    row = np.empty(widest)
    for state in range(len(layer.sets)):
        cut, a = layer.sets[state], layer.lasts[state]
        here = layer.values[layer.starts[state] : layer.starts[state] + steps.first[a + 1] - steps.first[a]]
        for b in range(count):
            if steps.closed[a, b] or not may_follow(cut, steps.conflicts[b], steps.mates[a], b):
                continue
            size = steps.first[b + 1] - steps.first[b]
            _step(steps, here, a, b, cut, row)
            least = _drop(onward, row[:size], b, cut)
            if least >= onward.limit:
                continue
            if rows == len(grown.sets) or cells + size > len(grown.values):
                grown, table = _grow(grown, rows, widest)
            key = cut | 1 << b
            slot = _find(table, grown, key, b)
            if table[slot] < 0:
                table[slot] = rows
                grown.sets[rows], grown.lasts[rows], grown.starts[rows] = key, b, cells
                grown.promise[rows] = least
                grown.values[cells : cells + size] = row[:size]
                rows += 1
                cells += size
            else:
                _merge(grown, table[slot], row[:size], least)
    return Layer(
        grown.sets[:rows], grown.lasts[:rows], grown.starts[:rows], grown.promise[:rows], grown.values[:cells]
    )


@njit(cache=True)
def may_follow(cut: int, conflicts: int, mates: int, b: int) -> bool:
    """Whether contour b may come when ``cut`` is done, the last one with these mates."""
    return cut & conflicts == 0 and (mates >> b & 1 == 1 or mates & ~cut == 0)


@njit(cache=True)
def _step(steps: Steps, here: Floats, a: int, b: int, cut: int, row: Floats) -> None:
    """Set ``row`` to the least cost of reaching each point of b from the row ``here`` of a."""
    low, size = steps.first[b], steps.first[b + 1] - steps.first[b]
    row[:size] = np.inf
    for i in range(len(here)):
        if here[i] == np.inf:
            continue
        v = steps.first[a] + i
        for j in range(size):
            if len(steps.crossed) == 0 or steps.crossed[v, low + j] & cut == 0:
                row[j] = min(row[j], here[i] + steps.costs[v, low + j] + steps.prices[b])


@njit(cache=True)
def _drop(onward: Onward, row: Floats, b: int, cut: int) -> float:
    """Drop the states of a row that no walk below the limit goes through; return the least bound left."""
    remembered = 0
    for c in range(len(onward.bits)):
        if onward.bits[b, c] >= 0 and cut >> c & 1:
            remembered |= 1 << onward.bits[b, c]
    low = onward.offset[b] + remembered * len(row)
    least = onward.limit
    for j in range(len(row)):
        total = row[j] + onward.bound[low + j]
        if total < onward.limit:
            least = min(least, total)
        else:
            row[j] = np.inf
    return least


@njit(cache=True)
def _merge(layer: Layer, number: int, row: Floats, least: float) -> None:
    """Keep the better of two rows, state by state."""
    begin = layer.starts[number]
    for j in range(len(row)):
        layer.values[begin + j] = min(layer.values[begin + j], row[j])
    layer.promise[number] = min(layer.promise[number], least)


@njit(cache=True)
def _empty_layer(rows: int, widest: int) -> Layer:
    return Layer(
        np.empty(rows, dtype=np.int64),
        np.empty(rows, dtype=np.int64),
        np.empty(rows, dtype=np.int64),
        np.empty(rows),
        np.empty(rows * widest),
    )


@njit(cache=True)
def _grow(layer: Layer, rows: int, widest: int) -> tuple:
    """Return a layer of twice the room with the same rows, and its hash table."""
    grown = _empty_layer(2 * len(layer.sets), widest)
    grown.sets[:rows], grown.lasts[:rows] = layer.sets[:rows], layer.lasts[:rows]
    grown.starts[:rows], grown.promise[:rows] = layer.starts[:rows], layer.promise[:rows]
    grown.values[: len(layer.values)] = layer.values
    table = np.full(2 * len(grown.sets), -1, dtype=np.int64)
    for number in range(rows):
        table[_find(table, grown, grown.sets[number], grown.lasts[number])] = number
    return grown, table


@njit(cache=True)
def _find(table: Ints, layer: Layer, key: int, last: int) -> int:
    """Return the slot of a row, or the free one where it belongs."""
    mixed = (key * np.int64(-7046029254386353131)) ^ (last * np.int64(0x27D4EB2F165667C5))
    slot = ((mixed ^ (mixed >> 29)) & np.int64(0x7FFFFFFFFFFFFFFF)) % len(table)
    while table[slot] >= 0 and (layer.sets[table[slot]] != key or layer.lasts[table[slot]] != last):
        slot = (slot + 1) % len(table)
    return int(slot)
