"""Closed loops become outlines: polylines with corners and true lengths, free of faults.

A joint of two elements is a corner when

    (1) the direction turns by more than ``SMOOTH`` there, or
    (2) a straight segment and a curve meet.

So a section between two corners is one straight edge or one smooth curve, in however many pieces it is drawn.
"""

from dataclasses import dataclass

import numpy as np

from cutgap.instances.arrays import Floats
from cutgap.instances.formats.drawings.chaining import Chain
from cutgap.instances.formats.drawings.curves import Element

SMOOTH = float(np.radians(1.0))
"""Largest turn in rad that still counts as going on smoothly."""


@dataclass(frozen=True, slots=True)
class Outline:
    """A closed contour as drawn.

    Parameters
    ----------
    points
        Shape (k, 2), mm: closed polyline, first point not repeated.
    corners
        Indices of points, ascending.
    curved
        Whether the section after each corner is a curve; one entry for the whole when there is no corner.
    perimeter
        True length, mm.
    layer, place
        Where it stands in the drawing.
    """

    points: Floats
    corners: tuple[int, ...]
    curved: tuple[bool, ...]
    perimeter: float
    layer: str
    place: str


def outline(loop: Chain) -> Outline:
    """Return the outline of a closed loop; where ends meet with a gap, the middle of it becomes the point.

    The perimeter is the sum of the elements' lengths as drawn, without such gaps.
    """
    elements = [element for strand in loop.strands for element in strand.elements]
    starts = [(last.points[-1] + first.points[0]) / 2 for last, first in _joints(elements)]
    rows = [np.vstack((start, element.points[1:-1])) for start, element in zip(starts, elements, strict=True)]
    first_point = np.cumsum([0, *map(len, rows[:-1])])
    is_corner = np.array([_is_corner(last, first) for last, first in _joints(elements)])
    corners = first_point[is_corner]
    sections = np.flatnonzero(is_corner) if is_corner.any() else [0]
    return Outline(
        points=np.concatenate(rows),
        corners=tuple(corners.tolist()),
        curved=tuple(elements[section].curved for section in sections),
        perimeter=float(sum(element.length for element in elements)),
        layer=loop.strands[0].layer,
        place=place_of(loop),
    )


def place_of(chain: Chain) -> str:
    """Return where a chain stands, for people: layer, first and last entity."""
    places = list(dict.fromkeys(strand.place for strand in chain.strands))
    names = places[0] if len(places) == 1 else f"{places[0]} to {places[-1]}"
    pieces = f" ({len(places)} pieces)" if len(places) > 2 else ""
    return f"layer {chain.strands[0].layer!r}, {names}{pieces}"


def _joints(elements: list[Element]) -> list[tuple[Element, Element]]:
    """Return each element with the one before it, as (before, element)."""
    return list(zip([elements[-1], *elements[:-1]], elements, strict=True))


def _is_corner(before: Element, after: Element) -> bool:
    if before.curved != after.curved:
        return True
    turn = np.arctan2(
        _cross(before.directions[1], after.directions[0]), before.directions[1] @ after.directions[0]
    )
    return bool(abs(turn) > SMOOTH)


def _cross(a: Floats, b: Floats) -> float:
    return float(a[0] * b[1] - a[1] * b[0])
