"""Random tiny sheets: polygons side by side and nested, with parts, rings, entry points and precedence.

A contour is drawn in a disc that is free; the discs inside of it are free for the next ones. A contour inside
of an outer ring is an inner ring of that part, one inside of an inner ring bounds a part in the window.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from cutgap.instances import Contour, Head, Instance, Machine
from cutgap.instances.arrays import Floats

Shape = Literal["polygons", "rectangles"]
CELL = 200.0
"""Side of the square that an outermost contour has for itself, mm."""

ROOM = 5.0
"""No contour is drawn in a disc of a smaller radius, mm."""


@dataclass(frozen=True)
class _Disc:
    x: float
    y: float
    radius: float
    around: int | None
    """The contour that this disc lies directly in."""


def random_sheet(
    rng: np.random.Generator,
    contours: int,
    *,
    entries: int = 3,
    heads: int = 1,
    homes: bool | None = True,
    shape: Shape | None = None,
    nested: float = 0.6,
    precedence: bool | None = None,
) -> Instance:
    """Draw a sheet.

    Parameters
    ----------
    entries
        Largest number of entry points of a contour, which are corners of it.
    homes
        Whether heads have homes; ``None`` draws it for each head.
    shape
        ``polygons`` of 3 to 6 corners, some concave, in general position; ``rectangles`` on whole
        coordinates, with edges in line and equal x. ``None`` draws one.
    nested
        Chance of each contour to lie in an earlier one, where there is room.
    precedence
        Whether each contour must be cut before the one that it lies in; ``None`` draws it.
    """
    shape = shape or ("polygons", "rectangles")[int(rng.integers(2))]
    # In one row each outline hides the next from the one before.
    columns = int(rng.choice([1, 3, max(1, contours)]))
    numbers = rng.permutation(contours)
    cells = [_Disc(CELL * (i % columns), CELL * (i // columns), CELL / 2, None) for i in numbers]
    free: list[_Disc] = []
    found: list[Contour] = []
    pairs: list[tuple[int, int]] = []
    for index in range(contours):
        inside = bool(free) and rng.random() < nested
        disc = free.pop(int(rng.integers(len(free)))) if inside else cells.pop()
        curve, room = _polygon(rng, disc) if shape == "polygons" else _rectangle(rng, disc)
        outside = None if disc.around is None else found[disc.around]
        found.append(_contour(rng, index, curve, outside, entries))
        if disc.around is not None:
            pairs.append((index, disc.around))
        if found[-1].ring != "hole" and room >= ROOM:
            free += _discs_in(rng, disc, room, index) if shape == "polygons" else [_within(disc, room, index)]
    if not (rng.random() < 0.5 if precedence is None else precedence):
        pairs = []
    machine = Machine(
        v_jump=float(rng.choice([50.0, 150.0])),
        t_aux=float(rng.choice([0.0, 1.0])),
        metric="euclidean" if rng.random() < 0.8 else "chebyshev",
    )
    stays = [rng.random() < 0.5 if homes is None else homes for _ in range(heads)]
    places = rng.uniform((-CELL, -CELL, 0), (3 * CELL, 3 * CELL, 0), (heads, 3))
    if shape == "rectangles":
        places = np.round(places, -1)
    return Instance(
        f"sheet of {shape}",
        tuple(found),
        tuple(Head(f"h{i}", places[i] if stays[i] else None) for i in range(heads)),
        machine,
        tuple(pairs),
    )


def _contour(
    rng: np.random.Generator, index: int, curve: Floats, outside: Contour | None, entries: int
) -> Contour:
    count = int(rng.integers(1, min(entries, len(curve)) + 1))
    corners = curve[rng.choice(len(curve), count, replace=False)]
    points = np.column_stack((corners, np.zeros(count)))
    perimeter = float(np.hypot(*(curve - np.roll(curve, 1, axis=0)).T).sum())
    if outside is not None and outside.ring == "outer":
        return Contour(f"c{index}", points, perimeter, outside.part, "inner", curve)
    if rng.random() < 0.2:
        return Contour(f"c{index}", points, perimeter, None, "hole", curve)
    return Contour(f"c{index}", points, perimeter, f"p{index}", "outer", curve)


def _polygon(rng: np.random.Generator, disc: _Disc) -> tuple[Floats, float]:
    """Return a polygon around the middle of a disc, and how far from the middle it stays."""
    corners = int(rng.integers(3, 7))
    # Less than half a turn from corner to corner, so that the middle is inside.
    angles = 2 * np.pi * (np.arange(corners) + rng.uniform(0, 0.4, corners) + rng.random()) / corners
    radii = disc.radius * rng.uniform(0.6, 0.98, corners)
    offsets = radii[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))
    nexts = np.roll(offsets, -1, axis=0)
    edges = nexts - offsets
    share = np.clip(-(offsets * edges).sum(axis=1) / (edges**2).sum(axis=1), 0, 1)
    room = float(np.hypot(*(offsets + share[:, None] * edges).T).min())
    return offsets + np.array((disc.x, disc.y)), room


def _rectangle(rng: np.random.Generator, disc: _Disc) -> tuple[Floats, float]:
    """Return a rectangle on whole coordinates around the middle of a disc, and its smaller half side."""
    half = disc.radius * 0.7
    width, height = (max(1.0, float(np.round(half * rng.choice([0.5, 0.75, 1.0])))) for _ in range(2))
    signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    return signs * (width, height) + np.array((disc.x, disc.y)), min(width, height)


def _within(disc: _Disc, room: float, around: int) -> _Disc:
    return _Disc(disc.x, disc.y, 0.9 * room, around)


def _discs_in(rng: np.random.Generator, disc: _Disc, room: float, around: int) -> list[_Disc]:
    """Return one or two discs in the disc of radius ``room``."""
    if rng.random() < 0.5:
        return [_within(disc, room, around)]
    angle = rng.uniform(0, np.pi)
    x, y = room / 2 * np.cos(angle), room / 2 * np.sin(angle)
    return [
        _Disc(disc.x + x, disc.y + y, 0.45 * room, around),
        _Disc(disc.x - x, disc.y - y, 0.45 * room, around),
    ]


def moved_sheet(instance: Instance, matrix: Floats, shift: Floats | tuple[float, float]) -> Instance:
    """Return the sheet with every point ``p`` of the plane at ``p @ matrix + shift``; perimeters stay."""

    def moved(points: Floats) -> Floats:
        return np.column_stack((points[:, :2] @ matrix + np.asarray(shift), points[:, 2:]))

    contours = tuple(
        replace(
            contour,
            entry_points=moved(contour.entry_points),
            geometry=None if contour.geometry is None else moved(contour.geometry),
        )
        for contour in instance.contours
    )
    heads = tuple(
        replace(head, home=None if head.home is None else moved(head.home[None])[0]) for head in instance.heads
    )
    return replace(instance, contours=contours, heads=heads)
