"""The curves of a DXF file: what its model space shows, in mm.

LINE, ARC, CIRCLE, ELLIPSE, LWPOLYLINE, POLYLINE (2D and 3D) and SPLINE count, also within block references
(INSERT), which may be scaled, rotated, nested and arrays. All other entities, and what is on layers that are
frozen or off, are left out with a note. An entity on layer 0 of a block lies on the layer of the reference.

Units are those of the header; without, numbers are taken as mm. Curves must lie parallel to the xy plane.
"""

import io
from collections import Counter
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from ezdxf import recover, units
from ezdxf.document import Drawing
from ezdxf.enums import InsertUnits
from ezdxf.lldxf.tagger import binary_tags_loader

from cutgap.instances.arrays import Floats
from cutgap.instances.formats.drawings import curves
from cutgap.instances.formats.drawings.curves import Element, Strand
from cutgap.instances.formats.options import DrawingOptions

DEEPEST = 64
"""Depth of block references; deeper ones contain themselves."""
MOST_STRANDS = 500_000
Entity = Any
"""An entity of ezdxf; its attributes depend on its kind."""

BINARY_MARK = b"AutoCAD Binary DXF"


def strands_of(content: bytes, options: DrawingOptions) -> tuple[list[Strand], list[str]]:
    """Return the curves of a DXF file in its order, and notes on what was taken for granted or left out.

    Raises
    ------
    ValueError
        When the file is damaged, a layer is asked for that it does not have, or a curve is not flat.
    """
    document, notes = _document(content)
    scale, unit_notes = _scale(document)
    reader = _Reader(document, options, scale)
    for entity in document.modelspace():
        reader.visit(entity, None, "")
    return reader.strands, [*notes, *unit_notes, *reader.notes()]


def _document(content: bytes) -> tuple[Drawing, list[str]]:
    is_binary = content.startswith(BINARY_MARK)
    if not content.rstrip().endswith(b"EOF\0" if is_binary else b"\nEOF"):
        raise ValueError("not a complete DXF file: it does not end with EOF; save or copy it again")
    if is_binary:
        return Drawing.load(binary_tags_loader(content)), []
    document, audit = recover.read(io.BytesIO(content))
    if audit.has_errors:
        found = "; ".join(error.message for error in audit.errors[:3])
        raise ValueError(f"damaged DXF: {found:.300}; open and save it with a CAD program")
    if not audit.fixes:
        return document, []
    found = "; ".join(fix.message for fix in audit.fixes[:3])
    return document, [f"{len(audit.fixes)} flaws of the file were mended on reading: {found:.300}"]


def _scale(document: Drawing) -> tuple[float, list[str]]:
    """Return mm per unit of the drawing."""
    code = document.header.get("$INSUNITS", 0)
    if not code:
        return 1.0, ["the drawing has no units: its numbers are taken as mm"]
    try:
        return units.conversion_factor(InsertUnits(code), InsertUnits.Millimeters), []
    except (ValueError, TypeError, IndexError):
        raise ValueError(f"header, $INSUNITS: unknown unit {code}") from None


class _Reader:
    """Collects strands; blocks are read where they are placed."""

    def __init__(self, document: Drawing, options: DrawingOptions, scale: float) -> None:
        self.strands: list[Strand] = []
        self._chord, self._tolerance, self._scale = options.chord, options.tolerance, scale
        self._ignored: Counter[str] = Counter()
        self._hidden: Counter[str] = Counter()
        self._table = {layer.dxf.name.casefold(): layer for layer in document.layers}
        self._asked = {name.casefold(): name for name in options.layers}
        self._met: dict[str, str] = {}

    def notes(self) -> list[str]:
        """Return notes on what was left out.

        Raises
        ------
        ValueError
            When a layer that was asked for does not exist.
        """
        known = {**{key: layer.dxf.name for key, layer in self._table.items()}, **self._met}
        unknown = [name for key, name in self._asked.items() if key not in known]
        if unknown:
            raise ValueError(
                f"--layers: no layer {unknown[0]!r}; the drawing has {', '.join(sorted(known.values())):.500}"
            )
        notes = []
        if self._ignored:
            notes.append(f"entities that are no contours are left out: {_counted(self._ignored)}")
        if self._hidden:
            hidden = _counted(self._hidden)
            notes.append(
                f"entities that are invisible, or on layers that are frozen or off, are left out: {hidden}"
            )
        return notes

    def visit(self, entity: Entity, outer_layer: str | None, within: str, depth: int = 0) -> None:
        """Collect an entity, or what a block reference shows."""
        kind = entity.dxftype()
        if kind not in _ELEMENTS and kind != "INSERT":
            self._ignored[kind] += 1
            return
        own = entity.dxf.get("layer", "0")
        layer = outer_layer if outer_layer is not None and own == "0" else own
        if entity.dxf.get("invisible", 0):
            self._hidden[layer] += 1
            return
        if kind == "INSERT":
            self._visit_block(entity, layer, within, depth)
            return
        self._met.setdefault(layer.casefold(), layer)
        if self._asked and layer.casefold() not in self._asked:
            return
        if self._is_hidden(layer):
            self._hidden[layer] += 1
        else:
            self._add(entity, kind, layer, f"{kind} {_handle(entity)}{within}")

    def _is_hidden(self, layer: str) -> bool:
        """Whether a layer is frozen or off; one that is asked for by name is read nevertheless."""
        entry = self._table.get(layer.casefold())
        return entry is not None and not self._asked and (entry.is_frozen() or entry.is_off())

    def _visit_block(self, insert: Entity, layer: str, within: str, depth: int) -> None:
        if depth >= DEEPEST:
            raise ValueError(
                f"block {insert.dxf.name!r}: references nested deeper than {DEEPEST}; does it contain itself?"
            )
        entry = self._table.get(layer.casefold())
        if entry is not None and entry.is_frozen() and not self._asked:
            self._hidden[layer] += 1
            return
        inner = f" in block {insert.dxf.name!r} of INSERT {_handle(insert)}{within}"
        for each in insert.multi_insert() if insert.mcount > 1 else (insert,):
            for entity in each.virtual_entities(skipped_entity_callback=self._skipped):
                self.visit(entity, layer, inner, depth + 1)

    def _skipped(self, entity: Entity, reason: str) -> None:
        if entity.dxftype() in (*_ELEMENTS, "INSERT"):
            raise ValueError(
                f"{entity.dxftype()} {_handle(entity)}: cannot be placed by its block reference: {reason}"
            )
        self._ignored[entity.dxftype()] += 1

    def _add(self, entity: Entity, kind: str, layer: str, place: str) -> None:
        if len(self.strands) >= MOST_STRANDS:
            raise ValueError(f"more than {MOST_STRANDS} curves; split the drawing")
        missing = [name for name in _REQUIRED.get(kind, ()) if not entity.dxf.hasattr(name)]
        if missing:
            raise ValueError(f"layer {layer!r}, {place}: has no {missing[0]}; draw it again")
        try:
            elements = _ELEMENTS[kind](entity, _Frame(entity, self._scale, self._tolerance), self._chord)
        except _NotACurveError:
            self._ignored[kind] += 1
            return
        except ValueError as error:
            raise ValueError(f"layer {layer!r}, {place}: {error}") from error
        if elements:
            self.strands.append(Strand(tuple(elements), layer, place))


class _NotACurveError(Exception):
    """A mesh that DXF stores as a polyline."""


class _Frame:
    """Takes an entity's coordinates to mm in the plane, and refuses what is not flat."""

    def __init__(self, entity: Entity, scale: float, tolerance: float) -> None:
        x, y, z = entity.dxf.get("extrusion", (0, 0, 1))
        self._scale, self._tolerance = scale, tolerance
        self.flat = abs(x) + abs(y) <= 1e-9 * abs(z)
        # Seen from below, x runs the other way.
        self.side = -1.0 if z < 0 else 1.0

    def plane(self, points: Iterable[Iterable[float]]) -> Floats:
        """Return world points of shape (k, 3) as (k, 2)."""
        rows = np.array([tuple(point) for point in points], dtype=np.float64).reshape(-1, 3) * self._scale
        _require_finite(rows)
        if len(rows) and np.ptp(rows[:, 2]) > self._tolerance:
            raise ValueError("is not flat: its z changes; flatten the drawing")
        return rows[:, :2]

    def entity_plane(self, points: Iterable[Iterable[float]]) -> Floats:
        """Return points in the entity's own coordinates, shape (k, 2 or more), as (k, 2)."""
        if not self.flat:
            raise ValueError("is not parallel to the xy plane; flatten the drawing")
        rows = np.array([tuple(point)[:2] for point in points], dtype=np.float64).reshape(-1, 2)
        _require_finite(rows)
        return rows * (self._scale * self.side, self._scale)


def _require_finite(rows: Floats) -> None:
    if not (np.abs(rows) <= 1e9).all():
        raise ValueError(f"has a coordinate of {rows.flat[np.abs(rows).argmax()]:g} mm; the most is 1e9")


def _line(entity: Entity, frame: _Frame, chord: float) -> list[Element]:
    return curves.polygon_line(frame.plane((entity.dxf.start, entity.dxf.end)))


def _circle(entity: Entity, frame: _Frame, chord: float) -> list[Element]:
    return _circular(entity, frame, 0.0, 2 * np.pi, chord)


def _arc(entity: Entity, frame: _Frame, chord: float) -> list[Element]:
    start, end = np.radians(entity.dxf.start_angle), np.radians(entity.dxf.end_angle)
    sweep = (end - start) % (2 * np.pi)
    return _circular(entity, frame, start, start + (sweep if sweep > 1e-12 else 2 * np.pi), chord)


def _circular(entity: Entity, frame: _Frame, start: float, end: float, chord: float) -> list[Element]:
    radius = abs(entity.dxf.radius)
    centre, u, v = frame.entity_plane((entity.dxf.center, (radius, 0.0), (0.0, radius)))
    return curves.ellipse(centre, u, v, start, end, chord)


def _ellipse(entity: Entity, frame: _Frame, chord: float) -> list[Element]:
    tool = entity.construction_tool()
    if not frame.flat:
        raise ValueError("is not parallel to the xy plane; flatten the drawing")
    origin = (0.0, 0.0, 0.0)
    (centre,) = frame.plane((tool.center,))
    u, v, _ = frame.plane((tool.major_axis, tool.minor_axis, origin))
    start, end = tool.start_param, tool.end_param
    sweep = (end - start) % (2 * np.pi)
    return curves.ellipse(centre, u, v, start, start + (sweep if sweep > 1e-12 else 2 * np.pi), chord)


def _lwpolyline(entity: Entity, frame: _Frame, chord: float) -> list[Element]:
    rows = entity.get_points("xyb")
    return _bulged(frame.entity_plane(rows), [row[2] for row in rows], entity.closed, frame.side, chord)


def _polyline(entity: Entity, frame: _Frame, chord: float) -> list[Element]:
    if not (entity.is_2d_polyline or entity.is_3d_polyline):
        raise _NotACurveError
    # Vertices with the flag 16 only steer a fitted curve.
    vertices = [vertex for vertex in entity.vertices if not vertex.dxf.flags & 16]
    places = [vertex.dxf.location for vertex in vertices]
    if entity.is_3d_polyline:
        return _bulged(frame.plane(places), [0.0] * len(places), entity.is_closed, 1.0, chord)
    bulges = [vertex.dxf.get("bulge", 0.0) for vertex in vertices]
    return _bulged(frame.entity_plane(places), bulges, entity.is_closed, frame.side, chord)


def _bulged(points: Floats, bulges: list[float], closed: bool, side: float, chord: float) -> list[Element]:
    """Return segments and arcs through points; a bulge belongs to the way from its point to the next."""
    _require_finite(np.array(bulges))
    nexts = np.roll(points, -1, axis=0) if closed else points[1:]
    return [
        element
        for start, end, value in zip(points, nexts, bulges, strict=False)
        if (start != end).any()
        for element in curves.bulge(start, end, side * value, chord)
    ]


def _spline(entity: Entity, frame: _Frame, chord: float) -> list[Element]:
    tool = entity.construction_tool()
    weights = tool.weights()
    return curves.spline(
        tool.degree,
        np.array(tool.knots(), dtype=np.float64),
        frame.plane(tool.control_points),
        np.array(weights, dtype=np.float64) if len(weights) else None,
        chord,
    )


_ELEMENTS: dict[str, Callable[[Entity, _Frame, float], list[Element]]] = {
    "LINE": _line,
    "CIRCLE": _circle,
    "ARC": _arc,
    "ELLIPSE": _ellipse,
    "LWPOLYLINE": _lwpolyline,
    "POLYLINE": _polyline,
    "SPLINE": _spline,
}


# The library would put 0 or 1 in their place.
_REQUIRED = {
    "LINE": ("start", "end"),
    "CIRCLE": ("center", "radius"),
    "ARC": ("center", "radius", "start_angle", "end_angle"),
    "ELLIPSE": ("center", "major_axis", "ratio"),
}


def _handle(entity: Entity) -> str:
    """Return the handle of an entity, or of the one that it is a placed copy of."""
    source = entity.origin_of_copy if entity.is_copy else entity
    return str((source if source is not None else entity).dxf.get("handle") or "without handle")


def _counted(counter: Counter[str]) -> str:
    return ", ".join(f"{count} {name}" for name, count in sorted(counter.items()))
