"""Results on disk: nothing finished is lost, nothing torn or forged is believed, nothing unchecked is taken."""

import json
from dataclasses import replace

import numpy as np
import pytest
from oracles.random_instances import random_instance

from cutgap.benchmark.folder import open_folder
from cutgap.benchmark.records import Record, append_record, finished, make_record, read_records
from cutgap.benchmark.tasks import Task
from cutgap.instances import Plan, Rules, conclude


def plan_of(task, rng):
    holes = sorted(range(len(task.instance.contours)), key=lambda hole: task.instance.points[hole, 0])
    cut = int(rng.integers(1, len(holes)))
    return Plan.of_contours([holes[:cut], holes[cut:]])


def records(count, *, rules=None):
    rng = np.random.default_rng(count)
    made = []
    for seed in range(count):
        task = Task(random_instance(rng, 6, layout="uniform"), rules or Rules(), "k-means", seed)
        seconds = float(rng.uniform(0, 9))
        result = conclude(
            task.instance, task.rules, plan_of(task, rng), method=task.method, seconds=seconds, seed=seed
        )
        made.append(make_record(task, result))
    return made


def test_what_is_appended_is_read_back_exactly(tmp_path):
    path = tmp_path / "deep" / "results.jsonl"
    made = records(5, rules=Rules("weighted", weight=12.5, balance=1e-3, via_points=True))
    assert any(record.result.violations for record in made)
    for record in made:
        append_record(path, record)
    assert read_records(path) == (made, [])


def test_no_file_holds_no_records(tmp_path):
    assert read_records(tmp_path / "none.jsonl") == ([], [])


@pytest.mark.parametrize("kept", [1, 40, 0.5, -2, -1])
def test_a_torn_last_line_costs_only_itself(tmp_path, kept):
    path = tmp_path / "results.jsonl"
    first, second, third = records(3)
    for record in (first, second):
        append_record(path, record)
    start = path.read_bytes().index(b"\n") + 1
    whole = path.read_bytes()
    line = whole[start:]
    torn = line[: int(len(line) * kept)] if isinstance(kept, float) else line[:kept]
    path.write_bytes(whole[:start] + torn)
    before = path.read_bytes()
    found, damages = read_records(path)
    # Without its line break alone, a record is whole.
    assert found == ([first, second] if kept == -1 else [first])
    assert [damage.line for damage in damages] == ([] if kept == -1 else [2])
    append_record(path, third)
    found, damages = read_records(path)
    assert found[0] == first
    assert found[-1] == third
    assert len(damages) == (kept != -1)
    assert path.read_bytes().startswith(before)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda content: content["result"].update(value=1.0), "checksum"),
        (lambda content: content.pop("checksum"), "no checksum"),
        (lambda content: content.update(seed=content["seed"] + 1), "checksum"),
    ],
)
def test_a_changed_line_is_not_believed(tmp_path, change, reason):
    path = tmp_path / "results.jsonl"
    kept, changed = records(2)
    append_record(path, changed)
    content = json.loads(path.read_text())
    change(content)
    path.write_text(json.dumps(content) + "\n")
    append_record(path, kept)
    found, damages = read_records(path)
    assert found == [kept]
    assert [damage.line for damage in damages] == [1]
    assert reason in damages[0].reason


@pytest.mark.parametrize("line", [b"[]", b"null", b"{", b"\xff\xfe", b'{"checksum": 1e999}', b"[" * 100000])
def test_lines_of_any_kind_are_reported_not_raised(tmp_path, line):
    path = tmp_path / "results.jsonl"
    path.write_bytes(line + b"\n")
    (record,) = records(1)
    append_record(path, record)
    found, damages = read_records(path)
    assert found == [record]
    assert [damage.line for damage in damages] == [1]


def test_of_equal_keys_the_last_record_counts():
    (record,) = records(1)
    later = replace(record, result=replace(record.result, seconds=record.result.seconds + 1))
    assert finished([record, later]) == {record.key: later}


def test_a_plan_that_was_not_checked_is_refused():
    (record,) = records(1)
    with pytest.raises(ValueError, match="not checked"):
        replace(record, result=replace(record.result, evaluation=None))


def test_figures_that_are_not_those_of_the_plan_are_refused():
    rng = np.random.default_rng(8)
    task = Task(random_instance(rng, 6, layout="uniform"), Rules(), "k-means", 0)
    true = conclude(task.instance, task.rules, plan_of(task, rng), method="k-means", seconds=1.0, seed=0)
    overlapping = Plan.of_contours([tuple(range(0, 6, 2)), tuple(range(1, 6, 2))])
    hidden = conclude(task.instance, task.rules, overlapping, method="k-means", seconds=1.0, seed=0)
    assert hidden.violations
    assert isinstance(make_record(task, true), Record)
    for forged in (
        replace(hidden, violations=()),
        replace(true, plan=hidden.plan),
        replace(true, evaluation=hidden.evaluation),
    ):
        with pytest.raises(ValueError, match="not checked"):
            make_record(task, forged)


def test_a_new_run_moves_old_results_aside(tmp_path):
    made = records(3)
    for record in made:
        folder = open_folder(tmp_path, resume=False)
        (tmp_path / "report.html").write_text("report")
        folder.append(record)
    assert read_records(tmp_path / "results.jsonl") == ([made[2]], [])
    for number in (1, 2):
        earlier = tmp_path / f"earlier-{number}"
        assert read_records(earlier / "results.jsonl") == ([made[number - 1]], [])
        assert (earlier / "report.html").read_text() == "report"


def test_resume_goes_on_from_what_is_there(tmp_path):
    first, second = records(2)
    open_folder(tmp_path, resume=True).append(first)
    folder = open_folder(tmp_path, resume=True)
    folder.append(second)
    assert folder.set_aside is None
    assert folder.among([second.key, "unknown", first.key]) == [second, first]
