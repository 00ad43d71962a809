"""The curves of an SVG file, in mm with y upwards.

path, rect, circle, ellipse, polygon, polyline and line count, under all transforms and through ``use``. A px is
1/96 inch; width, height and viewBox of the file say how long a user unit is. y is measured from the lower edge
of the picture. A layer is a group at the top, by its ``inkscape:label`` or else its id.

XML of unknown origin: documents that declare entities, or hold anything within their DOCTYPE, are refused.
"""

import io
import re
from collections import Counter
from collections.abc import Iterator
from xml.etree import ElementTree
from xml.parsers import expat

import numpy as np
import svgelements

from cutgap.instances.arrays import Floats
from cutgap.instances.formats.drawings import curves
from cutgap.instances.formats.drawings.curves import Element, Strand
from cutgap.instances.formats.options import DrawingOptions

MM_PER_PX = 25.4 / 96
MOST_STRANDS = 500_000
NO_LAYER = "0"
"""Layer of what stands in no group."""

_PX_PER_UNIT = {"mm": 96 / 25.4, "cm": 96 / 2.54, "q": 96 / 101.6, "in": 96.0, "pt": 96 / 72, "pc": 16.0}
_WITH_UNIT = re.compile(
    r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(mm|cm|q|in|pt|pc)\s*", re.IGNORECASE
)
_LENGTHS = {"x", "y", "width", "height", "cx", "cy", "r", "rx", "ry", "x1", "y1", "x2", "y2"}
_NAMESPACE = "{http://www.w3.org/2000/svg}"
_LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
_LINK = "{http://www.w3.org/1999/xlink}href"
# What these hold is not drawn where it stands, or is no curve.
_NOT_DRAWN = ("clipPath", "marker", "mask", "pattern", "text", "image", "foreignObject", "switch")


def strands_of(content: bytes, options: DrawingOptions) -> tuple[list[Strand], list[str]]:
    """Return the curves of an SVG file in its order, and notes on what was left out.

    Raises
    ------
    ValueError
        When the file is no SVG, declares entities, refers to what it does not hold, or does not have a layer
        that is asked for.
    """
    _require_plain_xml(content)
    root = ElementTree.fromstring(content)
    notes = _without_what_is_not_drawn(root)
    _to_px(root)
    _require_links(root)
    picture = _parsed(root)
    asked = set(options.layers)
    layers: dict[str, None] = {}
    strands: list[Strand] = []
    for number, (shape, layer) in enumerate(_shapes(picture, None), start=1):
        layers[layer] = None
        if asked and layer not in asked:
            continue
        kind = str(shape.values.get("tag", "shape"))
        place = f"{kind} {shape.id!r}" if shape.id else f"{kind} number {number}"
        if shape.values.get("visibility") in ("hidden", "collapse"):
            notes.append(f"layer {layer!r}, {place}: hidden, left out")
            continue
        for elements in _subpaths(shape, float(picture.height), options.chord, f"layer {layer!r}, {place}"):
            strands.append(Strand(tuple(elements), layer, place))
        if len(strands) > MOST_STRANDS:
            raise ValueError(f"more than {MOST_STRANDS} curves; split the drawing")
    unknown = [name for name in options.layers if name not in layers]
    if unknown:
        raise ValueError(f"--layers: no layer {unknown[0]!r}; the drawing has {', '.join(layers):.500}")
    return strands, notes


def _require_plain_xml(content: bytes) -> None:
    """Refuse what could make a small file huge, before anything is built from it."""

    def doctype(name: str, system: str | None, public: str | None, has_subset: int) -> None:
        if has_subset:
            raise ValueError("holds declarations within its DOCTYPE; remove the DOCTYPE")

    def entity(name: str, *_: object) -> None:
        raise ValueError(f"declares the entity {name!r}; remove the DOCTYPE")

    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = doctype
    parser.EntityDeclHandler = entity
    try:
        parser.Parse(content, True)
    except expat.ExpatError as error:
        raise ValueError(f"line {error.lineno}: not XML: {expat.ErrorString(error.code)}") from error


def _without_what_is_not_drawn(root: ElementTree.Element) -> list[str]:
    """Take out of the tree what is not drawn where it stands, and return a note on it."""
    if root.tag not in (f"{_NAMESPACE}svg", "svg"):
        raise ValueError(f"not an SVG file: its root is {root.tag!r:.80}")
    removed: Counter[str] = Counter()
    for parent in list(root.iter()):
        for child in list(parent):
            tag = str(child.tag).removeprefix(_NAMESPACE)
            if tag == "symbol":
                raise ValueError(f"symbol {child.get('id')!r}: symbols are not read; make it a g within defs")
            if tag in _NOT_DRAWN:
                parent.remove(child)
                removed[tag] += 1
    counted = ", ".join(f"{count} {tag}" for tag, count in sorted(removed.items()))
    return [f"elements that are no contours are left out: {counted}"] if removed else []


def _parsed(root: ElementTree.Element) -> svgelements.SVG:
    try:
        return svgelements.SVG.parse(io.BytesIO(ElementTree.tostring(root)), ppi=96, on_error="raise")
    except ValueError as error:
        for number, path in enumerate(root.iter(f"{_NAMESPACE}path"), start=1):
            data = path.get("d", "")
            try:
                svgelements.Path().parse(data)
            except ValueError:
                name = path.get("id", f"number {number}")
                raise ValueError(f"path {name!r}: cannot read its d: {data!r:.80}") from error
        raise ValueError(f"cannot be read as SVG: {error or 'an attribute is no number'}") from error


def _to_px(root: ElementTree.Element) -> None:
    """Write lengths in px: the library's own factors are rounded to six digits."""
    for element in root.iter():
        for name, value in element.attrib.items():
            if name in _LENGTHS and (found := _WITH_UNIT.fullmatch(value)):
                number, unit = found.groups()
                element.set(name, repr(float(number) * _PX_PER_UNIT[unit.lower()]))


def _require_links(root: ElementTree.Element) -> None:
    """Refuse a ``use`` whose target is not in the file: its contours would silently be missing."""
    targets = {element.get("id") for element in root.iter()}
    for element in root.iter():
        if str(element.tag).removeprefix(_NAMESPACE) == "use":
            link = element.get("href", element.get(_LINK)) or ""
            if not link.startswith("#") or link[1:] not in targets:
                raise ValueError(f"use {element.get('id')!r}: nothing in the file is called {link!r:.80}")


def _shapes(group: svgelements.Group, layer: str | None) -> Iterator[tuple[svgelements.Shape, str]]:
    """Yield the shapes that are drawn, with the names of their layers."""
    for each in group:
        if isinstance(each, svgelements.Use):
            yield from _shapes(each, layer or NO_LAYER)
        elif isinstance(each, svgelements.Group):
            name = each.values.get("attributes", {}).get(_LABEL) or each.id or NO_LAYER
            yield from _shapes(each, name if layer is None else layer)
        elif isinstance(each, svgelements.Shape):
            yield each, layer or NO_LAYER


def _subpaths(shape: svgelements.Shape, height: float, chord: float, place: str) -> Iterator[list[Element]]:
    """Yield the elements of each subpath of a shape."""
    elements: list[Element] = []
    for segment in shape.segments():
        if isinstance(segment, svgelements.Move):
            if elements:
                yield elements
            elements = []
            continue
        if segment.start is None or segment.end is None:
            raise ValueError(f"{place}: the path does not begin with a move")
        try:
            elements += _elements(segment, height, chord)
        except ValueError as error:
            raise ValueError(f"{place}: {error}") from error
        if isinstance(segment, svgelements.Close):
            if elements:
                yield elements
            elements = []
    if elements:
        yield elements


def _elements(segment: svgelements.PathSegment, height: float, chord: float) -> list[Element]:
    if isinstance(segment, svgelements.Arc):
        centre, along, across = _points(height, segment.center, segment.prx, segment.pry)
        start = segment.get_start_t()
        found = curves.ellipse(centre, along - centre, across - centre, start, start + segment.sweep, chord)
        if found:
            found[0].points[[0, -1]] = _points(height, segment.start, segment.end)
        return found
    if isinstance(segment, svgelements.CubicBezier):
        controls = _points(height, segment.start, segment.control1, segment.control2, segment.end)
        return curves.bezier(controls, chord)
    if isinstance(segment, svgelements.QuadraticBezier):
        return curves.bezier(_points(height, segment.start, segment.control, segment.end), chord)
    return curves.polygon_line(_points(height, segment.start, segment.end))


def _points(height: float, *points: svgelements.Point) -> Floats:
    """Return points in mm, y upwards, shape (k, 2)."""
    rows = np.array([(point.x, height - point.y) for point in points], dtype=np.float64) * MM_PER_PX
    if not (np.abs(rows) <= 1e9).all():
        raise ValueError(f"has a coordinate of {rows.flat[np.abs(rows).argmax()]:g} mm; the most is 1e9")
    return rows
