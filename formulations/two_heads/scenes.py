"""Scenes of the threshold search: T_1(k) grows with the threshold, T_2(k) falls, their crossing is sought."""

from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from cutgap.formulations.branch_and_cut.wording import legs_around
from cutgap.instances.scene import Leg, Range, Scene, Threshold, plan_nodes

if TYPE_CHECKING:
    from cutgap.formulations.two_heads.split import Cell, SplitSearch

NAMES = ("left", "right")


def split_scene(search: "SplitSearch", cell: "Cell", text: Callable[[], str]) -> Scene:
    """Return the scene of a step at a cell."""
    thresholds = thresholds_of(search)
    places = [index for index, (left, _) in enumerate(thresholds) if left == cell.left and not cell.free]
    return Scene(
        text(),
        bound=search.bound(cell.left, cell.right, cell.free),
        legs=_tours(search, cell),
        best=None if search.best is None else plan_nodes(search.instance, search.best),
        owners=tuple(_owner(cell, contour) for contour in range(len(search.instance.contours))),
        thresholds=tuple(threshold for _, threshold in thresholds),
        threshold=places[0] if places else None,
    )


def tightened(search: "SplitSearch", cell: "Cell", head: int, before: float) -> str:
    """Say how the bound on a head's tour rose from ``before`` (mm)."""
    side = search.pair(cell)[head]
    how = "by 1-trees with prices (Held-Karp)"
    if side.search is not None:
        nodes = side.search.nodes
        how = f"by branch and cut, {nodes} node{'' if nodes == 1 else 's'}"
        how += ", to its shortest tour" if side.is_exact else ", far enough to be out of the question"
    speed = search.instance.machine.v_jump
    old, new = (length / speed + side.service_s for length in (before, side.lower))
    risen = f"T_{head + 1} ≥ {new:.2f} s, was {old:.2f} s"
    return f"{_place(cell)}: the {NAMES[head]} head's time is bounded {how}: {risen}."


def moved(cell: "Cell", what: str) -> str:
    """Say what became of a cell without work on a tour."""
    return f"{_place(cell)}: {what}"


def _place(cell: "Cell") -> str:
    left, right, free = cell.left.bit_count(), cell.right.bit_count(), len(cell.free)
    place = f"{left} contours left, {right} right"
    return f"{place}, {free} of equal x not decided" if free else place


def _owner(cell: "Cell", contour: int) -> int:
    return 0 if cell.left >> contour & 1 else 1 if cell.right >> contour & 1 else -1


def _tours(search: "SplitSearch", cell: "Cell") -> tuple[Leg, ...]:
    """Return the best tours known of the decided sets."""
    legs: tuple[Leg, ...] = ()
    for head, side in enumerate(search.pair(cell)):
        nodes = search.sides[head].nodes(side.order) if side.order else ()
        legs += legs_around(nodes, head)
    return legs


def thresholds_of(search: "SplitSearch") -> list[tuple[int, Threshold]]:
    """Return the left sets of all thresholds from left to right, with what is known of both heads' times."""
    everything = (1 << len(search.instance.contours)) - 1
    xs = np.sort(search.instance.points[: len(search.instance.contours), 0])
    # A threshold stands halfway between the x of two contours.
    places = [xs[0], *((a + b) / 2 for a, b in pairwise(xs)), xs[-1]]
    lefts = [left for left, _, free in search.first_cells() if not free]
    return [
        (
            left,
            Threshold(
                float(places[left.bit_count()]),
                left.bit_count(),
                (_times(search, 0, left), _times(search, 1, everything & ~left)),
            ),
        )
        for left in lefts
    ]


def _times(search: "SplitSearch", head: int, members: int) -> Range:
    """Return bounds on a head's time for a set, without leaving a trace in the search."""
    lower, upper, service_s = search.sides[head].peek(members)
    speed = search.instance.machine.v_jump
    return lower / speed + service_s, upper / speed + service_s
