"""Figures of a plan: by hand from the reference formulas, against the oracle, and under symmetries."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.problem import figures, plain_problem
from oracles.random_instances import mirrored, moved, permuted, random_instance, random_plan, scaled

from cutgap.instances import Contour, Head, Instance, Machine, Plan, Rules, Visit, evaluate

SEEDS = st.integers(0, 2**32 - 1)
METRICS = st.sampled_from(["euclidean", "chebyshev", "matrix"])
COORDINATES = st.sampled_from(["euclidean", "chebyshev"])
MACHINE = Machine(v_jump=100.0, v_cut=20.0, t_aux=2.0)


def two_heads(points, perimeters, machine=MACHINE, homes=([0, 0, 0], [1000, 0, 0])) -> Instance:
    contours = (Contour(f"c{i}", [p], h) for i, (p, h) in enumerate(zip(points, perimeters, strict=True)))
    heads = (Head(f"h{i}", home) for i, home in enumerate(homes))
    return Instance("by hand", tuple(contours), tuple(heads), machine)


def test_travel_and_time_by_hand():
    part = two_heads([[30, 40, 0], [30, 40, 120], [1000, 300, 400]], [40.0, 0.0, 100.0])
    result = evaluate(part, Plan.of_contours([[0, 1], [2]]))
    # Left: 50 + 120 + 130 mm, 40 mm cut, 2 holes. Right: 500 there and back, 100 mm cut, 1 hole.
    assert result.travel_mm == (300.0, 1000.0)
    assert result.time_s == (3.0 + 2.0 + 4.0, 10.0 + 5.0 + 2.0)
    assert (result.total_travel_mm, result.makespan_s, result.imbalance_s) == (1300.0, 17.0, 8.0)
    assert result.partition_gap_mm == 970.0


def test_objectives_by_hand():
    result = evaluate(two_heads([[100, 0, 0]], [20.0]), Plan.of_contours([[0], []]))
    # 200 mm in 2 s, 1 s cut, 2 s auxiliary: 5 s; the other head waits 5 s.
    assert result.objective(Rules("makespan")) == 5.0
    assert result.objective(Rules("travel")) == 200.0
    assert result.objective(Rules("weighted", weight=10.0)) == 250.0
    assert result.objective(Rules("weighted")) == 200.0


def test_chebyshev_takes_the_longest_axis():
    machine = Machine(v_jump=100.0, t_aux=0.0, metric="chebyshev")
    part = two_heads([[30, -40, 10], [30, 40, 0]], [0.0, 0.0], machine)
    assert evaluate(part, Plan.of_contours([[0, 1], []])).travel_mm == (40.0 + 80.0 + 40.0, 0.0)


def test_matrix_is_read_from_row_to_column():
    matrix = [[0, 1, 2], [4, 0, 8], [16, 32, 0]]
    contours = tuple(Contour(name, [[0, 0, 0]], 0.0) for name in "ab")
    machine = Machine(metric="matrix")
    part = Instance("asymmetric", contours, (Head("h", [0, 0, 0]),), machine, matrix=matrix)
    assert evaluate(part, Plan.of_contours([[0, 1]])).travel_mm == (16 + 1 + 8,)
    assert evaluate(part, Plan.of_contours([[1, 0]])).travel_mm == (32 + 4 + 2,)


def test_head_without_home_goes_around():
    part = two_heads([[0, 0, 0], [30, 0, 0], [0, 40, 0]], [0.0] * 3, homes=(None, None))
    assert evaluate(part, Plan.of_contours([[0, 1, 2], []])).travel_mm == (120.0, 0.0)
    assert evaluate(part, Plan.of_contours([[0], [1, 2]])).travel_mm == (0.0, 100.0)


def test_single_contour_around_costs_no_rapid_even_by_matrix():
    contours = (Contour("a", [[0, 0, 0]], 0.0),)
    machine = Machine(metric="matrix")
    part = Instance("diagonal", contours, (Head("h"),), machine, matrix=[[9999.0]])
    result = evaluate(part, Plan.of_contours([[0]]))
    assert (result.travel_mm, result.time_s) == ((0.0,), (1.0,))


def test_entry_point_of_the_visit_counts():
    contours = (Contour("a", [[10, 0, 0], [50, 0, 0]], 0.0), Contour("b", [[80, 0, 0]], 0.0))
    part = Instance("entries", contours, (Head("l", [0, 0, 0]), Head("r", [100, 0, 0])), MACHINE)
    near, far = (evaluate(part, Plan(((Visit(0, entry),), (Visit(1),)))) for entry in (0, 1))
    assert (near.travel_mm, far.travel_mm) == ((20.0, 40.0), (100.0, 40.0))
    assert (near.partition_gap_mm, far.partition_gap_mm) == (70.0, 30.0)


def test_partition_gap_by_hand():
    part = two_heads([[100, 0, 0], [300, 0, 0], [200, 0, 0], [700, 0, 0]], [0.0] * 4)
    gap = {
        orders: evaluate(part, Plan.of_contours(orders)).partition_gap_mm
        for orders in [((0, 2), (1, 3)), ((0, 1), (2, 3)), ((3,), (0, 1, 2)), ((0, 1, 2, 3), ()), ((), ())]
    }
    assert list(gap.values()) == [100.0, -100.0, -600.0, None, None]


def test_partition_gap_skips_an_empty_head_between():
    contours = tuple(Contour(str(x), [[x, 0, 0]], 0.0) for x in (100, 300))
    part = Instance("three", contours, tuple(Head(name, [0, 0, 0]) for name in "abc"))
    assert evaluate(part, Plan.of_contours([[0], [], [1]])).partition_gap_mm == 200.0
    assert evaluate(part, Plan.of_contours([[1], [], [0]])).partition_gap_mm == -200.0


def test_nothing_to_do_takes_no_time():
    result = evaluate(two_heads([], []), Plan.of_contours([[], []]))
    assert (result.travel_mm, result.time_s) == ((0.0, 0.0), (0.0, 0.0))
    assert (result.partition_gap_mm, result.separation_mm) == (None, 1000.0)


@pytest.mark.parametrize(
    ("plan", "message"),
    [
        (Plan.of_contours([[0]]), "plan: expected 2 tours, one a head, got 1"),
        (Plan.of_contours([[0], [1], []]), "plan: expected 2 tours, one a head, got 3"),
        (Plan.of_contours([[0], [2]]), "plan, head 'h1': no contour 2 among 2"),
        (Plan.of_contours([[-1], []]), "plan, head 'h0': no contour -1 among 2"),
        (Plan(((Visit(1, 1),), ())), "plan, contour 'c1': no entry point 1"),
        (Plan(((Visit(1, -1),), ())), "plan, contour 'c1': no entry point -1"),
    ],
)
def test_plan_must_name_what_exists(plan, message):
    with pytest.raises(ValueError, match=message):
        evaluate(two_heads([[1, 0, 0], [2, 0, 0]], [0.0, 0.0]), plan)


@settings(max_examples=150, deadline=None)
@given(SEEDS, st.integers(0, 9), st.integers(1, 3), METRICS)
def test_agrees_with_the_oracle(seed, holes, heads, metric):
    rng = np.random.default_rng(seed)
    part = random_instance(rng, holes, heads=heads, homes=None, metric=metric, entries=3)
    plan = random_plan(rng, part)
    result, expected = evaluate(part, plan), figures(plain_problem(part), plan.tours)
    assert result.travel_mm == pytest.approx(expected.travel, rel=1e-12, abs=1e-9)
    assert result.time_s == pytest.approx(expected.time, rel=1e-12, abs=1e-9)
    assert result.partition_gap_mm == expected.partition_gap
    for rules in (Rules("makespan"), Rules("travel"), Rules("weighted", weight=30.0)):
        assert result.objective(rules) == pytest.approx(expected.objective(rules), rel=1e-12, abs=1e-9)


def same(result, expected, factor: float = 1.0, turned: bool = False) -> None:
    """Compare figures, lengths multiplied; ``turned`` compares heads in the opposite order."""
    step = -1 if turned else 1
    assert result.time_s == pytest.approx(expected.time_s[::step], rel=1e-9, abs=1e-9)
    assert result.travel_mm == pytest.approx(
        [factor * length for length in expected.travel_mm[::step]], rel=1e-9, abs=1e-9
    )


def same_in_x(result, expected, factor: float = 1.0) -> None:
    for name in ("partition_gap_mm", "separation_mm"):
        before, after = getattr(expected, name), getattr(result, name)
        assert (before is None) == (after is None)
        assert before is None or after == pytest.approx(factor * before, rel=1e-9, abs=1e-6)


@settings(max_examples=30, deadline=None)
@given(SEEDS, st.integers(0, 8), st.integers(1, 3), COORDINATES)
def test_symmetries(seed, holes, heads, metric):
    rng = np.random.default_rng(seed)
    part = random_instance(rng, holes, heads=heads, homes=None, metric=metric, entries=2)
    plan = random_plan(rng, part)
    expected = evaluate(part, plan)

    translated = evaluate(moved(part, np.eye(3), rng.integers(-500, 500, 3)), plan)
    same(translated, expected)
    same_in_x(translated, expected)

    factor = float(rng.choice([0.25, 3.0]))
    enlarged = evaluate(scaled(part, factor), plan)
    same(enlarged, expected, factor)
    same_in_x(enlarged, expected, factor)

    order = rng.permutation(holes)
    places = {int(contour): place for place, contour in enumerate(order)}
    renamed = Plan(tuple(tuple(Visit(places[c], e) for c, e, *_ in tour) for tour in plan.tours))
    relabelled = evaluate(permuted(part, order), renamed)
    same(relabelled, expected)
    same_in_x(relabelled, expected)

    image = evaluate(mirrored(part), Plan(plan.tours[::-1]))
    same(image, expected, turned=True)
    same_in_x(image, expected)

    quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    same(evaluate(moved(part, quarter), plan), expected)


@settings(max_examples=30, deadline=None)
@given(SEEDS, st.integers(1, 8), COORDINATES)
def test_a_tour_run_backwards_is_as_long(seed, holes, metric):
    rng = np.random.default_rng(seed)
    part = random_instance(rng, holes, homes=None, metric=metric)
    plan = random_plan(rng, part)
    backwards = Plan(tuple(tour[::-1] for tour in plan.tours))
    same(evaluate(part, backwards), evaluate(part, plan))


def test_defaults_give_the_published_terms():
    """The inferred constants: 150 mm/s, 40 mm/s and 1 s."""
    contours = (Contour("a", [[300, 500, 100]], 60.0),)
    part = Instance("defaults", contours, (Head("left", [200, 200, 400]),))
    length = 2 * math.sqrt(100**2 + 300**2 + 300**2)
    result = evaluate(part, Plan.of_contours([[0]]))
    assert result.time_s[0] == pytest.approx(length / 150 + 60 / 40 + 1)
