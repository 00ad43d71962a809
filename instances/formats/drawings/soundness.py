"""What a drawing must not hold: open chains, copies, and contours that cross themselves or each other.

With the slack s = tolerance + chord, since both move a curve:

    (1) open        a chain without a closed way back
    (2) copies      contours A and B such that neither leaves the other by a strip wider than s
    (3) crossing    A crosses itself, or A and B share, and each has alone, a region wider than s

Contours that touch, along a common edge too, are sound.
"""

from dataclasses import dataclass

import numpy as np
import shapely
from scipy.spatial import KDTree

from cutgap.instances.arrays import Floats
from cutgap.instances.formats.drawings.chaining import Chain
from cutgap.instances.formats.drawings.outlines import Outline, outline, place_of
from cutgap.instances.formats.options import DrawingOptions, Fault

MOST_SHOWN = 20
"""Faults that a message lists one by one."""


@dataclass(frozen=True, slots=True)
class Flaw:
    """A fault and its wording."""

    kind: Fault
    text: str


def sound_outlines(chains: list[Chain], options: DrawingOptions) -> tuple[list[Outline], list[str]]:
    """Return the sound outlines of a drawing, and notes on what was left out.

    Raises
    ------
    ValueError
        Listing every fault of a kind that is not to be skipped.
    """
    slack = options.tolerance + options.chord
    kept = [each for each in chains if max(strand.extent for strand in each.strands) > options.tolerance]
    notes = []
    if len(kept) < len(chains):
        notes.append(f"{len(chains) - len(kept)} specks within {options.tolerance:g} mm are left out")
    flaws = _open_chains([each for each in kept if not each.closed])
    outlines, twisted = _simple([outline(each) for each in kept if each.closed], slack)
    outlines, copied = _single(outlines, slack)
    outlines, crossed = _uncrossed(outlines, slack)
    flaws += twisted + copied + crossed
    refused = [flaw for flaw in flaws if flaw.kind not in options.skip]
    if refused:
        raise ValueError(_message(refused, options))
    if flaws:
        notes.append(f"left out as asked: {_listed(flaws)}")
    return outlines, notes


def _open_chains(chains: list[Chain]) -> list[Flaw]:
    """(1)."""
    if not chains:
        return []
    ends = np.array([(each.strands[0].ends[0], each.strands[-1].ends[1]) for each in chains])
    nearest = KDTree(ends.reshape(-1, 2)).query(ends.reshape(-1, 2), k=2)[0][:, 1].reshape(-1, 2)
    return [
        Flaw(
            "open",
            f"open: {place_of(each)}, from {_at(start)} to {_at(end)}; "
            f"the nearest loose ends are {gaps[0]:.3g} and {gaps[1]:.3g} mm away",
        )
        for each, (start, end), gaps in zip(chains, ends, nearest, strict=True)
    ]


def _simple(outlines: list[Outline], slack: float) -> tuple[list[Outline], list[Flaw]]:
    """(3) for single contours; one that is nowhere wider than the slack runs back over itself."""
    kept, flaws = [], []
    for each in outlines:
        area = shapely.Polygon(each.points) if len(each.points) > 2 else None
        if area is not None and area.is_valid and not shapely.is_empty(_core(area, slack)):
            kept.append(each)
        elif area is None or area.is_valid or shapely.is_empty(_core(shapely.make_valid(area), slack)):
            flaws.append(Flaw("copies", f"drawn to and fro: {each.place}, at {_at(each.points[0])}"))
        else:
            reason = shapely.is_valid_reason(area)
            where = reason.partition("[")[2].rstrip("]").split()
            at = _at(np.array(where, dtype=float)) if len(where) == 2 else reason
            flaws.append(Flaw("crossing", f"crosses itself: {each.place}, at {at}"))
    return kept, flaws


def _single(outlines: list[Outline], slack: float) -> tuple[list[Outline], list[Flaw]]:
    """(2): keep the first of several copies."""
    areas = _areas(outlines)
    dropped: dict[int, int] = {}
    for i, j in _meeting(areas):
        if i in dropped or j in dropped:
            continue
        if shapely.is_empty(_core(shapely.symmetric_difference(areas[i], areas[j]), slack)):
            dropped[j] = i
    flaws = [
        Flaw(
            "copies",
            f"drawn again: {outlines[j].place} as {outlines[i].place}, at {_at(outlines[j].points[0])}",
        )
        for j, i in dropped.items()
    ]
    return [each for number, each in enumerate(outlines) if number not in dropped], flaws


def _uncrossed(outlines: list[Outline], slack: float) -> tuple[list[Outline], list[Flaw]]:
    """(3) for pairs; both are left out."""
    areas = _areas(outlines)
    dropped: set[int] = set()
    flaws = []
    for i, j in _meeting(areas):
        one, other = areas[i], areas[j]
        shared = _core(shapely.intersection(one, other), slack)
        alone = (_core(shapely.difference(one, other), slack), _core(shapely.difference(other, one), slack))
        if shared.is_empty or alone[0].is_empty or alone[1].is_empty:
            continue
        dropped |= {i, j}
        at = _at(np.array(shapely.get_coordinates(shared)[0]))
        flaws.append(Flaw("crossing", f"crossing: {outlines[i].place}, and {outlines[j].place}, near {at}"))
    return [each for number, each in enumerate(outlines) if number not in dropped], flaws


def _areas(outlines: list[Outline]) -> list[shapely.Polygon]:
    return [shapely.Polygon(each.points) for each in outlines]


def _meeting(areas: list[shapely.Polygon]) -> list[tuple[int, int]]:
    """Return the pairs of contours whose curves meet, ascending."""
    rings = [area.exterior for area in areas]
    first, second = shapely.STRtree(rings).query(rings, "intersects") if rings else ((), ())
    return sorted((int(i), int(j)) for i, j in zip(first, second, strict=True) if i < j)


def _core(area: shapely.Geometry, slack: float) -> shapely.Geometry:
    """Return what is left of an area without a rim of half the slack: nothing of strips that narrow."""
    return shapely.buffer(area, -slack / 2, quad_segs=1)


def _message(flaws: list[Flaw], options: DrawingOptions) -> str:
    kinds = ",".join(sorted({flaw.kind for flaw in flaws}))
    return (
        f"{_listed(flaws)}\nMend the drawing, close gaps by --tolerance (now {options.tolerance:g} mm), "
        f"choose layers by --layers, or leave such contours out by --skip {kinds}"
    )


def _listed(flaws: list[Flaw]) -> str:
    lines = [f"{len(flaws)} fault{'s' if len(flaws) > 1 else ''}", *(flaw.text for flaw in flaws[:MOST_SHOWN])]
    if len(flaws) > MOST_SHOWN:
        lines.append(f"and {len(flaws) - MOST_SHOWN} more")
    return "\n  ".join(lines)


def _at(point: Floats) -> str:
    return f"({point[0]:.6g}, {point[1]:.6g})"
