"""The gap table against figures worked out from the records themselves."""

import csv
import io
from dataclasses import replace
from statistics import fmean

import numpy as np
import pytest
from oracles.random_instances import random_instance

from cutgap.benchmark.records import make_record
from cutgap.benchmark.table import csv_columns, gap_table, summarise, table_csv
from cutgap.benchmark.tasks import Task
from cutgap.benchmark.trade_off import ContradictionError
from cutgap.formulations import solve, verify
from cutgap.instances import Plan, Rules, Status, conclude
from cutgap.instances.formats.json_format import format_instance as document
from cutgap.views.columns import PROOF, bound

HOLES = 6


def record(instance, method, seed, cut, *, share=None, rules=None, mixed=False, infeasible=False):
    """Return a record whose plan cuts after ``cut`` holes; ``share`` is its bound over its value."""
    rules = rules or Rules()
    holes = sorted(range(HOLES), key=lambda hole: instance.points[hole, 0])
    if mixed:
        holes[0], holes[-1] = holes[-1], holes[0]
    plan = None if infeasible else Plan.of_contours([holes[:cut], holes[cut:]])
    parts = {"method": method, "seconds": 1.0 + seed, "seed": seed}
    if infeasible:
        parts |= {"infeasible": True, "reason": "for the test"}
    result = conclude(instance, rules, plan, **parts)
    if share is not None:
        result = conclude(instance, rules, plan, **parts, lower_bound=result.value * share)
    return make_record(Task(instance, rules, method, seed), result)


@pytest.fixture
def instance():
    return random_instance(np.random.default_rng(12), HOLES, layout="uniform")


def test_gaps_are_against_the_best_proved_bound(instance):
    exact = record(instance, "split", 0, 3, share=0.8)
    heuristics = [record(instance, "k-means", seed, cut) for seed, cut in enumerate((1, 2, 4, 5))]
    bound = exact.result.lower_bound
    allowed = [each for each in heuristics if each.result.value >= bound]
    rows = gap_table([exact, *allowed])
    assert [row.method for row in rows] == ["split", "k-means"]
    values = [each.result.value for each in allowed]
    assert rows[0].gap == pytest.approx(0.2)
    assert rows[1].value == min(values)
    assert rows[1].mean_value == pytest.approx(fmean(values))
    assert rows[1].gap == pytest.approx((min(values) - bound) / min(values))
    assert rows[1].mean_gap == pytest.approx(fmean((value - bound) / value for value in values))
    assert rows[1].best.result.value == min(values)
    assert rows[1].seconds == pytest.approx(fmean(each.result.seconds for each in allowed))
    assert not rows[0].proved
    summary = summarise(rows)[1]
    assert (summary.runs, summary.allowed, summary.instances) == (len(allowed), len(allowed), 1)
    assert summary.spread[0] == rows[1].gap


@pytest.mark.parametrize("objective", ["makespan", "travel"])
def test_a_bound_is_certified_only_if_the_certificate_proves_it(instance, objective):
    task = Task(instance, Rules(objective), "split", 0)
    result = solve(instance, task.rules, certify=True)
    # A file name stands for the certificate once it is on disk.
    whole = replace(make_record(task, result), certificate="proof.json")
    assert whole.certified_bound == pytest.approx(float(verify(result.certificate, document(instance)).bound))
    assert [row.certified for row in gap_table([whole])] == [True]
    assert not replace(whole, certificate=None).certified
    less = result.certificate | {"bound": result.certificate["bound"] * 99 // 100}
    weak = replace(make_record(task, replace(result, certificate=less)), certificate="proof.json")
    assert weak.certified_bound == pytest.approx(0.99 * result.lower_bound)
    assert [row.certified for row in gap_table([weak])] == [False]
    row = gap_table([weak])[0]
    assert "claimed" in bound(row)
    assert PROOF.cell(row) == f"claimed, certified ≥ {weak.certified_bound:.6g}"


def test_a_plan_that_meets_the_bound_is_an_optimum(instance):
    exact = record(instance, "split", 0, 3, share=1.0)
    same = record(instance, "k-means", 0, 3)
    rows = gap_table([exact, same])
    assert exact.result.status == Status.OPTIMAL
    assert all(row.proved and row.gap == 0 for row in rows)


def test_a_plan_that_breaks_a_rule_shows_it_and_has_no_gap(instance):
    exact = record(instance, "split", 0, 3, share=0.5)
    broken = record(instance, "k-means", 0, 3, mixed=True)
    assert broken.result.violations
    row = gap_table([exact, broken])[1]
    assert (row.runs, row.allowed, row.gap, row.value) == (1, 0, None, None)
    assert "non-overlap" in row.note
    whole = record(instance, "k-means", 1, 3)
    row = gap_table([exact, broken, whole])[1]
    assert (row.runs, row.allowed, row.note) == (2, 1, "")
    assert row.best == whole


def test_rules_and_instances_are_kept_apart(instance):
    other = random_instance(np.random.default_rng(13), HOLES, layout="uniform")
    exact = record(instance, "split", 0, 3, share=0.9)
    elsewhere = record(replace(other, name=instance.name), "k-means", 0, 3)
    travel = record(instance, "k-means", 0, 3, rules=Rules("travel"))
    rows = gap_table([exact, elsewhere, travel])
    assert len(rows) == 3
    assert [row.lower_bound for row in rows] == [exact.result.lower_bound, None, None]
    assert [row.gap is None for row in rows] == [False, True, True]


def test_a_plan_below_a_bound_is_a_contradiction(instance):
    cuts = [record(instance, "k-means", seed, cut) for seed, cut in enumerate(range(1, HOLES))]
    best = min(cuts, key=lambda each: each.result.value)
    worst = max(cuts, key=lambda each: each.result.value)
    false = record(instance, "split", 0, worst.seed + 1, share=1.0)
    assert best.result.value < false.result.lower_bound
    with pytest.raises(ContradictionError, match="below the proved bound"):
        gap_table([false, best])


def test_a_plan_where_none_should_be_is_a_contradiction(instance):
    nothing = record(instance, "split", 0, 3, infeasible=True)
    assert gap_table([nothing])[0].note == "infeasible: for the test"
    with pytest.raises(ContradictionError, match="no plan exists"):
        gap_table([nothing, record(instance, "k-means", 0, 3)])


def test_csv_holds_the_figures_exactly(instance):
    exact = record(instance, "split", 0, 3, share=0.75)
    broken = record(instance, "k-means", 0, 2, mixed=True)
    rows = gap_table([exact, broken])
    first, second = csv.DictReader(io.StringIO(table_csv(rows)))
    assert list(first) == csv_columns(2)
    evaluation = exact.result.evaluation
    assert float(first["travel_mm"]) == evaluation.total_travel_mm
    assert [float(first["time_1_s"]), float(first["time_2_s"])] == list(evaluation.time_s)
    assert float(first["lower_bound"]) == exact.result.lower_bound
    assert float(first["gap_percent"]) == pytest.approx(25.0)
    assert (first["proven_optimum"], second["gap_percent"], second["value"]) == ("no", "", "")
    assert "non-overlap" in second["note"]


def test_a_table_of_nothing_has_only_its_header():
    assert table_csv([]) == ",".join(csv_columns(2)) + "\n"
