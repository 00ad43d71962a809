"""The method ``heat`` against every plan: travel under caps, least peak, the front, bounds of stopped runs."""

from dataclasses import replace

import numpy as np
import pytest
from oracles.heat import hot_plans
from oracles.heat_plates import STEEL, few_starts, tied_plate
from oracles.random_plates import random_plate

from cutgap.formulations.certificate import verify
from cutgap.formulations.front_door import solve
from cutgap.formulations.heat import exact, lazy, proof
from cutgap.formulations.heat import solve as method
from cutgap.formulations.heat.front import heat_front
from cutgap.formulations.heat.pairwise import pairwise_bound
from cutgap.formulations.heat.run import Run
from cutgap.formulations.heat.solve import solve_heat
from cutgap.instances import Contour, Head, Instance, Machine, Rules, Status, check, evaluate
from cutgap.instances.formats.json_format import format_instance
from cutgap.instances.generate.plates import dense_plate
from cutgap.instances.progress import nobody

TRAVEL, PEAK = Rules(objective="travel"), Rules(objective="peak")


@pytest.fixture(autouse=True)
def quick_start(monkeypatch):
    """Leave the work to the exact search: a short annealing would find the optimum of so small a plate."""
    monkeypatch.setattr(exact, "FIRST_SECONDS", 0.0)
    monkeypatch.setattr(lazy, "ANNEAL_SECONDS", 0.0)


def drawn(seed):
    rng = np.random.default_rng(seed)
    return tied_plate(rng, int(rng.integers(1, 5)), points=int(rng.integers(1, 4)))


def caps_of(plans):
    """Return peaks that plans have, from the least to nearly the largest; infinite ones are no caps."""
    peaks = np.unique([plan.peak for plan in plans.plans if np.isfinite(plan.peak)])
    return [float(peaks[int(share * (len(peaks) - 1))]) for share in (0.0, 0.1, 0.4, 0.8) if len(peaks)]


def least_travel(plans, cap):
    slack = 1e-9 * max(1.0, abs(cap - plans.ambient))
    return min((plan.travel for plan in plans.plans if plan.peak <= cap + slack), default=None)


def assert_optimal(instance, rules, value):
    result = solve_heat(instance, rules)
    assert result.status is Status.OPTIMAL
    assert result.value == pytest.approx(value, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("seed", range(40))
def test_travel_under_caps_and_peak_are_those_of_the_best_of_all_plans(seed):
    instance = drawn(seed)
    plans = hot_plans(instance)
    for cap in caps_of(plans):
        assert_optimal(instance, replace(TRAVEL, temperature_cap=cap), least_travel(plans, cap))
    coolest = plans.least_peak().peak
    if np.isfinite(coolest):
        assert_optimal(instance, PEAK, coolest)
        below = solve_heat(instance, replace(TRAVEL, temperature_cap=coolest - 1e-3))
        assert below.status is Status.INFEASIBLE
        assert f"{coolest - 1e-3:g}" in below.reason
    else:
        hot = solve_heat(instance, PEAK)
        assert hot.lower_bound is None


@pytest.mark.parametrize("seed", range(100, 112))
def test_the_front_is_that_of_all_plans(seed):
    instance = drawn(seed)
    expected = [plan for plan in hot_plans(instance).front() if np.isfinite(plan.peak)]
    found = [
        point for point in heat_front(instance, TRAVEL) if np.isfinite(point.evaluation.peak_temperature_c)
    ]
    assert all(point.status is Status.OPTIMAL for point in found)
    # Plans that differ by rounding are one point here.
    for point in found:
        assert any(near(point.value, each.travel) and near(peak(point), each.peak) for each in expected)
    for each in expected:
        assert any(beats(point, each) for point in found)


@pytest.mark.parametrize("seed", range(8))
def test_a_front_counts_the_price_of_going_back(seed):
    instance = tied_plate(np.random.default_rng(seed), 4, points=2, metric="euclidean")
    rules = replace(TRAVEL, backward_price=2.0)
    every = [evaluate(instance, each.plan) for each in hot_plans(instance).plans]
    found = heat_front(instance, rules)
    assert all(point.status is Status.OPTIMAL for point in found)
    for plan in every:
        if np.isfinite(plan.peak_temperature_c):
            value = plan.objective(rules)
            assert any(
                point.value <= value + 1e-8 and peak(point) <= plan.peak_temperature_c + 1e-6 for point in found
            )


def spots(matrix):
    """Return a plate of three contours without length on one spot, and one elsewhere."""
    made = []
    for k, (left, side) in enumerate(((0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (10.0, 2.0))):
        curve = np.array([[left, 0.0], [left + side, 0.0], [left + side, side], [left, side]])
        made.append(Contour(f"c{k}", np.array([[left, 0.0, 0.0]]), 4 * side, geometry=curve))
    machine = Machine(v_jump=20.0, v_cut=10.0, t_aux=0.0, metric="matrix")
    head = Head("head", np.zeros(3))
    return Instance("spots", tuple(made), (head,), machine, material=STEEL, matrix=matrix)


@pytest.fixture
def no_first_plan(monkeypatch):
    """Leave all to the branch and bound: on so small a plate the first plan is mostly the best one."""

    def first_path(run):
        return np.array(run.plate.first[:-1])

    monkeypatch.setattr(Run, "first_path", first_path)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.usefixtures("no_first_plan")
def test_a_plan_may_be_endlessly_hot_where_nothing_caps_it(seed):
    matrix = np.random.default_rng(seed).integers(0, 30, (5, 5)).astype(float)
    matrix[:3, :3] = 0.0
    instance = spots(matrix)
    plans = hot_plans(instance)
    assert_optimal(instance, TRAVEL, plans.least_travel().travel)
    hot = solve_heat(instance, PEAK)
    assert hot.plan is not None
    assert np.isinf(hot.value)
    assert hot.lower_bound is None


@pytest.mark.parametrize("seed", range(200, 220))
@pytest.mark.usefixtures("no_first_plan")
def test_branch_and_bound_alone(seed):
    instance = drawn(seed)
    plans = hot_plans(instance)
    assert_optimal(instance, TRAVEL, plans.least_travel().travel)
    for cap in caps_of(plans):
        assert_optimal(instance, replace(TRAVEL, temperature_cap=cap), least_travel(plans, cap))
    coolest = plans.least_peak().peak
    if np.isfinite(coolest):
        assert_optimal(instance, PEAK, coolest)


@pytest.mark.parametrize("seed", range(2))
def test_annealing_for_the_peak_stays_within_a_limit_on_travel(seed):
    instance = dense_plate(20, np.random.default_rng(seed))
    shortest = Run(instance, TRAVEL, nobody)
    path = shortest.first_path()
    run = Run(instance, PEAK, nobody, most_travel=1.05 * shortest.value)
    run.offer(shortest.best)
    before = run.value
    for _ in zip(range(15), run.annealing(path), strict=False):
        pass
    assert run.value < 0.95 * before
    assert evaluate(instance, run.best).total_travel_mm <= 1.05 * shortest.value + 1e-6


def near(a, b):
    return a == pytest.approx(b, rel=1e-8, abs=1e-8)


def peak(point):
    return point.evaluation.peak_temperature_c


def beats(point, plan):
    return point.value <= plan.travel + 1e-8 and peak(point) <= plan.peak + 1e-8 * max(1.0, plan.peak)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("clear", [False, True])
def test_precedence_and_clear_rapids(seed, clear):
    rng = np.random.default_rng(seed)
    instance = random_plate(rng, 4, entries=2, homes=None, precedence=True)
    plans = hot_plans(instance, clear_rapids=clear)
    rules = replace(TRAVEL, clear_rapids=clear)
    if not plans.plans:
        assert solve_heat(instance, rules).status is Status.INFEASIBLE
        return
    for cap in caps_of(plans):
        assert_optimal(instance, replace(rules, temperature_cap=cap), least_travel(plans, cap))
    if np.isfinite(plans.least_peak().peak):
        assert_optimal(instance, replace(PEAK, clear_rapids=clear), plans.least_peak().peak)


def test_five_contours_of_three_points():
    instance = tied_plate(np.random.default_rng(5), 5, home=True)
    plans = hot_plans(instance)
    cap = caps_of(plans)[1]
    assert_optimal(instance, replace(TRAVEL, temperature_cap=cap), least_travel(plans, cap))
    assert_optimal(instance, PEAK, plans.least_peak().peak)
    assert solve(instance, PEAK).method == "heat"


def test_a_makespan_is_least_where_travel_is():
    instance = few_starts(5, 3, seed=1)
    cap = solve_heat(instance, PEAK).value
    shortest = solve_heat(instance, replace(TRAVEL, temperature_cap=cap))
    fastest = solve_heat(instance, Rules(objective="makespan", temperature_cap=cap))
    work = float(instance.service_times.sum())
    assert fastest.value == pytest.approx(shortest.value / instance.machine.v_jump + work)


def test_a_weight_of_imbalance_means_nothing_to_one_head():
    instance = few_starts(4, 2, seed=1)
    cap = solve_heat(instance, PEAK).value
    shortest = solve_heat(instance, replace(TRAVEL, temperature_cap=cap))
    assert_optimal(instance, Rules(objective="weighted", weight=3.0, temperature_cap=cap), shortest.value)


def test_parts_in_one_go_and_a_price_of_going_back_are_kept():
    plain = few_starts(5, 2, seed=3)
    parts = ("a", "b", "a", "b", None)
    contours = tuple(
        Contour(c.id, c.entry_points, c.perimeter, part=part, geometry=c.geometry)
        for c, part in zip(plain.contours, parts, strict=True)
    )
    instance = replace(plain, contours=contours)
    rules = Rules(objective="travel", parts_in_one_go=True, backward_price=0.5)
    capped = replace(rules, temperature_cap=solve_heat(instance, replace(PEAK, parts_in_one_go=True)).value)
    allowed = [
        plan
        for plan in map(lambda hot: hot.plan, hot_plans(instance).plans)
        if not check(instance, capped, plan)
    ]
    assert_optimal(instance, capped, min(evaluate(instance, plan).objective(capped) for plan in allowed))


@pytest.mark.parametrize("seed", range(4))
def test_forbidden_runs_find_the_same_optimum(seed, monkeypatch):
    instance = tied_plate(np.random.default_rng(seed), 4, points=2, home=True)
    plans = hot_plans(instance)
    monkeypatch.setattr(method, "fits", lambda first: False)
    # Whether there is a plan is asked; by how much the cap is too low is worked out afterwards, for seconds.
    monkeypatch.setattr(method, "WHY_SECONDS", 0.0)
    for cap in caps_of(plans):
        assert_optimal(instance, replace(TRAVEL, temperature_cap=cap), least_travel(plans, cap))
    coolest = plans.least_peak().peak
    if np.isfinite(coolest):
        below = solve_heat(instance, replace(TRAVEL, temperature_cap=coolest - 1e-3))
        assert below.status is Status.INFEASIBLE


def test_without_a_home_the_bound_of_larger_plates_leaves_heat_out(monkeypatch):
    instance = tied_plate(np.random.default_rng(2), 4, points=2, home=False)
    plans = hot_plans(instance)
    monkeypatch.setattr(method, "fits", lambda first: False)
    monkeypatch.setattr(lazy, "ANNEAL_SECONDS", 0.5)
    cap = caps_of(plans)[1]
    result = solve_heat(instance, replace(TRAVEL, temperature_cap=cap), time_limit=2.0)
    assert result.lower_bound == pytest.approx(min(plan.travel for plan in plans.plans))
    assert result.value >= least_travel(plans, cap) - 1e-9


@pytest.mark.parametrize("rules", [TRAVEL, PEAK])
def test_a_run_that_is_stopped_at_once_has_a_valid_bound(rules):
    instance = few_starts(8, 4, seed=1)
    if rules is TRAVEL:
        rules = replace(TRAVEL, temperature_cap=solve_heat(instance, PEAK).value + 2.0)
    optimum = solve_heat(instance, rules)
    stopped = solve_heat(instance, rules, time_limit=0.0)
    assert optimum.status is Status.OPTIMAL
    assert stopped.lower_bound <= optimum.value + 1e-9
    assert stopped.value is None or stopped.value >= optimum.value - 1e-9


def test_an_interrupted_run_keeps_what_it_has():
    instance = few_starts(8, 4, seed=2)
    seen = []

    def watch(progress):
        seen.append(progress)
        if progress.value is not None and progress.lower_bound is not None:
            raise KeyboardInterrupt

    result = solve_heat(instance, PEAK, watch=watch)
    assert result.status in (Status.FEASIBLE, Status.OPTIMAL)
    assert result.lower_bound <= result.value
    assert len(seen) > 0


def test_nothing_to_cut_is_as_warm_as_its_surroundings():
    empty = Instance("empty", (), (Head("head", np.zeros(3)),), material=STEEL)
    assert solve_heat(empty, PEAK).value == STEEL.ambient_c
    assert solve_heat(empty, PEAK).status is Status.OPTIMAL
    cold = solve_heat(empty, replace(TRAVEL, temperature_cap=STEEL.ambient_c - 1.0))
    assert cold.status is Status.INFEASIBLE


@pytest.fixture
def capped():
    """Return a plate whose shortest plan is too hot, and the cap."""
    instance = few_starts(5, 3, seed=4)
    cap = solve_heat(instance, PEAK).value
    assert (
        solve_heat(instance, replace(TRAVEL, temperature_cap=cap)).value
        > solve_heat(instance, TRAVEL).value + 1
    )
    return instance, cap


@pytest.mark.parametrize("objective", ["travel", "makespan", "peak"])
def test_certificates_prove_bounds_under_heat(capped, objective):
    instance, cap = capped
    rules = Rules(objective=objective, temperature_cap=None if objective == "peak" else cap)
    result = solve_heat(instance, rules, certify=True)
    verified = verify(result.certificate, format_instance(instance))
    assert float(verified.bound) == pytest.approx(result.value, rel=1e-6)
    assert verified.unit == rules.unit
    assert (result.status, result.reason, result.certificate["plan"]) == (Status.OPTIMAL, None, None)


def test_a_certificate_says_that_no_plan_is_so_cool(capped):
    instance, cap = capped
    for objective in ("travel", "peak"):
        rules = Rules(objective=objective, temperature_cap=cap - 0.001)
        result = solve_heat(instance, rules, certify=True)
        assert result.status is Status.INFEASIBLE
        assert verify(result.certificate, format_instance(instance)).bound is None


@pytest.mark.parametrize(("objective", "unit"), [("travel", "mm"), ("makespan", "s")])
def test_where_a_proof_is_too_long_the_bound_without_heat_is_certified(capped, objective, unit, monkeypatch):
    monkeypatch.setattr(proof, "MOST_STEPS", 100)
    instance, cap = capped
    free = solve_heat(instance, Rules(objective=objective)).value
    result = solve_heat(instance, Rules(objective=objective, temperature_cap=cap), certify=True)
    verified = verify(result.certificate, format_instance(instance))
    assert float(verified.bound) == pytest.approx(free, abs=1e-3)
    assert f"proves {free:.3f} {unit}, the bound without heat" in result.reason
    assert solve_heat(instance, PEAK, certify=True).certificate is None


def test_a_certificate_that_proves_the_bound_needs_no_words():
    instance = few_starts(5, 3, seed=4)
    result = solve_heat(instance, TRAVEL, certify=True)
    assert result.certificate is not None
    assert result.reason is None


@pytest.mark.parametrize("seed", range(4))
def test_pairs_bound_the_peak_and_two_contours_are_a_pair(seed):
    for contours in (2, 3):
        instance = tied_plate(np.random.default_rng(seed), contours, points=2, metric="euclidean")
        peaks = hot_plans(instance).least_peak().peak
        warmest = max(plan.peak for plan in hot_plans(instance).plans if np.isfinite(plan.peak))
        bound = pairwise_bound(instance, PEAK, warmest=warmest, workers=1, isolated=False, time_limit=20.0)
        assert bound.lower_bound <= peaks + 1e-9
        if contours == 2 and np.isfinite(peaks):
            assert bound.lower_bound == pytest.approx(peaks, rel=0.02, abs=0.05)


def moved(instance, matrix, shift=(0.0, 0.0), scale=1.0):
    """Return the instance under a linear map and a shift; times by the square of the scale."""

    def map_all(points):
        flat = points[:, :2] @ np.array(matrix).T * scale + np.array(shift)
        return np.column_stack([flat, points[:, 2:]])

    contours = tuple(
        Contour(c.id, map_all(c.entry_points), c.perimeter * scale, geometry=map_all(c.geometry))
        for c in instance.contours
    )
    home = map_all(instance.heads[0].home[None])[0]
    speeds = replace(
        instance.machine,
        v_jump=instance.machine.v_jump / scale,
        v_cut=instance.machine.v_cut / scale,
        t_aux=instance.machine.t_aux * scale**2,
    )
    return replace(instance, contours=contours, heads=(Head("head", home),), machine=speeds)


@pytest.mark.parametrize(
    ("matrix", "shift", "scale"),
    [
        ([[1, 0], [0, 1]], (300.0, -70.0), 1.0),
        ([[-1, 0], [0, 1]], (0.0, 0.0), 1.0),
        ([[0, 1], [1, 0]], (0.0, 0.0), 1.0),
        # Heat spreads as the root of time: k times as long, k^2 times as late, cut at a k-th of the speed.
        ([[1, 0], [0, 1]], (0.0, 0.0), 3.0),
    ],
)
def test_moved_mirrored_and_scaled_plates(matrix, shift, scale):
    instance = few_starts(6, 3, seed=7)
    other = moved(instance, matrix, shift, scale)
    least = solve_heat(instance, PEAK).value
    assert solve_heat(other, PEAK).value == pytest.approx(least, rel=1e-7)
    rules = replace(TRAVEL, temperature_cap=least + 3.0)
    travel = solve_heat(instance, rules).value
    assert solve_heat(other, rules).value == pytest.approx(scale * travel, rel=1e-7)


def test_what_the_method_does_not_take_is_refused():
    plate = few_starts(3, 2, seed=1)
    with pytest.raises(ValueError, match="one head"):
        solve_heat(replace(plate, heads=(Head("a"), Head("b"))), PEAK)
    with pytest.raises(ValueError, match="via points"):
        solve_heat(plate, replace(PEAK, via_points=True))
    with pytest.raises(ValueError, match="material"):
        solve_heat(replace(plate, material=None), PEAK)
    with pytest.raises(ValueError, match="at most 62"):
        solve_heat(few_starts(63, 1, seed=1), PEAK)
