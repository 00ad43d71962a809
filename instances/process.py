r"""The sheet under a cutting process: what a rapid crosses, which parts are neighbours, what a rapid costs.

    (1) A rapid crosses a contour when its middle part, from v + t (w - v) to w - t (w - v) with t = 1e-6,
        meets the contour's curve. The ends lie on curves themselves, and coordinates are rounded.
    (2) Parts A and B are neighbours when a rapid from an entry point of A to one of B crosses no contour of
        another part; parts that enclose A or B do not count as other parts.
    (3) cost of a rapid from v to w = its length + backward price * max(0, x_v - x_w)                 [mm]

A contour without a part is a part of its own. Only rapids between contours count: the way from a home crosses
nothing that is cut yet, and on the way back the head is raised.

Source: Li et al. (2019), constraints (6), (7), (8); (1) says exactly what they leave to the figure.
"""

from functools import lru_cache

import numpy as np
import numpy.typing as npt
import shapely

from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.instance import Instance
from cutgap.instances.nesting import enclosures
from cutgap.instances.rules import Rules

END_SHARE = 1e-6
"""t of (1)."""

WORD = 64
"""Contours per word of a set."""

Words = npt.NDArray[np.uint64]
Bools = npt.NDArray[np.bool_]


def require_geometry(instance: Instance, rule: str) -> None:
    """Raise ``ValueError`` when a rule needs the curve of every contour and one has none."""
    if not instance.located:
        raise ValueError(f"instance {instance.name!r} has a matrix but no coordinates: {rule} needs them")
    bare = next((c.id for c in instance.contours if c.geometry is None), None)
    if bare is not None:
        raise ValueError(f"instance {instance.name!r}, contour {bare!r}: no geometry, which {rule} needs")


def rapid_costs(instance: Instance, rules: Rules) -> Floats:
    """Return (3) between all nodes, shape (nodes, nodes), mm; rapids from and to homes cost their length."""
    costs = instance.rapids
    if rules.backward_price == 0.0:
        return costs
    x = instance.points[:, 0]
    backward = np.maximum(0.0, np.subtract.outer(x, x))
    places = int(instance.first_node[-1])
    backward[places:] = backward[:, places:] = 0.0
    return costs + rules.backward_price * backward


def part_of(instance: Instance) -> Ints:
    """Return the number of the part of each contour, in order of appearance, shape (contours,)."""
    numbers: dict[tuple[str, str | int], int] = {}
    keys = [
        ("contour", index) if contour.part is None else ("part", contour.part)
        for index, contour in enumerate(instance.contours)
    ]
    return np.array([numbers.setdefault(key, len(numbers)) for key in keys], dtype=np.int64)


@lru_cache(maxsize=8)
def crossings(instance: Instance) -> Words:
    """Return which contours each rapid crosses, by (1), as sets in words of 64 bits.

    Returns
    -------
    Words
        Shape (points, points, words): bit k % 64 of word k // 64 says that the rapid between two entry
        points crosses contour k. Read-only.

    Raises
    ------
    ValueError
        When a contour has no geometry.
    """
    require_geometry(instance, "what rapids cross")
    places = int(instance.first_node[-1])
    words = (len(instance.contours) + WORD - 1) // WORD
    table: Words = np.zeros((places, places, words), dtype=np.uint64)
    # One by one: they differ in length.
    curves = [shapely.linearrings(contour.geometry) for contour in instance.contours]
    tree = shapely.STRtree(curves)
    for v in range(places - 1):
        others = np.arange(v + 1, places)
        others = others[(instance.points[others, :2] != instance.points[v, :2]).any(axis=1)]
        lines = _middles(instance.points[v, :2], instance.points[others, :2])
        which, contours = tree.query(lines, "intersects")
        bits = np.left_shift(np.uint64(1), (contours % WORD).astype(np.uint64))
        np.bitwise_or.at(table, (v, others[which], contours // WORD), bits)
        table[others, v] = table[v, others]
    table.setflags(write=False)
    return table


def _middles(start: Floats, ends: Floats) -> npt.NDArray[np.object_]:
    """Return the middle parts of rapids from one point to others, as lines."""
    steps = END_SHARE * (ends - start)
    return shapely.linestrings(np.stack((start + steps, ends - steps), axis=1))


def contours_in(words: Words) -> list[int]:
    """Return the contours of one set, ascending."""
    return [
        WORD * place + bit
        for place, word in enumerate(words.tolist())
        for bit in range(WORD)
        if word >> bit & 1
    ]


@lru_cache(maxsize=8)
def adjacent_parts(instance: Instance) -> Bools:
    """Return which parts are neighbours, by (2), shape (parts, parts), symmetric, read-only.

    Raises
    ------
    ValueError
        When a contour has no geometry.
    """
    require_geometry(instance, "neighbours only")
    parts = part_of(instance)
    count = int(parts.max(initial=-1)) + 1
    table = crossings(instance)
    around = enclosures([contour.geometry for contour in instance.contours if contour.geometry is not None])
    own = np.zeros((count, table.shape[2]), dtype=np.uint64)
    for contour, part in enumerate(parts.tolist()):
        enclosing = {parts[each] for each in around[contour]} | {part}
        for other in np.flatnonzero(np.isin(parts, list(enclosing))).tolist():
            own[part, other // WORD] |= np.uint64(1 << other % WORD)
    nodes = np.repeat(parts, np.diff(instance.first_node))
    adjacent: Bools = np.zeros((count, count), dtype=np.bool_)
    for a in range(count):
        rows = table[nodes == a]
        for b in range(a + 1, count):
            blocked = rows[:, nodes == b] & ~(own[a] | own[b])
            adjacent[a, b] = adjacent[b, a] = bool((~blocked.any(axis=2)).any())
    adjacent.setflags(write=False)
    return adjacent
