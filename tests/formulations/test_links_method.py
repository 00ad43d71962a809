"""The method ``links`` against brute force over plans on tiny sheets."""

from dataclasses import replace

import numpy as np
import pytest
from oracles.link_plans import least
from oracles.random_link_sheets import SIZES, instance_of, tiny

from cutgap.formulations import outline_bound, solve
from cutgap.formulations.certificate import verify
from cutgap.instances import Contour, Head, Instance, Machine, Rules, Status, check
from cutgap.instances.formats.json_format import format_instance


def square(name: str, x: float, y: float, side: float) -> Contour:
    corners = np.array([[x, y], [x + side, y], [x + side, y + side], [x, y + side]])
    return Contour(name, np.column_stack((corners, np.zeros(4))), 4 * side, geometry=corners)


def sheet_of(*contours: Contour) -> Instance:
    return Instance("squares", contours, (Head("head", np.zeros(3)),), Machine(100.0, 10.0, 7.0))


NESTED = sheet_of(square("outline", 0, 0, 30), square("hole", 10, 10, 10), square("beside", 40, 0, 5))


@pytest.mark.parametrize("seed", range(16))
def test_links_reach_the_optimum(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sheet = tiny(rng, SIZES[seed % len(SIZES)])
    instance = instance_of(sheet)
    for objective in ("travel", "makespan"):
        for pierces in (None, 1, 2):
            rules = Rules(objective, links=True, pierces=pierces)
            best = least(sheet, objective, pierces)
            result = solve(instance, rules, certify=True)
            if best is None:
                assert result.status is Status.INFEASIBLE
                assert result.certificate is not None
                continue
            assert result.status is Status.OPTIMAL
            assert result.value == pytest.approx(best, rel=1e-9, abs=1e-9)
            assert result.plan is not None
            assert check(instance, rules, result.plan) == []
            assert result.certificate is not None
            verdict = verify(result.certificate, format_instance(instance))
            assert best - 1e-3 <= float(verdict.bound or 0) <= best
            assert float(verdict.value or 0) == pytest.approx(best, rel=1e-9, abs=1e-9)


def test_more_pierces_than_allowed_are_needed() -> None:
    for pierces, status in ((1, Status.INFEASIBLE), (2, Status.OPTIMAL), (None, Status.OPTIMAL)):
        rules = Rules(links=True, pierces=pierces)
        result = solve(NESTED, rules, certify=True)
        assert result.status is status
        assert result.certificate is not None
        verdict = verify(result.certificate, format_instance(NESTED))
        assert (verdict.bound is None) == (pierces == 1)
        if pierces == 1:
            assert result.reason is not None
            assert "'hole'" in result.reason
        else:
            assert result.evaluation is not None
            assert result.evaluation.pierces == (2,)


def test_none_and_one() -> None:
    for contours, least_mm in (((), 0.0), ((square("a", 3, 4, 10),), 10.0)):
        instance = sheet_of(*contours)
        result = solve(instance, Rules("travel", links=True, pierces=1), certify=True)
        assert (result.status, result.value) == (Status.OPTIMAL, pytest.approx(least_mm))
        assert result.certificate is not None
        assert verify(result.certificate, format_instance(instance)).bound == pytest.approx(least_mm, abs=1e-3)


def test_touching_shapes_need_no_length() -> None:
    instance = sheet_of(square("a", 0, 0, 10), square("b", 10, 0, 10), square("c", 20, 0, 10))
    result = solve(instance, Rules("travel", links=True, pierces=1))
    assert (result.status, result.value) == (Status.OPTIMAL, 0.0)
    assert result.evaluation is not None
    assert result.evaluation.pierces == (1,)


@pytest.mark.parametrize("seed", range(8))
def test_outlines_bound_links_from_any_points(seed: int) -> None:
    """The bound is below brute force over corners, and below it still when more points are given."""
    sheet = tiny(np.random.default_rng(seed), SIZES[2 + seed % 4])
    instance = instance_of(sheet)
    for objective in ("travel", "makespan"):
        for pierces in (None, 1):
            best = least(sheet, objective, pierces)
            bound = outline_bound(instance, Rules(objective, links=True, pierces=pierces))
            assert best is None or bound <= best


def test_the_bound_of_outlines_is_tight_for_two() -> None:
    instance = sheet_of(square("a", 3, 4, 10), square("b", 20, 0, 10))
    rules = Rules("travel", links=True, pierces=1)
    # Home to the corner (3, 4) and back; 7 mm between edges, at y from 4 to 10 where no corner is.
    assert outline_bound(instance, rules) == pytest.approx(10 + 14)
    timed = replace(rules, objective="makespan")
    # There an open stroke from a to b, by one link, asks for less than the way back.
    assert outline_bound(instance, timed) == pytest.approx((5 + 20) / 100 + (7 + 80) / 10 + 7)
    assert outline_bound(sheet_of(), rules) == 0.0
    with pytest.raises(ValueError, match="allow no links"):
        outline_bound(instance, Rules())


def twenty_squares() -> Instance:
    """Return squares of random sizes in four rows."""
    rng = np.random.default_rng(1)
    places = [(x, y) for x in range(5) for y in range(4)]
    return sheet_of(*(square(f"c{x}{y}", 30 * x, 30 * y, float(rng.uniform(5, 25))) for x, y in places))


def test_a_stopped_run_keeps_plan_and_bound() -> None:
    instance = twenty_squares()
    rules = Rules("travel", links=True, pierces=1)
    stopped = solve(instance, rules, time_limit=0.0)
    assert stopped.status is Status.FEASIBLE
    assert stopped.lower_bound is not None
    assert stopped.reason == "stopped early"
    better = solve(instance, rules, time_limit=3.0)
    again = solve(instance, rules, time_limit=0.0, start=better.plan)
    assert better.value is not None
    assert again.value == pytest.approx(better.value)
    assert stopped.lower_bound <= (better.lower_bound or 0.0) <= better.value <= (stopped.value or 0.0)


def test_precedence_may_need_a_start() -> None:
    rng = np.random.default_rng(3)
    instance = instance_of(tiny(rng, (2, 2)))
    rules = Rules("makespan", links=True)
    plan = solve(instance, rules).plan
    assert plan is not None
    for pair in ((0, 1), (1, 0)):
        ordered = replace(instance, precedence=(pair,))
        result = solve(ordered, rules, start=plan)
        free = solve(instance, rules)
        assert result.lower_bound == free.lower_bound
        assert (result.status is Status.OPTIMAL) == (check(ordered, rules, plan) == [])


def test_other_methods_and_rules_are_refused() -> None:
    with pytest.raises(ValueError, match="take links"):
        solve(NESTED, Rules(links=True), method="gtsp")
    with pytest.raises(ValueError, match="allow no links"):
        solve(NESTED, Rules(), method="links")


def test_an_open_gap_is_told_as_it_is_proved(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a proof falls short of the search, the bound of a stopped run is the proof's."""
    monkeypatch.setattr("cutgap.formulations.links.proof.MARGINS_MM", (0.5,))
    rules = Rules("travel", links=True, pierces=1)
    result = solve(twenty_squares(), rules, time_limit=1.0, certify=True)
    assert result.certificate is not None
    proved = result.certificate["bound"] / result.certificate["scale"]
    assert result.lower_bound == proved
    assert result.status is Status.FEASIBLE
    assert result.reason is not None
