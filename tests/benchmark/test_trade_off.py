"""Plates: what is asked of them, and both figures of each plan against bounds worked out from the records."""

from dataclasses import replace

import numpy as np
import pytest

from cutgap.benchmark.methods import run
from cutgap.benchmark.plate_caps import PLATE_RULES, PLATE_SUITES, cap_row, halfway_caps
from cutgap.benchmark.records import make_record
from cutgap.benchmark.table import gap_table, summarise
from cutgap.benchmark.tasks import Task, find_suite, suite_tasks
from cutgap.benchmark.trade_off import ContradictionError, gap_to
from cutgap.benchmark.wording import describe_all
from cutgap.formulations.heat.front import heat_front
from cutgap.instances import Plan, conclude
from cutgap.instances.formats import MachineOptions
from cutgap.instances.generate import generate
from cutgap.instances.suites import load_suite
from cutgap.views.columns import columns

PEAK = replace(PLATE_RULES, objective="peak")


@pytest.fixture(scope="module")
def plate():
    return generate("dense-plate", holes=5, seed=2)


def task_record(plate, rules, method, seed=0):
    return make_record(Task(plate, rules, method, seed), run(method, plate, rules, seed=seed))


@pytest.fixture(scope="module")
def records(plate):
    cap = replace(PLATE_RULES, temperature_cap=45.0)
    return [
        task_record(plate, PLATE_RULES, "contour-dp"),
        *(task_record(plate, PLATE_RULES, "plain-ga", seed) for seed in range(3)),
        task_record(plate, PEAK, "heat"),
        task_record(plate, cap, "heat"),
        task_record(plate, cap, "plain-ga"),
    ]


def figures(record):
    return record.result.evaluation.total_travel_mm, record.result.evaluation.peak_temperature_c


def test_each_plan_is_compared_with_a_bound_on_each_figure(plate, records):
    rows = gap_table(records)
    assert [row.method for row in rows] == ["contour-dp", "plain-ga", "heat", "heat", "plain-ga"]
    travel, peak = records[0].result.lower_bound, records[4].result.lower_bound
    ambient = plate.material.ambient_c
    assert all(row.peak.lower_bound == peak for row in rows)
    assert [row.travel.lower_bound for row in rows[:3]] == [travel] * 3
    capped = max(travel, records[5].result.lower_bound)
    assert [row.travel.lower_bound for row in rows[3:]] == [capped] * 2
    drawn = [figures(each) for each in records[1:4]]
    shown = min(drawn, key=lambda pair: pair[0])
    assert rows[1].travel.gap == pytest.approx((shown[0] - travel) / shown[0], abs=1e-8)
    assert rows[1].peak.gap == pytest.approx((shown[1] - peak) / (shown[1] - ambient))
    assert rows[1].peak.mean_gap == pytest.approx(np.mean([(hot - peak) / (hot - ambient) for _, hot in drawn]))
    assert rows[0].travel.gap == rows[2].peak.gap == 0.0
    assert rows[0].travel.proved
    assert rows[2].peak.proved


def test_a_shorter_plan_above_the_cap_does_not_prove_the_least_travel_under_it(plate, records):
    shortest, coolest = records[0], records[4]
    cap = (figures(shortest)[1] + figures(coolest)[1]) / 2
    assert figures(shortest)[1] > cap
    rules = replace(PLATE_RULES, temperature_cap=cap)
    plan = coolest.result.plan
    longest = conclude(plate, rules, plan, method="heat", seconds=0.0)
    between = (figures(shortest)[0] + longest.value) / 2
    assert figures(shortest)[0] < between < longest.value
    open_run = make_record(Task(plate, rules, "heat", 0), replace(longest, lower_bound=between))
    row = gap_table([shortest, coolest, open_run])[2]
    assert (row.travel.lower_bound, row.travel.proved) == (between, False)
    assert row.peak.proved


def test_the_summary_keeps_questions_apart(records):
    found = {(each.question, each.method): each for each in summarise(gap_table(records))}
    assert set(found) == {
        ("travel", "contour-dp"),
        ("travel", "plain-ga"),
        ("peak", "heat"),
        ("travel under cap", "heat"),
        ("travel under cap", "plain-ga"),
    }
    assert found["travel", "plain-ga"].travel_gap == pytest.approx(np.mean(found["travel", "plain-ga"].gaps))


def test_columns_of_both_figures_stand_where_temperatures_are_asked_for_alone(records):
    assert "rise gap [%]" in [column.heading for column in columns(gap_table(records))]
    headings = [column.heading for column in columns(gap_table(records[:4]))]
    assert "rise gap [%]" not in headings
    assert "makespan [s]" in headings


def test_a_plan_cooler_than_the_least_peak_is_a_contradiction(plate, records):
    hot = Plan.of_contours([range(5)])
    result = conclude(plate, PEAK, hot, method="heat", seconds=0.0)
    cool = min(figures(each)[1] for each in records[:4])
    assert result.value > cool
    false = make_record(Task(plate, PEAK, "heat", 0), replace(result, lower_bound=result.value))
    with pytest.raises(ContradictionError, match=r"peak .* is below the proved bound"):
        gap_table([*records[:4], false])


def test_gaps_at_the_ends():
    assert gap_to(25.0, 25.0, 20.0) == 0.0
    assert gap_to(30.0, 25.0, 20.0) == 0.5
    assert gap_to(np.inf, 25.0, 20.0) == 1.0


def test_plates_are_asked_for_travel_peak_and_travel_half_way():
    for name in PLATE_SUITES:
        suite, caps = find_suite(name, MachineOptions()), halfway_caps(name)
        assert set(caps) == (set() if name == "plate30" else {each.name for each in suite.instances})
        for instance, rules in suite.problems(suite.rules, lambda rules: rules):
            if rules.temperature_cap is not None:
                assert rules == replace(PLATE_RULES, temperature_cap=caps[instance.name])
        plate = suite.instances[0]
        asked = [rules for each, rules in suite.problems(suite.rules, lambda rules: rules) if each is plate]
        assert asked[:2] == [PLATE_RULES, PEAK]
        assert [rules for each, rules in suite.problems(suite.rules) if each is plate] == [PLATE_RULES]
    assert "cap of 23.4 to 49.8 deg C" in describe_all(
        rules for _, rules in find_suite("small-plates", MachineOptions()).problems(PLATE_RULES, lambda r: r)
    )


def test_heuristics_run_once_for_equal_constraints(plate):
    problems = [(plate, PLATE_RULES), (plate, PEAK), (plate, replace(PLATE_RULES, temperature_cap=40.0))]
    tasks = suite_tasks(problems, None, seeds=1)
    found = [(task.rules.objective, task.rules.temperature_cap, task.method) for task in tasks]
    assert ("travel", None, "plain-ga") in found
    assert [method for objective, _, method in found if objective == "peak"] == ["auto"]
    capped = [method for _, cap, method in found if cap is not None]
    assert "dual-coded-ga" in capped
    assert "entry-search" not in capped
    named = suite_tasks(problems, ("contour-dp", "heat"), seeds=1)
    assert [task.method for task in named] == ["contour-dp", "heat", "heat", "heat"]


@pytest.mark.parametrize("number", [0, 2])
def test_caps_are_half_way_between_the_ends_of_the_exact_front(number):
    plate = load_suite("small-plates")[number]
    front = heat_front(plate, PLATE_RULES)
    hot, cool = (front[end].evaluation.peak_temperature_c for end in (0, -1))
    assert halfway_caps("small-plates")[plate.name] == pytest.approx((hot + cool) / 2, abs=0.06)
    row = cap_row("small-plates", plate)
    assert row["cap_c"] == halfway_caps("small-plates")[plate.name]
