"""A nest of 28 sheet-metal parts, standing in for the one of Li et al. (2019), whose drawing is not published.

Their table gives, for 26 types of parts, number of pieces, perimeter and bounding box, on a sheet of 3000 x
1800 mm. Every part here has exactly that box, and the perimeters of its rings add up to the printed figure,
itself rounded to the millimetre, within 0.01 mm; its curves, which are polylines, within 0.05 %. Shapes, holes
and places on the sheet are drawn: parts whose perimeter is well above that of their box get windows, holes or a
notch, the others cut or rounded corners. Every nest has 28 outlines and 19 inner rings. The head's home is the
sheet's corner (0, 0, 0).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.generate.holes import DECIMALS
from cutgap.instances.generate.packing import pack
from cutgap.instances.generate.rings import Ring
from cutgap.instances.generate.sheet_parts import (
    Draft,
    arrow,
    bracket,
    chamfered,
    clevis,
    drilled,
    fitted,
    flange,
    gusset,
    panel,
    plain,
    rounded,
    slanted,
    strap,
    tongue,
    trapezoid,
)
from cutgap.instances.instance import Contour, Head, Instance
from cutgap.instances.process import Bools

SHEET = (3000, 1800)
MARGIN = 10
"""Between parts and the edge of the sheet, mm."""

WEB = 10
"""Between the boxes of parts, mm."""

CONTOURS = 47
OUTLINE_ENTRIES, LARGE_RING_ENTRIES, RING_ENTRIES = 11, 8, 4
"""Feature points of outlines, of inner rings from ``LARGE_RING`` mm on, and of others; joints may be more."""

LARGE_RING = 300.0

Shape = Callable[[float, float, np.random.Generator], Draft]

SIMPLE: tuple[Shape, ...] = tuple(
    plain(outline) for outline in (rounded, chamfered, trapezoid, gusset, arrow, slanted, tongue, bracket)
)


class Type(NamedTuple):
    """A row of the published table: pieces, perimeter in m, box in mm; and the shapes it may take."""

    pieces: int
    perimeter_m: float
    width: int
    height: int
    shapes: tuple[Shape, ...] = SIMPLE


TYPES: tuple[Type, ...] = (
    Type(1, 0.867, 314, 181),
    Type(1, 0.865, 317, 144),
    Type(1, 0.748, 280, 120),
    Type(1, 1.114, 337, 315),
    Type(1, 3.217, 575, 575, (flange,)),
    Type(1, 2.06, 756, 205, (strap,)),
    Type(2, 0.688, 280, 104),
    Type(1, 0.918, 280, 205),
    Type(1, 0.929, 303, 191),
    Type(1, 1.113, 313, 303),
    Type(1, 1.055, 386, 201),
    Type(1, 1.123, 335, 281),
    Type(1, 1.138, 315, 280),
    Type(1, 1.42, 348, 400, (drilled(rounded, 1), drilled(chamfered, 1), drilled(tongue, 1))),
    Type(1, 1.361, 369, 353),
    Type(1, 1.395, 353, 370),
    Type(1, 1.482, 494, 280),
    Type(1, 3.571, 1122, 430, (clevis,)),
    Type(2, 1.279, 573, 92),
    Type(1, 1.516, 520, 309),
    Type(1, 1.457, 378, 416),
    Type(1, 1.981, 665, 352, (drilled(rounded, 2), drilled(chamfered, 2), drilled(tongue, 2))),
    Type(1, 3.231, 1010, 350, (panel,)),
    Type(1, 4.032, 1130, 630, (panel,)),
    Type(1, 1.344, 359, 313, (drilled(rounded, 1), drilled(chamfered, 1), drilled(arrow, 1))),
    Type(1, 1.37, 424, 295),
)
"""Table 1 of Li et al. (2019), in its order."""


class Piece(NamedTuple):
    """A part with its rings, outline first, in a box that begins at (0, 0)."""

    name: str
    rings: list[Ring]
    box: tuple[int, int]


def nest28(rng: np.random.Generator) -> Instance:
    """Return the nest; ``rng`` decides shapes, holes, mirror images and places."""
    pieces = draw_pieces(rng)
    boxes = np.array([piece.box for piece in pieces])
    room = (SHEET[0] - 2 * MARGIN + WEB, SHEET[1] - 2 * MARGIN + WEB)
    places, turned = pack(boxes + WEB, room, rng)
    contours: list[Contour] = []
    precedence: list[tuple[int, int]] = []
    for piece, place, turn in zip(pieces, places + MARGIN, turned, strict=True):
        outline = len(contours) + len(piece.rings) - 1
        precedence += [(inner, outline) for inner in range(len(contours), outline)]
        motion = Motion(piece.box, rng.random(2) < 0.5, bool(turn), place)
        contours += [contour(piece, number, motion) for number in (*range(1, len(piece.rings)), 0)]
    return Instance("nest28", tuple(contours), (Head("head", np.zeros(3)),), precedence=tuple(precedence))


def draw_pieces(rng: np.random.Generator) -> list[Piece]:
    """Return the 28 pieces; pieces of one type are equal."""
    pieces = []
    for number, kind in enumerate(TYPES, 1):
        rings = draw_rings(kind, rng)
        for letter in "ab"[: kind.pieces] if kind.pieces > 1 else [""]:
            pieces.append(Piece(f"{number}{letter}", rings, (kind.width, kind.height)))
    return pieces


def draw_rings(kind: Type, rng: np.random.Generator) -> list[Ring]:
    """Return rings of the printed perimeter, in a shape drawn from those that can have it."""
    while True:
        shape = kind.shapes[int(rng.integers(len(kind.shapes)))]
        rings = fitted(shape(kind.width, kind.height, rng), 1000.0 * kind.perimeter_m)
        if rings is not None:
            return rings


class Motion(NamedTuple):
    """From a box at (0, 0) to its place: perhaps mirrored in x or y, perhaps turned by 90 degrees, moved."""

    box: tuple[int, int]
    mirrored: Bools
    turned: bool
    place: Ints

    def __call__(self, points: Floats) -> Floats:
        """Return the points, shape (k, 2), in their place, rounded to whole micrometres."""
        moved = np.where(self.mirrored, np.array(self.box) - points, points)
        if self.turned:
            moved = np.column_stack([self.box[1] - moved[:, 1], moved[:, 0]])
        return np.round(moved + self.place, DECIMALS)


def contour(piece: Piece, number: int, motion: Motion) -> Contour:
    """Return ring ``number`` of a piece in its place."""
    ring = piece.rings[number]
    if number == 0:
        name, entries = f"{piece.name}-outline", OUTLINE_ENTRIES
    else:
        name, entries = f"{piece.name}-ring{number}", RING_ENTRIES
        if ring.length >= LARGE_RING:
            entries = LARGE_RING_ENTRIES
    points, features = ring.polyline(entries)
    curve = motion(points)
    return Contour(
        name,
        np.column_stack([curve[features], np.zeros(len(features))]),
        round(ring.length, DECIMALS),
        part=piece.name,
        ring="inner" if number else "outer",
        geometry=curve,
    )
