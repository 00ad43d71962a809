"""The dual-coded genetic algorithm: its fitness by hand, its figures, its plans against brute force."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles.heat import hot_plans
from oracles.random_plates import random_plate

from cutgap.heuristics import HEURISTICS
from cutgap.heuristics.dual_coded import dual_coded, front_of_population, measure
from cutgap.heuristics.dual_coded_fitness import ROOM_C, DualCodedParameters, raw_fitness, scaled, travel_unit
from cutgap.heuristics.hot_routes import (
    barred_steps,
    nearest_neighbours,
    plan_of_route,
    plate_of,
    random_route,
)
from cutgap.instances import Contour, Head, Instance, Machine, Rules, check, evaluate
from cutgap.instances.generate import generate
from cutgap.instances.progress import Progress

NAMES = ("dual-coded-ga", "dual-coded-ga-cool", "dual-coded-ga-travel", "plain-ga")
TABLE = ((42.74, 300.56), (38.87, 350.99), (40.82, 156.45), (75.23, 142.37))
"""Printed: time distance in m and highest temperature in deg C, the last two for mu = 4 and 0.6."""

SHORT = DualCodedParameters(generations=20, population=20)


@pytest.mark.parametrize(("mu", "row"), [(4.0, 2), (0.6, 3)])
def test_in_seconds_the_printed_plans_are_the_fittest_for_their_mu_but_not_in_metres(mu, row):
    metres, peaks = np.array(TABLE).T
    parameters = DualCodedParameters(mu=mu)
    seconds = metres * 60.0 / 4.0
    for f_1, agrees in ((seconds, True), (metres, False), (metres / 0.0142, True), (metres / 0.094, True)):
        assert (raw_fitness(f_1, peaks - ROOM_C, np.inf, parameters).argmax() == row) == agrees


def test_the_units_that_agree_with_the_table_end_at_14_and_94_mm():
    metres, peaks = np.array(TABLE).T
    for unit_m in (0.013, 0.096):
        best = [
            raw_fitness(metres / unit_m, peaks - ROOM_C, np.inf, DualCodedParameters(mu=each)).argmax()
            for each in (4.0, 0.6)
        ]
        assert best != [2, 3]


def test_raw_fitness_and_penalty_by_hand():
    parameters = DualCodedParameters(mu=4.0, penalty=10.0)
    f_1, rises = np.array([8.0, 8.0]), np.array([80.0, 105.0])
    # f_2 = 20 + 80; 20 + 105 + 10 * (105 - 100).
    assert raw_fitness(f_1, rises, 100.0, parameters) == pytest.approx([0.5 + 1 / 100, 0.5 + 1 / 175])
    assert raw_fitness(f_1, rises, np.inf, parameters) == pytest.approx([0.5 + 1 / 100, 0.5 + 1 / 125])
    assert raw_fitness(f_1, rises, 100.0, replace(parameters, mu=None)) == pytest.approx([1 / 8, 1 / 8])
    assert raw_fitness(f_1, np.full(2, np.inf), 100.0, parameters) == pytest.approx([0.5, 0.5])


def test_dynamic_scaling_by_hand():
    raw = np.array([1.0, 3.0, 4.0, 8.0])
    # The mean is 4; 2 is a third of the way down to 1, and so on.
    for generation in (0, 1, 300):
        up, down = 0.1 * 1.01**generation * 4.0, 0.05 * 1.01**generation * 4.0
        expected = [4.0 - down, 4.0 - down / 3.0, 4.0, 4.0 + up]
        assert scaled(raw, generation, DualCodedParameters()) == pytest.approx(expected)
    assert (scaled(raw, 300, DualCodedParameters()) > 0.0).all()
    assert scaled(np.full(3, 0.7), 5, DualCodedParameters()).tolist() == [0.7] * 3


def test_a_translated_mu_weighs_a_nearest_neighbour_route_as_the_printed_one():
    instance = generate("dense-plate", holes=12, seed=1)
    plate = plate_of(instance, Rules())
    found = evaluate(instance, plan_of_route(*nearest_neighbours(plate)))
    unit = travel_unit(plate, DualCodedParameters())
    ratio = (found.total_travel_mm / unit) / found.peak_temperature_c
    assert ratio == pytest.approx(38.87 * 15.0 / 350.99)
    assert travel_unit(plate, DualCodedParameters(printed_units=True)) == instance.machine.v_jump


@given(st.integers(0, 2**32 - 1), st.integers(1, 8))
def test_figures_of_routes_are_those_of_evaluate_and_check(seed, count):
    rng = np.random.default_rng(seed)
    instance = random_plate(rng, count, homes=None, precedence=None, nested=0.6)
    rules = Rules("travel", clear_rapids=True)
    plate = plate_of(instance, rules)
    sizes = [len(contour.entry_points) for contour in instance.contours]
    orders = np.array([rng.permutation(count) for _ in range(3)], dtype=np.int64)
    starts = rng.integers(0, sizes, (3, count))
    random_route(plate, orders[0], starts[0], rng)
    travels, rises, barred = measure(plate, orders, starts)
    for i in range(3):
        plan = plan_of_route(orders[i], starts[i])
        expected = evaluate(instance, plan)
        assert travels[i] == pytest.approx(expected.total_travel_mm, rel=1e-12)
        peak = instance.material.ambient_c + rises[i]
        assert peak == pytest.approx(expected.peak_temperature_c, rel=1e-12)
        assert (barred[i] == 0) == (not check(instance, rules, plan))
    most = int(barred[1])
    assert barred_steps(plate, orders[1], starts[1], most) == most
    assert most == 0 or barred_steps(plate, orders[1], starts[1], most - 1) == most


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("seed", range(4))
def test_plans_keep_the_rules_and_do_not_beat_brute_force(name, seed):
    rng = np.random.default_rng((2, seed))
    instance = random_plate(rng, int(rng.integers(2, 5)), homes=None, precedence=None, nested=0.6)
    plans = hot_plans(instance, clear_rapids=True)
    least = plans.least_peak()
    if least is None:
        pytest.fail("draw another seed: no plan is allowed")
    cap = (least.peak + plans.least_travel().peak) / 2
    rules = Rules("travel", clear_rapids=True, temperature_cap=cap)
    plan = HEURISTICS[name](instance, rules, rng=rng)
    assert not check(instance, rules, plan)
    found = evaluate(instance, plan)
    assert found.total_travel_mm >= plans.least_travel(cap).travel * (1 - 1e-9)
    assert found.peak_temperature_c >= least.peak - 1e-9


@pytest.mark.parametrize("seed", range(3))
def test_the_fittest_plan_of_a_tiny_plate_is_found(seed):
    rng = np.random.default_rng((3, seed))
    instance = random_plate(rng, 4)
    parameters = DualCodedParameters(mu=4.0, printed_units=True)
    plans = hot_plans(instance).plans

    def fitness(travel, peak):
        return 4.0 * instance.machine.v_jump / travel + 1.0 / (ROOM_C + peak - instance.material.ambient_c)

    best = max(fitness(plan.travel, plan.peak) for plan in plans)
    found = evaluate(instance, dual_coded(instance, Rules("travel"), rng=rng, parameters=parameters))
    assert fitness(found.total_travel_mm, found.peak_temperature_c) == pytest.approx(best, rel=1e-9)


def test_the_front_falls_and_is_not_beaten_by_the_answer():
    instance, rules = generate("dense-plate", holes=10, seed=4), Rules("travel", clear_rapids=True)
    front = front_of_population(instance, rules, rng=np.random.default_rng(1), parameters=SHORT)
    answer = evaluate(instance, dual_coded(instance, rules, rng=np.random.default_rng(1), parameters=SHORT))
    figures = [evaluate(instance, plan) for plan in front]
    points = [(each.total_travel_mm, each.peak_temperature_c) for each in figures]
    assert not any(check(instance, rules, plan) for plan in front)
    assert points == sorted(points)
    assert [peak for _, peak in points] == sorted((peak for _, peak in points), reverse=True)
    # The answer is the fittest of all that were seen, so it is on the front.
    assert (answer.total_travel_mm, answer.peak_temperature_c) in points


@pytest.mark.parametrize("name", NAMES)
def test_the_same_seed_gives_the_same_plan(name):
    instance, rules = generate("dense-plate", holes=8, seed=2), Rules("peak", clear_rapids=True)
    plans = [HEURISTICS[name](instance, rules, rng=np.random.default_rng(7)) for _ in range(2)]
    assert plans[0] == plans[1]
    assert len(evaluate(instance, plans[0]).travel_mm) == 1


def test_a_cap_that_nothing_keeps_gives_a_plan_that_check_names():
    instance = generate("dense-plate", holes=6, seed=2)
    plan = dual_coded(instance, Rules(temperature_cap=0.0), rng=np.random.default_rng(0), parameters=SHORT)
    assert [each.constraint for each in check(instance, Rules(temperature_cap=0.0), plan)] == [
        "temperature cap"
    ]


def test_the_watch_sees_values_fall_and_a_limit_stops():
    instance, rules = generate("dense-plate", holes=10, seed=2), Rules("travel", clear_rapids=True)
    seen: list[Progress] = []
    travel_alone = replace(SHORT, mu=None)
    rng = np.random.default_rng(0)
    plan = dual_coded(instance, rules, rng=rng, watch=seen.append, parameters=travel_alone)
    values = [progress.value for progress in seen]
    assert len(values) > 1
    assert values == sorted(values, reverse=True)
    assert values[-1] == evaluate(instance, plan).total_travel_mm
    first = dual_coded(instance, rules, rng=np.random.default_rng(0), time_limit=0.0, parameters=travel_alone)
    assert evaluate(instance, first).total_travel_mm >= values[0]
    assert not check(instance, rules, first)


def test_ctrl_c_gives_the_best_plan_so_far():
    instance = generate("dense-plate", holes=6, seed=2)

    def interrupt(progress: Progress) -> None:
        raise KeyboardInterrupt

    plan = dual_coded(instance, Rules("travel"), rng=np.random.default_rng(0), watch=interrupt)
    assert not check(instance, Rules("travel"), plan)


def dot(name, geometry=True):
    curve = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]) if geometry else None
    return Contour(name, np.zeros((1, 3)), 3.0, geometry=curve)


STEEL = generate("plate", holes=1, seed=0).material


def test_what_it_does_not_take_is_refused_and_left_out_of_tables():
    head, other = Head("h", np.zeros(3)), Head("k", np.ones(3))
    matrix = np.ones((2, 2))
    cases = [
        (Instance("x", (dot("a"),), (head, other), material=STEEL), Rules(), "one head, got 2"),
        (Instance("x", (dot("a"),), (head,)), Rules(), "material: missing"),
        (Instance("x", (dot("a", False),), (head,), material=STEEL), Rules(), "no geometry"),
        (
            Instance("x", (dot("a"),), (head,), Machine(metric="matrix"), matrix=matrix, material=STEEL),
            Rules(),
            "has a matrix",
        ),
        (Instance("x", (dot("a"),), (head,), material=STEEL), Rules(via_points=True), "via points"),
        (Instance("x", (dot("a"),), (head,), material=STEEL), Rules(parts_in_one_go=True), "parts in one go"),
        (Instance("x", (dot("a"),), (head,), material=STEEL), Rules(neighbours_only=True), "neighbours only"),
    ]
    for instance, rules, message in cases:
        for name in NAMES:
            with pytest.raises(ValueError, match=message):
                HEURISTICS[name](instance, rules, rng=np.random.default_rng(0))
            assert not HEURISTICS[name].applies(instance, rules)
    assert HEURISTICS[NAMES[0]].applies(Instance("x", (dot("a"),), (head,), material=STEEL), Rules("peak"))


@pytest.mark.parametrize("contours", [0, 1])
def test_next_to_nothing_to_cut(contours):
    instance = Instance("x", (dot("a"),)[:contours], (Head("h"),), material=STEEL)
    for name in NAMES:
        plan = HEURISTICS[name](instance, Rules(), rng=np.random.default_rng(0))
        assert [len(tour) for tour in plan.tours] == [contours]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mu": 0.0}, "mu: expected a number above 0"),
        ({"population": 1}, "population: expected a whole number of at least 2"),
        ({"generations": 0}, "generations"),
        ({"tries": True}, "tries"),
        ({"crossover_probability": 1.5}, "crossover_probability: expected at most 1"),
        ({"mutation_probability": -0.1}, "mutation_probability"),
        ({"penalty": 0.0}, "penalty"),
        ({"start_shape": -1.0}, "start_shape"),
        ({"k_2": 0.05}, "k_2: expected k_2 c_2"),
        ({"c_1": 20.0}, r"c_1: c_1\^300 is no finite number, got 20"),
        ({"generations": 100_000, "c_2": 1.0, "c_1": 1.1}, "c_1"),
        ({"generations": 400}, r"k_2: .* take c_2 = 1\.00751 at most"),
    ],
)
def test_bad_parameters_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        DualCodedParameters(**change)
