"""Nests for flame cutting: irregular outlines with kerf gaps on a sheet, to be cut with few ignitions.

Boxes of 80 to 260 mm, 5 to 15 mm apart, are packed on a sheet of about 2 : 1, of which they fill nearly
``FILL``; each holds one part, in turn an L, a U, a convex and a concave polygon and a plate with rounded or
cut corners. Some polygons have rounded corners; arcs are polylines within 0.05 mm. Parts that do not fill their
box are farther apart than the boxes are. The home is the sheet's corner (0, 0, 0), and entry points are link
points (``links.points``).

The nest of 108 shapes of the reference (Chen, Li, Chu) is not published; this one stands in for it.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from cutgap.instances.arrays import Floats, Ints, closed_length
from cutgap.instances.generate.holes import DECIMALS
from cutgap.instances.generate.nest28 import Motion
from cutgap.instances.generate.packing import pack
from cutgap.instances.generate.rings import Point, Ring
from cutgap.instances.generate.sheet_parts import (
    bracket,
    chamfered,
    gusset,
    rounded,
    slanted,
    tongue,
    trapezoid,
)
from cutgap.instances.instance import FLAME, Contour, Head, Instance
from cutgap.instances.links.points import with_link_points

SHAPES = 108
SIDES = (80, 260)
GAPS = (5, 15)
MARGIN = 10
FILL = 0.82
"""Share of the sheet that the boxes take; more and the packing is hard to find."""

RADII = (0.0, 0.0, 6.0, 12.0)
"""Of the corners of polygons, where edges leave room."""

LINK_DECIMALS = 6
"""Of link points, mm: the same on every machine, and well within what ``clearance`` allows."""

PLATES = (rounded, chamfered, gusset, slanted, tongue, trapezoid)


def flame(shapes: int, rng: np.random.Generator) -> Instance:
    """Return a nest of so many shapes; ``rng`` decides shapes, mirror images and places."""
    sizes = rng.integers(SIDES[0], SIDES[1] + 1, (shapes, 2), dtype=np.int64)
    boxes: Ints = sizes + rng.integers(GAPS[0], GAPS[1] + 1, (shapes, 1))
    places, turned = _packed(boxes, rng)
    contours = []
    for number, (size, place, turn) in enumerate(zip(sizes.tolist(), places, turned, strict=True)):
        width, height = size
        ring = DRAWERS[number % len(DRAWERS)](width, height, rng)
        motion = Motion((width, height), rng.random(2) < 0.5, bool(turn), place + MARGIN)
        contours.append(_contour(str(number + 1), motion(ring.polyline(1)[0])))
    instance = with_link_points(
        Instance(f"flame-{shapes}", tuple(contours), (Head("head", np.zeros(3)),), FLAME)
    )
    rounded_off = (
        replace(contour, entry_points=np.round(contour.entry_points, LINK_DECIMALS))
        for contour in instance.contours
    )
    return replace(instance, contours=tuple(rounded_off))


def _packed(boxes: Ints, rng: np.random.Generator) -> tuple[Ints, Ints]:
    """Return places of boxes on a sheet of their size, and which are turned."""
    if not len(boxes):
        return np.empty((0, 2), dtype=np.int64), np.empty(0, dtype=np.int64)
    area = float(boxes.prod(axis=1).sum()) / FILL
    height = max(round(math.sqrt(area / 2)), int(boxes.max()))
    # Few boxes leave more waste at the end of the sheet.
    width = round(area / height) + int(boxes.max()) // 2
    return pack(boxes, (width, height), rng)


def _contour(name: str, curve: Floats) -> Contour:
    entry = np.append(curve[0], 0.0)[None]
    return Contour(name, entry, round(closed_length(curve), DECIMALS), name, "outer", geometry=curve)


def _plate(width: float, height: float, rng: np.random.Generator) -> Ring:
    """Return a plate with rounded, cut or slanted corners."""
    return PLATES[int(rng.integers(len(PLATES)))](width, height, rng)(rng.uniform(0.2, 0.9))


def _l_shape(width: float, height: float, rng: np.random.Generator) -> Ring:
    """Return an L with more or less rounded corners."""
    return bracket(width, height, rng)(rng.uniform(0.0, 0.6))


def _u_shape(width: float, height: float, rng: np.random.Generator) -> Ring:
    """Return a U, open above, with arms of different width."""
    left, right = width * rng.uniform(0.2, 0.35), width * rng.uniform(0.65, 0.8)
    floor = height * rng.uniform(0.25, 0.6)
    notch = ((right, height), (right, floor), (left, floor), (left, height))
    return softened(((0.0, 0.0), (width, 0.0), (width, height), *notch, (0.0, height)), rng)


def _convex(width: float, height: float, rng: np.random.Generator) -> Ring:
    """Return a polygon of 3 to 7 corners of an ellipse."""
    return _polygon(width, height, np.ones(int(rng.integers(3, 8))), rng)


def _concave(width: float, height: float, rng: np.random.Generator) -> Ring:
    """Return a polygon of 6 to 10 corners, every second one nearer to the middle."""
    corners = 2 * int(rng.integers(3, 6))
    reach = np.ones(corners)
    reach[::2] = rng.uniform(0.35, 0.65, corners // 2)
    return _polygon(width, height, reach, rng)


def _polygon(width: float, height: float, reach: Floats, rng: np.random.Generator) -> Ring:
    """Return a polygon around a middle, with corners at such distances from it, stretched to its box."""
    shares = rng.uniform(0.7, 1.3, len(reach))
    angles = rng.uniform(0.0, math.tau) + math.tau * np.cumsum(shares) / shares.sum()
    points = reach[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))
    points -= points.min(axis=0)
    points *= np.array([width, height]) / points.max(axis=0)
    return softened([(x, y) for x, y in points.tolist()], rng)


def softened(corners: Sequence[Point], rng: np.random.Generator) -> Ring:
    """Return a polygon with corners of one of ``RADII``, less where an arc would take half of an edge."""
    radius = float(rng.choice(RADII))
    points = np.array(corners)
    ahead = np.roll(points, -1, axis=0) - points
    lengths = np.hypot(*ahead.T)
    headings = np.arctan2(ahead[:, 1], ahead[:, 0])
    turns = np.abs(np.remainder(headings - np.roll(headings, 1) + math.pi, math.tau) - math.pi)
    room = 0.45 * np.minimum(lengths, np.roll(lengths, 1)) / np.tan(turns / 2)
    return Ring(tuple(corners), tuple(np.minimum(radius, room).tolist()))


DRAWERS: tuple[Callable[[float, float, np.random.Generator], Ring], ...] = (
    _l_shape,
    _u_shape,
    _convex,
    _concave,
    _plate,
)
