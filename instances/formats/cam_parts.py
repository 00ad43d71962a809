"""Nested parts of a CAM system as JSON: ``[{"partid": ..., "paths": [[[x, y, bulge], ...], ...]}, ...]``, mm.

A path is a closed polyline whose last point repeats the first. A piece of it is straight when the bulge b of
its first point is 0, else an arc that turns by 4 atan(b), counter-clockwise for b > 0.

Contours are numbered from 1 through the file and take the points of their path as entry points. A path inside
another one is cut before it; inside a path of the same part it is an inner ring. Of parts with the same id the
second is called ``id-2``, and so on. A first part without holes around all the others is the sheet, which is
not cut. Homes and speeds are given on reading.

    (1) length of an arc = chord (1 + b^2) / (4 |b|) * 4 atan |b|            [mm]

Geometry follows arcs within ``FLATNESS``, by at most ``MOST_CHORDS``; perimeters are those of the arcs, by (1).
"""

import math
from collections import defaultdict
from collections.abc import Iterator
from itertools import count
from typing import Annotated, Any

import numpy as np
import shapely
from pydantic import BaseModel, ConfigDict, Field, RootModel

from cutgap.instances.arrays import Floats
from cutgap.instances.formats.json_models import Point3
from cutgap.instances.formats.json_text import fit
from cutgap.instances.formats.options import MachineOptions
from cutgap.instances.instance import Contour, Instance, Ring
from cutgap.instances.nesting import enclosures

FLATNESS = 0.05
"""Largest distance in mm of an arc from its polyline."""
MOST_CHORDS = 1000
"""Most chords of one arc."""
FARTHEST = 1e9
"""Largest coordinate that is read, mm, and largest bulge."""
STRAIGHT = 1e-9
"""Bulges up to this are straight: the arc leaves its chord by less than a nanometre per m."""


class _Part(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    partid: str
    paths: Annotated[
        list[Annotated[list[Point3], Field(min_length=3, fail_fast=True)]], Field(min_length=1, fail_fast=True)
    ]


class _Parts(RootModel[Annotated[list[_Part], Field(fail_fast=True)]]):
    pass


def recognises(document: Any) -> bool:
    """Whether the content of a JSON file is meant as a list of parts."""
    first = document[0] if isinstance(document, list) and document else None
    return isinstance(first, dict) and "partid" in first


def parse_document(document: Any, name: str, options: MachineOptions) -> Instance:
    """Return the instance in a list of parts; errors are ``ValueError`` naming part, path and value."""
    parts = fit(document, _Parts).root
    names = _unique([part.partid for part in parts])
    paths = [
        (title, np.array(path), f"part {title!r}, path {number}")
        for title, part in zip(names, parts, strict=True)
        for number, path in enumerate(part.paths, start=1)
    ]
    curves = [_curve(path, place) for _, path, place in paths]
    _refuse_overlaps(curves, [place for *_, place in paths])
    around = enclosures(curves)
    if len(parts[0].paths) == 1 and len(paths) > 1 and all(0 in each for each in around[1:]):
        paths, curves, around = paths[1:], curves[1:], [[k - 1 for k in each if k > 0] for each in around[1:]]
    contours = []
    for number, (title, path, _) in enumerate(paths):
        is_inner = any(paths[outer][0] == title for outer in around[number])
        points = np.column_stack([path[:-1, :2], np.zeros(len(path) - 1)])
        ring: Ring = "inner" if is_inner else "outer"
        contours.append(Contour(str(number + 1), points, _length(path), title, ring, curves[number]))
    pairs = tuple((inner, outers[0]) for inner, outers in enumerate(around) if outers)
    return Instance(name, tuple(contours), options.heads(), options.machine(), precedence=pairs)


def _refuse_overlaps(curves: list[Floats], places: list[str]) -> None:
    areas = shapely.polygons([shapely.linearrings(curve) for curve in curves])
    pairs = np.transpose(shapely.STRtree(areas).query(areas, "overlaps"))
    if len(pairs):
        a, b = sorted(pairs[0].tolist())
        raise ValueError(f"{places[a]} and {places[b]} cross each other; move one of them")


def _unique(names: list[str]) -> list[str]:
    """Number the names that appear again."""
    numbers: dict[str, Iterator[int]] = defaultdict(lambda: count(2))
    found: list[str] = []
    taken, seen = set(names), set()
    for name in names:
        title = name
        if name in seen:
            title = next(each for number in numbers[name] if (each := f"{name}-{number}") not in taken)
            taken.add(title)
        seen.add(name)
        found.append(title)
    return found


def _length(path: Floats) -> float:
    """Return the length of a path by (1), mm."""
    chords = np.hypot(*np.diff(path[:, :2], axis=0).T)
    bulges = np.abs(path[:-1, 2])
    factors = np.ones_like(bulges)
    bent = bulges > 0
    factors[bent] = (1 + bulges[bent] ** 2) * np.arctan(bulges[bent]) / bulges[bent]
    return float(chords @ factors)


def _curve(path: Floats, place: str) -> Floats:
    """Return the closed polyline of a path, shape (points, 2), mm, its first point not repeated."""
    if (np.abs(path) > FARTHEST).any():
        far = path.flat[np.abs(path).argmax()]
        raise ValueError(f"{place}: {far:g} is no coordinate in mm or bulge; expected up to {FARTHEST:g}")
    if (path[0, :2] != path[-1, :2]).any():
        (x, y, _), (u, v, _) = path[0].tolist(), path[-1].tolist()
        raise ValueError(f"{place}: open, from {x:g}, {y:g} to {u:g}, {v:g}; end it where it begins")
    pieces = [_piece(*path[i].tolist(), *path[i + 1, :2].tolist()) for i in range(len(path) - 1)]
    curve = np.concatenate(pieces)
    if len(curve) < 3 or not shapely.LinearRing(curve).is_simple:
        raise ValueError(f"{place}: touches or crosses itself; draw it as a simple closed curve")
    return curve


def _piece(x: float, y: float, bulge: float, u: float, v: float) -> Floats:
    """Return the points of one piece without its end: the first one, and some on the arc."""
    start, end = complex(x, y), complex(u, v)
    if abs(bulge) <= STRAIGHT or start == end:
        return np.array([[x, y]])
    turn = 4 * math.atan(bulge)
    centre = (start + end) / 2 + 1j * (end - start) * (1 - bulge * bulge) / (4 * bulge)
    sagitta = min(FLATNESS / abs(start - centre), 1 - math.cos(math.pi / 8))
    step = max(2 * math.acos(1 - sagitta), abs(turn) / MOST_CHORDS)
    steps = math.ceil(abs(turn) / step)
    on_arc = centre + (start - centre) * np.exp(1j * turn * np.arange(steps) / steps)
    on_arc[0] = start
    return np.column_stack([on_arc.real, on_arc.imag])
