"""TSPLIB: distances worked out by hand, published optima, explicit layouts, bad files."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles.held_karp import shortest_tour

from cutgap.instances import Contour, Head, Instance, Machine, Material
from cutgap.instances.formats import MachineOptions, read_instance, write_instance
from cutgap.instances.formats.options import NO_OVERRIDES
from cutgap.instances.formats.tsplib import format_instance, parse_instance
from cutgap.instances.formats.tsplib_metrics import FORMATS, explicit_matrix
from formats.strategies import same_bits

BURMA14 = [
    *[(16.47, 96.10), (16.47, 94.44), (20.09, 92.54), (22.39, 93.37), (25.23, 97.24), (22.00, 96.05)],
    *[(20.47, 97.02), (17.20, 96.29), (16.30, 97.38), (14.05, 98.12), (16.53, 97.38), (21.52, 95.59)],
    *[(19.41, 97.13), (20.09, 94.55)],
]
BURMA14_OPTIMUM = 3323  # published with TSPLIB


def located(points, metric="EUC_2D") -> str:
    rows = [f"{n} {' '.join(map(str, point))}" for n, point in enumerate(points, start=1)]
    head = [f"NAME: points{len(points)}", "TYPE : TSP", "COMMENT : a", "COMMENT : b"]
    return "\n".join(
        [*head, f"DIMENSION: {len(points)}", f"EDGE_WEIGHT_TYPE : {metric}", "NODE_COORD_SECTION", *rows, "EOF"]
    )


def explicit(numbers, size, layout="FULL_MATRIX", kind="TSP") -> str:
    # Numbers run over line ends as they come, as in many published files.
    lines = [" ".join(f"{number:g}" for number in numbers[i : i + 5]) for i in range(0, len(numbers), 5)]
    head = ["NAME : m", f"TYPE : {kind}", f"DIMENSION : {size}", "EDGE_WEIGHT_TYPE : EXPLICIT"]
    return "\n".join([*head, f"EDGE_WEIGHT_FORMAT : {layout}", "EDGE_WEIGHT_SECTION", *lines, "EOF", ""])


def read(tmp_path, text, options=NO_OVERRIDES) -> Instance:
    path = tmp_path / "nodes.tsp"
    path.write_text(text)
    return read_instance(path, options)


def listed(matrix, layout) -> list[float]:
    """List a symmetric matrix as a layout asks, written out by its definition."""
    size = len(matrix)
    columns = {
        "FULL_MATRIX": lambda row: range(size),
        "UPPER_ROW": lambda row: range(row + 1, size),
        "LOWER_ROW": lambda row: range(row),
        "UPPER_DIAG_ROW": lambda row: range(row, size),
        "LOWER_DIAG_ROW": lambda row: range(row + 1),
    }[layout]
    return [float(matrix[row, column]) for row in range(size) for column in columns(row)]


@pytest.mark.parametrize(
    ("metric", "point", "length"),
    [
        # sqrt(1 + 1) = 1.41, sqrt(4 + 4) = 2.83, 2.5 goes up
        ("EUC_2D", (1, 1), 1),
        ("EUC_2D", (2, 2), 3),
        ("EUC_2D", (1.5, 2), 3),
        ("EUC_2D", (3, 4), 5),
        ("CEIL_2D", (1, 1), 2),
        ("CEIL_2D", (3, 4), 5),
        # sqrt((9 + 16) / 10) = 1.58, sqrt(100 / 10) = 3.16, sqrt(160 / 10) = 4
        ("ATT", (3, 4), 2),
        ("ATT", (10, 0), 4),
        ("ATT", (4, 12), 4),
        # 1 degree, and 30 minutes, of 6378.388 km * pi / 180 = 111.32 km, plus 1, cut off
        ("GEO", (1.0, 0.0), 112),
        ("GEO", (0.0, 0.30), 56),
        ("GEO", (-0.30, 0.0), 56),
        # along the equator to the antipode: 6378.388 * pi = 20038.3
        ("GEO", (0.0, 180.0), 20039),
    ],
)
def test_lengths_are_those_worked_out_by_hand(tmp_path, metric, point, length):
    instance = read(tmp_path, located([(0, 0), point], metric))
    assert instance.rapids.tolist() == [[0, length], [length, 0]]
    assert instance.machine.metric == "matrix"


def test_burma14_has_its_published_optimum(tmp_path):
    instance = read(tmp_path, located(BURMA14, "GEO"))
    assert shortest_tour(instance.rapids.tolist())[0] == BURMA14_OPTIMUM
    assert instance.located
    assert instance.name == "points14"
    assert instance.points[4].tolist() == [25.23, 97.24, 0]
    assert [contour.id for contour in instance.contours[:2]] == ["1", "2"]
    assert [head.home for head in instance.heads] == [None]


@pytest.mark.parametrize("layout", FORMATS)
def test_every_layout_gives_the_same_matrix(tmp_path, layout):
    rapids = read(tmp_path, located(BURMA14, "GEO")).rapids
    instance = read(tmp_path, explicit(listed(rapids, layout), 14, layout))
    assert np.array_equal(instance.rapids, rapids)
    assert not instance.located


def test_an_asymmetric_matrix_keeps_its_directions(tmp_path):
    instance = read(tmp_path, explicit([9999, 1, 2, 3, 9999, 4, 5, 6, 9999], 3, kind="ATSP"))
    assert instance.rapids.tolist() == [[0, 1, 2], [3, 0, 4], [5, 6, 0]]


def test_homes_have_lengths_of_the_same_metric(tmp_path):
    options = MachineOptions(homes=((6, 8), (0, 0)), v_jump=500.0)
    instance = read(tmp_path, located([(3, 4), (1, 1)]), options)
    assert [head.id for head in instance.heads] == ["left", "right"]
    assert instance.rapids.tolist() == [[0, 4, 5, 5], [4, 0, 1, 9], [5, 1, 0, 10], [5, 9, 10, 0]]
    assert instance.machine == Machine(v_jump=500.0, metric="matrix")


def test_layout_of_keywords_is_free(tmp_path):
    text = located([(0, 0), (3, 4)]).lower().replace(" : ", ":").replace("section", "section :")
    text = "\r\n\r\n".join(["display_data_section", "1 8 8", "2 9 9", *text.splitlines(), "after the end"])
    assert read(tmp_path, text).rapids.tolist() == [[0, 5], [5, 0]]


def test_nodes_may_come_in_any_order_with_z(tmp_path):
    instance = read(tmp_path, located([(0, 0), (3, 4)]).replace("1 0 0\n2 3 4", "2 3 4 5\n1 0 0 1e1"))
    assert instance.points.tolist() == [[0, 0, 10], [3, 4, 5]]


GOOD = located([(0, 0), (3, 4)])
EXPLICIT = explicit([0, 7, 7, 0], 2)
BAD_FILES = [
    ("", r"TYPE: the field is missing; add one of TSP, ATSP"),
    ("hello world\n", r"line 1: expected KEYWORD : value or a section, got 'hello world'"),
    ("TYPE\n", r"line 1: expected KEYWORD : value or a section, got 'TYPE'"),
    ("1 2 3\n", r"line 1: expected KEYWORD : value"),
    (GOOD.replace("TSP", "GTSP"), r"line 2, TYPE: expected one of TSP, ATSP, got 'GTSP'"),
    (GOOD.replace("COMMENT : b", "TYPE : TSP"), r"line 4, TYPE: appears more than once"),
    (GOOD.replace("DIMENSION: 2", "DIMENSION: two"), r"line 5, DIMENSION: .*got 'two'"),
    (GOOD.replace("DIMENSION: 2", "DIMENSION: 0"), r"line 5, DIMENSION: .*got '0'"),
    (GOOD.replace("DIMENSION: 2", "DIMENSION: 5001"), r"line 5, DIMENSION: at most 5000 nodes"),
    (
        GOOD.replace("DIMENSION: 2", "DIMENSION: 3"),
        r"line 7, NODE_COORD_SECTION: expected 3 nodes, got 2; no node 3",
    ),
    (GOOD.replace("DIMENSION: 2", "DIMENSION: 1"), r"line 9, NODE_COORD_SECTION: node 2 is above DIMENSION 1"),
    (GOOD.replace("DIMENSION: 2\n", ""), r"DIMENSION: the field is missing"),
    (
        GOOD.replace("EUC_2D", "EUC_9D"),
        r"line 6, EDGE_WEIGHT_TYPE: expected one of EXPLICIT, EUC_2D, .*'EUC_9D'",
    ),
    (GOOD.replace("NODE_COORD", "FIXED_EDGES"), r"line 7, FIXED_EDGES_SECTION: not known here"),
    (
        re.sub(r"NODE.*4\n", "", GOOD, flags=re.S),
        r"NODE_COORD_SECTION: the section is missing; EUC_2D needs it",
    ),
    (GOOD.replace("2 3 4", "2 3"), r"line 9, NODE_COORD_SECTION: expected node, x, y \(and z\), got 2 words"),
    (GOOD.replace("2 3 4", "1 3 4"), r"line 9, NODE_COORD_SECTION: node 1 appears more than once"),
    (GOOD.replace("2 3 4", "0 3 4"), r"line 9, NODE_COORD_SECTION, node: .*got '0'"),
    (GOOD.replace("2 3 4", "2 nan 4"), r"line 9, NODE_COORD_SECTION, node 2: .*got 'nan'"),
    (GOOD.replace("2 3 4", "2 1e999 4"), r"line 9, NODE_COORD_SECTION, node 2: number too large"),
    (GOOD.replace("2 3 4", "2 1e200 4"), r"matrix: expected finite numbers, got inf"),
    (EXPLICIT.replace("FULL_MATRIX", "UPPER_COL"), r"line 5, EDGE_WEIGHT_FORMAT: expected one of FULL_MATRIX"),
    (
        EXPLICIT.replace("0 7 7 0", "0 7 7"),
        r"line 6, EDGE_WEIGHT_SECTION: expected 4 numbers for FULL_MATRIX, got 3",
    ),
    (EXPLICIT.replace("0 7 7 0", "0 7 7 0 1"), r"line 7, EDGE_WEIGHT_SECTION: more than the 4 numbers"),
    (EXPLICIT.replace("0 7 7 0", "0 7 -7 0"), r"line 7, EDGE_WEIGHT_SECTION: .*at least 0, got '-7'"),
    (EXPLICIT.replace("0 7 7 0", "0 7 8 0"), r"line 6, .*TYPE TSP is symmetric, but 1 to 2 is 7 and back 8"),
    (EXPLICIT.split("EDGE_WEIGHT_SECTION")[0], r"EDGE_WEIGHT_SECTION: the section is missing"),
]


@pytest.mark.parametrize(("text", "message"), BAD_FILES)
def test_a_bad_file_is_named_with_line_and_section(tmp_path, text, message):
    with pytest.raises(ValueError, match=r"nodes\.tsp: .*" + message):
        read(tmp_path, text)


@pytest.mark.parametrize(
    ("text", "home", "message"),
    [
        (EXPLICIT, (1, 2), "EXPLICIT gives no lengths to other homes; leave --home out"),
        (GOOD, (1, 2, 3), "EUC_2D has no z; give --home X,Y"),
    ],
)
def test_homes_without_computable_lengths_are_refused(tmp_path, text, home, message):
    with pytest.raises(ValueError, match=message):
        read(tmp_path, text, MachineOptions(homes=(home,)))


@given(st.data())
def test_what_the_format_holds_round_trips_bit_for_bit(data):
    size = data.draw(st.integers(1, 5))
    lengths = st.floats(0, 1e9) | st.integers(0, 10**6).map(float)
    layout = data.draw(st.sampled_from(["FULL_MATRIX", "UPPER_ROW"]))
    count = size * size if layout == "FULL_MATRIX" else size * (size - 1) // 2
    numbers = np.array(data.draw(st.lists(lengths, min_size=count, max_size=count)), dtype=np.float64)
    flat = data.draw(st.booleans())
    coordinate = st.just(0.0) if flat else st.floats(-1e6, 1e6)
    points = [data.draw(st.lists(coordinate, min_size=3, max_size=3)) for _ in range(size)]
    instance = Instance(
        name=data.draw(st.sampled_from(["m", "two words", "EOF", "a : b"])),
        contours=tuple(Contour(str(n), np.array([point]), 0.0) for n, point in enumerate(points, start=1)),
        heads=(Head("head"),),
        machine=Machine(metric="matrix"),
        matrix=explicit_matrix(layout, size, numbers),
        located=not flat,
    )
    assert same_bits(parse_instance(format_instance(instance), "unused", NO_OVERRIDES), instance)


POINTS = tuple(Contour(str(n), np.zeros((1, 3)), 0.0) for n in (1, 2))
BARE = Instance("bare", POINTS, (Head("head"),), Machine(metric="matrix"), matrix=np.ones((2, 2)))


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"contours": (replace(POINTS[0], entry_points=np.zeros((2, 3))),)}, "several entry points"),
        ({"contours": (replace(POINTS[0], geometry=np.eye(3, 2)), POINTS[1])}, "geometry"),
        ({"contours": (replace(POINTS[0], part="p"), POINTS[1])}, "parts and rings"),
        ({"contours": (replace(POINTS[0], perimeter=1.0), POINTS[1])}, "perimeters"),
        ({"contours": POINTS[::-1]}, "ids other than 1, 2"),
        ({"contours": (), "matrix": np.ones((0, 0))}, "no node"),
        ({"precedence": ((0, 1),)}, "precedence"),
        ({"material": Material("steel", 48.0, 480.0, 7850.0, 2.0, 1000.0)}, "a material"),
        ({"heads": (Head("head", np.zeros(3)),), "matrix": np.ones((3, 3))}, "homes"),
        ({"heads": (Head("a"), Head("b"))}, "several heads"),
        ({"machine": Machine(), "matrix": None}, "the metric euclidean unrounded"),
        ({"name": "two\nlines"}, "a name that is empty or has odd blanks"),
        ({"name": ""}, "a name that is empty or has odd blanks"),
    ],
)
def test_tsplib_refuses_what_it_cannot_hold(tmp_path, changes, reason):
    with pytest.raises(ValueError, match=rf"out\.tsp: .*TSPLIB cannot hold {reason}.*write \.json"):
        write_instance(replace(BARE, **changes), tmp_path / "out.tsp")
    assert not (tmp_path / "out.tsp").exists()


def test_whole_numbers_are_written_without_a_point(tmp_path):
    write_instance(replace(BARE, matrix=np.array([[0, 3], [3, 0]])), tmp_path / "out.tsp")
    assert "EDGE_WEIGHT_SECTION\n0 3\n3 0\nEOF\n" in (tmp_path / "out.tsp").read_text()
