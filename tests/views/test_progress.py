"""What a watcher sees on a terminal, and that nothing is written where there is none."""

import re

import numpy as np
from oracles.random_instances import random_instance
from rich.console import Console

from cutgap.benchmark.executors import SerialExecutor
from cutgap.benchmark.runner import run_tasks
from cutgap.benchmark.tasks import suite_tasks
from cutgap.instances import Rules
from cutgap.instances.progress import Progress
from cutgap.views.progress import RunLine, SuiteView, watch_run, watch_suite


def text_of(renderable):
    console = Console(width=120)
    with console.capture() as capture:
        console.print(renderable)
    return capture.get()


def test_a_run_shows_incumbent_bound_gap_and_time():
    line = RunLine("part, split", "s")
    line.watch(Progress(0.1, lower_bound=80.0))
    assert "bound 80.00 s" in text_of(line)
    assert "gap" not in text_of(line)
    line.watch(Progress(0.2, value=100.0, message="3 nodes"))
    text = text_of(line)
    for word in ("part, split", "incumbent 100.00 s", "bound 80.00 s", "gap 20.000 %", "3 nodes"):
        assert word in text
    assert re.search(r"\d+\.\d s", text)


def test_a_suite_shows_its_runs_one_after_the_other():
    instance = random_instance(np.random.default_rng(1), 5, layout="uniform")
    tasks = suite_tasks([(instance, Rules())], ("split", "task-balancing"), seeds=1)
    view = SuiteView(tasks, one_by_one=True)
    assert "0/2" in text_of(view)
    assert "split" in text_of(view)
    for outcome in run_tasks(tasks[:1], SerialExecutor(), watch=view.watch):
        assert "incumbent" in text_of(view)
        view.advance(outcome)
    assert "1/2" in text_of(view)
    assert "task-balancing" in text_of(view)


def test_without_a_terminal_nothing_is_written(capfd):
    with watch_run("part", "s") as watch, watch_suite([], one_by_one=False):
        watch(Progress(0.0, 1.0, 1.0))
    assert capfd.readouterr() == ("", "")
