"""Each constraint alone: a plan that keeps it, a plan that breaks it, and what the violation says."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.problem import figures, plain_problem
from oracles.random_instances import random_instance, random_plan

from cutgap.instances import Contour, Head, Instance, Machine, Plan, Rules, Violation, Visit, check

SEEDS = st.integers(0, 2**32 - 1)
FREE = Rules(non_overlap=None, empty_heads=True)
"""No constraint beyond each contour once."""


def part(xs=(100.0, 200.0, 300.0), heads=2, **more) -> Instance:
    """Holes named by letters on the x axis, no work in them, homes at the origin, 100 mm/s."""
    contours = tuple(Contour(chr(ord("a") + i), [[x, 0, 0]], 0.0) for i, x in enumerate(xs))
    names = ("left", "right", "third")[:heads]
    machine = more.pop("machine", Machine(v_jump=100.0, v_cut=10.0, t_aux=0.0))
    return Instance("line", contours, tuple(Head(name, [0, 0, 0]) for name in names), machine, **more)


def only(violations: list[Violation]) -> Violation:
    (violation,) = violations
    return violation


def test_each_contour_once():
    assert check(part(), FREE, Plan.of_contours([[0, 1], [2]])) == []
    missing = only(check(part(), FREE, Plan.of_contours([[0], [2]])))
    assert missing == Violation("each contour once", "contour 'b' is cut 0 times", -1, "times")
    twice = only(check(part(), FREE, Plan.of_contours([[0, 1], [2, 1, 1]])))
    assert twice == Violation("each contour once", "contour 'b' is cut 3 times", 2, "times")
    assert str(twice) == "each contour once: contour 'b' is cut 3 times (2 times)"


def test_each_missing_contour_is_named():
    violations = check(part(), FREE, Plan.of_contours([[], [1]]))
    assert [violation.place for violation in violations] == [
        "contour 'a' is cut 0 times",
        "contour 'c' is cut 0 times",
    ]


def test_non_overlap():
    rules = Rules(non_overlap=0.0)
    assert check(part(), rules, Plan.of_contours([[0, 1], [2]])) == []
    broken = only(check(part(), rules, Plan.of_contours([[0, 2], [1]])))
    assert broken == Violation("non-overlap", "partition gap -100 mm, least 0 mm", 100.0, "mm")
    assert check(part(), FREE, Plan.of_contours([[0, 2], [1]])) == []


@pytest.mark.parametrize("orders", [[[0, 1], [2]], [[0], [1, 2]], [[0, 2], [1]], [[0, 1, 2], []]])
def test_equal_x_may_go_either_side_without_a_gap(orders):
    assert (
        check(part(xs=(7.0, 7.0, 7.0)), Rules(non_overlap=0.0, empty_heads=True), Plan.of_contours(orders))
        == []
    )


def test_positive_gap_is_kept_to_the_last_bit():
    plan = Plan.of_contours([[0, 1], [2]])
    assert check(part(), Rules(non_overlap=100.0), plan) == []
    above = float(np.nextafter(100.0, 200.0))
    broken = only(check(part(), Rules(non_overlap=above), plan))
    assert (broken.constraint, broken.unit) == ("non-overlap", "mm")
    assert broken.amount == above - 100.0


def test_gap_asks_nothing_of_a_head_without_work():
    rules = Rules(non_overlap=1e6, empty_heads=True)
    assert check(part(), rules, Plan.of_contours([[0, 1, 2], []])) == []
    assert check(part(), rules, Plan.of_contours([[], [2, 0, 1]])) == []
    assert check(part(heads=1), rules, Plan.of_contours([[2, 0, 1]])) == []


def test_non_overlap_of_three_heads_looks_at_neighbours():
    three = part(heads=3)
    assert check(three, Rules(), Plan.of_contours([[0], [1], [2]])) == []
    assert only(check(three, Rules(), Plan.of_contours([[0], [2], [1]]))).amount == 100.0
    resting = Rules(empty_heads=True)
    assert only(check(three, resting, Plan.of_contours([[1, 2], [], [0]]))).amount == 200.0
    assert check(three, resting, Plan.of_contours([[0], [], [1, 2]])) == []


def test_balance():
    # Left: 400 mm in 4 s. Right: 600 mm in 6 s.
    plan = Plan.of_contours([[0, 1], [2]])
    assert check(part(), Rules(balance=2.0), plan) == []
    broken = only(check(part(), Rules(balance=1.5), plan))
    assert broken == Violation("balance", "imbalance 2 s, most 1.5 s", 0.5, "s")
    assert only(check(part(), Rules(balance=0.0), plan)).amount == 2.0
    assert check(part(), Rules(balance=None), plan) == []


def test_balance_forgives_rounding_only():
    thirds = part(xs=(100 / 3, -100 / 3), machine=Machine(v_jump=7.0, t_aux=0.1))
    plan = Plan.of_contours([[0], [1]])
    assert check(thirds, Rules(balance=0.0, non_overlap=None), plan) == []
    uneven = part(xs=(100.0, 100.0001))
    assert only(check(uneven, Rules(balance=0.0), plan)).amount == pytest.approx(2e-6, rel=1e-3)


def test_balance_of_one_head_is_kept():
    assert check(part(heads=1), Rules(balance=0.0), Plan.of_contours([[0, 1, 2]])) == []


def test_balance_counts_a_head_without_work():
    rules = Rules(balance=5.0, empty_heads=True)
    assert only(check(part(), rules, Plan.of_contours([[0, 1, 2], []]))).amount == 1.0


def test_via_points():
    rules = Rules(via_points=True)
    assert check(part(), rules, Plan.of_contours([[0], [1, 2]])) == []
    broken = only(check(part(), rules, Plan.of_contours([[0], [2, 1]])))
    place = "head 'right' starts with contour 'c', not the leftmost"
    assert broken == Violation("via points", place, 100.0, "mm")
    assert check(part(), Rules(), Plan.of_contours([[0], [2, 1]])) == []


def test_via_point_may_be_any_of_the_leftmost():
    tied, rules = part(xs=(100.0, 100.0, 300.0), heads=1), Rules(via_points=True)
    for order in ([0, 1, 2], [1, 2, 0]):
        assert check(tied, rules, Plan.of_contours([order])) == []
    assert only(check(tied, rules, Plan.of_contours([[2, 0, 1]]))).amount == 200.0


def test_via_point_is_where_the_visit_enters():
    wide = Contour("wide", [[100, 0, 0], [300, 0, 0]], 0.0)
    both = Instance("entries", (wide, Contour("a", [[200, 0, 0]], 0.0)), (Head("h", [0, 0, 0]),))
    rules = Rules(via_points=True)
    assert check(both, rules, Plan(((Visit(0, 0), Visit(1)),))) == []
    assert only(check(both, rules, Plan(((Visit(0, 1), Visit(1)),)))).amount == 100.0
    assert check(both, rules, Plan(((Visit(1), Visit(0, 1)),))) == []


def test_empty_heads():
    plan = Plan.of_contours([[0, 1, 2], []])
    assert check(part(), Rules(empty_heads=True), plan) == []
    broken = only(check(part(), Rules(empty_heads=False), plan))
    assert broken == Violation("no empty heads", "head 'right' has no work", 1, "contours")
    assert check(part(), Rules(empty_heads=False), Plan.of_contours([[0, 1], [2]])) == []


def test_heads_may_rest_when_there_are_fewer_contours():
    rules = Rules(empty_heads=False)
    assert check(part(xs=()), rules, Plan.of_contours([[], []])) == []
    assert check(part(xs=(5.0,)), rules, Plan.of_contours([[], [0]])) == []
    assert len(check(part(xs=(5.0, 6.0), heads=3), rules, Plan.of_contours([[], [], [0, 1]]))) == 0
    assert len(check(part(heads=3), rules, Plan.of_contours([[], [], [0, 1, 2]]))) == 2


def test_precedence_on_one_head():
    ordered = part(heads=1, precedence=[(2, 0)], machine=Machine(v_jump=100.0, t_aux=1.0))
    assert check(ordered, FREE, Plan.of_contours([[2, 1, 0]])) == []
    # a starts at 1 s; b at 3 s; c at 5 s, done at 6 s, 5 s after a started.
    broken = only(check(ordered, FREE, Plan.of_contours([[0, 1, 2]])))
    assert broken == Violation("precedence", "'c' before 'a'", 5.0, "s")


def test_precedence_across_heads_is_about_time():
    machine = Machine(v_jump=100.0, t_aux=1.0)
    plan = Plan.of_contours([[0], [1, 2]])
    # a: 1 s to 2 s. b: 2 s to 3 s. c: 4 s to 5 s.
    assert check(part(precedence=[(0, 1), (1, 2), (0, 2)], machine=machine), FREE, plan) == []
    broken = only(check(part(precedence=[(1, 0)], machine=machine), FREE, plan))
    assert broken == Violation("precedence", "'b' before 'a'", 2.0, "s")


def test_precedence_holds_where_nothing_takes_time():
    """Two points at one place start at the same time on one head; their order still counts."""
    same = part(xs=(100.0, 100.0), heads=1, precedence=[(0, 1)])
    assert check(same, FREE, Plan.of_contours([[0, 1]])) == []
    broken = only(check(same, FREE, Plan.of_contours([[1, 0]])))
    assert (broken.constraint, broken.place, broken.amount) == ("precedence", "'a' before 'b'", 0.0)


def test_precedence_of_a_missing_contour_is_not_reported_twice():
    ordered = part(heads=1, precedence=[(2, 0)])
    assert only(check(ordered, FREE, Plan.of_contours([[0, 1]]))).constraint == "each contour once"


def test_all_broken_constraints_are_named():
    rules = Rules(non_overlap=10.0, balance=0.0, via_points=True)
    violations = check(part(), rules, Plan.of_contours([[2, 0], [1, 1]]))
    assert {violation.constraint for violation in violations} == {
        "each contour once",
        "non-overlap",
        "balance",
        "via points",
    }


def test_rules_in_x_need_coordinates():
    contours = tuple(Contour(name, [[0, 0, 0]], 0.0) for name in "ab")
    heads = (Head("l"), Head("r"))
    bare = Instance("bare", contours, heads, Machine(metric="matrix"), matrix=np.ones((2, 2)), located=False)
    plan = Plan.of_contours([[0], [1]])
    assert check(bare, FREE, plan) == []
    for rules in (Rules(), Rules(non_overlap=None, via_points=True)):
        with pytest.raises(ValueError, match="instance 'bare' has a matrix but no coordinates"):
            check(bare, rules, plan)
    single = Instance("one", contours[:1], heads[:1], bare.machine, matrix=[[0.0]], located=False)
    assert check(single, Rules(), Plan.of_contours([[0]])) == []


def test_plan_that_names_what_does_not_exist_is_an_error():
    with pytest.raises(ValueError, match="plan, head 'right': no contour 9 among 3"):
        check(part(), Rules(), Plan.of_contours([[0], [9]]))


@settings(max_examples=150, deadline=None)
@given(SEEDS, st.integers(0, 5), st.sampled_from([None, 0.0, 50.0]), st.sampled_from([None, 0.0, 3.0]))
def test_agrees_with_the_oracle(seed, holes, non_overlap, balance):
    """The names of the broken constraints, from the reference's words alone."""
    rng = np.random.default_rng(seed)
    drawn = random_instance(rng, holes, homes=None, entries=2)
    plan = random_plan(rng, drawn)
    via_points, empty_heads = (bool(flag) for flag in rng.integers(0, 2, 2))
    rules = Rules(non_overlap=non_overlap, balance=balance, via_points=via_points, empty_heads=empty_heads)
    problem = plain_problem(drawn)
    measured = figures(problem, plan.tours)
    starts = [[problem.entries[c][e][0] for c, e, *_ in tour] for tour in plan.tours]
    gap = measured.partition_gap
    expected = {
        "non-overlap": non_overlap is not None and gap is not None and gap < non_overlap,
        "balance": balance is not None and measured.imbalance > balance + 1e-9,
        "via points": via_points and any(xs and xs[0] != min(xs) for xs in starts),
        "no empty heads": not empty_heads and holes >= 2 and not all(starts),
    }
    found = {violation.constraint for violation in check(drawn, rules, plan)}
    assert found == {name for name, broken in expected.items() if broken}


def test_a_gap_is_compared_as_decimals():
    """0.3 - 0.1 is below 0.2 in binary floating point, yet the gap is 0.2 mm."""
    contours = (Contour("a", [[0.1, 0, 0]], 1.0), Contour("b", [[0.3, 0, 0]], 1.0))
    part = Instance("decimal", contours, (Head("left", [0, 0, 0]), Head("right", [1, 0, 0])))
    plan = Plan.of_contours([[0], [1]])
    assert check(part, Rules(non_overlap=0.2), plan) == []
    assert len(check(part, Rules(non_overlap=0.2000001), plan)) == 1
