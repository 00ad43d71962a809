"""Routing tasks of a CAM system as JSON: ``{"TaskData": {...}, "Contours": [...]}``, mm and s.

A contour lists the points at which it may be pierced, and holds the contours that lie directly inside it as
``NestedContours``: these are cut before it. Contours at even depth are outlines of parts, those at odd depth
their inner rings; a part is named after its outline. Contours are ordered by the file's ``Index``, which is
their id. Speeds, the time per pierce and the home of the single head are the file's.

The curves are not in the file, and a polygon through the few points would cross others. So contours have no
geometry, and the perimeter is the length of the closed polygon through the points: at most the true one, by 5 %
less for 6 points on a circle, and 0 for a single point. The points follow the contour.

A head returns to where it started. A file that asks for something else (no return, or another finish) is
refused, unless a home is given in its place; pierce points off the contour are refused too.
"""

from collections.abc import Iterator
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from cutgap.instances.arrays import closed_length
from cutgap.instances.formats.json_models import Length, Number, Positive
from cutgap.instances.formats.json_text import fit
from cutgap.instances.formats.options import MachineOptions
from cutgap.instances.instance import Contour, Head, Instance, Machine


class _Model(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


class _Task(_Model):
    StartX: Number
    StartY: Number
    FinishX: Number
    FinishY: Number
    TerminalMotion: bool
    ToolIdlingSpeed: Positive
    ToolCutSpeed: Positive
    PiercingDuration: Length
    SheetMinX: Number = 0.0
    SheetMaxX: Number = 0.0
    SheetMinY: Number = 0.0
    SheetMaxY: Number = 0.0


class _Point(_Model):
    X: Number
    Y: Number
    Index: int | None = None
    ZeroBasedIndex: int | None = None
    GlobalIndex: int | None = None
    ZeroBasedGlobalIndex: int | None = None
    UseCircuitAndFinishCutPoint: bool = False
    CircuitPointX: Number | None = None
    CircuitPointY: Number | None = None
    FinishCutX: Number | None = None
    FinishCutY: Number | None = None


class _Contour(_Model):
    Index: int
    ZeroBasedIndex: int | None = None
    Points: Annotated[list[_Point], Field(min_length=1, fail_fast=True)]
    NestedContours: Annotated[list["_Contour"], Field(fail_fast=True)] = []


class _Routing(_Model):
    TaskData: _Task
    Contours: Annotated[list[_Contour], Field(fail_fast=True)]


def recognises(document: Any) -> bool:
    """Whether the content of a JSON file is meant as a routing task."""
    return isinstance(document, dict) and "TaskData" in document


def parse_document(document: Any, name: str, options: MachineOptions) -> Instance:
    """Return the instance in a routing task; errors are ``ValueError`` naming field path and value."""
    model = fit(document, _Routing)
    task = model.TaskData
    found = sorted(_walk(model.Contours, None, 0), key=lambda each: each[0].Index)
    index: dict[int, int] = {}
    for number, (contour, _, _) in enumerate(found):
        if contour.Index in index:
            raise ValueError(f"Contours: the Index {contour.Index} appears more than once; number them anew")
        index[contour.Index] = number
    return Instance(
        name=name,
        contours=tuple(_cut(contour, outer, depth) for contour, outer, depth in found),
        heads=options.heads() if options.homes else (_head(task),),
        machine=options.machine(Machine(task.ToolIdlingSpeed, task.ToolCutSpeed, task.PiercingDuration)),
        precedence=tuple(
            (number, index[outer.Index]) for number, (_, outer, _) in enumerate(found) if outer is not None
        ),
    )


def _walk(
    contours: list[_Contour], outer: _Contour | None, depth: int
) -> Iterator[tuple[_Contour, _Contour | None, int]]:
    """Yield each contour, the one directly around it, and how many are around it."""
    for contour in contours:
        yield contour, outer, depth
        yield from _walk(contour.NestedContours, contour, depth + 1)


def _head(task: _Task) -> Head:
    mend = "give --home X,Y to plan a head that returns there"
    if not task.TerminalMotion:
        raise ValueError(f"TaskData.TerminalMotion: false, but a head here returns to its start; {mend}")
    start, finish = (task.StartX, task.StartY), (task.FinishX, task.FinishY)
    if start != finish:
        raise ValueError(
            f"TaskData.FinishX, FinishY: {finish[0]:g}, {finish[1]:g} is not the start "
            f"{start[0]:g}, {start[1]:g}, to which a head here returns; {mend}"
        )
    return Head("head", np.array([*start, 0.0]))


def _cut(contour: _Contour, outer: _Contour | None, depth: int) -> Contour:
    for number, point in enumerate(contour.Points, start=1):
        if point.UseCircuitAndFinishCutPoint:
            raise ValueError(
                f"contour {contour.Index}, point {number}, UseCircuitAndFinishCutPoint: true, but cutting here "
                "starts and ends at the point of piercing; export the points on the contour"
            )
    points = np.array([(point.X, point.Y, 0.0) for point in contour.Points])
    perimeter = closed_length(points)
    if outer is not None and depth % 2 == 1:
        return Contour(str(contour.Index), points, perimeter, str(outer.Index), "inner")
    return Contour(str(contour.Index), points, perimeter, str(contour.Index), "outer")
