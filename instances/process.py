r"""The sheet under a cutting process: what a rapid crosses, which parts are neighbours, what a rapid costs.

    (1) A rapid crosses a contour when its middle part, from v + t (w - v) to w - t (w - v) with t = 10^-6,
        meets the contour's curve. The ends lie on curves themselves. See ``crossing`` for how it is decided.
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
from cutgap.instances.crossing import mark_meetings
from cutgap.instances.instance import Instance
from cutgap.instances.nesting import enclosures
from cutgap.instances.rules import Rules

WORD = 64
"""Contours per word of a set."""

ENTRY_TOLERANCE_MM = 0.1
"""How far an entry point may be off its contour's curve where curves matter; chords of arcs are off them."""

Words = npt.NDArray[np.uint64]
Bools = npt.NDArray[np.bool_]


def require_geometry(instance: Instance, rule: str) -> None:
    """Raise ``ValueError`` when a rule needs the curve of every contour and one has none."""
    if not instance.located:
        raise ValueError(f"instance {instance.name!r} has a matrix but no coordinates: {rule} needs them")
    bare = next((c.id for c in instance.contours if c.geometry is None), None)
    if bare is not None:
        raise ValueError(f"instance {instance.name!r}, contour {bare!r}: no geometry, which {rule} needs")


@lru_cache(maxsize=8)
def entry_distances(instance: Instance) -> Floats:
    """Return how far each entry point is off the curve of its contour, shape (points,), mm; 0 without one."""
    found = np.zeros(int(instance.first_node[-1]))
    for index, contour in enumerate(instance.contours):
        if contour.geometry is not None:
            points = shapely.points(contour.entry_points[:, :2])
            own = slice(*instance.first_node[index : index + 2].tolist())
            found[own] = shapely.distance(points, shapely.LinearRing(contour.geometry))
    found.setflags(write=False)
    return found


def require_entries_on_curves(instance: Instance, rule: str) -> None:
    """Raise ``ValueError`` when an entry point is more than ``ENTRY_TOLERANCE_MM`` off its contour's curve."""
    distances = entry_distances(instance)
    for node in np.flatnonzero(distances > ENTRY_TOLERANCE_MM)[:1].tolist():
        contour = int(np.searchsorted(instance.first_node, node, side="right")) - 1
        x, y = instance.points[node, :2]
        raise ValueError(
            f"instance {instance.name!r}, contour {instance.contours[contour].id!r}: entry point "
            f"{node - int(instance.first_node[contour])} at {x:g}, {y:g} is {distances[node]:.3g} mm off "
            f"its curve; {rule} takes at most {ENTRY_TOLERANCE_MM:g} mm: "
            "move the point onto the curve, or mend the geometry"
        )


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
    points = np.array(instance.points[: int(instance.first_node[-1]), :2], order="C")
    words = (len(instance.contours) + WORD - 1) // WORD
    table: Words = np.zeros((words, len(points), len(points)), dtype=np.uint64)
    for index, contour in enumerate(instance.contours):
        if contour.geometry is not None:
            mark_meetings(points, contour.geometry, table[index // WORD], np.uint64(1 << index % WORD))
    table = np.ascontiguousarray(np.moveaxis(table, 0, 2))
    table.setflags(write=False)
    return table


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
