"""Drawings made on the spot, and how tests read them."""

import io

import ezdxf
import numpy as np

from cutgap.instances import Instance
from cutgap.instances.formats.drawings.plate import instance_of
from cutgap.instances.formats.drawings.worker import read
from cutgap.instances.formats.options import DrawingOptions, MachineOptions


def new_drawing(units=4):
    """Return an empty drawing in mm (``units`` is the code of $INSUNITS)."""
    document = ezdxf.new("R2010")
    document.header["$INSUNITS"] = units
    return document


def dxf_bytes(document, fmt="asc") -> bytes:
    if fmt == "bin":
        stream = io.BytesIO()
        document.write(stream, fmt="bin")
        return stream.getvalue()
    text = io.StringIO()
    document.write(text)
    return text.getvalue().encode(document.output_encoding)


def outlines_of(document, **options):
    """Return outlines and notes, read within this process."""
    return read("dxf", dxf_bytes(document), DrawingOptions(**options))


def plate_of(document, **options) -> Instance:
    drawing = DrawingOptions(**options)
    outlines, _ = read("dxf", dxf_bytes(document), drawing)
    return instance_of(outlines, "plate", MachineOptions(homes=((0, 0),), drawing=drawing))


def square(layout, x, y, side, **attributes):
    """Add a closed square polyline with its lower left corner at (x, y)."""
    corners = [(x, y), (x + side, y), (x + side, y + side), (x, y + side)]
    return layout.add_lwpolyline(corners, close=True, dxfattribs=attributes)


def single(document, **options):
    """Return the only outline."""
    ((outline,), _) = outlines_of(document, **options)
    return outline


def layered():
    """Return a drawing of four squares on four layers, two of which are hidden."""
    document = new_drawing()
    for number, name in enumerate(("Cut", "Mark", "Frozen", "Off")):
        document.layers.add(name)
        square(document.modelspace(), 20 * number, 0, 10, layer=name)
    document.layers.get("Frozen").freeze()
    document.layers.get("Off").off()
    return document


def star(rng, corners):
    """Return the corners of a random simple polygon around (0, 0), shape (corners, 2)."""
    angles = (np.arange(corners) + rng.uniform(0.1, 0.9, corners)) * 2 * np.pi / corners
    return np.column_stack((np.cos(angles), np.sin(angles))) * rng.uniform(20, 100, corners)[:, None]


def same_ring(one, other) -> bool:
    """Whether two closed polylines are the same up to start and direction, bit for bit."""
    if len(one) != len(other):
        return False
    runs = [np.roll(way, shift, axis=0) for way in (other, other[::-1]) for shift in range(len(other))]
    return any(np.array_equal(one, run) for run in runs)
