"""Bad input is refused with the field and the value; odd but good input is taken."""

import numpy as np
import pytest

from cutgap.instances import Contour, Head, Instance, Machine, Material, Plan, Rules, Visit

POINT = [[10.0, 20.0, 30.0]]
STEEL = {
    "name": "steel",
    "conductivity_w_per_m_k": 48.0,
    "specific_heat_j_per_kg_k": 480.0,
    "density_kg_per_m3": 7850.0,
    "thickness_mm": 2.0,
    "power_w": 2000.0,
}


def hole(name="a", points=POINT, perimeter=40.0, **more) -> Contour:
    return Contour(name, points, perimeter, **more)


HEADS = (Head("left", [0, 0, 0]), Head("right", [9, 0, 0]))


def instance(contours=(), heads=HEADS, **more) -> Instance:
    return Instance("plate", tuple(contours), tuple(heads), **more)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_coordinates_must_be_finite(value, axis):
    point = [[1.0, 2.0, 3.0]]
    point[0][axis] = value
    with pytest.raises(ValueError, match=f"contour 'a', entry_points: .*finite.* got {value}"):
        hole(points=point)
    with pytest.raises(ValueError, match=f"head 'left', home: .*finite.* got {value}"):
        Head("left", point[0])


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([[1.0, 2.0]], r"contour 'a', entry_points: expected 3 numbers a row, got shape \(1, 2\)"),
        ([], r"contour 'a', entry_points: expected 3 numbers a row, got shape \(0,\)"),
        (np.empty((0, 3)), "contour 'a', entry_points: expected at least one row"),
        ([1.0, 2.0, 3.0], "contour 'a', entry_points: expected at least one row"),
        ([["x", 2.0, 3.0]], "contour 'a', entry_points: expected numbers, got .*'x'"),
        ([[1.0, 2.0, 3.0], [1.0, 2.0]], "contour 'a', entry_points: expected numbers"),
        ([[10**400, 0, 0]], "contour 'a', entry_points: expected numbers, got .*1000"),
    ],
)
def test_entry_points_must_be_rows_of_three(points, message):
    with pytest.raises(ValueError, match=message):
        hole(points=points)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (-1.0, "expected a number of at least 0, got -1"),
        (-1e-300, "expected a number of at least 0, got -1e-300"),
        (float("nan"), "expected a finite number, got nan"),
        (float("inf"), "expected a finite number, got inf"),
        (10**400, "expected a finite number, got inf"),
        ("40", "expected a number, got '40'"),
        (None, "expected a number, got None"),
        (True, "expected a number, got True"),
    ],
)
def test_perimeter_must_be_finite_and_not_negative(value, message):
    with pytest.raises(ValueError, match=f"contour 'a', perimeter: {message}"):
        hole(perimeter=value)


def test_perimeter_of_zero_is_a_point_to_visit():
    given = instance([hole(perimeter=0)])
    assert given.perimeters.tolist() == [0.0]
    assert given.service_times.tolist() == [1.0]


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("v_jump", 0.0, "above 0, got 0"),
        ("v_jump", -150.0, "above 0, got -150"),
        ("v_jump", float("nan"), "finite number, got nan"),
        ("v_jump", float("inf"), "finite number, got inf"),
        ("v_cut", 0, "above 0, got 0"),
        ("v_cut", -1.0, "above 0, got -1"),
        ("v_cut", float("nan"), "finite number, got nan"),
        ("t_aux", -0.5, "at least 0, got -0.5"),
        ("t_aux", float("nan"), "finite number, got nan"),
        ("metric", "manhattan", "euclidean, chebyshev, matrix, got 'manhattan'"),
    ],
)
def test_machine_names_field_and_value(field, value, message):
    with pytest.raises(ValueError, match=f"machine, {field}: .*{message}"):
        Machine(**{field: value})


def test_no_auxiliary_time_is_taken():
    assert instance([hole()], machine=Machine(t_aux=0)).service_times.tolist() == [1.0]


@pytest.mark.parametrize(
    "field",
    ["conductivity_w_per_m_k", "specific_heat_j_per_kg_k", "density_kg_per_m3", "thickness_mm", "power_w"],
)
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan")])
def test_material_names_field_and_value(field, value):
    with pytest.raises(ValueError, match=f"material, {field}: .*got {value:g}"):
        Material(**(STEEL | {field: value}))


def test_material_ambient_may_be_below_zero_but_not_endless():
    assert Material(**STEEL, ambient_c=-10).ambient_c == -10
    with pytest.raises(ValueError, match=r"material, ambient_c: .*got inf"):
        Material(**STEEL, ambient_c=float("inf"))


def test_ids_are_texts_and_appear_once():
    with pytest.raises(ValueError, match="contour id 'a' appears more than once"):
        instance([hole("a"), hole("b"), hole("a")])
    with pytest.raises(ValueError, match="head id 'h' appears more than once"):
        instance(heads=[Head("h"), Head("h")])
    for bad in ("", 7, None):
        with pytest.raises(ValueError, match=f"contour id: expected a non-empty text, got {bad!r}"):
            hole(bad)
        with pytest.raises(ValueError, match=f"head id: expected a non-empty text, got {bad!r}"):
            Head(bad)


def test_home_is_one_point():
    with pytest.raises(ValueError, match=r"head 'left', home: expected 3 numbers a row, got shape \(2,\)"):
        Head("left", [1.0, 2.0])
    with pytest.raises(ValueError, match=r"head 'left', home: expected x, y, z, got shape \(1, 3\)"):
        Head("left", POINT)


def test_ring_and_geometry():
    with pytest.raises(ValueError, match=r"contour 'a', ring: .*got 'slot'"):
        hole(ring="slot")
    with pytest.raises(ValueError, match="contour 'a', geometry: expected at least 3 rows"):
        hole(geometry=[[0, 0], [1, 1]])
    with pytest.raises(ValueError, match=r"contour 'a', geometry: .*got shape \(1, 3\)"):
        hole(geometry=POINT)
    assert hole(geometry=[[0, 0], [1, 0], [0, 1]], ring="outer", part="door").geometry.shape == (3, 2)


@pytest.mark.parametrize(
    ("pairs", "message"),
    [
        ([(0, 1), (1, 2), (2, 0)], "cycle among 'a', 'b', 'c'"),
        ([(0, 1), (1, 0)], "cycle among 'a', 'b'"),
        ([(2, 2)], "cycle among 'c'"),
        ([(0, 3)], r"pair \(0, 3\) names no contour of 3"),
        ([(-1, 0)], r"pair \(-1, 0\) names no contour of 3"),
    ],
)
def test_precedence_has_no_cycle(pairs, message):
    with pytest.raises(ValueError, match=f"precedence: .*{message}"):
        instance([hole("a"), hole("b"), hole("c")], precedence=pairs)


def test_precedence_may_be_a_diamond_and_repeat_pairs():
    pairs = ((0, 1), (0, 2), (1, 3), (2, 3), (0, 1))
    assert instance([hole(name) for name in "abcd"], precedence=pairs).precedence == pairs


def test_at_least_one_head_but_no_contour_needed():
    with pytest.raises(ValueError, match="instance 'plate', heads: expected at least one, got none"):
        instance(heads=[])
    empty = instance()
    assert (empty.node_count, empty.points.shape, empty.perimeters.shape) == (2, (2, 3), (0,))
    nowhere = instance(heads=[Head("only")])
    assert (nowhere.node_count, nowhere.points.shape, nowhere.rapids.shape) == (0, (0, 3), (0, 0))


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (np.zeros((2, 2)), r"expected 3 x 3, got shape \(2, 2\)"),
        (np.zeros((3, 2)), r"expected 3 x 3, got shape \(3, 2\)"),
        (np.zeros(9), r"expected 3 x 3, got shape \(9,\)"),
        (-np.ones((3, 3)), "negative length -1"),
        (np.full((3, 3), np.nan), "finite numbers, got nan"),
        (None, "missing"),
    ],
)
def test_matrix_fits_the_nodes(matrix, message):
    with pytest.raises(ValueError, match=f"instance 'plate', matrix: .*{message}"):
        instance([hole()], machine=Machine(metric="matrix"), matrix=matrix)


def test_matrix_goes_with_its_metric():
    with pytest.raises(ValueError, match="instance 'plate', matrix: given, but the metric is euclidean"):
        instance([hole()], matrix=np.zeros((3, 3)))
    with pytest.raises(ValueError, match="instance 'plate': without coordinates the metric must be matrix"):
        instance([hole()], located=False)


def test_staying_costs_nothing_whatever_the_matrix_says():
    given = instance([hole()], machine=Machine(metric="matrix"), matrix=np.full((3, 3), 9999.0))
    assert np.array_equal(given.rapids, 9999.0 * (1 - np.eye(3)))


def test_coordinates_whose_distance_overflows_are_refused():
    with pytest.raises(ValueError, match=r"instance 'plate': coordinates too far apart \(up to 1e\+200 mm\)"):
        instance([hole(points=[[1e200, 0, 0]])])


def test_arrays_are_read_only_copies():
    points, home, matrix = np.array(POINT), np.zeros(3), np.ones((2, 2))
    given = instance([hole(points=points)], [Head("h", home)], machine=Machine(metric="matrix"), matrix=matrix)
    points[:], home[:], matrix[:] = 7.0, 7.0, 7.0
    assert given.points.tolist() == [*POINT, [0, 0, 0]]
    assert given.rapids.tolist() == [[0, 1], [1, 0]]
    for array in (
        given.contours[0].entry_points,
        given.heads[0].home,
        given.matrix,
        given.points,
        given.rapids,
    ):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_nodes_are_entry_points_then_homes():
    contours = [hole("a", [[1, 0, 0], [2, 0, 0]]), hole("b", [[3, 0, 0]])]
    given = instance(contours, [Head("x"), Head("y", [4, 0, 0]), Head("z"), Head("w", [5, 0, 0])])
    assert given.points[:, 0].tolist() == [1, 2, 3, 4, 5]
    assert [given.node(0), given.node(0, 1), given.node(1)] == [0, 1, 2]
    assert [given.home_node(head) for head in range(4)] == [None, 3, None, 4]


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"objective": "speed"}, "rules, objective: .*makespan, travel, weighted, peak, got 'speed'"),
        ({"objective": "weighted", "weight": -1.0}, "rules, weight: .*at least 0, got -1"),
        ({"objective": "weighted", "weight": float("nan")}, "rules, weight: .*got nan"),
        ({"objective": "travel", "weight": 1.0}, "rules, weight: .*not travel"),
        ({"non_overlap": -5.0}, "rules, non_overlap: .*at least 0, got -5"),
        ({"non_overlap": float("inf")}, "rules, non_overlap: .*got inf"),
        ({"balance": -0.5}, "rules, balance: .*at least 0, got -0.5"),
        ({"balance": float("nan")}, "rules, balance: .*got nan"),
    ],
)
def test_rules_name_field_and_value(fields, message):
    with pytest.raises(ValueError, match=message):
        Rules(**fields)


def test_rules_say_their_unit():
    assert [Rules(objective).unit for objective in ("makespan", "travel", "weighted")] == ["s", "mm", "mm"]


def test_plan_of_contours_takes_the_first_entry_points():
    plan = Plan.of_contours([np.array([2, 0]), [], (1,)])
    assert plan.tours == ((Visit(2, 0), Visit(0, 0)), (), (Visit(1, 0),))
    assert plan == Plan((((2, 0), (0, 0)), (), ((1, 0),)))


def test_messages_stay_short():
    with pytest.raises(ValueError, match="contour 'a', entry_points: expected numbers") as caught:
        hole(points=[["x" * 10_000, 0, 0]])
    assert len(str(caught.value)) < 300
