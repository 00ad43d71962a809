"""The command ``gaps``: methods against proved bounds over a suite."""

import json as json_library
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cutgap.benchmark.executors import SerialExecutor, dask_executor, process_executor
from cutgap.benchmark.folder import REPORT_NAME, TABLE_NAME, Folder, open_folder
from cutgap.benchmark.methods import default_methods
from cutgap.benchmark.runner import Failure, run_tasks
from cutgap.benchmark.table import ContradictionError, cells, gap_table, table_csv
from cutgap.benchmark.tasks import Suite, Task, find_suite, instance_hash, suite_tasks
from cutgap.instances.formats import write_atomically
from cutgap.views.options import (
    DEFAULT_RULES,
    FILE_MACHINE,
    Json,
    MachineArguments,
    RuleOptions,
    TimeLimit,
    require_time_limit,
)
from cutgap.views.progress import watch_suite
from cutgap.views.report import Run, report_html
from cutgap.views.tables import print_gaps

RESULTS = Path("results")
DASK_IN_FLIGHT = 1000
"""Most runs handed to a cluster at a time: enough for any number of workers, and not the whole suite."""


def gaps(
    suite: str = "table1",
    /,
    *,
    methods: Annotated[
        str | None, Parameter(help="Names with commas between; by default auto and all heuristics.")
    ] = None,
    seeds: Annotated[int, Parameter(help="Runs of each heuristic, with seeds 0, 1, ...")] = 5,
    rules: RuleOptions = DEFAULT_RULES,
    time_limit: TimeLimit = 60.0,
    jobs: Annotated[int, Parameter(help="Number of processes.")] = 1,
    dask: Annotated[str | None, Parameter(help="Address of a dask scheduler to run on.")] = None,
    resume: Annotated[bool, Parameter(help="Skip runs that the folder holds already.")] = False,
    out: Annotated[
        Path | None,
        Parameter(
            help="Folder for results.jsonl, table.csv and report.html; results/SUITE by default. "
            "Without --resume what is there moves to earlier-1, earlier-2, ... in it."
        ),
    ] = None,
    machine: MachineArguments = FILE_MACHINE,
    json: Json = False,
) -> int:
    """Compare methods with proved optima or bounds over a suite.

    Prints the gap table and writes results.jsonl, table.csv and report.html. Results that are there
    already are moved to a folder earlier-1, earlier-2, ... unless --resume is given. Ctrl-C keeps what is
    finished.

    Parameters
    ----------
    suite
        Name of a shipped suite, an instance file, or a folder of instance files.
    """
    require_time_limit(time_limit)
    if jobs < 1:
        raise ValueError(f"--jobs: expected at least 1, got {jobs}")
    if dask is not None and jobs > 1:
        raise ValueError("--jobs and --dask: give one of them")
    chosen = default_methods() if methods is None else tuple(name.strip() for name in methods.split(","))
    found = find_suite(suite, machine.options())
    tasks = suite_tasks(found, rules.rules(), chosen, seeds=seeds, time_limit=time_limit)
    folder = open_folder(out if out is not None else RESULTS / found.name, resume=resume)
    _say_what_is_there(folder, tasks)
    failures, stopped = _run_all(tasks, folder, jobs, dask)
    run = Run(found.name, rules.rules(), chosen, seeds, time_limit, len(tasks))
    for failure in failures:
        print(f"cutgap: failed: {failure}", file=sys.stderr)
    try:
        _publish(run, found, tasks, folder, failures, json)
    except ContradictionError as error:
        print(f"cutgap: no table, because results contradict each other: {error}", file=sys.stderr)
        return 1
    if stopped:
        print("cutgap: stopped; finished runs are kept, --resume goes on from them", file=sys.stderr)
    return 1 if failures or stopped else 0


def _say_what_is_there(folder: Folder, tasks: Sequence[Task]) -> None:
    if folder.set_aside is not None:
        print(f"cutgap: earlier results are now in {folder.set_aside}", file=sys.stderr)
    for damage in folder.damages:
        print(f"cutgap: {folder.results}, {damage}; ignored, the run is done again", file=sys.stderr)
    done = len(folder.among(task.key for task in tasks))
    if done:
        print(f"cutgap: {done} of {len(tasks)} runs are finished already", file=sys.stderr)


@contextmanager
def _executor(jobs: int, dask: str | None) -> Iterator[tuple[Executor, int]]:
    """Give the executor and the number of runs that it is handed at a time."""
    if dask is not None:
        with dask_executor(dask) as executor:
            yield executor, DASK_IN_FLIGHT
    elif jobs > 1:
        with process_executor(jobs) as executor:
            yield executor, 2 * jobs
    else:
        yield SerialExecutor(), 1


def _run_all(tasks: Sequence[Task], folder: Folder, jobs: int, dask: str | None) -> tuple[list[Failure], bool]:
    """Run what is not finished; return the failures, and whether Ctrl-C stopped it."""
    open_tasks = [task for task in tasks if task.key not in folder.done]
    failures: list[Failure] = []
    if not open_tasks:
        return failures, False
    try:
        with (
            _executor(jobs, dask) as (executor, in_flight),
            watch_suite(open_tasks, one_by_one=in_flight == 1) as view,
        ):
            for outcome in run_tasks(open_tasks, executor, in_flight=in_flight, watch=view.watch):
                if isinstance(outcome, Failure):
                    failures.append(outcome)
                else:
                    folder.append(outcome)
                view.advance(outcome)
    except KeyboardInterrupt:
        return failures, True
    except BrokenExecutor as error:
        print(f"cutgap: a worker process ended: {error}", file=sys.stderr)
        return failures, True
    return failures, False


def _publish(
    run: Run, suite: Suite, tasks: Sequence[Task], folder: Folder, failures: Sequence[Failure], json: bool
) -> None:
    """Print the table of this command's runs, and write table and report."""
    records = folder.among(task.key for task in tasks)
    rows = gap_table(records)
    instances = {instance_hash(instance): instance for instance in suite.instances}
    write_atomically(folder.path / TABLE_NAME, table_csv(rows))
    write_atomically(folder.path / REPORT_NAME, report_html(run, records, rows, instances, failures))
    if json:
        print(json_library.dumps([cells(row) for row in rows], indent=2, allow_nan=False))
    else:
        print_gaps(rows)
    print(f"cutgap: {folder.path / REPORT_NAME}", file=sys.stderr)
