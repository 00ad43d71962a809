"""Suites of published files: their rules, what is published about them, and the methods that they get."""

import csv
import json

import numpy as np
import pytest
from formats.test_gtsp import BURMA_OPTIMUM, BURMA_SETS, document
from formats.test_tsplib import BURMA14
from oracles.random_instances import random_instance

from cutgap.benchmark import methods
from cutgap.benchmark.best_known import best_known, published_runs
from cutgap.benchmark.methods import AUTO, default_methods, excerpt
from cutgap.benchmark.tasks import FILE_SUITES, SUITE_RULES, find_suite, suite_tasks
from cutgap.heuristics import HEURISTICS, Heuristic
from cutgap.instances import Head, Plan, Rules, Visit
from cutgap.instances.formats import MachineOptions
from cutgap.views.cli import main
from cutgap.views.options import RuleOptions

BURMA = document("GTSP", 14, BURMA_SETS, points=BURMA14, metric="GEO")
NEST = document("PCGLNS", 4, [[1], [2, 3], [4]], matrix=np.full((4, 4), 7), ordering=[(3, 2)], start=1)
PATHS = document("PCGTSP", 4, [[1], [2, 3], [4]], points=[(0, 0), (1, 0), (2, 0), (0, 3)], ordering=[(3, 2)])
FILES = {"3burma14.gtsp": BURMA, "nest.pcglns": NEST, "paths.txt": PATHS, "readme.md": "no instance"}


def in_order(instance, rules, *, rng, watch=None, time_limit=None) -> Plan:
    """Cut the contours with one head, each as soon as those before it are done, at a random entry point."""
    waiting, tour = list(range(len(instance.contours))), []
    while waiting:
        free = [c for c in waiting if all(a not in waiting for a, b in instance.precedence if b == c)]
        waiting.remove(free[0])
        tour.append(Visit(free[0], int(rng.integers(len(instance.contours[free[0]].entry_points)))))
    return Plan((tuple(tour),))


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "public"
    place.mkdir()
    for name, text in FILES.items():
        (place / name).write_text(text)
    return place


@pytest.fixture
def one_head(monkeypatch):
    """Let a heuristic for one head be known."""
    monkeypatch.setitem(
        HEURISTICS, "in-order", Heuristic(in_order, lambda instance, rules: len(instance.heads) == 1)
    )


@pytest.mark.parametrize(
    ("kind", "instance"), [("gtsp", "3burma14"), ("pcgtsp", "nest"), ("cutting-paths", "paths")]
)
def test_a_suite_takes_the_files_of_its_kind_and_asks_for_travel(folder, kind, instance):
    suite = find_suite(f"{kind}:{folder}", MachineOptions())
    assert [each.name for each in suite.instances] == [instance]
    assert suite.rules == Rules("travel")
    assert suite.name == f"{kind}-public"
    single = find_suite(f"{kind}:{folder / (instance + FILE_SUITES[kind])}", MachineOptions())
    assert (single.name, single.rules) == (f"{kind}-{instance}", suite.rules)
    named = folder.rename(folder.parent / kind)
    assert find_suite(f"{kind}:{named}", MachineOptions()).name == kind


def test_other_suites_ask_for_makespan(folder):
    assert find_suite("small", MachineOptions()).rules == Rules()
    assert find_suite("flame108", MachineOptions()).rules == Rules("travel", links=True, pierces=1)
    for plates in ("plate30", "plate30-dense", "small-plates"):
        assert find_suite(plates, MachineOptions()).rules == Rules("travel", clear_rapids=True)
    assert find_suite(str(folder), MachineOptions()).rules == Rules()
    assert find_suite(str(folder), MachineOptions()).published == {}


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("gtsp:nowhere", r"suite: expected one of table1, .*gtsp:PATH, .*got 'gtsp:nowhere'"),
        ("tsp:public", r"suite: expected one of .*got 'tsp:public'"),
        ("gtsp:public/paths.txt", r"suite 'gtsp:public/paths.txt': expected a file that ends in \.gtsp"),
        ("pcgtsp:public/deeper", r"suite 'pcgtsp:public/deeper': the folder holds no \.pcglns file"),
    ],
)
def test_what_is_no_suite_is_refused(folder, monkeypatch, name, message):
    monkeypatch.chdir(folder.parent)
    (folder / "deeper").mkdir()
    with pytest.raises(ValueError, match=message):
        find_suite(name, MachineOptions())


def test_published_runs_are_known_by_name_and_size(folder):
    suite = find_suite(f"gtsp:{folder}", MachineOptions())
    assert suite.published["3burma14"].value == BURMA_OPTIMUM
    assert suite.published["3burma14"].lower_bound is None
    assert best_known("pcgtsp", suite.instances) == {}
    smaller = document("GTSP", 13, [BURMA_SETS[0], BURMA_SETS[1], BURMA_SETS[2][:-1]], points=BURMA14[:13])
    (folder / "3burma14.gtsp").write_text(smaller)
    assert find_suite(f"gtsp:{folder}", MachineOptions()).published == {}


def test_other_homes_make_another_problem(folder):
    (folder / "3burma14.gtsp").write_text(BURMA)
    assert find_suite(f"gtsp:{folder}", MachineOptions(homes=((1, 2),))).published == {}
    assert find_suite(f"gtsp:{folder}", MachineOptions(v_jump=9.0)).published != {}


def test_the_published_table_agrees_with_itself():
    runs = published_runs()
    assert {run.suite for run in runs} <= set(SUITE_RULES)
    assert len({(run.instance, run.method) for run in runs}) == len(runs)
    for run in runs:
        assert run.lower_bound is None or 0 < run.lower_bound <= run.value
        assert run.sets < run.nodes
    for instance in {run.instance for run in runs}:
        group = [run for run in runs if run.instance == instance]
        assert len({(run.sets, run.nodes) for run in group}) == 1
        bounds = [run.lower_bound for run in group if run.lower_bound is not None]
        assert max(bounds, default=0) <= min(run.value for run in group)


def test_options_replace_what_the_suite_asks_for():
    base = Rules("travel", clear_rapids=True, neighbours_only=True, backward_price=0.5, non_overlap=None)
    assert RuleOptions().rules(base) == base
    assert RuleOptions().rules() == Rules()
    given = RuleOptions(clear_rapids=False, backward_price=0.0, objective="makespan", non_overlap=3.0)
    assert given.rules(base) == Rules(neighbours_only=True, non_overlap=3.0)
    assert RuleOptions(overlap=True, via_points=True).rules() == Rules(non_overlap=None, via_points=True)


@pytest.mark.parametrize(
    ("options", "asked"),
    [
        ([], Rules("travel", parts_in_one_go=True)),
        (["--no-parts-in-one-go"], Rules("travel")),
        (["--objective", "makespan", "--empty-heads"], Rules(parts_in_one_go=True, empty_heads=True)),
    ],
)
def test_the_command_line_calls_off_rules_of_a_suite(folder, tmp_path, monkeypatch, one_head, options, asked):
    monkeypatch.setitem(SUITE_RULES, "gtsp", Rules("travel", parts_in_one_go=True))
    out = tmp_path / "results"
    tokens = ["--methods", "in-order", "--seeds", "1", "--out", str(out), *options]
    assert main(["gaps", f"gtsp:{folder}", *tokens]) == 0
    line = json.loads((out / "results.jsonl").read_text())
    found = {name: line["result"]["rules"][name] for name in ("objective", "parts_in_one_go", "empty_heads")}
    assert found == {name: getattr(asked, name) for name in found}


def test_published_values_stand_in_table_csv_and_report(folder, tmp_path, capsys, one_head):
    out = tmp_path / "results"
    tokens = ["gaps", f"gtsp:{folder}", "--methods", "in-order", "--out", str(out)]
    assert main([*tokens, "--seeds", "2"]) == 0
    assert "published" in capsys.readouterr().out
    row = next(csv.DictReader((out / "table.csv").open()))
    assert float(row["published_value"]) == BURMA_OPTIMUM
    assert row["published_bound"] == ""
    assert float(row["value"]) >= BURMA_OPTIMUM
    report = (out / "report.html").read_text(encoding="utf-8")
    assert f"<td>{BURMA_OPTIMUM}</td>" in report
    assert "best known (GTSPLIB)" in report
    # Under other rules nothing is published.
    assert main([*tokens, "--objective", "makespan"]) == 0
    assert "published" not in capsys.readouterr().out
    assert "published_value" not in next(csv.DictReader((out / "table.csv").open()))


def test_each_instance_gets_the_heuristics_that_apply_to_it(folder, one_head):
    suite = find_suite(f"pcgtsp:{folder}", MachineOptions())
    for_one = ["entry-search", "ant-colony", "in-order"]
    assert [task.method for task in suite_tasks(suite.problems(suite.rules), None, seeds=1)] == [AUTO, *for_one]
    assert default_methods(suite.instances, suite.rules) == (AUTO, *for_one)
    two_heads = find_suite("small", MachineOptions()).instances[:1]
    for_two = ["task-balancing", "k-means", "fuzzy-c-means", "local-search"]
    assert default_methods(two_heads, Rules()) == (AUTO, *for_two)
    assert default_methods((*two_heads, *suite.instances), Rules()) == (AUTO, *for_two, *for_one)


@pytest.mark.parametrize("name", ["task-balancing", "k-means", "fuzzy-c-means", "local-search"])
@pytest.mark.parametrize("rules", [Rules(), Rules(non_overlap=None), Rules(parts_in_one_go=True)])
@pytest.mark.parametrize("heads", [1, 2, 3])
def test_a_heuristic_applies_where_it_makes_a_plan(name, rules, heads):
    rng = np.random.default_rng(5)
    instance = random_instance(rng, 6, layout="uniform", heads=2)
    three = (*instance.heads, Head("third", np.array([5000.0, 0, 0])))
    instance = type(instance)(instance.name, instance.contours, three[:heads], instance.machine)
    heuristic = HEURISTICS[name]
    try:
        heuristic(instance, rules, rng=rng)
        makes_a_plan = True
    except ValueError:
        makes_a_plan = False
    assert heuristic.applies(instance, rules) == (makes_a_plan and not rules.process)


def test_an_excerpt_keeps_lengths_precedence_and_homes(folder):
    whole = find_suite(f"pcgtsp:{folder}", MachineOptions()).instances[0]
    assert np.array_equal(excerpt(whole).rapids, whole.rapids)
    assert excerpt(whole).precedence == whole.precedence
    small = excerpt(whole, contours=1, entries=1)
    assert (small.node_count, small.precedence) == (2, ())
    burma = find_suite(f"gtsp:{folder}", MachineOptions()).instances[0]
    nodes = [burma.node(1, 0), burma.node(1, 1), burma.node(2, 0), burma.node(2, 1)]
    assert np.array_equal(excerpt(burma, entries=2).rapids[1:, 1:], burma.rapids[np.ix_(nodes, nodes)])


def test_warm_up_runs_a_method_once_for_a_kind_of_instance(folder, monkeypatch):
    seen = []
    monkeypatch.setattr(methods, "_WARM", set())
    monkeypatch.setattr(methods, "run", lambda method, instance, rules, **_: seen.append((method, instance)))
    burma = find_suite(f"gtsp:{folder}", MachineOptions()).instances[0]
    nest = find_suite(f"pcgtsp:{folder}", MachineOptions()).instances[0]
    for instance in (burma, nest, burma, excerpt(burma)):
        methods.warm_up("in-order", Rules("travel"), instance)
    assert [(method, instance.name) for method, instance in seen] == [
        ("in-order", "3burma14"),
        ("in-order", "nest"),
    ]
    assert all(len(each.entry_points) <= 3 for _, instance in seen for each in instance.contours)
