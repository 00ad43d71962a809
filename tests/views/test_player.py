"""What the player's page holds: the steps that were kept, and what the command refuses."""

import json
import re

import numpy as np
import pytest
from oracles.random_instances import random_instance

from cutgap.benchmark.methods import run
from cutgap.instances import Rules, conclude
from cutgap.instances.formats import write_instance
from cutgap.instances.progress import Progress
from cutgap.instances.scene import Branch, Leg, Scene
from cutgap.views.cli import main
from cutgap.views.recording import BYTES, FIRST, MOST, Recorder, differences

LIMIT = 2_000_000


def restored(document):
    """Return the steps of a document with all of their fields."""
    steps, state = [], {}
    for change in document["steps"]:
        state = {**state, **change}
        steps.append(state)
    return steps


def data_of(page):
    return json.loads(
        re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)[1]
    )


@pytest.fixture
def instance():
    return random_instance(np.random.default_rng(5), 6, layout="uniform")


@pytest.mark.parametrize(
    ("method", "heads"), [("tour", 1), ("gtsp", 1), ("contour-dp", 1), ("split", 2), ("free", 2)]
)
def test_the_steps_are_the_events_of_the_run(method, heads):
    instance = random_instance(np.random.default_rng(7), 8, layout="uniform", heads=heads)
    recorder, events = Recorder(instance), []

    def watch(progress):
        recorder.watch(progress)
        if progress.scene is not None:
            events.append(progress)

    result = run(method, instance, Rules(), watch=watch)
    recorder.finish(result)
    steps = restored(recorder.document())
    assert len(steps) == len(events) + 1 <= FIRST
    for step, event in zip(steps, events, strict=False):
        for shown, told in ((step["lower"], event.lower_bound), (step["value"], event.value)):
            assert shown == (None if told is None else pytest.approx(told, abs=1e-4))
    assert steps[-1]["value"] == pytest.approx(result.value, abs=1e-4)
    assert steps[-1]["lower"] == pytest.approx(result.lower_bound, abs=1e-4)
    assert "optimal" in steps[-1]["text"]


def progress_of(number, value, legs=()):
    branch = Branch(number, None if number == 0 else number // 2, float(number), "open")
    scene = Scene(f"event {number}", bound=float(number), legs=legs, branch=number, branches=(branch,))
    return Progress(0.1, value, float(number), scene=lambda: scene)


def record(instance, count, legs=lambda number: ()):
    recorder = Recorder(instance)
    for number in range(count):
        recorder.watch(progress_of(number, 1e6 - number // 1000, legs(number)))
    recorder.finish(conclude(instance, Rules(), None, method="tour", seconds=1.0, lower_bound=0.0))
    return recorder.document()


def test_a_long_run_keeps_the_steps_that_the_page_says(instance):
    count = 5000
    document = record(instance, count)
    at = [step["at"] for step in restored(document)]
    stride = document["stride"]
    kept = {n for n in range(count) if n < FIRST or n % stride == 0 or n % 1000 == 0} | {count}
    assert set(at) - {count - 1} == kept - {count - 1}
    assert at == sorted(at)
    assert document["events"] == count + 1
    later = sum(n % stride == 0 for n in range(FIRST, count))
    assert MOST / 2 - 10 <= later <= MOST + 10


@pytest.mark.parametrize("size", [500, 1200])
def test_a_long_run_stays_below_the_size(instance, size):
    legs = [Leg(i % 6, i % 5, 0.5, 0) for i in range(size)]
    rng = np.random.default_rng(1)

    def shown(number):
        return tuple(Leg(leg.start, leg.end, float(rng.random())) for leg in legs)

    document = record(instance, 250, shown)
    assert len(json.dumps(document["steps"])) <= BYTES
    assert document["steps"][0]["at"] == 0
    assert document["stride"] > 1
    assert (document["first"] < FIRST) == (size == 1200)


def test_differences_restore_the_steps():
    rng = np.random.default_rng(2)
    steps = [{key: int(rng.integers(3)) for key in "abc"} for _ in range(30)]
    assert restored({"steps": differences(steps)}) == steps


def test_the_command_writes_one_page_without_network(part, tmp_path, capsys):
    out = tmp_path / "page.html"
    assert main(["play", str(part), "-o", str(out)]) == 0
    assert "split, optimal" in capsys.readouterr().out
    page = out.read_text(encoding="utf-8")
    assert not re.search(r'(src|href)="(?!data:)', page)
    assert "http" not in page.replace("http://www.w3.org/2000/svg", "")
    assert data_of(page)["method"] == "split"
    assert restored(data_of(page))[-1]["thresholds"]


def test_names_do_not_break_the_page(tmp_path):
    from dataclasses import replace

    instance = random_instance(np.random.default_rng(3), 5, layout="uniform", heads=1)
    evil = "</script><b>$x&"
    contours = (replace(instance.contours[0], id=evil), *instance.contours[1:])
    path, out = tmp_path / "part.json", tmp_path / "page.html"
    write_instance(replace(instance, name=evil, contours=contours), path)
    assert main(["play", str(path), "--out", str(out)]) == 0
    page = out.read_text(encoding="utf-8")
    assert page.count("</script>") == 2
    assert data_of(page)["instance"]["contours"][0] == evil


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["-o", "page.txt"], "expected a name ending in .html"),
        (["-o", "nowhere/page.html"], "does not exist"),
        (["-o", "page.html", "--method", "cpsat"], "shows no steps; expected one of tour"),
        (["-o", "page.html", "--method", "local-search"], "shows no steps"),
        (["-o", "page.html", "--method", "magic"], "expected one of auto"),
        (["-o", "page.html", "--method", "tour"], "needs one head"),
        (["-o", "page.html", "--time-limit", "0"], "above 0"),
    ],
)
def test_bad_input_is_named(part, tmp_path, monkeypatch, capsys, options, words):
    monkeypatch.chdir(tmp_path)
    assert main(["play", str(part), *options]) == 2
    assert words in capsys.readouterr().err
    assert not (tmp_path / "page.html").exists()


def test_auto_says_when_what_suits_shows_nothing(tmp_path, capsys):
    path = tmp_path / "part.json"
    write_instance(random_instance(np.random.default_rng(1), 5, layout="uniform", entries=3), path)
    assert main(["play", str(path), "-o", str(tmp_path / "page.html")]) == 2
    assert "the method that suits" in capsys.readouterr().err


def test_an_instance_without_coordinates_is_refused(tmp_path, capsys):
    path = tmp_path / "bare.tsp"
    path.write_text(
        "NAME: bare\nTYPE: TSP\nDIMENSION: 3\nEDGE_WEIGHT_TYPE: EXPLICIT\nEDGE_WEIGHT_FORMAT: FULL_MATRIX\n"
        "EDGE_WEIGHT_SECTION\n0 1 2\n1 0 3\n2 3 0\nEOF\n"
    )
    assert main(["play", str(path), "-o", str(tmp_path / "page.html")]) == 2
    assert "no coordinates" in capsys.readouterr().err


def test_an_infeasible_instance_has_a_page_that_says_so(tmp_path):
    path, out = tmp_path / "part.json", tmp_path / "page.html"
    write_instance(random_instance(np.random.default_rng(1), 5, layout="uniform"), path)
    assert main(["play", str(path), "-o", str(out), "--non-overlap", "1e6"]) == 0
    assert "No plan is allowed" in restored(data_of(out.read_text(encoding="utf-8")))[-1]["text"]
