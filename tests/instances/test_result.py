"""What a run may claim: a bound above the value, or "infeasible" beside a plan, is refused."""

import pytest

from cutgap.instances import Contour, Head, Instance, Machine, Plan, Result, Rules, Status, conclude, evaluate

PART = Instance(
    "two holes",
    (Contour("a", [[100, 0, 0]], 0.0), Contour("b", [[300, 0, 0]], 0.0)),
    (Head("left", [0, 0, 0]), Head("right", [400, 0, 0])),
    Machine(v_jump=100.0, t_aux=1.0),
)
GOOD = Plan.of_contours([[0], [1]])  # 200 mm and 3 s each
SWAPPED = Plan.of_contours([[1], [0]])  # overlaps by 200 mm
TRAVEL = Rules("travel")


def run(plan=GOOD, rules=TRAVEL, **claims) -> Result:
    return conclude(PART, rules, plan, method="guess", seconds=0.5, **claims)


def test_plan_without_bound_is_feasible():
    result = run(seed=7, reason="time limit")
    assert (result.status, result.value, result.lower_bound, result.gap) == ("feasible", 400.0, None, None)
    assert (result.method, result.seconds, result.seed, result.reason) == ("guess", 0.5, 7, "time limit")
    assert (result.plan, result.rules, result.violations) == (GOOD, TRAVEL, ())
    assert result.evaluation == evaluate(PART, GOOD)


def test_bound_below_the_value_gives_a_gap():
    result = run(lower_bound=300.0)
    assert (result.status, result.lower_bound) == (Status.FEASIBLE, 300.0)
    assert result.gap == 0.25


@pytest.mark.parametrize("bound", [400.0, 400.0 - 1e-7, 400.0 + 1e-7])
def test_bound_that_meets_the_value_is_optimal(bound):
    result = run(lower_bound=bound)
    assert result.status is Status.OPTIMAL
    assert result.gap == pytest.approx(0.0, abs=1e-8)
    assert result.gap >= 0.0


@pytest.mark.parametrize("bound", [400.0 - 1e-4, 399.0, 0.0, -5.0])
def test_bound_that_does_not_meet_the_value_is_not_optimal(bound):
    assert run(lower_bound=bound).status is Status.FEASIBLE


@pytest.mark.parametrize("bound", [400.0 + 1e-4, 401.0, 1e9])
def test_bound_above_the_value_is_refused(bound):
    with pytest.raises(ValueError, match=f"guess: lower bound {bound} exceeds value 400"):
        run(lower_bound=bound)


@pytest.mark.parametrize("bound", [float("nan"), float("inf"), -float("inf")])
@pytest.mark.parametrize("plan", [GOOD, SWAPPED, None])
def test_bound_is_a_finite_number(bound, plan):
    with pytest.raises(ValueError, match=f"guess, lower bound: expected a finite number, got {bound}"):
        run(plan, lower_bound=bound)


def test_value_follows_the_objective():
    assert run(rules=Rules("makespan")).value == 3.0
    uneven = Plan.of_contours([[0, 1], []])  # 600 mm, 8 s and 0 s
    rules = Rules("weighted", weight=10.0, empty_heads=True)
    assert run(uneven, rules).value == 600.0 + 80.0


def test_plan_that_breaks_a_rule_proves_nothing():
    result = run(SWAPPED, lower_bound=100.0)
    assert result.status is Status.UNKNOWN
    assert [violation.constraint for violation in result.violations] == ["non-overlap"]
    assert (result.plan, result.value, result.lower_bound, result.gap) == (SWAPPED, 1200.0, 100.0, None)


def test_bound_above_the_value_of_a_broken_plan_is_no_contradiction():
    result = run(SWAPPED, Rules("makespan"), lower_bound=50.0)
    assert (result.status, result.lower_bound) == (Status.UNKNOWN, 50.0)


def test_no_plan_is_unknown_but_may_have_a_bound():
    result = run(None, lower_bound=300.0, reason="time limit")
    assert (result.status, result.lower_bound, result.reason) == (Status.UNKNOWN, 300.0, "time limit")
    assert (result.plan, result.value, result.evaluation, result.gap) == (None, None, None, None)
    assert run(None).status is Status.UNKNOWN


def test_infeasible_has_a_reason_and_no_bound():
    result = run(None, infeasible=True, lower_bound=300.0, reason="all x equal")
    assert (result.status, result.reason) == (Status.INFEASIBLE, "all x equal")
    assert (result.plan, result.value, result.lower_bound, result.gap) == (None, None, None, None)


def test_infeasible_beside_an_allowed_plan_is_refused():
    with pytest.raises(ValueError, match="guess: claims that no plan exists, yet one was found"):
        run(infeasible=True)


def test_gap_of_nothing_to_do_is_zero():
    empty = Instance("empty", (), PART.heads)
    result = conclude(empty, TRAVEL, Plan.of_contours([[], []]), method="guess", seconds=0.0, lower_bound=0.0)
    assert (result.status, result.value, result.gap) == (Status.OPTIMAL, 0.0, 0.0)


def test_plan_that_names_what_does_not_exist_is_an_error():
    with pytest.raises(ValueError, match="no contour 5 among 2"):
        run(Plan.of_contours([[5], []]))
