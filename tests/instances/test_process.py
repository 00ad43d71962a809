"""What rapids cross, who are neighbours, and each process rule: against exact arithmetic and by hand."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.entry_tours import broken_rules, value_of
from oracles.exact_sheet import inside, sheet_of
from oracles.problem import plain_problem
from oracles.random_instances import random_plan
from oracles.random_sheets import moved_sheet, random_sheet

from cutgap.instances import Contour, Head, Instance, Machine, Plan, Rules, Violation, check, evaluate
from cutgap.instances.nesting import enclosures
from cutgap.instances.process import adjacent_parts, contours_in, crossings, part_of, rapid_costs

SEEDS = st.integers(0, 2**32 - 1)
FREE = Rules("travel", non_overlap=None, empty_heads=True)
SQUARE = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])
DIAMOND = np.array([[5.0, 0.0], [10.0, 5.0], [5.0, 10.0], [0.0, 5.0]])


def crossed(instance: Instance) -> dict[tuple[int, int, int, int], frozenset[int]]:
    """The table of the package, by contour and entry, for rapids between contours."""
    table = crossings(instance)
    places = [(c, e) for c, each in enumerate(instance.contours) for e in range(len(each.entry_points))]
    return {
        (*one, *other): frozenset(contours_in(table[instance.node(*one), instance.node(*other)]))
        for one in places
        for other in places
        if one[0] != other[0]
    }


def neighbours(instance: Instance) -> frozenset[tuple[str, str]]:
    names = [f"part {c.part}" if c.part is not None else f"contour {c.id}" for c in instance.contours]
    numbers, adjacent = part_of(instance), adjacent_parts(instance)
    pairs = [(i, j) for i, a in enumerate(numbers) for j, b in enumerate(numbers) if a != b and adjacent[a, b]]
    return frozenset((names[i], names[j]) for i, j in pairs)


def assert_exact(instance: Instance) -> None:
    expected = sheet_of(instance)
    assert crossed(instance) == {pair: met for pair, met in expected.crossed.items() if pair[0] != pair[2]}
    assert neighbours(instance) == expected.neighbours


@settings(max_examples=60)
@given(SEEDS)
def test_crossings_and_neighbours_agree_with_exact_arithmetic(seed):
    rng = np.random.default_rng(seed)
    assert_exact(random_sheet(rng, int(rng.integers(1, 9)), entries=4))


@settings(max_examples=15)
@given(SEEDS, st.sampled_from([1.0, 0.1, 7.0]))
def test_rapids_that_touch_corners_and_run_along_edges_are_decided_exactly(seed, unit):
    """On a lattice of diamonds and squares slanted lines meet many corners, and edges lie on one line."""
    rng = np.random.default_rng(seed)
    contours = []
    for i in range(6):
        curve = unit * ((SQUARE, DIAMOND)[int(rng.integers(2))] + 15.0 * np.array([i % 3, i // 3]))
        contours.append(alone(f"c{i}", curve, range(4)))
    assert_exact(Instance("lattice", tuple(contours), (Head("h"),)))


def test_a_sheet_of_more_than_64_contours():
    rng = np.random.default_rng(1)
    assert_exact(random_sheet(rng, 66, entries=1))


@settings(max_examples=30)
@given(SEEDS)
def test_enclosing_curves_agree_with_exact_arithmetic(seed):
    rng = np.random.default_rng(seed)
    instance = random_sheet(rng, int(rng.integers(1, 9)), nested=0.9)
    curves = sheet_of(instance).curves
    found = enclosures([contour.geometry for contour in instance.contours])
    for i, outside in enumerate(found):
        assert set(outside) == {k for k, curve in enumerate(curves) if k != i and inside(curves[i], curve)}
        assert all(inside(curves[a], curves[b]) for a, b in pairwise(outside))


@settings(max_examples=30)
@given(SEEDS)
def test_a_sheet_moved_scaled_or_mirrored_is_crossed_as_before(seed):
    rng = np.random.default_rng(seed)
    instance = random_sheet(rng, int(rng.integers(1, 8)), shape="polygons")
    angle, factor = rng.uniform(0, 7), rng.uniform(0.1, 10)
    turn = factor * np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    mirror = np.diag([1.0, -1.0])
    for matrix in (turn, turn @ mirror):
        moved = moved_sheet(instance, matrix, rng.uniform(-1000, 1000, 2))
        assert crossed(moved) == crossed(instance)
        assert neighbours(moved) == neighbours(instance)


@settings(max_examples=60)
@given(SEEDS, st.integers(1, 2))
def test_broken_rules_and_values_agree_with_the_oracle(seed, heads):
    """In general position on two heads: there the last bits decide ties in time."""
    rng = np.random.default_rng(seed)
    shape = "polygons" if heads == 2 else None
    instance = random_sheet(rng, int(rng.integers(1, 7)), heads=heads, homes=None, shape=shape)
    for _ in range(5):
        flags = [bool(each) for each in rng.random(5) < 0.5]
        rules = Rules("travel", 0.0, None, None, *flags, backward_price=float(rng.choice([0.0, 0.5, 3.0])))
        plan = random_plan(rng, instance)
        tours = tuple(tuple(tuple(visit) for visit in tour) for tour in plan.tours)
        found = {violation.constraint for violation in check(instance, rules, plan)}
        assert found == broken_rules(instance, rules, tours)
        value = evaluate(instance, plan).objective(rules)
        assert value == pytest.approx(value_of(plain_problem(instance), rules, tours), rel=1e-12)
        legs = rapid_costs(instance, rules)
        legs, between = rapid_costs(instance, rules), 0.0
        for tour in plan.tours:
            between += sum(float(legs[instance.node(*a[:2]), instance.node(*b[:2])]) for a, b in pairwise(tour))
        lengths = evaluate(instance, plan).objective(replace(rules, backward_price=0.0))
        rapids = sum(
            float(instance.rapids[instance.node(*a[:2]), instance.node(*b[:2])])
            for t in plan.tours
            for a, b in pairwise(t)
        )
        assert value == pytest.approx(lengths - rapids + between, rel=1e-9)


def alone(name: str, curve: np.ndarray, entries=(0,), part: str | None = None, ring: str = "hole") -> Contour:
    corners = np.asarray(curve, dtype=float)[list(entries)]
    return Contour(name, np.column_stack((corners, np.zeros(len(corners)))), 0.0, part, ring, curve)


def row(heads=("h",), machine=None, parts=(None, None, None)) -> Instance:
    """Squares a, b, c side by side, entered at their lower left corners or the middles of their lower edges.

    The rapid between the corners of a and c runs along the edges of all three; from middle to middle as well.
    """
    contours = [
        alone(name, SQUARE + np.array([20.0 * i, 0.0]), part=part, ring="hole" if part is None else "outer")
        for i, (name, part) in enumerate(zip("abc", parts, strict=True))
    ]
    machine = machine or Machine(v_jump=10.0, v_cut=10.0, t_aux=1.0)
    return Instance("row", tuple(contours), tuple(Head(name) for name in heads), machine)


def only(violations: list[Violation]) -> Violation:
    (violation,) = violations
    return violation


def test_parts_in_one_go():
    rules, sheet = replace(FREE, parts_in_one_go=True), row(parts=("p", "q", "p"))
    assert check(sheet, rules, Plan.of_contours([[0, 2, 1]])) == []
    broken = only(check(sheet, rules, Plan.of_contours([[0, 1, 2]])))
    assert broken == Violation("parts in one go", "head 'h' begins part 'p' 2 times", 1, "times")
    assert check(sheet, FREE, Plan.of_contours([[0, 1, 2]])) == []


def test_parts_in_one_go_asks_each_head_for_itself():
    rules, sheet = replace(FREE, parts_in_one_go=True), row(heads="lr", parts=("p", "q", "p"))
    assert check(sheet, rules, Plan.of_contours([[0, 1], [2]])) == []
    assert check(row(heads="lr"), rules, Plan.of_contours([[0, 1, 2], []])) == []


def test_neighbours_only():
    rules, sheet = replace(FREE, neighbours_only=True), row()
    assert check(sheet, rules, Plan.of_contours([[0, 1, 2]])) == []
    broken = only(check(sheet, rules, Plan.of_contours([[0, 2, 1]])))
    assert broken == Violation("neighbours only", "contour 'a' to contour 'c'", 1, "rapids")
    assert check(sheet, FREE, Plan.of_contours([[0, 2, 1]])) == []


def test_rings_of_one_part_and_what_is_in_its_window_are_neighbours():
    """A frame p with a window; in the window the part q, outside the contour r."""
    contours = (
        alone("outer", 10 * SQUARE, part="p", ring="outer"),
        alone("inner", 8 * SQUARE + 10, part="p", ring="inner"),
        alone("q", SQUARE + 45),
        alone("r", SQUARE + np.array([150.0, 45.0])),
    )
    sheet, rules = Instance("frame", contours, (Head("h"),)), replace(FREE, neighbours_only=True)
    assert check(sheet, rules, Plan.of_contours([[2, 1, 0, 3]])) == []
    assert check(sheet, rules, Plan.of_contours([[2, 3, 0, 1]])) == []  # p encloses q
    assert neighbours(sheet) == {
        (a, b)
        for a in ("part p", "contour q", "contour r")
        for b in ("part p", "contour q", "contour r")
        if a != b
    }


def test_clear_rapids():
    rules, sheet = replace(FREE, clear_rapids=True), row()
    # Along its own lower edge a rapid to the right crosses what has just been cut; to the left it is clear.
    assert check(sheet, rules, Plan.of_contours([[2, 1, 0]])) == []
    broken = check(sheet, rules, Plan.of_contours([[0, 2, 1]]))
    assert broken[0] == Violation("clear rapids", "'a' to 'c' crosses 'a'", 1, "contours")
    broken = only(check(sheet, rules, Plan.of_contours([[1, 0, 2]])))
    assert broken.place == "'a' to 'c' crosses 'a', 'b'"
    assert check(sheet, FREE, Plan.of_contours([[0, 2, 1]])) == []


def test_the_leg_that_closes_a_tour_and_the_ways_home_are_clear():
    rules = replace(FREE, clear_rapids=True, neighbours_only=True)
    closed = row()
    housed = replace(closed, heads=(Head("h", [-50.0, 0.0, 0.0]),))
    for sheet in (closed, housed):
        assert check(sheet, rules, Plan.of_contours([[2, 1, 0]])) == []


def test_clear_rapids_of_two_heads_are_about_time():
    """The left head goes from c to a across b, at 1 s; the right one is done with b at 1 s or at 2 s."""
    sheet = row(heads="lr")
    rules = replace(FREE, clear_rapids=True)
    plan = Plan.of_contours([[2, 0], [1]])
    broken = only(check(sheet, rules, plan))
    assert broken == Violation("clear rapids", "'c' to 'a' crosses 'b'", 1, "contours")
    longer = replace(sheet.contours[1], perimeter=10.0)
    later = replace(sheet, contours=(sheet.contours[0], longer, sheet.contours[2]))
    assert check(later, rules, plan) == []


def test_backward_price():
    sheet = row()
    plan = Plan.of_contours([[1, 2, 0]])
    # 20 mm on, 40 mm back, and the leg of 20 mm that closes the tour.
    assert evaluate(sheet, plan).backward_mm == (40.0,)
    assert evaluate(sheet, plan).objective(replace(FREE, backward_price=0.5)) == 80.0 + 20.0
    assert evaluate(sheet, Plan.of_contours([[0, 1, 2]])).objective(replace(FREE, backward_price=0.5)) == 80.0
    housed = replace(sheet, heads=(Head("h", [100.0, 0.0, 0.0]),))
    assert evaluate(housed, Plan.of_contours([[0, 1, 2]])).backward_mm == (0.0,)


@pytest.mark.parametrize("rule", ["neighbours_only", "clear_rapids"])
def test_rules_of_curves_need_geometry(rule):
    sheet = row()
    bare = replace(sheet, contours=(sheet.contours[0], replace(sheet.contours[1], geometry=None)))
    with pytest.raises(
        ValueError, match=f"'row', contour 'b': no geometry, which {rule.replace('_', ' ')} needs"
    ):
        check(bare, replace(FREE, **{rule: True}), Plan.of_contours([[0, 1]]))
    assert check(bare, replace(FREE, parts_in_one_go=True), Plan.of_contours([[0, 1]])) == []


@pytest.mark.parametrize("rule", [{"neighbours_only": True}, {"clear_rapids": True}, {"backward_price": 1.0}])
def test_rules_of_places_need_coordinates(rule):
    contours = tuple(Contour(name, [[0, 0, 0]], 0.0) for name in "ab")
    machine = Machine(metric="matrix")
    bare = Instance("bare", contours, (Head("h"),), machine, matrix=np.ones((2, 2)), located=False)
    with pytest.raises(ValueError, match="'bare' has a matrix but no coordinates"):
        check(bare, replace(FREE, **rule), Plan.of_contours([[0, 1]]))
    assert check(bare, FREE, Plan.of_contours([[0, 1]])) == []


def test_the_price_of_going_back_goes_with_lengths():
    with pytest.raises(ValueError, match="backward_price: goes with the objectives travel and weighted"):
        Rules("makespan", backward_price=1.0)
    with pytest.raises(ValueError, match="backward_price: expected a number of at least 0"):
        Rules("travel", backward_price=-1.0)
