"""Nests of outlines: what they mean, link points on reading, and bad files."""

import json

import numpy as np
import pytest

from cutgap.benchmark.tasks import ONE_STROKE, find_suite
from cutgap.instances import Instance, Machine, Plan, Rules, check
from cutgap.instances.formats import MachineOptions, read_instance, write_instance
from cutgap.instances.formats.options import NO_OVERRIDES
from cutgap.instances.links.points import with_link_points
from cutgap.views.cli import main

HOME = MachineOptions(homes=((1, 2),))
SQUARE = [[0.0, 5], [4, 5], [4, 9], [0, 9]]
TRIANGLE = [[6, 7], [9, 5], [9, 9]]
NEST = {
    "name": "two",
    "strip": [[0, 0], [10, 0], [10, 10], [0, 10]],
    "parts": [{"item": 3, "contour": SQUARE}, {"item": 3, "contour": TRIANGLE}],
}


def read(tmp_path, content, options=HOME) -> Instance:
    path = tmp_path / "nest.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return read_instance(path, options)


def with_parts(*contours) -> dict:
    return NEST | {"parts": [{"item": 0, "contour": contour} for contour in contours]}


def test_a_nest_becomes_outlines(tmp_path):
    nest = read(tmp_path, NEST)
    assert (nest.name, nest.machine) == ("two", Machine(v_jump=150.0, v_cut=10.0, t_aux=80.0))
    assert [head.home.tolist() for head in nest.heads] == [[1, 2, 0]]
    square, triangle = nest.contours
    assert [(each.id, each.part, each.ring) for each in nest.contours] == [
        ("1", "3-1", "outer"),
        ("2", "3-2", "outer"),
    ]
    np.testing.assert_array_equal(square.geometry, SQUARE)
    np.testing.assert_array_equal(square.entry_points[:, :2], SQUARE)
    assert (square.perimeter, triangle.perimeter) == (16.0, pytest.approx(4 + 2 * np.hypot(3, 2)))


def test_given_figures_replace_those_of_flame_cutting(tmp_path):
    options = MachineOptions(homes=((0, 0),), v_cut=20.0, t_aux=0.5)
    assert read(tmp_path, NEST, options).machine == Machine(v_jump=150.0, v_cut=20.0, t_aux=0.5)


def test_a_closing_point_is_dropped(tmp_path):
    closed = with_parts([*SQUARE, SQUARE[0]])
    np.testing.assert_array_equal(read(tmp_path, closed).contours[0].geometry, SQUARE)


def test_no_parts_are_a_nest(tmp_path):
    nest = read(tmp_path, with_parts(), MachineOptions(homes=((0, 0),), link_points=True))
    assert nest.contours == ()
    assert check(nest, ONE_STROKE, Plan(((),))) == []


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (with_parts(SQUARE, SQUARE[:2]), r"parts\[1\].contour: expected .*at least 3"),
        (
            with_parts([[0, 0], [1, 1], [0, 0]]),
            r"\[0\].contour: expected at least 3 different points, got 2",
        ),
        (
            with_parts([*SQUARE[:2], *SQUARE[1:]]),
            r"\[0\].contour\[2\]: .* repeats the point before it",
        ),
        (
            json.dumps(with_parts(SQUARE)).replace("0.0", "NaN"),
            r"\[0\].contour\[0\]\[0\]: expected a finite",
        ),
        (json.dumps(with_parts(SQUARE)).replace("0.0", "1e999"), r"contour\[0\]\[0\]: expected a finite"),
        (with_parts([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), r"parts\[0\].contour\[0\]: expected .*at most 2"),
        (with_parts([["0", 0], [1, 0], [0, 1]]), r"contour\[0\]\[0\]: expected a valid number, got '0'"),
        (NEST | {"unit": "mm"}, "unit: unknown field"),
        ({"name": "x", "parts": []}, "strip: missing; add it"),
        (NEST | {"parts": [{"contour": SQUARE}]}, r"parts\[0\].item: missing"),
    ],
)
def test_bad_nests_are_refused_with_their_place(tmp_path, content, message):
    with pytest.raises(ValueError, match=r"nest\.json: .*" + message):
        read(tmp_path, content)


def test_a_home_has_to_be_given(tmp_path):
    with pytest.raises(ValueError, match="homes: the format carries none; give --home"):
        read(tmp_path, NEST, NO_OVERRIDES)


@pytest.mark.parametrize(
    ("contours", "message"),
    [
        ((SQUARE, SQUARE), "contours '1' and '2' overlap"),
        (([[0, 0], [4, 4], [4, 0], [0, 4]],), "'1', geometry: links need a simple closed curve"),
        ((SQUARE, [[0, 0], [4, 0], [8, 0]]), "'2', geometry: links need a simple closed curve"),
    ],
)
def test_shapes_that_no_link_fits_are_for_the_rules_to_refuse(tmp_path, contours, message):
    nest = read(tmp_path, with_parts(*contours))
    with pytest.raises(ValueError, match=message):
        check(nest, Rules("travel", links=True), Plan(((),)))


def test_the_suite_has_link_points_and_asks_for_one_stroke(tmp_path):
    (tmp_path / "nest.json").write_text(json.dumps(NEST))
    suite = find_suite(f"nests:{tmp_path}", NO_OVERRIDES)
    assert suite.rules == Rules("travel", links=True, pierces=1)
    (nest,) = suite.instances
    assert nest.heads[0].home.tolist() == [0, 0, 0]
    assert [4.0, 7.0, 0.0] in nest.contours[0].entry_points.tolist()  # across from the triangle's tip
    (moved,) = find_suite(f"nests:{tmp_path}", HOME).instances
    assert moved.heads[0].home.tolist() == [1, 2, 0]


def test_all_commands_can_ask_for_link_points(tmp_path):
    source, target = tmp_path / "nest.json", tmp_path / "linked.json"
    source.write_text(json.dumps(NEST))
    assert main(["convert", str(source), str(target), "--home", "1,2", "--link-points"]) == 0
    expected = with_link_points(read_instance(source, HOME))
    for written in (read_instance(target), read_instance(target, MachineOptions(link_points=True))):
        for one, other in zip(written.contours, expected.contours, strict=True):
            np.testing.assert_array_equal(one.entry_points, other.entry_points)


def test_shipped_suites_take_link_points_too(tmp_path):
    square = read(tmp_path, NEST)
    write_instance(square, tmp_path / "nest.json")
    (plain,) = find_suite(str(tmp_path / "nest.json"), NO_OVERRIDES).instances
    assert len(plain.contours[0].entry_points) == len(SQUARE)
    with pytest.raises(ValueError, match="no geometry, which links needs"):
        find_suite("small", MachineOptions(link_points=True))
