"""JSON of CAM systems: routing tasks and lists of parts; what they mean, and bad files."""

import copy
import json
import math

import numpy as np
import pytest
import shapely

from cutgap.instances import Instance, Machine
from cutgap.instances.formats import MachineOptions, read_instance
from cutgap.instances.formats.cam_parts import FLATNESS
from cutgap.instances.formats.options import NO_OVERRIDES

HOME = MachineOptions(homes=((0, 0),))


def read(tmp_path, content, options=NO_OVERRIDES) -> Instance:
    path = tmp_path / "job.json"
    path.write_text(json.dumps(content))
    return read_instance(path, options)


def square(index, low, high, *nested) -> dict:
    corners = [(low, low), (high, low), (high, high), (low, high)]
    points = [
        {"Index": number, "X": x, "Y": y, "UseCircuitAndFinishCutPoint": False}
        for number, (x, y) in enumerate(corners, start=1)
    ]
    contour = {"Index": index, "ZeroBasedIndex": index - 1, "Points": points}
    return contour | ({"NestedContours": list(nested)} if nested else {})


ROUTING = {
    "TaskData": {
        "StartX": 3.0,
        "StartY": 4,
        "TerminalMotion": True,
        "FinishX": 3.0,
        "FinishY": 4.0,
        "SheetMinX": 0.0,
        "SheetMaxX": 8000.0,
        "SheetMinY": 0.0,
        "SheetMaxY": 2000.0,
        "ToolIdlingSpeed": 500.0,
        "ToolCutSpeed": 10.0,
        "PiercingDuration": 7.0,
    },
    # Contour 4 is a part in the hole 2 of part 1.
    "Contours": [
        square(1, 0, 90, square(2, 10, 80, square(4, 20, 70, square(5, 30, 60)))),
        square(3, 100, 110),
    ],
}


def edited(path, value) -> dict:
    """Return the routing task with one field changed; ``None`` removes it."""
    content = copy.deepcopy(ROUTING)
    *way, last = path
    place = content
    for step in way:
        place = place[step]
    if value is None:
        del place[last]
    else:
        place[last] = value
    return content


def test_a_routing_task_has_the_files_machine_home_and_nesting(tmp_path):
    instance = read(tmp_path, ROUTING)
    assert instance.machine == Machine(v_jump=500.0, v_cut=10.0, t_aux=7.0)
    assert instance.heads[0].home.tolist() == [3, 4, 0]
    assert [contour.id for contour in instance.contours] == ["1", "2", "3", "4", "5"]
    assert [(c.part, c.ring) for c in instance.contours] == [
        ("1", "outer"),
        ("1", "inner"),
        ("3", "outer"),
        ("4", "outer"),
        ("4", "inner"),
    ]
    assert set(instance.precedence) == {(1, 0), (3, 1), (4, 3)}
    assert instance.contours[1].entry_points.tolist() == [[10, 10, 0], [80, 10, 0], [80, 80, 0], [10, 80, 0]]
    assert [c.perimeter for c in instance.contours] == [360, 280, 40, 200, 120]
    assert all(contour.geometry is None for contour in instance.contours)
    assert instance.name == "job"


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("TaskData", "TerminalMotion"), False, r"TaskData\.TerminalMotion: false.*give --home X,Y"),
        (
            ("TaskData", "FinishX"),
            9.0,
            r"TaskData\.FinishX, FinishY: 9, 4 is not the start 3, 4.*give --home X,Y",
        ),
    ],
)
def test_a_head_that_does_not_return_is_refused_unless_a_home_replaces_it(tmp_path, path, value, message):
    with pytest.raises(ValueError, match=r"job\.json: " + message):
        read(tmp_path, edited(path, value))
    instance = read(tmp_path, edited(path, value), MachineOptions(homes=((7, 8),), v_cut=20.0))
    assert instance.heads[0].home.tolist() == [7, 8, 0]
    assert instance.machine == Machine(v_jump=500.0, v_cut=20.0, t_aux=7.0)


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("TaskData", "StartX"), None, r"TaskData\.StartX: missing"),
        (("TaskData", "ToolIdlingSpeed"), 0, r"TaskData\.ToolIdlingSpeed: expected greater than 0, got 0"),
        (("TaskData", "PiercingDuration"), "7", r"TaskData\.PiercingDuration: expected .*number, got '7'"),
        (("TaskData", "Speed"), 7, r"TaskData\.Speed: unknown field"),
        (("Contours",), None, r"Contours: missing"),
        (("Contours", 0, "Points"), [], r"Contours\[0\]\.Points: .*at least 1"),
        (("Contours", 1, "Index"), 4, r"Contours: the Index 4 appears more than once"),
        (("Contours", 1, "Points", 2, "X"), math.inf, r"Contours\[1\]\.Points\[2\]\.X: .*finite"),
        (
            ("Contours", 0, "NestedContours", 0, "Points", 1, "Y"),
            None,
            r"NestedContours\[0\]\.Points\[1\]\.Y: miss",
        ),
        (
            ("Contours", 1, "Points", 2, "UseCircuitAndFinishCutPoint"),
            True,
            r"contour 3, point 3, UseCircuitAndFinishCutPoint: true",
        ),
    ],
)
def test_a_bad_routing_task_is_named_by_field(tmp_path, path, value, message):
    with pytest.raises(ValueError, match=r"job\.json: .*" + message):
        read(tmp_path, edited(path, value))


def test_contours_nested_without_end_are_refused(tmp_path):
    contour = square(1, 0, 1)
    for index in range(2, 400):
        contour = square(index, 0, 1, contour)
    with pytest.raises(ValueError, match=r"job\.json: nested too deeply"):
        read(tmp_path, edited(("Contours",), [contour]))


def circle(x, y, radius, bulge=1.0) -> list[list[float]]:
    return [[x - radius, y, bulge], [x + radius, y, bulge], [x - radius, y, bulge]]


def box(low, high) -> list[list[float]]:
    return [[low, low, 0], [high, low, 0], [high, high, 0], [low, high, 0], [low, low, 0]]


SHEET = {"partid": "2X8", "paths": [box(0, 1000)]}
DISC = {"partid": "disc", "paths": [circle(300, 300, 200, -1.0), circle(300, 300, 150)]}
INSIDE = {"partid": "disc", "paths": [circle(300, 300, 50)]}
PARTS = [SHEET, DISC, INSIDE, {"partid": "box", "paths": [box(600, 700)]}]


def test_a_list_of_parts_has_arcs_rings_and_precedence_but_no_sheet(tmp_path):
    instance = read(tmp_path, PARTS, HOME)
    assert [(c.id, c.part, c.ring) for c in instance.contours] == [
        ("1", "disc", "outer"),
        ("2", "disc", "inner"),
        ("3", "disc-2", "outer"),
        ("4", "box", "outer"),
    ]
    assert set(instance.precedence) == {(1, 0), (2, 1)}
    radii = [200, 150, 50]
    assert [c.perimeter for c in instance.contours] == pytest.approx([*(math.tau * r for r in radii), 400])
    assert instance.contours[1].entry_points.tolist() == [[150, 300, 0], [450, 300, 0]]
    for contour, radius in zip(instance.contours, radii, strict=False):
        ring = shapely.LinearRing(contour.geometry)
        away = np.hypot(*(np.array(contour.geometry) - 300).T)
        assert away == pytest.approx(np.full(len(away), radius), rel=1e-12)
        centre = shapely.Point(300, 300)
        assert radius - FLATNESS <= ring.distance(centre) < radius
        assert shapely.distance(ring, shapely.points(contour.entry_points[:, :2])).max() == 0


@pytest.mark.parametrize("bulge", [0.4, -0.4, 0.01, 1.0, 2.5])
def test_an_arc_turns_by_four_times_the_arc_tangent_of_its_bulge(tmp_path, bulge):
    # The chord lies on y = 0; a positive bulge turns counter-clockwise, so that the arc lies below it.
    path = [[0, 0, bulge], [100, 0, 0], [50, 900 if bulge > 0 else -900, 0], [0, 0, 0]]
    contour = read(tmp_path, [{"partid": "a", "paths": [path]}], HOME).contours[0]
    heights = -np.sign(bulge) * np.array(contour.geometry)[:, 1]
    # The bulge is twice the height of the arc over its chord; with more than half a circle it is wider.
    assert heights.max() == pytest.approx(abs(bulge) * 50, abs=FLATNESS)
    turn = 4 * math.atan(abs(bulge))
    radius = 50 / math.sin(turn / 2)
    assert contour.perimeter == pytest.approx(radius * turn + 2 * math.hypot(50, 900))
    drawn = np.linalg.norm(np.diff(contour.geometry, axis=0, append=contour.geometry[:1]), axis=1).sum()
    assert drawn <= contour.perimeter
    assert drawn == pytest.approx(contour.perimeter, rel=1e-2)


def test_a_first_part_with_holes_or_beside_others_is_no_sheet(tmp_path):
    for parts in ([DISC, INSIDE], [{"partid": "b", "paths": [box(600, 700)]}, DISC], [SHEET]):
        assert len(read(tmp_path, parts, HOME).contours) == sum(len(part["paths"]) for part in parts)


def test_parts_of_one_name_never_share_it(tmp_path):
    parts = [
        {"partid": name, "paths": [box(10 * k, 10 * k + 9)]} for k, name in enumerate(["a", "a", "a-2", "a"])
    ]
    assert [contour.part for contour in read(tmp_path, parts, HOME).contours] == ["a", "a-3", "a-2", "a-4"]


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        (
            [{"partid": "a", "paths": [[[0, 0, 0], [9, 0, 0], [9, 9, 0]]]}],
            r"part 'a', path 1: open, from 0, 0 to 9, 9",
        ),
        (
            [{"partid": "a", "paths": [[[0, 0, 0], [9, 9, 0], [9, 0, 0], [0, 9, 0], [0, 0, 0]]]}],
            r"crosses itself",
        ),
        (
            [{"partid": "a", "paths": [[[0, 0, 0], [9, 9, 0], [0, 0, 0]]]}],
            r"part 'a', path 1: touches or crosses",
        ),
        (
            [{"partid": "a", "paths": [box(0, 9)]}, {"partid": "b", "paths": [box(5, 14)]}],
            r"'a', path 1 and part 'b'",
        ),
        ([{"partid": "a", "paths": []}], r"\[0\]\.paths: .*at least 1"),
        ([{"partid": "a", "paths": [[]]}], r"\[0\]\.paths\[0\]: .*at least 3"),
        ([{"partid": "a", "paths": [[[0, 0], [1, 1], [0, 0]]]}], r"\[0\]\.paths\[0\]\[0\]: .*at least 3"),
        ([{"partid": "a", "paths": [box(0, math.nan)]}], r"\[0\]\.paths\[0\]\[1\]\[0\]: .*finite"),
        ([{"partid": "a", "paths": [box(0, 1e300)]}], r"part 'a', path 1: 1e\+300 is no coordinate"),
        ([DISC, {"paths": [box(0, 1)]}], r"\[1\]\.partid: missing"),
        ([DISC | {"count": 2}], r"\[0\]\.count: unknown field"),
    ],
)
def test_bad_parts_are_named(tmp_path, parts, message):
    with pytest.raises(ValueError, match=r"job\.json: .*" + message):
        read(tmp_path, parts, HOME)


def test_parts_need_a_home(tmp_path):
    with pytest.raises(ValueError, match=r"homes: the format carries none; give --home"):
        read(tmp_path, PARTS)


@pytest.mark.parametrize("chord", [1e-3, 1e3, 1e9])
def test_arcs_of_any_size_have_few_chords(tmp_path, chord):
    path = [[0, 0, 1.0], [chord, 0, 1.0], [0, 0, 0]]
    contour = read(tmp_path, [{"partid": "a", "paths": [path]}], HOME).contours[0]
    assert 8 <= len(contour.geometry) <= 2000
    assert contour.perimeter == pytest.approx(math.pi * chord)


@pytest.mark.parametrize("bulge", [1e-300, 1e-12])
def test_arcs_without_height_are_straight(tmp_path, bulge):
    path = [[0, 0, bulge], [9, 0, bulge], [0, 9, -bulge], [0, 0, 0]]
    contour = read(tmp_path, [{"partid": "a", "paths": [path]}], HOME).contours[0]
    assert contour.geometry.tolist() == [[0, 0], [9, 0], [0, 9]]
