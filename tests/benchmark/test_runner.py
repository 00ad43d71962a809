"""Running tasks: in this process, in others, on a dask cluster; failures and Ctrl-C on the way."""

import os
import signal
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from distributed import LocalCluster
from oracles.random_instances import random_instance

from cutgap.benchmark import runner
from cutgap.benchmark.executors import SerialExecutor, dask_executor, process_executor
from cutgap.benchmark.methods import is_exact
from cutgap.benchmark.records import Record
from cutgap.benchmark.runner import Failure, run_tasks
from cutgap.benchmark.tasks import Task, suite_tasks
from cutgap.heuristics import HEURISTICS
from cutgap.instances import Rules

PAIR = random_instance(np.random.default_rng(0), 4, layout="uniform")
METHODS = (
    "split",
    "free",
    "cpsat",
    *(name for name, each in HEURISTICS.items() if each.applies(PAIR, Rules())),
)


@pytest.fixture(scope="module")
def tasks():
    rng = np.random.default_rng(21)
    instances = tuple(random_instance(rng, holes, layout="uniform") for holes in (5, 6))
    return suite_tasks([(each, Rules()) for each in instances], METHODS, seeds=2)


@pytest.fixture(scope="module")
def expected(tasks):
    return outcomes(run_tasks(tasks, SerialExecutor()))


def outcomes(records):
    """Return what must not depend on where a run happens, by task: plan or, where optima tie, the value."""
    return {
        record.key: round(record.result.value, 6) if is_exact(record.result.method) else record.result.plan
        for record in records
    }


def test_one_record_a_task(tasks, expected):
    assert set(expected) == {task.key for task in tasks}
    assert None not in expected.values()


def test_worker_processes_find_the_same(tasks, expected):
    some = [task for task in tasks if task.method in ("split", "local-search")]
    with process_executor(2) as executor:
        found = outcomes(run_tasks(some, executor, in_flight=4))
    assert found == {task.key: expected[task.key] for task in some}


def test_a_dask_cluster_finds_the_same(tasks, expected):
    options = {"n_workers": 2, "threads_per_worker": 1, "processes": False, "dashboard_address": None}
    with (
        LocalCluster(**options) as cluster,
        dask_executor(cluster.scheduler_address) as executor,
    ):
        assert outcomes(run_tasks(tasks, executor, in_flight=100)) == expected


def test_a_failing_task_does_not_stop_the_others(tasks, monkeypatch):
    broken = tasks[1]

    def run(method, instance, rules, **options):
        if (method, options["seed"], instance) == (broken.method, broken.seed, broken.instance):
            raise ZeroDivisionError("for the test")
        return original(method, instance, rules, **options)

    original = runner.run
    monkeypatch.setattr(runner, "run", run)
    with ThreadPoolExecutor(1) as executor:
        found = list(run_tasks(tasks[:4], executor, in_flight=2))
    failures = [each for each in found if isinstance(each, Failure)]
    assert [failure.task for failure in failures] == [broken]
    assert "ZeroDivisionError: for the test" in str(failures[0])
    assert {each.key for each in found if isinstance(each, Record)} == {
        task.key for task in tasks[:4] if task is not broken
    }


@pytest.mark.parametrize("swallowed", [True, False])
def test_ctrl_c_keeps_what_is_finished_and_drops_what_was_cut_short(tasks, monkeypatch, swallowed):
    original = runner.run
    found: list[Record | Failure] = []

    def run(method, instance, rules, **options):
        if len(found) == 2:
            try:
                os.kill(os.getpid(), signal.SIGINT)
            except KeyboardInterrupt:
                if not swallowed:
                    raise
        return original(method, instance, rules, **options)

    def collect():
        for outcome in run_tasks(tasks, SerialExecutor()):
            found.append(outcome)

    monkeypatch.setattr(runner, "run", run)
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        collect()
    assert [each.key for each in found] == [task.key for task in tasks[:2]]
    assert signal.getsignal(signal.SIGINT) is before


def test_ctrl_c_ends_worker_processes(tasks):
    with pytest.raises(KeyboardInterrupt), process_executor(2) as executor:  # noqa: PT012
        future = executor.submit(sum, (1, 2))
        assert future.result() == 3
        pids = list(executor._processes)
        executor.submit(signal.pause)
        raise KeyboardInterrupt
    for pid in pids:
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)


def test_tasks_know_their_methods(tasks):
    assert {task.method for task in tasks} == set(METHODS)
    with pytest.raises(ValueError, match="'none'"):
        Task(tasks[0].instance, Rules(), "none", 0)
