"""Outlines become parts: nesting by containment gives rings and precedence.

    depth 0   outer outline of a part
    depth 1   inner ring of the part around it
    depth 2   outer outline of another part, which lies in that hole; and so on

Each contour directly inside another one is cut before it. Parts are numbered in the order of the drawing; the
outline of part 3 is the contour ``3``, its inner rings are ``3.1``, ``3.2``, ...
"""

from dataclasses import dataclass

import numpy as np

from cutgap.instances.formats.drawings.entry_points import with_entry_points
from cutgap.instances.formats.drawings.outlines import Outline
from cutgap.instances.formats.options import MachineOptions
from cutgap.instances.instance import Contour, Head, Instance
from cutgap.instances.nesting import enclosures


@dataclass(frozen=True, slots=True)
class _Role:
    """Of an outline: its part, whether it is an inner ring, and the outline that it is directly within."""

    part: int
    inner: bool
    within: int | None


def sheet_note(outlines: list[Outline]) -> list[str]:
    """Return a note when one outline encloses all others and is alone on its layer: it may be the sheet."""
    around = enclosures([outline.points for outline in outlines])
    outermost = [number for number, enclosing in enumerate(around) if not enclosing]
    layer = outlines[outermost[0]].layer
    others = dict.fromkeys(outline.layer for number, outline in enumerate(outlines) if number != outermost[0])
    if len(outermost) > 1 or not others or layer in others:
        return []
    return [
        f"one contour on layer {layer!r} encloses all others; if it is the sheet, leave its layer out: "
        f"--layers {','.join(others):.200}"
    ]


def instance_of(outlines: list[Outline], name: str, options: MachineOptions) -> Instance:
    """Return the instance of a plate, part by part, each outline followed by its inner rings."""
    roles = _roles(outlines)
    order = sorted(range(len(outlines)), key=lambda number: (roles[number].part, roles[number].inner, number))
    place = {number: index for index, number in enumerate(order)}
    contours, ring, part = [], 0, 0
    for number in order:
        role = roles[number]
        ring = ring + 1 if role.part == part else 0
        part = role.part
        contours.append(_contour(outlines[number], role, ring, options.drawing.entries))
    pairs = [
        (place[number], place[role.within]) for number, role in enumerate(roles) if role.within is not None
    ]
    heads = options.heads() if options.homes else (Head("head"),)
    return Instance(name, tuple(contours), heads, options.machine(), precedence=tuple(sorted(pairs)))


def _roles(outlines: list[Outline]) -> list[_Role]:
    around = enclosures([outline.points for outline in outlines])
    parts: dict[int, int] = {}
    for number, enclosing in enumerate(around):
        if len(enclosing) % 2 == 0:
            parts[number] = len(parts) + 1
    roles = []
    for number, enclosing in enumerate(around):
        within = enclosing[0] if enclosing else None
        inner = len(enclosing) % 2 == 1
        roles.append(_Role(parts[enclosing[0]] if inner else parts[number], inner, within))
    return roles


def _contour(outline: Outline, role: _Role, ring: int, entries: int | None) -> Contour:
    geometry, places = with_entry_points(outline, entries)
    return Contour(
        id=f"{role.part}.{ring}" if role.inner else str(role.part),
        entry_points=np.column_stack((places, np.zeros(len(places)))),
        perimeter=outline.perimeter,
        part=str(role.part),
        ring="inner" if role.inner else "outer",
        geometry=geometry,
    )
