"""The main job: table, files and report of a suite."""

import csv
import json
import re
from html.parser import HTMLParser

import pytest

from cutgap.benchmark import runner
from cutgap.benchmark.records import read_records
from cutgap.views.cli import main

VOID = {"meta", "br", "link", "img", "input", "hr"}


class Page(HTMLParser):
    """Collects tags and text, and refuses tags that do not close."""

    def __init__(self):
        super().__init__()
        self.open, self.tags, self.ids, self.texts = [], [], [], []

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self.ids += [value for name, value in attrs if name == "id"]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)


def page(path):
    parsed = Page()
    parsed.feed(path.read_text(encoding="utf-8"))
    assert parsed.open == []
    return parsed


def test_the_main_job(parts, tmp_path, capsys):
    out = tmp_path / "results"
    assert main(["gaps", str(parts), "--seeds", "2", "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    rows = list(csv.DictReader((out / "table.csv").open()))
    methods = ("split", "task-balancing", "k-means", "fuzzy-c-means", "local-search")
    assert [row["method"] for row in rows] == [*methods] * 3
    for row in rows:
        assert row["part"] in printed
        exact = row["method"] == "split"
        assert row["runs"] == ("1" if exact else "2")
        assert row["proven_optimum"] == "yes"
        if exact:
            assert float(row["gap_percent"]) == 0.0
        if row["gap_percent"]:
            value, bound = float(row["value"]), float(row["lower_bound"])
            assert float(row["gap_percent"]) == pytest.approx(100 * (value - bound) / value, abs=1e-5)
        else:
            assert row["note"]
    records, damages = read_records(out / "results.jsonl")
    assert not damages
    assert len(records) == 3 * (1 + 2 * (len(methods) - 1))


def test_the_report_is_complete_and_needs_no_network(parts, tmp_path):
    out = tmp_path / "results"
    main(["gaps", str(parts), "--seeds", "2", "--out", str(out), "--methods", "split,k-means,local-search"])
    text = (out / "report.html").read_text(encoding="utf-8")
    assert not re.search(r"https?:|//\w|@import|url\((?!#)", text)
    assert str(tmp_path) not in text
    parsed = page(out / "report.html")
    assert len(parsed.ids) == len(set(parsed.ids))
    assert not {"iframe", "img"} & {tag for tag, _ in parsed.tags}
    assert not [attrs for _, attrs in parsed.tags if "src" in attrs]
    labels = [attrs["aria-label"] for tag, attrs in parsed.tags if tag == "svg" and "aria-hidden" not in attrs]
    assert len(labels) == 1 + 3 * 3
    words = " ".join(parsed.texts)
    for word in ("3 of 3", "proven optimum", "local-search", "highspy", "Partition gap", "Seeds", "makespan"):
        assert word in words
    for record in read_records(out / "results.jsonl")[0]:
        assert record.instance_hash in words


def test_names_cannot_break_the_report(parts, tmp_path):
    path = parts / "part-5.json"
    document = json.loads(path.read_text())
    document["name"] = '<script>alert("&")</script>'
    path.write_text(json.dumps(document))
    out = tmp_path / "results"
    tokens = ["--out", str(out), "--methods", "split,k-means", "--seeds", "1"]
    assert main(["gaps", str(path), *tokens]) == 0
    assert [tag for tag, _ in page(out / "report.html").tags].count("script") == 1  # the page's own


def test_json_is_the_table(parts, tmp_path, capsys):
    assert main(["gaps", str(parts), "--methods", "split", "--out", str(tmp_path / "r"), "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["method"] for row in rows] == ["split"] * 3
    assert all(row["value"] >= row["lower_bound"] - 1e-6 for row in rows)


def test_resume_runs_nothing_twice_and_a_new_run_keeps_the_old(parts, tmp_path, capsys, monkeypatch):
    out = tmp_path / "results"
    tokens = ["gaps", str(parts), "--methods", "split,task-balancing", "--seeds", "1", "--out", str(out)]
    assert main(tokens) == 0
    old = (out / "results.jsonl").read_bytes()
    monkeypatch.setattr(runner, "run", None)
    assert main([*tokens, "--resume"]) == 0
    assert "6 of 6 runs are finished already" in capsys.readouterr().err
    assert (out / "results.jsonl").read_bytes() == old
    monkeypatch.undo()
    assert main(tokens) == 0
    assert (out / "earlier-1" / "results.jsonl").read_bytes() == old
    assert "earlier-1" in capsys.readouterr().err


def test_a_damaged_line_is_reported_and_run_again(parts, tmp_path, capsys):
    out = tmp_path / "results"
    tokens = ["gaps", str(parts), "--methods", "split,task-balancing", "--seeds", "1", "--out", str(out)]
    main(tokens)
    path = out / "results.jsonl"
    text = path.read_text()
    path.write_text(text[:-20])
    capsys.readouterr()
    assert main([*tokens, "--resume"]) == 0
    error = capsys.readouterr().err
    assert "line 6: torn or not JSON" in error
    assert "5 of 6 runs are finished already" in error
    records, damages = read_records(path)
    assert (len(records), len(damages)) == (6, 1)


def test_a_failing_run_is_exit_code_1_and_said(parts, tmp_path, capsys, monkeypatch):
    original = runner.run

    def run(method, instance, rules, **options):
        if method == "k-means":
            raise ZeroDivisionError("for the test")
        return original(method, instance, rules, **options)

    monkeypatch.setattr(runner, "run", run)
    out = tmp_path / "results"
    tokens = ["gaps", str(parts), "--methods", "split,k-means", "--seeds", "1", "--out", str(out)]
    assert main(tokens) == 1
    assert "k-means" in capsys.readouterr().err
    assert "for the test" in (out / "report.html").read_text()
    assert len(read_records(out / "results.jsonl")[0]) == 3


@pytest.mark.parametrize(
    ("tokens", "words"),
    [
        (["nowhere"], ("'nowhere'", "table1")),
        (["small", "--methods", "magic"], ("'magic'", "split")),
        (["small", "--methods", "split,split"], ("'split'", "more than once")),
        (["small", "--seeds", "0"], ("seeds", "0")),
        (["small", "--jobs", "0"], ("--jobs", "0")),
        (["small", "--jobs", "2", "--dask", "tcp://127.0.0.1:1"], ("--jobs", "--dask")),
        (["small", "--time-limit", "-1"], ("--time-limit", "-1")),
        (["small", "--v-jump", "-1"], ("--v-jump", "-1")),
        (["small", "--weight", "2"], ("weight", "makespan")),
    ],
)
def test_bad_input_is_exit_code_2_and_writes_nothing(tokens, words, tmp_path, capsys):
    out = tmp_path / "results"
    assert main(["gaps", *tokens, "--out", str(out)]) == 2
    error = capsys.readouterr().err
    for word in words:
        assert word in error
    assert not out.exists()


def test_a_broken_instance_in_a_folder_is_named(parts, tmp_path, capsys):
    (parts / "part-6.json").write_text('{"format": "cutgap-instance"')
    assert main(["gaps", str(parts), "--out", str(tmp_path / "r")]) == 2
    assert "part-6.json" in capsys.readouterr().err
