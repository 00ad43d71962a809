"""Compact models under heat against every plan, with lags known up to their cells and exactly."""

from dataclasses import replace
from itertools import pairwise

import cvxpy as cp
import numpy as np
import pytest
from oracles.heat import hot_plans
from oracles.heat_cells import CellPeaks
from oracles.heat_plates import STEEL, few_starts, tied_plate
from oracles.random_plates import random_plate

from cutgap.formulations import ladder, verify
from cutgap.formulations.compact import TOUR_FORMULATIONS, compact_model
from cutgap.formulations.compact.programme import assemble
from cutgap.formulations.compact.solvers import run
from cutgap.formulations.heat.solve import solve_heat
from cutgap.instances import Head, Rules, Status, check
from cutgap.instances.formats.json_format import format_instance

TRAVEL, PEAK = Rules("travel"), Rules("peak")
HOT = 8
"""Seed of a plate whose least peak needs all its contours."""

EXACT = [name for name in TOUR_FORMULATIONS if name != "assignment"]


def close(value):
    return pytest.approx(value, rel=2e-6, abs=2e-6)


def small(seed):
    """Return a plate of 3 contours with ties, or a dense one."""
    rng = np.random.default_rng(seed)
    return tied_plate(rng, 3, points=int(rng.integers(1, 4))) if seed % 3 else few_starts(3, 3, seed)


def caps_between(peaks):
    """Return caps between the peaks that plans have, so that no plan keeps a cap by a hair."""
    peaks = np.unique(np.round([peak for peak in peaks if np.isfinite(peak)], 6))
    middles = [(a + b) / 2 for a, b in pairwise(peaks) if b - a > 1e-4]
    return [middles[int(share * (len(middles) - 1))] for share in (0.0, 0.3)] if middles else []


@pytest.mark.parametrize("above", [False, True])
@pytest.mark.parametrize("home", [True, False])
def test_a_plan_is_as_warm_as_its_cells_say(above, home):
    """x held at a plan: all rows at once, each lag in its cell, the least or the most heat of it."""
    instance = few_starts(4, 2, seed=2 + above)
    if not home:
        instance = replace(instance, heads=(Head("head"),))
    cells = CellPeaks(instance, 3)
    margin = 1.0 if above else 0.0
    programme = assemble(instance, PEAK, "mtz", integer=True, margin_s=margin, lag_cells=3)
    head, problem = programme.heads[0], programme.problem()
    held = cp.Parameter(len(head.network.tails))
    problem = cp.Problem(problem.objective, [*problem.constraints, head.x == held])
    plans = hot_plans(instance).plans
    for plan in [plans[k] for k in np.random.default_rng(0).integers(len(plans), size=12)]:
        held.value = head.network.legs_of(plan.plan.tours[0])
        found, expected = run(problem, "HIGHS", None, integer=True).value, cells.peak(plan.tour, above=above)
        assert found == pytest.approx(expected, rel=1e-5)
        assert found >= plan.peak - 1e-6 if above else found <= plan.peak + 1e-6


@pytest.mark.parametrize("seed", range(10))
def test_the_bound_is_that_of_the_best_plan_with_cells(seed):
    instance = small(seed)
    plans, cells = hot_plans(instance), CellPeaks(instance, 4)
    peaks = {plan.tour: cells.peak(plan.tour) for plan in plans.plans}
    coolest, true = min(peaks.values()), plans.least_peak().peak
    if np.isfinite(true):
        result = compact_model(instance, PEAK, lag_cells=4).solve()
        assert result.lower_bound == close(coolest)
        assert result.lower_bound <= true + 1e-6 <= result.value + 2e-6
        assert solve_heat(instance, PEAK).value == pytest.approx(true)
    for cap in caps_between(peaks.values()):
        rules = replace(TRAVEL, temperature_cap=float(cap))
        shortest = min(plan.travel for plan in plans.plans if peaks[plan.tour] <= cap)
        result = compact_model(instance, rules, lag_cells=4).solve()
        assert result.lower_bound == close(shortest)
        least = plans.least_travel(float(cap))
        assert least is None or result.lower_bound <= least.travel + 1e-6
    below = replace(TRAVEL, temperature_cap=coolest - 1e-3)
    result = compact_model(instance, below, lag_cells=4).solve()
    assert (result.status, result.plan) == ("infeasible", None)


@pytest.mark.parametrize("seed", [1265, 1528])
def test_huge_rises_above_a_cap_cost_no_optimum(seed):
    """HiGHS lost the optimum of these plates while what is above the cap was priced in the rows."""
    instance = tied_plate(np.random.default_rng(seed), 3, points=1 + seed % 3)
    plans, cells = hot_plans(instance), CellPeaks(instance, 4)
    peaks = {plan.tour: cells.peak(plan.tour) for plan in plans.plans}
    levels = np.unique(np.round([peak for peak in peaks.values() if peak < 9e5], 6))
    third = len(levels) // 3
    cap = float(levels[third] + levels[third + 1]) / 2
    shortest = min(plan.travel for plan in plans.plans if peaks[plan.tour] <= cap)
    result = compact_model(instance, replace(TRAVEL, temperature_cap=cap), lag_cells=4).solve()
    assert result.lower_bound == close(shortest)


def test_fine_cells_close_the_gap():
    """At most (n - 2) w below the least peak; under a cap that no plan misses by so little, not at all."""
    instance = tied_plate(np.random.default_rng(HOT), 3, points=3, home=True, metric="euclidean")
    plans = hot_plans(instance)
    best, found = plans.least_peak().peak, []
    for cells in (1, 2, 4, 8, 64):
        result = compact_model(instance, PEAK, lag_cells=cells).solve()
        envelopes = CellPeaks(instance, cells)
        widths = [envelopes.peak(p.tour, above=True) - envelopes.peak(p.tour) for p in plans.plans]
        assert best - result.lower_bound <= max(widths) + 1e-5
        found.append(result.lower_bound)
    # Cells that are halved know more of each lag.
    assert all(more >= less - 1e-5 for less, more in pairwise(found))
    assert best - found[-1] < 0.1 * (best - found[0])
    for cap in caps_between(plan.peak for plan in plans.plans):
        rules = replace(TRAVEL, temperature_cap=float(cap))
        result = compact_model(instance, rules, lag_cells=64).solve()
        assert (result.status, result.value) == ("optimal", close(plans.least_travel(float(cap)).travel))
        assert result.value == close(solve_heat(instance, rules).value)


@pytest.mark.parametrize("seed", range(6))
def test_two_contours_are_exact(seed):
    instance = tied_plate(np.random.default_rng(seed), 2, points=3)
    plans = hot_plans(instance)
    least = plans.least_peak().peak
    result = compact_model(instance, PEAK, lag_cells=1).solve()
    if np.isfinite(least):
        assert (result.status, result.value) == ("optimal", close(least))
    for cap in caps_between(plan.peak for plan in plans.plans):
        result = compact_model(instance, replace(TRAVEL, temperature_cap=float(cap)), lag_cells=1).solve()
        assert (result.status, result.value) == ("optimal", close(plans.least_travel(float(cap)).travel))


@pytest.mark.parametrize("clear", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_precedence_and_clear_rapids(seed, clear):
    instance = random_plate(np.random.default_rng(seed), 3, entries=2, homes=None, precedence=True, nested=0.8)
    plans, cells = hot_plans(instance, clear_rapids=clear), CellPeaks(instance, 3)
    peaks = {plan.tour: cells.peak(plan.tour) for plan in plans.plans}
    rules = replace(TRAVEL, clear_rapids=clear)
    coolest = compact_model(instance, replace(PEAK, clear_rapids=clear), lag_cells=3).solve()
    if not peaks:
        assert coolest.status is Status.INFEASIBLE
        return
    assert coolest.lower_bound == close(min(peaks.values()))
    for cap in caps_between(peaks.values()):
        shortest = min(plan.travel for plan in plans.plans if peaks[plan.tour] <= cap)
        asked = replace(rules, temperature_cap=float(cap))
        assert compact_model(instance, asked, lag_cells=3).solve().lower_bound == close(shortest)


def test_formulations_agree_and_relax():
    instance = few_starts(3, 2, seed=7)
    bounds = {}
    for name in EXACT:
        model = compact_model(instance, PEAK, name, lag_cells=2)
        bounds[name] = model.solve().lower_bound
        assert STEEL.ambient_c <= model.relax().lower_bound <= bounds[name] + 1e-6
    assert list(bounds.values()) == [close(bounds["mtz"])] * len(EXACT)


def test_a_makespan_is_least_where_travel_is():
    instance = few_starts(3, 3, seed=1)
    cap = solve_heat(instance, PEAK).value + 0.5
    travel, makespan = (
        compact_model(instance, Rules(objective, temperature_cap=cap)).solve()
        for objective in ("travel", "makespan")
    )
    seconds = travel.lower_bound / instance.machine.v_jump + instance.service_times.sum()
    assert makespan.lower_bound == close(seconds)


def test_a_plan_beyond_the_cap_is_replaced_by_one_that_keeps_the_most_of_its_cells():
    """With one cell the model does not tell plans well: what it takes for cool enough is too warm."""
    replaced = 0
    for seed in range(6):
        instance = few_starts(3, 3, seed=seed)
        plans, cells = hot_plans(instance), CellPeaks(instance, 1)
        for cap in caps_between(plan.peak for plan in plans.plans):
            result = compact_model(instance, replace(TRAVEL, temperature_cap=float(cap)), lag_cells=1).solve()
            safe = [plan.travel for plan in plans.plans if cells.peak(plan.tour, above=True) <= cap]
            if result.reason is None or not safe:
                continue
            replaced += 1
            assert "cell" in result.reason
            assert check(instance, result.rules, result.plan) == []
            assert result.value == close(min(safe))
            assert result.lower_bound <= plans.least_travel(float(cap)).travel + 1e-6
    assert replaced


def test_below_freezing_bounds_may_be_negative():
    plate = few_starts(3, 2, seed=1)
    cold = replace(plate, material=replace(STEEL, ambient_c=-100.0))
    warm = replace(plate, material=replace(STEEL, ambient_c=0.0))
    bound = compact_model(cold, PEAK).solve().lower_bound
    assert bound == close(compact_model(warm, PEAK).solve().lower_bound - 100.0)
    assert compact_model(cold, PEAK).relax().lower_bound <= bound < 0


def test_nothing_and_one_contour():
    for count in (0, 1):
        plate = replace(few_starts(1, 3, seed=1), material=STEEL)
        plate = replace(plate, contours=plate.contours[:count])
        model = compact_model(plate, PEAK)
        result = model.solve()
        assert (result.status, result.value) == ("optimal", STEEL.ambient_c)
        assert model.relax().value == STEEL.ambient_c
        for cap, status in ((STEEL.ambient_c + 1.0, "optimal"), (STEEL.ambient_c - 1.0, "infeasible")):
            assert compact_model(plate, replace(TRAVEL, temperature_cap=cap)).solve().status == status


def test_an_infinite_peak_has_no_bound():
    """Two contours without length on one spot, where one is cut at once after the other."""
    spot = tied_plate(np.random.default_rng(0), 2, points=1, home=True, metric="euclidean")
    corners = np.zeros((4, 2))
    contours = tuple(
        replace(contour, entry_points=np.zeros((1, 3)), perimeter=0.0, geometry=corners)
        for contour in spot.contours
    )
    result = compact_model(replace(spot, contours=contours), PEAK).solve()
    assert (result.status, result.value, result.lower_bound) == ("feasible", np.inf, None)


def test_stopped_at_once_nothing_is_known():
    result = compact_model(few_starts(4, 2, seed=1), PEAK).solve(time_limit=0.0)
    assert (result.status, result.plan) == ("unknown", None)
    assert result.lower_bound in (None, STEEL.ambient_c)


def test_certificates_leave_the_cap_out():
    plate = few_starts(3, 2, seed=3)
    capped = replace(TRAVEL, temperature_cap=solve_heat(plate, PEAK).value)
    bare, under, peak = (next(ladder(plate, rules, names=["time-indexed"])) for rules in (TRAVEL, capped, PEAK))
    assert under.bound == pytest.approx(bare.bound)
    assert float(verify(under.certificate, format_instance(plate)).bound) == pytest.approx(under.bound)
    assert peak.bound is None
    assert "objective peak" in peak.note


def test_what_is_refused():
    plate = few_starts(3, 2, seed=1)
    two = replace(plate, heads=(Head("a"), Head("b")))
    with pytest.raises(ValueError, match="two heads: does not take the objective peak"):
        compact_model(two, replace(PEAK, non_overlap=None))
    capped = compact_model(two, Rules("travel", non_overlap=None, temperature_cap=300.0))
    with pytest.raises(ValueError, match="can be relaxed, not solved"):
        capped.solve()
    assert capped.relax().value > 0.0
    with pytest.raises(ValueError, match="lag_cells: expected at least 1, got 0"):
        compact_model(plate, PEAK, lag_cells=0)
    with pytest.raises(ValueError, match=r"with 8 cells.*limit is 200000.*method heat"):
        compact_model(few_starts(20, 3, seed=1), PEAK).size()
    with pytest.raises(ValueError, match="material"):
        compact_model(replace(plate, material=None), PEAK)
