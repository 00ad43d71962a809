"""Hole lists as CSV, and disc lists ``x y z r``."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cutgap.instances import Contour, Head, Instance, Machine, Material
from cutgap.instances.formats import MachineOptions, discs, read_instance, write_instance
from cutgap.instances.formats.csv_format import format_instance, parse_instance
from formats.strategies import FINITE, LENGTHS, NAMES, same_bits

HOME = MachineOptions(homes=((0, 0),))


def read(tmp_path, name, text, options=HOME):
    path = tmp_path / name
    path.write_bytes(text.encode())
    return read_instance(path, options)


@given(st.lists(st.tuples(NAMES, FINITE, FINITE, FINITE, LENGTHS), unique_by=lambda hole: hole[0], max_size=6))
def test_holes_round_trip_bit_for_bit(holes):
    contours = tuple(Contour(name, np.array([[x, y, z]]), p) for name, x, y, z, p in holes)
    instance = Instance("part", contours, HOME.heads())
    assert same_bits(parse_instance(format_instance(instance), "part", HOME), instance)


def test_columns_come_in_any_order_and_z_may_be_left_out(tmp_path):
    text = "perimeter, y ,id,x\r\n5,2,a,1\r\n\r\n6.5,-3e1,b, 4 \r\n"
    instance = read(tmp_path, "part.csv", text)
    assert instance.name == "part"
    assert [contour.id for contour in instance.contours] == ["a", "b"]
    assert instance.points[:2].tolist() == [[1, 2, 0], [4, -30, 0]]
    assert instance.perimeters.tolist() == [5, 6.5]


def test_a_header_alone_is_an_empty_part(tmp_path):
    assert read(tmp_path, "part.csv", "id,x,y,perimeter\n").contours == ()


def test_machine_figures_are_given_with_the_file(tmp_path):
    options = MachineOptions(homes=((9, 1, 2), (1, 1)), v_jump=500.0, v_cut=50.0, t_aux=0.5)
    instance = read(tmp_path, "part.csv", "id,x,y,perimeter\na,1,2,3\n", options)
    assert instance.machine == Machine(500.0, 50.0, 0.5)
    assert [head.home.tolist() for head in instance.heads] == [[1, 1, 0], [9, 1, 2]]


HEADER = "id,x,y,z,perimeter\n"
BAD_CSV = [
    ("", r"line 1: empty file; the header is id,x,y,z,perimeter"),
    ("\n\n", r"line 1: empty file"),
    ("id,x,y,z\na,1,2,3\n", r"line 1: column 'perimeter' is missing"),
    ("x,y,z,perimeter\n", r"line 1: column 'id' is missing"),
    ("id,x,y,Z,perimeter\n", r"line 1: unknown column 'Z'"),
    ("id,x,y,z,perimeter,comment\n", r"line 1: unknown column 'comment'"),
    ("id;x;y;z;perimeter\n", r"line 1: unknown column 'id;x;y;z;perimeter'.*separate columns by commas"),
    ("id,x,x,y,perimeter\n", r"line 1: column 'x' appears more than once"),
    (HEADER + "a,1,2,3\n", r"line 2: expected 5 columns as in the header, got 4"),
    (HEADER + "a,1,2,3,4\nb,1,2,3,4,5\n", r"line 3: expected 5 columns as in the header, got 6"),
    (HEADER + "a,one,2,3,4\n", r"line 2, column x: expected a finite decimal number, got 'one'"),
    (HEADER + "a,1,,3,4\n", r"line 2, column y: expected a finite decimal number, got ''"),
    (HEADER + "a,1,2,nan,4\n", r"line 2, column z: .*got 'nan'"),
    (HEADER + "a,1,inf,3,4\n", r"line 2, column y: .*got 'inf'"),
    (HEADER + "a,1_0,2,3,4\n", r"line 2, column x: .*got '1_0'"),
    (HEADER + "a,\u0661,2,3,4\n", r"line 2, column x: "),
    (HEADER + "a,1e999,2,3,4\n", r"line 2, column x: number too large: '1e999'"),
    (HEADER + 'a,"1,5",2,3,4\n', r"line 2, column x: .*write decimals with a point"),
    (HEADER + "a,1,2,3,-4\n", r"line 2, column perimeter: expected a number of at least 0, got '-4'"),
    (HEADER + ",1,2,3,4\n", r"line 2, column id: empty"),
    (HEADER + "a,1,2,3,4\n\na,5,6,7,8\n", r"line 4, column id: 'a' is already on line 2"),
    (HEADER + '"a\nb",1,2,3,4\nc,1,2,3,x\n', r"line 4, column perimeter: .*got 'x'"),
    (HEADER + '"a,1,2,3,4\n', r"line 2: not CSV: "),
    (HEADER + '"a"b,1,2,3,4\n', r"line 2: not CSV: "),
    (HEADER + "a" * 200_000 + ",1,2,3,4\n", r"line 2: not CSV: field larger than"),
]


@pytest.mark.parametrize(("text", "message"), BAD_CSV)
def test_bad_csv_names_file_line_column_and_value(tmp_path, text, message):
    with pytest.raises(ValueError, match=r"(?s)part\.csv: " + message):
        read(tmp_path, "part.csv", text)


@pytest.mark.parametrize("name", ["part.csv", "part.cetsp"])
def test_homes_are_demanded(tmp_path, name):
    text = HEADER if name.endswith("csv") else "1 2 3 4\n"
    with pytest.raises(ValueError, match=r"homes: .* give --home X,Y\[,Z\] once per head"):
        read(tmp_path, name, text, MachineOptions())


POINT = Contour("a", np.zeros((1, 3)), 1.0)
PART = Instance("part", (POINT, replace(POINT, id="b")), (Head("head", np.zeros(3)),))
STEEL = Material("steel", 48.0, 480.0, 7850.0, 2.0, 1000.0)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"contours": (replace(POINT, entry_points=np.zeros((2, 3))),)}, "several entry points"),
        ({"contours": (replace(POINT, geometry=np.eye(3, 2)),)}, "geometry"),
        ({"contours": (replace(POINT, part="p"),)}, "parts and rings"),
        ({"contours": (replace(POINT, ring="outer"),)}, "parts and rings"),
        ({"precedence": ((0, 1),)}, "precedence"),
        ({"machine": Machine(metric="chebyshev")}, "the metric chebyshev"),
        ({"machine": Machine(metric="matrix"), "matrix": np.ones((3, 3))}, "the metric matrix"),
        ({"material": STEEL}, "a material"),
        ({"heads": (Head("head"),)}, "a closed tour"),
    ],
)
def test_csv_refuses_what_it_cannot_hold(tmp_path, changes, reason):
    with pytest.raises(ValueError, match=rf"part\.csv: .*CSV cannot hold {reason}.*write \.json"):
        write_instance(replace(PART, **changes), tmp_path / "part.csv")
    assert not (tmp_path / "part.csv").exists()


def test_discs_become_holes(tmp_path):
    text = "// x y z r\r\n1\t2\t3\t0.5\r\n 4.5  -6 7e1 0 // a point\r\n\r\n"
    instance = read(tmp_path, "door.cetsp", text, MachineOptions(homes=((7, 8),)))
    assert [contour.id for contour in instance.contours] == ["1", "2"]
    assert instance.points.tolist() == [[1, 2, 3], [4.5, -6, 70], [7, 8, 0]]
    assert instance.perimeters.tolist() == [math.pi, 0]


@pytest.mark.parametrize("depot", ["//Depot is 10, 20, 30", "//Depot: 10, 20, 30", "  // depot:10,20,3e1"])
def test_a_depot_is_the_home_unless_homes_are_given(depot):
    text = f"1 2 3 4 12\n5 6 7 8 0.5\n{depot}\n//Max demand = 12\n//3 4 depot in original form\n"
    (head,) = discs.parse_instance(text, "depot", MachineOptions()).heads
    assert head.home.tolist() == [10, 20, 30]
    (head,) = discs.parse_instance(text, "depot", HOME).heads
    assert head.home.tolist() == [0, 0, 0]


BAD_DISCS = [
    ("", "no disc found"),
    ("// nothing\n\n", "no disc found"),
    ("1 2 3\n", r"line 1: expected 4 \(x y z r\) or 5 \(x y z r demand\) columns, got 3"),
    ("1 2 3 4 5 6\n", "line 1: expected 4 .* columns, got 6"),
    ("1 2 3 4\n//\n1 2 3 4 5\n", "line 3: expected 4 columns, got 5"),
    ("1 2 3 4\n1 2 x 4\n", "line 2, column z: expected a finite decimal number, got 'x'"),
    ("1 2 3 -4\n", "line 1, column r: expected a number of at least 0, got '-4'"),
    ("1 2 3 4 many\n", "line 1, column demand: .*got 'many'"),
    ("nan 2 3 4\n", "line 1, column x: .*got 'nan'"),
    ("1 2 3 1e400\n", "line 1, column r: number too large"),
]


@pytest.mark.parametrize(("text", "message"), BAD_DISCS)
def test_bad_discs_name_file_line_column_and_value(tmp_path, text, message):
    with pytest.raises(ValueError, match=r"door\.txt: " + message):
        read(tmp_path, "door.txt", text)
