"""The audit of the published table: its data, its statistics by other means, and the command."""

import csv
import json
import re
from dataclasses import replace
from statistics import mean, median, stdev

import numpy as np
import pytest

from cutgap.benchmark import runner
from cutgap.benchmark.audit import (
    EQUAL_WORK,
    MAKESPAN,
    MAKESPAN_RULES,
    TRAVEL,
    audit_rows,
    audit_tasks,
    overall,
)
from cutgap.benchmark.executors import SerialExecutor
from cutgap.benchmark.published import published_sizes, published_table
from cutgap.benchmark.runner import run_tasks
from cutgap.formulations import solve
from cutgap.instances import Machine, Rules, Status
from cutgap.instances.generate import generate
from cutgap.views.cli import main

MISPRINTED = (2, "K-means")


@pytest.fixture(scope="module")
def records():
    tasks = audit_tasks(parts=3, sizes=[45])
    return list(run_tasks(tasks, SerialExecutor()))


def test_the_published_rows_agree_with_themselves():
    table = published_table()
    assert [row.holes for row in table[::3]] == list(published_sizes()) == list(range(45, 91, 5))
    assert len({(row.part, row.method) for row in table}) == len(table) == 30
    for row in table:
        assert row.imbalance_s == pytest.approx(abs(row.time_1_s - row.time_2_s), abs=0.11)
    assert [(row.part, row.method) for row in table if row.partition_gap_mm is None] == [(1, "task balancing")]
    assert all(row.comment for row in table if row.partition_gap_mm is None)
    assert next(row for row in table if (row.part, row.method) == MISPRINTED).comment


def test_all_methods_on_a_part_do_the_same_work_but_for_the_misprint():
    for part in range(1, 11):
        works = {row.method: row.work_s(Machine().v_jump) for row in published_table() if row.part == part}
        middle = median(works.values())
        away = {(part, method) for method, work in works.items() if abs(work - middle) > 0.5}
        assert away == ({MISPRINTED} if part == MISPRINTED[0] else set())


def test_statistics_by_other_means(records):
    rows = audit_rows(records)
    assert {row.figure for row in rows} == {MAKESPAN, EQUAL_WORK, TRAVEL}
    for rules in MAKESPAN_RULES:
        optima = [solve(generate("random", holes=45, seed=seed), rules) for seed in range(3)]
        evaluations = [each.evaluation for each in optima]
        expected = {
            MAKESPAN: [each.makespan_s for each in evaluations],
            TRAVEL: [sum(each.travel_mm) for each in evaluations],
        }
        for row in (row for row in rows if row.rules == rules and row.figure in expected):
            values = expected[row.figure]
            source = next(p for p in published_table() if p.holes == 45 and p.method == row.method)
            times = max(source.time_1_s, source.time_2_s)
            assert row.published == (source.travel_mm if row.figure == TRAVEL else times)
            assert (row.mean, row.deviation) == pytest.approx((mean(values), stdev(values)))
            assert (row.p05, row.p50, row.p95) == pytest.approx(tuple(np.quantile(values, (0.05, 0.5, 0.95))))
            assert row.rank_percent == pytest.approx(100 * sum(v < row.published for v in values) / 3)
            assert row.gap == pytest.approx(1 - mean(values) / row.published)
            assert row.gap_error == pytest.approx(stdev(values) * (4 / 3) ** 0.5 / row.published)
            assert (row.parts, row.unproved) == (3, 0)


def test_equal_work_moves_each_optimum_by_half_the_difference_of_work(records):
    source = [row for row in published_table() if row.holes == 45]
    published_work = median(row.time_1_s + row.time_2_s - row.travel_mm / 150 for row in source)
    for rules in MAKESPAN_RULES:
        moved = []
        for record in (each for each in records if each.result.rules == rules):
            part = generate("random", holes=45, seed=int(record.instance.rpartition("s")[2]))
            work = sum(hole.perimeter / 40 + 1 for hole in part.contours)
            moved.append(record.result.value + (published_work - work) / 2)
        row = next(r for r in audit_rows(records) if r.rules == rules and r.figure == EQUAL_WORK)
        assert row.mean == pytest.approx(mean(moved))
        raw = next(r for r in audit_rows(records) if r.rules == rules and r.figure == MAKESPAN)
        assert row.deviation < raw.deviation


def test_overall_is_the_mean_over_sizes(records):
    rows = audit_rows(records)
    doubled = [*rows, *(replace(row, holes=50, gap=row.gap + 0.02) for row in rows)]
    for one, two in zip(overall(rows), overall(doubled), strict=True):
        assert two.sizes == 2
        assert two.gap == pytest.approx(one.gap + 0.01)
        assert two.gap_error == pytest.approx(one.gap_error / 2**0.5)


def test_runs_without_a_proof_are_counted_and_left_out(records):
    stopped = replace(records[0], result=replace(records[0].result, status=Status.FEASIBLE))
    rows = audit_rows([stopped, *records[1:]])
    assert {(row.parts, row.unproved) for row in rows if row.rules == stopped.result.rules} == {(2, 1)}


def test_travel_adds_the_least_travel_which_no_other_plan_beats(records):
    tasks = [t for t in audit_tasks(parts=1, sizes=[45], travel=True) if t.rules == Rules("travel")]
    (record,) = run_tasks(tasks, SerialExecutor())
    same = [each for each in records if each.instance == record.instance and not each.result.rules.via_points]
    assert same
    for each in same:
        assert each.result.evaluation.total_travel_mm >= record.result.value - 1e-6
    assert {row.figure for row in audit_rows([record])} == {TRAVEL}


def test_the_command(tmp_path, capsys, monkeypatch):
    out = tmp_path / "audit"
    tokens = ["gaps", "paper-audit", "--parts", "1", "--sizes", "45,50", "--out", str(out)]
    assert main(tokens) == 0
    printed = capsys.readouterr().out
    for words in (
        "task balancing",
        "implied gap",
        "coordinates are missing",
        "leftmost contour first",
        "misprint",
    ):
        assert words in printed
    rows = list(csv.DictReader((out / "audit.csv").open()))
    assert len(rows) == 2 * 3 * 2 * 3
    assert {row["deviation"] for row in rows} == {""}
    text = (out / "audit.html").read_text(encoding="utf-8")
    assert text.count("<svg") == 2 * 3
    assert not re.search(r"https?:|//\w|@import|url\((?!#)|\$[a-z]", text)
    monkeypatch.setattr(runner, "run", None)
    assert main([*tokens, "--resume", "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert [f"{row['published']}" for row in shown] == [row["published"] for row in rows]


def test_a_new_run_sets_the_old_one_aside(tmp_path):
    out = tmp_path / "audit"
    tokens = ["gaps", "paper-audit", "--parts", "1", "--sizes", "45", "--out", str(out)]
    assert main(tokens) == 0
    old = {name: (out / name).read_bytes() for name in ("results.jsonl", "audit.csv", "audit.html")}
    assert main(tokens) == 0
    assert {name: (out / "earlier-1" / name).read_bytes() for name in old} == old


@pytest.mark.parametrize(
    ("tokens", "words"),
    [
        (["--parts", "0"], ("parts", "0")),
        (["--sizes", "47"], ("sizes", "47", "45, 50")),
        (["--sizes", "45,45"], ("sizes", "45", "more than once")),
        (["--sizes", "many"], ("--sizes", "'many'")),
        (["--jobs", "0"], ("--jobs", "0")),
        (["--time-limit", "0"], ("--time-limit", "0")),
    ],
)
def test_bad_input_is_exit_code_2_and_writes_nothing(tokens, words, tmp_path, capsys):
    out = tmp_path / "audit"
    assert main(["gaps", "paper-audit", *tokens, "--out", str(out)]) == 2
    error = capsys.readouterr().err
    for word in words:
        assert word in error
    assert not out.exists()
