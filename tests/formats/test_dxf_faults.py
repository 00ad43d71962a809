"""Drawings that are refused: faults with their places, and files that are damaged or empty."""

import re

import pytest

from cutgap.instances.formats.drawings.worker import read
from cutgap.instances.formats.options import DrawingOptions
from formats.drawing_samples import dxf_bytes, layered, new_drawing, outlines_of, plate_of, single, square


def test_open_chains_are_refused_with_their_place_or_left_out():
    document = new_drawing()
    square(document.modelspace(), 0, 0, 10)
    line = document.modelspace().add_line((20, 1), (35, 2), dxfattribs={"layer": "Cut"})
    place = rf"layer 'Cut', LINE {line.dxf.handle}, from \(20, 1\) to \(35, 2\)"
    with pytest.raises(ValueError, match=rf"1 fault\n  open: {place}.*\n.*--skip open"):
        outlines_of(document)
    outlines, notes = outlines_of(document, skip=("open",))
    assert len(outlines) == 1
    assert re.search(place, notes[-1])


@pytest.mark.parametrize("gap", [0.9, 1.1])
def test_a_gap_closes_within_the_tolerance(gap):
    document = new_drawing()
    document.modelspace().add_lwpolyline([(0, 0), (50, 0), (50, 50), (gap, 0)])
    if gap <= 1.0:
        assert len(single(document, tolerance=1.0).points) == 3
    else:
        with pytest.raises(ValueError, match=r"nearest loose ends are 1\.1 and 1\.1 mm away"):
            outlines_of(document, tolerance=1.0)


@pytest.mark.parametrize("kind", ["circle", "lines", "doubled lines"])
def test_copies_are_found(kind):
    document = new_drawing()
    space = document.modelspace()
    corners = [(0, 0), (30, 0), (30, 40)]
    edges = list(zip(corners, corners[1:] + corners[:1], strict=True))
    if kind == "circle":
        space.add_circle((0, 0), 5)
        space.add_circle((0.001, 0), 5)
    for start, end in {"circle": [], "lines": edges * 2, "doubled lines": sorted(edges * 2)}[kind]:
        space.add_line(start, end)
    with pytest.raises(ValueError, match="1 fault\n  drawn again: layer '0'"):
        outlines_of(document)
    assert len(outlines_of(document, skip=("copies",))[0]) == 1


def test_a_contour_that_crosses_itself_and_two_that_cross_each_other():
    document = new_drawing()
    document.modelspace().add_lwpolyline([(0, 0), (10, 10), (10, 0), (0, 10)], close=True)
    square(document.modelspace(), 20, 0, 10)
    square(document.modelspace(), 25, 5, 10)
    square(document.modelspace(), 50, 0, 10)
    with pytest.raises(ValueError, match="crosses itself") as caught:
        outlines_of(document)
    message = str(caught.value)
    assert message.startswith("2 faults")
    assert "at (5, 5)" in message
    x, y = map(float, re.search(r"near \((.*), (.*)\)", message).groups())
    assert 25 <= x <= 30
    assert 5 <= y <= 10
    outlines, notes = outlines_of(document, skip=("crossing",))
    assert [each.points[:, 0].min() for each in outlines] == [50]
    assert "left out as asked: 2 faults" in notes[-1]


def test_contours_that_touch_are_sound():
    document = new_drawing()
    square(document.modelspace(), 0, 0, 10)
    square(document.modelspace(), 10, 3, 10)
    square(document.modelspace(), 0, 10, 10)
    document.modelspace().add_circle((5, 5), 5)
    assert [each.id for each in plate_of(document).contours] == ["1", "1.1", "2", "3"]


def test_a_line_drawn_to_and_fro_is_no_contour():
    document = new_drawing()
    document.modelspace().add_line((0, 0), (30, 0))
    document.modelspace().add_line((30, 0), (0, 0))
    with pytest.raises(ValueError, match="drawn to and fro"):
        outlines_of(document)


def test_empty_drawings_are_refused():
    with pytest.raises(ValueError, match=r"no closed contour in the drawing; .* \(it is empty\)"):
        outlines_of(new_drawing())
    document = layered()
    for entity in list(document.modelspace())[:2]:
        document.modelspace().delete_entity(entity)
    with pytest.raises(ValueError, match=r"no closed contour.*1 Frozen, 1 Off"):
        outlines_of(document)


def test_what_is_not_flat_is_refused():
    document = new_drawing()
    document.modelspace().add_line((0, 0, 0), (5, 0, 5))
    with pytest.raises(ValueError, match=r"LINE .*: is not flat"):
        outlines_of(document)
    tilted = new_drawing()
    tilted.modelspace().add_circle((0, 0), 5, dxfattribs={"extrusion": (1, 0, 1)})
    with pytest.raises(ValueError, match=r"CIRCLE .*: is not parallel"):
        outlines_of(tilted)


def test_binary_files_are_read_like_text():
    document = layered()
    assert document.modelspace()
    texts = read("dxf", dxf_bytes(document), DrawingOptions())[0]
    binary = read("dxf", dxf_bytes(document, "bin"), DrawingOptions())[0]
    assert [each.points.tolist() for each in binary] == [each.points.tolist() for each in texts]


@pytest.mark.parametrize("share", [0.0, 0.3, 0.7, 0.999])
@pytest.mark.parametrize("fmt", ["asc", "bin"])
def test_truncated_files_are_refused(share, fmt):
    content = dxf_bytes(layered(), fmt)
    with pytest.raises(ValueError, match="not a complete DXF file"):
        read("dxf", content[: int(share * len(content))], DrawingOptions())
