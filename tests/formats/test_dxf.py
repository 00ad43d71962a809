"""DXF: every kind of entity, units, layers, blocks, faults, nesting."""

import math
import re

import numpy as np
import pytest
from ezdxf.math import Matrix44
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from cutgap.instances.formats.drawings.worker import read
from cutgap.instances.formats.options import DrawingOptions
from formats.drawing_samples import dxf_bytes, layered, new_drawing, outlines_of, plate_of, single, square


def test_lines_close_to_a_contour():
    document = new_drawing()
    corners = [(0, 0), (30, 0), (30, 40)]
    for start, end in zip(corners, corners[1:] + corners[:1], strict=True):
        document.modelspace().add_line(start, end)
    found = single(document)
    assert found.points.tolist() == [[0, 0], [30, 0], [30, 40]]
    assert found.corners == (0, 1, 2)
    assert found.perimeter == 120


def test_a_circle_is_as_long_as_it_is_and_keeps_to_the_chord_tolerance():
    for chord in (1.0, 0.1, 0.001):
        document = new_drawing()
        document.modelspace().add_circle((5, 6), 20)
        found = single(document, chord=chord)
        assert found.perimeter == pytest.approx(40 * math.pi, rel=1e-12)
        assert found.corners == ()
        middles = (found.points + np.roll(found.points, -1, axis=0)) / 2
        radii = np.linalg.norm(np.vstack((found.points, middles)) - (5, 6), axis=1)
        assert radii.max() == pytest.approx(20)
        assert 20 - 1.000001 * chord <= radii.min()


def test_arcs_and_lines_make_a_slot():
    document = new_drawing()
    space = document.modelspace()
    space.add_arc((0, 0), 5, 90, 270)
    space.add_line((0, 5), (30, 5))
    space.add_arc((30, 0), 5, -90, 90)
    space.add_line((0, -5), (30, -5))
    found = single(document)
    assert found.perimeter == pytest.approx(60 + 10 * math.pi, rel=1e-12)
    assert len(found.corners) == 4
    assert sorted(found.curved) == [False, False, True, True]


@pytest.mark.parametrize("kind", ["lwpolyline", "polyline"])
def test_bulges_are_arcs(kind):
    document = new_drawing()
    # A square with half circles, outwards, for two of its sides.
    rows = [(0, 0, 1.0), (10, 0, 0.0), (10, 10, 1.0), (0, 10, 0.0)]
    if kind == "lwpolyline":
        document.modelspace().add_lwpolyline(rows, format="xyb", close=True)
    else:
        document.modelspace().add_polyline2d(rows, format="xyb", close=True)
    found = single(document)
    assert found.perimeter == pytest.approx(20 + 10 * math.pi, rel=1e-12)
    assert found.points[:, 1].min() == pytest.approx(-5)
    assert found.points[:, 1].max() == pytest.approx(15)


def test_ellipses_are_as_long_as_their_integral():
    document = new_drawing()
    document.modelspace().add_ellipse((3, 4), major_axis=(30, 40), ratio=0.3)
    speed = quad(lambda t: math.hypot(50 * math.sin(t), 15 * math.cos(t)), 0, 2 * math.pi, epsrel=1e-12)[0]
    assert single(document).perimeter == pytest.approx(speed, rel=1e-9)


def test_a_half_ellipse_closed_by_a_line():
    document = new_drawing()
    document.modelspace().add_ellipse((0, 0), (20, 0), 0.5, start_param=0, end_param=math.pi)
    document.modelspace().add_line((-20, 0), (20, 0))
    found = single(document)
    assert found.points[:, 1].max() == pytest.approx(10)
    assert found.points[:, 1].min() == pytest.approx(0)
    assert len(found.corners) == 2


def test_splines_keep_to_the_curve_and_its_length():
    document = new_drawing()
    # A cubic Bezier curve as a spline, and one with weights: a quarter circle.
    document.modelspace().add_open_spline([(0, 0), (0, 10), (10, 10), (10, 0)], degree=3)
    document.modelspace().add_line((0, 0), (10, 0))
    found = single(document, chord=0.001)

    def speed(t):
        return math.hypot(60 * t * (1 - t), 30 * (1 - 2 * t))

    assert found.perimeter == pytest.approx(10 + quad(speed, 0, 1)[0], rel=1e-9)
    rounded = new_drawing()
    rounded.modelspace().add_rational_spline(
        [(10, 0), (10, 10), (0, 10)], weights=[1, math.sqrt(0.5), 1], degree=2
    )
    rounded.modelspace().add_lwpolyline([(0, 10), (0, 0), (10, 0)])
    found = single(rounded, chord=0.001)
    assert found.perimeter == pytest.approx(20 + 5 * math.pi, rel=1e-9)
    radii = np.linalg.norm(found.points[found.points.min(axis=1) > 0], axis=1)
    assert radii == pytest.approx(np.full(len(radii), 10))


def test_a_spline_through_fit_points_and_one_with_a_corner():
    document = new_drawing()
    document.modelspace().add_spline([(0, 0), (5, 8), (10, 0)])
    document.modelspace().add_line((10, 0), (0, 0))
    assert single(document).points[:, 1].max() == pytest.approx(8, abs=0.01)
    angular = new_drawing()
    spline = angular.modelspace().add_spline()
    spline.dxf.degree = 2
    spline.control_points = [(0, 0), (5, 0), (10, 0), (10, 5), (10, 10)]
    spline.knots = [0, 0, 0, 1, 1, 2, 2, 2]
    angular.modelspace().add_line((10, 10), (0, 0))
    assert len(single(angular).corners) == 3


def test_blocks_are_placed_scaled_turned_nested_and_in_arrays():
    document = new_drawing()
    hole = document.blocks.new("HOLE")
    hole.add_circle((0, 0), 1)
    plate = document.blocks.new("PLATE", base_point=(5, 5))
    square(plate, 0, 0, 10)
    plate.add_blockref("HOLE", (3, 3))
    plate.add_blockref("HOLE", (7, 7), dxfattribs={"xscale": 2, "yscale": 2})
    array = document.modelspace().add_blockref("PLATE", (100, 0), dxfattribs={"rotation": 90})
    array.dxf.row_count, array.dxf.row_spacing = 2, 30
    array.dxf.column_count, array.dxf.column_spacing = 3, 40
    instance = plate_of(document)
    assert len(instance.contours) == 6 * 3
    sizes = sorted(contour.perimeter for contour in instance.contours)
    assert sizes == pytest.approx([2 * math.pi] * 6 + [4 * math.pi] * 6 + [40] * 6)
    centres = sorted(
        tuple(np.round(c.geometry.mean(axis=0), 6) + 0.0) for c in instance.contours if c.ring == "outer"
    )
    assert centres == [(100 - 30 * row, 40 * column) for row in (1, 0) for column in range(3)]


def test_a_stretched_block_turns_circles_into_ellipses():
    document = new_drawing()
    document.blocks.new("HOLE").add_circle((0, 0), 1)
    document.modelspace().add_blockref("HOLE", (0, 0), dxfattribs={"xscale": 3, "yscale": -1})
    other = new_drawing()
    other.modelspace().add_ellipse((0, 0), (3, 0), 1 / 3)
    assert single(document).perimeter == pytest.approx(single(other).perimeter, rel=1e-9)


@given(st.floats(0, 360), st.floats(-500, 500), st.booleans())
@settings(max_examples=10)
def test_moved_turned_and_mirrored_drawings_have_the_same_perimeters(angle, shift, mirrored):
    def drawing(move):
        document = new_drawing()
        space = document.modelspace()
        square(space, 0, 0, 100)
        space.add_circle((20, 30), 7)
        space.add_ellipse((60, 60), (15, 5), 0.4)
        space.add_lwpolyline([(10, 80, 0.3), (30, 80, -0.2), (20, 95, 0)], format="xyb", close=True)
        space.add_arc((80, 20), 8, 10, 200)
        start, end = (np.array((np.cos(a), np.sin(a))) * 8 + (80, 20) for a in np.radians((10, 200)))
        space.add_line(start, end)
        for entity in space:
            entity.transform(move)
        return plate_of(document)

    flip = Matrix44.scale(-1, 1, 1) if mirrored else Matrix44()
    one = drawing(Matrix44())
    other = drawing(flip @ Matrix44.z_rotate(math.radians(angle)) @ Matrix44.translate(shift, -2 * shift, 0))
    assert [each.id for each in one.contours] == [each.id for each in other.contours]
    assert other.perimeters == pytest.approx(one.perimeters, rel=1e-9)
    assert other.precedence == one.precedence


@pytest.mark.parametrize(("code", "factor"), [(0, 1.0), (1, 25.4), (4, 1.0), (5, 10.0), (6, 1000.0)])
def test_units_become_mm(code, factor):
    document = new_drawing(units=code)
    square(document.modelspace(), 1, 0, 2)
    (found,), notes = outlines_of(document)
    assert found.perimeter == pytest.approx(8 * factor)
    assert found.points[:, 0].min() == pytest.approx(factor)
    assert any("no units" in note for note in notes) == (code == 0)


def test_layers_are_chosen_and_hidden_ones_left_out_with_a_note():
    outlines, notes = outlines_of(layered())
    assert [each.layer for each in outlines] == ["Cut", "Mark"]
    assert "frozen or off, are left out: 1 Frozen, 1 Off" in notes[0]
    assert [each.layer for each in outlines_of(layered(), layers=("mark", "Off"))[0]] == ["Mark", "Off"]
    with pytest.raises(ValueError, match=r"no layer 'Cuts'; the drawing has 0, Cut, .*Frozen, Mark, Off"):
        outlines_of(layered(), layers=("Cut", "Cuts"))


def test_what_lies_on_layer_0_of_a_block_is_on_the_layer_of_the_reference():
    document = new_drawing()
    square(document.blocks.new("PART"), 0, 0, 10)
    document.modelspace().add_blockref("PART", (0, 0), dxfattribs={"layer": "Cut"})
    assert single(document, layers=("Cut",)).layer == "Cut"


def test_invisible_entities_and_blocks_are_left_out_with_a_note():
    document = new_drawing()
    square(document.blocks.new("PART"), 0, 0, 10)
    document.modelspace().add_blockref("PART", (0, 0), dxfattribs={"invisible": 1})
    square(document.modelspace(), 20, 0, 10, invisible=1)
    square(document.modelspace(), 40, 0, 10)
    (found,), notes = outlines_of(document)
    assert found.points[:, 0].min() == 40
    assert "2 0" in notes[0]


def test_text_and_hatches_are_left_out_with_a_note():
    document = new_drawing()
    square(document.modelspace(), 0, 0, 10)
    document.modelspace().add_text("part 7")
    document.modelspace().add_hatch().paths.add_polyline_path([(0, 0), (5, 0), (5, 5)])
    outlines, notes = outlines_of(document)
    assert len(outlines) == 1
    assert any("1 HATCH, 1 TEXT" in note for note in notes)


def test_entities_of_unknown_kinds_are_left_out_with_a_note():
    document = layered()
    document.modelspace().add_text("part 7")
    content = dxf_bytes(document).replace(b"\nTEXT\n", b"\nROBOT\n")
    outlines, notes = read("dxf", content, DrawingOptions())
    assert len(outlines) == 2
    assert any("1 ROBOT" in note for note in notes)


def test_an_entity_without_its_figures_is_refused():
    document = new_drawing()
    document.modelspace().add_circle((3, 4), 7.25)
    content = re.sub(rb" 40\n7\.25\n", b"", dxf_bytes(document))
    with pytest.raises(ValueError, match=r"CIRCLE .*: has no radius"):
        read("dxf", content, DrawingOptions())


def nested(depth):
    document = new_drawing()
    for level in range(depth):
        square(document.modelspace(), 10 * level, 10 * level, 100 - 20 * level)
    square(document.modelspace(), 200, 0, 10)
    return plate_of(document)


def test_nesting_gives_parts_rings_and_precedence():
    instance = nested(4)
    found = [(each.id, each.part, each.ring) for each in instance.contours]
    assert found == [
        ("1", "1", "outer"),
        ("1.1", "1", "inner"),
        ("2", "2", "outer"),
        ("2.1", "2", "inner"),
        ("3", "3", "outer"),
    ]
    assert set(instance.precedence) == {(1, 0), (2, 1), (3, 2)}
