"""GTSPLIB and its relatives: what files mean, published optima, exact round trips, bad files."""

from dataclasses import replace
from itertools import permutations, product

import numpy as np
import pytest
from oracles.random_instances import layout_points

from cutgap.instances import Contour, Head, Instance, Machine, Material, Plan, Rules, check, evaluate
from cutgap.instances.formats import MachineOptions, read_instance, write_instance
from cutgap.instances.formats.options import NO_OVERRIDES
from formats.strategies import same_bits
from formats.test_tsplib import BURMA14

BURMA_SETS = [[5], [1, 8, 9, 10, 11], [2, 3, 4, 6, 7, 12, 13, 14]]
BURMA_OPTIMUM = 1805  # published with GTSPLIB


def document(kind, size, sets, *, points=None, matrix=None, metric="EUC_2D", ordering=(), start=None) -> str:
    """Write a file; nodes and sets are numbered from 1."""
    lines = ["NAME : x", f"TYPE : {kind}", f"DIMENSION : {size}", f"GTSP_SETS : {len(sets)}"]
    if matrix is not None:
        lines += ["EDGE_WEIGHT_TYPE : EXPLICIT", "EDGE_WEIGHT_FORMAT : FULL_MATRIX", "EDGE_WEIGHT_SECTION"]
        lines += [" ".join(f"{number:g}" for number in row) for row in matrix]
    else:
        lines.append(f"EDGE_WEIGHT_TYPE : {metric}")
    if points is not None:
        lines.append("NODE_COORD_SECTION")
        lines += [f"{n} {' '.join(map(repr, map(float, point)))}" for n, point in enumerate(points, start=1)]
    lines.append("GTSP_SET_SECTION")
    lines += [f"{k} {' '.join(map(str, nodes))} -1" for k, nodes in enumerate(sets, start=1)]
    if ordering:
        lines += ["GTSP_SET_ORDERING", *(" ".join(map(str, row)) + " -1" for row in ordering)]
    if start is not None:
        lines += ["START_GROUP_SECTION", str(start)]
    return "\n".join([*lines, "EOF", ""])


def read(tmp_path, text, suffix=".gtsp", options=NO_OVERRIDES) -> Instance:
    path = tmp_path / f"nodes{suffix}"
    path.write_text(text)
    return read_instance(path, options)


def shortest(instance, rules=None) -> float:
    """Return the least travel of one head over all orders and entry points that are allowed."""
    rules = rules or Rules("travel", non_overlap=None)
    entries = [range(len(contour.entry_points)) for contour in instance.contours]
    plans = (
        Plan(((*zip(order, chosen, strict=True),),))
        for order in permutations(range(len(entries)))
        for chosen in product(*(entries[contour] for contour in order))
    )
    return min(evaluate(instance, p).total_travel_mm for p in plans if not check(instance, rules, p))


def random_sets(rng, size, count) -> list[list[int]]:
    """Split the nodes 1 .. size at random into sets, none of them empty."""
    nodes = rng.permutation(size) + 1
    return [
        part.tolist() for part in np.split(nodes, np.sort(rng.choice(size - 1, count - 1, replace=False)) + 1)
    ]


def test_burma14_has_its_published_optimum(tmp_path):
    instance = read(tmp_path, document("GTSP", 14, BURMA_SETS, points=BURMA14, metric="GEO"))
    assert shortest(instance) == BURMA_OPTIMUM
    assert [contour.id for contour in instance.contours] == ["1", "2", "3"]
    assert instance.name == "nodes"  # the file's, not the field's
    assert [head.home for head in instance.heads] == [None]


@pytest.mark.parametrize("seed", range(5))
def test_each_set_is_a_contour_whose_entries_keep_lengths_and_places(tmp_path, seed):
    rng = np.random.default_rng(seed)
    size = 12
    points = layout_points(rng, "uniform", size)[:, :2]
    matrix = rng.integers(1, 99, (size, size))
    sets = random_sets(rng, size, 4)
    instance = read(tmp_path, document("AGTSP", size, sets, points=points, matrix=matrix))
    nodes = [node - 1 for members in sets for node in members]
    assert [len(c.entry_points) for c in instance.contours] == [len(members) for members in sets]
    assert np.array_equal(instance.points[:, :2], points[nodes])
    expected = matrix[np.ix_(nodes, nodes)]
    assert all(instance.rapids[a, b] == expected[a, b] for a in range(size) for b in range(size) if a != b)


def test_sets_may_be_listed_in_any_order_and_run_over_lines(tmp_path):
    text = document("GTSP", 4, [[1, 3], [4, 2]], points=[(0, 0), (9, 0), (0, 9), (9, 9)])
    shuffled = text.replace("1 1 3 -1\n2 4 2 -1", "2 4\n2 -1 1 1\n3\n-1")
    assert shuffled != text
    assert same_bits(read(tmp_path, shuffled), read(tmp_path, text))


# Home at (0, 0); sets 2 and 3 with two nodes each, 4 with one.
POINTS = [(0, 0), (10, 0), (20, 0), (10, 10), (20, 10), (0, 20)]
SETS = [[1], [2, 3], [4, 5], [6]]


def ordered_matrix(ordering, sets) -> np.ndarray:
    """Return lengths that tell all arcs apart, with -1 where the ordering forbids them."""
    size = sum(map(len, sets))
    matrix = 100.0 + np.arange(size * size).reshape(size, size)
    for first, *others in ordering:
        for other in others:
            matrix[np.ix_([n - 1 for n in sets[other - 1]], [n - 1 for n in sets[first - 1]])] = -1
    return matrix


def test_a_start_set_of_one_node_is_the_home_and_its_arcs_count(tmp_path):
    ordering = [(3, 2, 4), (2, 4)]
    matrix = ordered_matrix(ordering, SETS)
    text = document("PCGLNS", 6, SETS, points=POINTS, matrix=matrix, ordering=ordering, start=1)
    instance = read(tmp_path, text, ".pcglns")
    assert [contour.id for contour in instance.contours] == ["2", "3", "4"]
    assert instance.heads[0].home.tolist() == [0, 0, 0]
    assert instance.precedence == ((1, 0), (1, 2), (0, 2))
    nodes = [1, 2, 3, 4, 5, 0]
    for a, b in product(range(6), repeat=2):
        given, back = matrix[nodes[a], nodes[b]], matrix[nodes[b], nodes[a]]
        assert instance.rapids[a, b] == (0 if a == b else back if given == -1 else given)
    assert (instance.rapids >= 0).all()


def test_a_start_set_of_several_nodes_comes_first_on_a_closed_tour(tmp_path):
    sets, points = [[1], [2, 3], [4, 5, 6]], POINTS
    text = document("PCGLNS", 6, sets, points=points, matrix=np.full((6, 6), 7), ordering=[(2, 1)], start=2)
    instance = read(tmp_path, text, ".pcglns")
    assert [head.home for head in instance.heads] == [None]
    assert instance.precedence == ((1, 0), (1, 2))
    # Into the start set the tour closes, so that these arcs are needed.
    matrix = np.full((6, 6), 7)
    matrix[0, [1, 2]] = -1
    with pytest.raises(ValueError, match="from node 1 to node 2: -1, but GTSP_SET_ORDERING does not forbid"):
        read(tmp_path, document("PCGLNS", 6, sets, matrix=matrix, ordering=[(2, 1)], start=2), ".pcglns")


def test_an_arc_is_forbidden_by_pairs_in_a_row_too(tmp_path):
    matrix = np.full((4, 4), 5)
    matrix[3, 1] = -1
    sets = [[1], [2], [3], [4]]
    instance = read(tmp_path, document("PCGLNS", 4, sets, matrix=matrix, ordering=[(2, 3), (3, 4)], start=1))
    assert instance.rapids[2, 0] == 5
    assert instance.precedence == ((0, 1), (1, 2))


def test_cutting_paths_have_exact_lengths_a_home_and_geometry(tmp_path):
    points = [(0, 0), (1, 1), (41.5, 1), (41.5, 31.25), (1, 31.25), (10, 10), (20, 10), (15, 20)]
    text = document("PCGTSP ", 8, [[1], [2, 3, 4, 5], [6, 7, 8]], points=points, ordering=[(3, 2)])
    instance = read(tmp_path, text, ".txt")
    assert instance.machine.metric == "euclidean"
    assert instance.rapid_length(0, 2) == pytest.approx(np.hypot(40.5, 30.25), rel=1e-15)
    assert instance.heads[0].home.tolist() == [0, 0, 0]
    assert instance.precedence == ((1, 0),)
    assert instance.contours[0].geometry.tolist() == [list(point) for point in points[1:5]]
    assert [c.perimeter for c in instance.contours] == pytest.approx([2 * (40.5 + 30.25), 10 + 2 * 125**0.5])
    moved = read(tmp_path, text, ".txt", MachineOptions(homes=((5, 6, 0),), v_jump=300.0))
    assert moved.heads[0].home.tolist() == [5, 6, 0]
    assert same_bits(moved.contours, instance.contours)
    assert moved.machine == Machine(v_jump=300.0)


@pytest.mark.parametrize(
    ("sets", "ordering"),
    [([[1, 2], [3, 4, 5]], ()), ([[1], [2, 3, 4, 5]], ((2, 1),))],
)
def test_a_first_set_that_cannot_be_the_home_is_a_contour(tmp_path, sets, ordering):
    instance = read(tmp_path, document("PCGTSP", 5, sets, points=POINTS[:5], ordering=ordering), ".txt")
    assert len(instance.contours) == 2
    assert instance.heads[0].home is None


def test_points_that_do_not_run_around_a_contour_are_no_geometry(tmp_path):
    crossed = [(0, 0), (0, 0), (10, 10), (10, 0), (0, 10), (1, 1), (2, 2)]
    instance = read(tmp_path, document("PCGTSP", 7, [[1], [2, 3, 4, 5], [6, 7]], points=crossed), ".txt")
    assert [contour.geometry for contour in instance.contours] == [None, None]


def test_discs_in_a_txt_file_are_still_discs(tmp_path):
    instance = read(tmp_path, "\n//Depot is 1, 2, 0\n3 4 0 5\n", ".txt")
    assert instance.contours[0].perimeter == pytest.approx(10 * np.pi)


def test_numbers_in_bulk_keep_every_bit(tmp_path):
    rng = np.random.default_rng(7)
    matrix = rng.uniform(0, 1e3, (30, 30))
    lines = [" ".join(f"{number!r}" for number in row.tolist()) for row in matrix]
    text = document("AGTSP", 30, [[n] for n in range(1, 31)], matrix=np.zeros((30, 30)))
    instance = read(tmp_path, text.replace("\n".join([" ".join(["0"] * 30)] * 30), "\n".join(lines)))
    np.fill_diagonal(matrix, 0)
    assert np.array_equal(instance.rapids, matrix)


GOOD = document("GTSP", 4, [[1, 2], [3, 4]], points=POINTS[:4])
ORDERED = document("PCGLNS", 3, [[1], [2], [3]], matrix=np.full((3, 3), 7), ordering=[(2, 3)], start=1)
FULL = document("GTSP", 2, [[1], [2]], matrix=[[0, 7], [7, 0]])
BAD_FILES = [
    ("", r"TYPE: the field is missing; add one of GTSP, AGTSP, PCGLNS, PCGTSP"),
    (GOOD.replace("TYPE : GTSP", "TYPE : TSP"), r"line 2, TYPE: expected one of GTSP.*got 'TSP'"),
    (GOOD.replace("GTSP_SETS : 2\n", ""), r"GTSP_SETS: the field is missing"),
    (GOOD.replace("GTSP_SETS : 2", "GTSP_SETS : -2"), r"line 4, GTSP_SETS: .*got '-2'"),
    (GOOD.replace("GTSP_SETS : 2", "GTSP_SETS : 5"), r"line 4, GTSP_SETS: 5 sets of 4 nodes"),
    (GOOD.replace("GTSP_SETS : 2", "GTSP_SETS : 3"), r"line 11, GTSP_SET_SECTION: .*there is no set 3"),
    (GOOD.replace("GTSP_SETS : 2", "GTSP_SETS : 1"), r"line 13, .*there is no set 2; GTSP_SETS is 1"),
    (GOOD.split("GTSP_SET_SECTION")[0], r"GTSP_SET_SECTION: the section is missing"),
    (GOOD.replace("2 3 4 -1", "2 3 4"), r"line 13, GTSP_SET_SECTION: the list that begins here does not end"),
    (GOOD.replace("1 1 2 -1", "1 1 2"), r"line 12, GTSP_SET_SECTION, set 1: node 2 is in set 1 already"),
    (GOOD.replace("2 3 4 -1", "2 3 1 -1"), r"line 13, .*set 2: node 1 is in set 1 already; keep it in one"),
    (GOOD.replace("2 3 4 -1", "2 3 -1"), r"line 11, GTSP_SET_SECTION: node 4 is in no set; put it into one"),
    (GOOD.replace("2 3 4 -1", "2 3 4 5 -1"), r"line 13, .*set 2: node 5 is not among the nodes 1 to 4"),
    (GOOD.replace("2 3 4 -1", "2 3 4 0 -1"), r"line 13, .*set 2: node 0 is not among"),
    (GOOD.replace("2 3 4 -1", "2 -1"), r"line 13, GTSP_SET_SECTION, set 2: has no node"),
    (GOOD.replace("2 3 4 -1", "1 3 4 -1"), r"line 13, .*set 1: listed more than once"),
    (GOOD.replace("2 3 4 -1", "2 3 4 -1 -1"), r"line 13, .*a list with no number before its -1"),
    (GOOD.replace("2 3 4 -1", "2 3 4.5 -1"), r"line 13, .*expected a whole number, got '4.5'"),
    (GOOD.replace("EUC_2D", "MAN_2D"), r"line 5, EDGE_WEIGHT_TYPE: .*got 'MAN_2D'"),
    (
        GOOD.replace("NODE_COORD", "DISPLAY_DATA"),
        r"NODE_COORD_SECTION: the section is missing; EUC_2D needs it",
    ),
    (GOOD.replace("EOF", "TOUR_SECTION\n1 2\nEOF"), r"line 14, TOUR_SECTION: not known here"),
    (
        FULL.replace("\n0 7\n", "\n0 8\n"),
        r"TYPE GTSP is symmetric, but 1 to 2 is 8 and back 7; write TYPE AGTSP",
    ),
    (FULL.replace("\n0 7\n", "\n0 -1\n"), r"line 8, EDGE_WEIGHT_SECTION: .*at least 0, got '-1'"),
    (FULL.replace("\n0 7\n", "\n0 1e999\n"), r"line 8, EDGE_WEIGHT_SECTION: number too large: '1e999'"),
    (FULL.replace("\n0 7\n", "\n0 7_0\n"), r"line 8, EDGE_WEIGHT_SECTION: .*got '7_0'"),
    (FULL.replace("\n0 7\n", "\n0 1e\n"), r"line 8, EDGE_WEIGHT_SECTION: .*got '1e'"),
    (ORDERED.replace("2 3 -1", "2 4 -1"), r"line 16, GTSP_SET_ORDERING: there is no set 4; GTSP_SETS is 3"),
    (ORDERED.replace("2 3 -1", "2 2 -1"), r"line 16, .*set 2 cannot come before itself"),
    (
        ORDERED.replace("2 3 -1", "2 3 -1\n3 2 -1"),
        r"line 15, GTSP_SET_ORDERING: no order is possible.* (2, 3, 2|3, 2, 3) comes",
    ),
    (ORDERED.replace("2 3 -1", "2 3"), r"line 16, GTSP_SET_ORDERING: the list that begins here does not end"),
    (ORDERED.replace("2 3 -1", "2 1 -1"), r"set 2 cannot come before set 1, which START_GROUP_SECTION names"),
    (
        ORDERED.replace("SECTION\n1\n", "SECTION\n\n"),
        r"START_GROUP_SECTION: expected the number of one set, got ''",
    ),
    (ORDERED.replace("SECTION\n1\n", "SECTION\n1 2\n"), r"START_GROUP_SECTION: .*got '1 2'"),
    (ORDERED.replace("SECTION\n1\n", "SECTION\n9\n"), r"START_GROUP_SECTION: there is no set 9"),
    (
        ORDERED.replace("7 7 7\n7 7 7\n", "7 -1 7\n7 7 7\n", 1),
        r"from node 1 to node 2: -1, but .* from set 1 to set 2",
    ),
    (
        ORDERED.replace("7 7 7\nG", "7 -0.5 7\nG"),
        r"from node 3 to node 2: expected a length of at least 0, .*-0.5",
    ),
    (ORDERED.replace("7 7 7\nG", "7 -2 7\nG"), r"line 10, EDGE_WEIGHT_SECTION: .*got '-2'"),
    (
        ORDERED.replace("7 7 7\nG", "7 -1 7\nG").replace("START_GROUP_SECTION\n1\n", ""),
        r"from node 3 to node 2: -1 without a start set, so the arc may close the tour",
    ),
    (
        document("PCGTSP", 4, [[1], [2, 3, 4]], points=[(0, 0), (1e308, 0), (0, 1e308), (-1e308, -1e308)]),
        r"contour '2', perimeter: expected a finite number",
    ),
    (
        document("PCGTSP", 2, [[1], [2]], points=[(0, 0, 0), (1, 1, 1)]),
        r"line 6, NODE_COORD_SECTION: EUC_2D has no z; give x and y",
    ),
]


@pytest.mark.parametrize(("text", "message"), BAD_FILES)
def test_a_bad_file_is_named_with_line_and_set(tmp_path, text, message):
    with pytest.raises(ValueError, match=r"nodes\.gtsp: .*(" + message + ")"):
        read(tmp_path, text)


def test_the_good_ones_are_good(tmp_path):
    assert [len(read(tmp_path, text).contours) for text in (GOOD, ORDERED, FULL)] == [2, 2, 2]


def random_entry_instance(rng, *, home, located, symmetric) -> Instance:
    """Draw contours with several entry points, ids that are numbers of sets, and lengths far from whole."""
    count = int(rng.integers(1, 6))
    numbers = list(range(1, count + 1 + home))
    if home:
        numbers.pop(int(rng.integers(len(numbers))))
    reach = 9.0 if located else 0.0
    contours = tuple(
        Contour(str(number), rng.uniform(0, reach, (int(rng.integers(1, 4)), 3)), 0.0) for number in numbers
    )
    size = sum(len(contour.entry_points) for contour in contours) + home
    matrix = np.where(
        rng.random((size, size)) < 0.5, rng.integers(0, 9, (size, size)), rng.uniform(0, 1e6, (size, size))
    )
    order = rng.permutation(count)
    pairs = [(int(order[a]), int(order[b])) for b in range(count) for a in range(b) if rng.random() < 0.4]
    return Instance(
        "round trip",
        contours,
        (Head("head", rng.uniform(0, reach, 3) if home else None),),
        Machine(metric="matrix"),
        tuple(pairs),
        np.maximum(matrix, matrix.T) if symmetric else matrix,
        located=located,
    )


@pytest.mark.parametrize("seed", range(40))
def test_what_the_formats_hold_round_trips_bit_for_bit(tmp_path, seed):
    rng = np.random.default_rng(seed)
    home, located, symmetric = rng.integers(2, size=3).astype(bool).tolist()
    instance = random_entry_instance(rng, home=home, located=located, symmetric=symmetric)
    for suffix in (".pcglns", ".gtsp"):
        path = tmp_path / f"round trip{suffix}"
        if suffix == ".gtsp":
            instance = replace(instance, precedence=())
            if home:
                break
        write_instance(instance, path)
        assert same_bits(read_instance(path), instance)


def test_the_marks_of_forbidden_arcs_are_written_again(tmp_path):
    ordering = [(3, 2, 4), (2, 4)]
    matrix = ordered_matrix(ordering, SETS)
    instance = read(tmp_path, document("PCGLNS", 6, SETS, matrix=matrix, ordering=ordering, start=1))
    write_instance(instance, tmp_path / "again.pcglns")
    text = (tmp_path / "again.pcglns").read_text()
    rows = text.split("EDGE_WEIGHT_SECTION\n")[1].splitlines()[:6]
    written = np.array([row.split() for row in rows], dtype=float)
    assert np.array_equal(written == -1, matrix == -1)
    assert "3 2 4 -1\n2 4 -1\nSTART_GROUP_SECTION\n1\n" in text


TWO = Instance(
    "two",
    (Contour("1", np.zeros((2, 3)), 0.0), Contour("2", np.ones((1, 3)), 0.0)),
    (Head("head"),),
    Machine(metric="matrix"),
    matrix=np.ones((3, 3)),
)
HOME = {"heads": (Head("head", np.zeros(3)),), "matrix": np.ones((4, 4))}


@pytest.mark.parametrize(
    ("suffix", "change", "message"),
    [
        (".gtsp", {"precedence": ((0, 1),)}, "precedence; write .pcglns instead"),
        (".gtsp", HOME, "homes; write .pcglns instead"),
        (
            ".gtsp",
            {"machine": Machine(), "matrix": None},
            "the metric euclidean unrounded; write .json instead",
        ),
        (".pcglns", {"heads": (Head("a"), Head("b"))}, "several heads"),
        (".pcglns", {"material": Material("steel", 1, 1, 1, 1, 1)}, "a material"),
        (".pcglns", {"contours": (TWO.contours[1], TWO.contours[0])}, "ids other than the numbers of sets"),
        (".pcglns", {"contours": (TWO.contours[0], Contour("3", np.ones((1, 3)), 0.0))}, "ids other than"),
        (".pcglns", {"contours": (TWO.contours[0], Contour("2", np.ones((1, 3)), 9.0))}, "perimeters"),
        (".gtsp", {"contours": (TWO.contours[0], Contour("2", np.ones((1, 3)), 0.0, "p"))}, "parts and rings"),
        (
            ".gtsp",
            {"contours": (TWO.contours[0], Contour("2", np.ones((1, 3)), 0.0, geometry=np.eye(3, 2)))},
            "geometry",
        ),
        (".gtsp", {"contours": (), "matrix": np.empty((0, 0))}, "no node"),
        (".gtsp", {"name": " "}, "a name"),
    ],
)
def test_what_would_be_lost_is_not_written(tmp_path, suffix, change, message):
    path = tmp_path / f"two{suffix}"
    with pytest.raises(ValueError, match=rf"two{suffix}: .*cannot hold .*{message}"):
        write_instance(replace(TWO, **change), path)
    assert not path.exists()
