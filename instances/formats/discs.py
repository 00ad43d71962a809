"""Lists of discs ``x y z r`` (mm), separated by blanks or tabs, with ``//`` comments.

The format of close-enough TSP instances (Mennell, 2009) and of measured car-door points. Each disc becomes a
hole with its centre as entry point, perimeter 2 pi r, and as region the ball around the centre; where discs and
homes are all at one height, the disc at that height. A fifth column (the demand of a customer in vehicle
routing) says nothing about cutting: it must be a number and is not used. A depot stands in a comment,
``//Depot is 100, 100, 0`` or ``//Depot: 0, 0, 0``; it is the home of a single head unless homes are given.
"""

import math
import re
from dataclasses import replace

import numpy as np

from cutgap.instances.formats.numbers import parse_number
from cutgap.instances.formats.options import MachineOptions
from cutgap.instances.instance import Contour, Instance
from cutgap.instances.region import Ellipsoid

_NUMBER = r"\s*([-+.0-9eE]+)\s*"
_DEPOT = re.compile(rf"\s*depot\s*(?:is|:){_NUMBER},{_NUMBER},{_NUMBER}", re.IGNORECASE)


def parse_instance(text: str, name: str, options: MachineOptions) -> Instance:
    """Return the instance in a list of discs, holes numbered from 1; errors name line, column and value."""
    discs: list[list[float]] = []
    depot: tuple[float, ...] | None = None
    width = 0
    for line, row in enumerate(text.splitlines(), start=1):
        data, _, comment = row.partition("//")
        if found := _DEPOT.fullmatch(comment):
            depot = tuple(parse_number(part, f"line {line}, depot") for part in found.groups())
        cells = data.split()
        if not cells:
            continue
        width = width or len(cells)
        if len(cells) != width or width not in (4, 5):
            asked = width if width in (4, 5) else "4 (x y z r) or 5 (x y z r demand)"
            raise ValueError(f"line {line}: expected {asked} columns, got {len(cells)}")
        discs.append(_numbers(line, cells))
    if not discs:
        raise ValueError("no disc found; expected lines x y z r")
    if depot is not None and not options.homes:
        options = replace(options, homes=(depot,))
    heights = {disc[2] for disc in discs} | {home[2] for home in options.homes}
    axes = 2 if len(heights) == 1 else 3
    contours = tuple(_disc(str(number), disc, axes) for number, disc in enumerate(discs, start=1))
    return Instance(name, contours, options.heads(), options.machine())


def _numbers(line: int, cells: list[str]) -> list[float]:
    columns = ("x", "y", "z", "r", "demand")
    return [
        parse_number(cell, f"line {line}, column {column}", least=0.0 if column == "r" else None)
        for column, cell in zip(columns, cells, strict=False)
    ]


def _disc(name: str, disc: list[float], axes: int) -> Contour:
    centre, radius = np.array(disc[:3]), disc[3]
    region = Ellipsoid(centre, radius * np.eye(3)[:axes]) if radius > 0 else None
    return Contour(name, centre[None], math.tau * radius, region=region)
