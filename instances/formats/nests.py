"""Nests as JSON: ``{"name": ..., "strip": [[x, y], ...], "parts": [{"item": ..., "contour": [...]}, ...]}``.

Such files come from packing records: their lengths have no unit, and are read as mm whatever the parts were.
A contour is the list of corners [x, y] of a part's outline, its first one repeated at the end or not. Contours
are numbered from 1 in the file's order; the part of contour 7, of item 3, is called ``3-7``. The strip is
not cut. Entry points are the corners (``--link-points`` takes places for links instead).

The machine is ``FLAME`` unless figures are given. Homes are given on reading.
"""

from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from cutgap.instances.arrays import closed_length
from cutgap.instances.formats.json_models import Name, Point2
from cutgap.instances.formats.json_text import fit
from cutgap.instances.formats.options import MachineOptions
from cutgap.instances.instance import FLAME, Contour, Instance

_Curve = Annotated[list[Point2], Field(min_length=3, fail_fast=True)]


class _Part(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    item: int
    contour: _Curve


class _Nest(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    name: Name
    strip: _Curve
    parts: Annotated[list[_Part], Field(fail_fast=True)]


def recognises(document: Any) -> bool:
    """Whether the content of a JSON file is meant as a nest."""
    return isinstance(document, dict) and "parts" in document and "format" not in document


def parse_document(document: Any, name: str, options: MachineOptions) -> Instance:
    """Return the instance in a nest; errors are ``ValueError`` naming field path and value."""
    nest = fit(document, _Nest)
    contours = tuple(_contour(part, number) for number, part in enumerate(nest.parts))
    return Instance(nest.name, contours, options.heads(), options.machine(FLAME))


def _contour(part: _Part, number: int) -> Contour:
    place = f"parts[{number}].contour"
    points = part.contour[:-1] if part.contour[0] == part.contour[-1] else part.contour
    for corner, point in enumerate(points):
        if point == points[corner - 1]:
            raise ValueError(f"{place}[{corner}]: {point} repeats the point before it; remove one of them")
    if len(points) < 3:
        raise ValueError(
            f"{place}: expected at least 3 different points, got {len(points)}; complete or remove it"
        )
    curve = np.array(points)
    corners = np.column_stack((curve, np.zeros(len(curve))))
    return Contour(
        str(number + 1), corners, closed_length(curve), f"{part.item}-{number + 1}", "outer", geometry=curve
    )
