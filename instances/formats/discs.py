"""Lists of discs ``x y z r`` (mm), separated by blanks or tabs, with ``//`` comments.

The format of close-enough TSP instances (Mennell, 2009) and of measured car-door points. Each disc becomes a
hole with its centre as entry point and perimeter 2 pi r. A fifth column (the demand of a customer in vehicle
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

_NUMBER = r"\s*([-+.0-9eE]+)\s*"
_DEPOT = re.compile(rf"\s*depot\s*(?:is|:){_NUMBER},{_NUMBER},{_NUMBER}", re.IGNORECASE)


def parse_instance(text: str, name: str, options: MachineOptions) -> Instance:
    """Return the instance in a list of discs, holes numbered from 1; errors name line, column and value."""
    contours: list[Contour] = []
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
        contours.append(_disc(str(len(contours) + 1), line, cells))
    if not contours:
        raise ValueError("no disc found; expected lines x y z r")
    if depot is not None and not options.homes:
        options = replace(options, homes=(depot,))
    return Instance(name, tuple(contours), options.heads(), options.machine())


def _disc(name: str, line: int, cells: list[str]) -> Contour:
    columns = ("x", "y", "z", "r", "demand")
    x, y, z, radius, *_ = (
        parse_number(cell, f"line {line}, column {column}", least=0.0 if column == "r" else None)
        for column, cell in zip(columns, cells, strict=False)
    )
    return Contour(name, np.array([[x, y, z]]), math.tau * radius)
