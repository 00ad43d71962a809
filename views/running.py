"""Running the tasks of a command into a folder: where they run, what is skipped, what is said."""

import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor
from contextlib import contextmanager
from typing import Annotated

from cyclopts import Parameter

from cutgap.benchmark.executors import SerialExecutor, dask_executor, process_executor
from cutgap.benchmark.folder import Folder
from cutgap.benchmark.runner import Failure, run_tasks
from cutgap.benchmark.tasks import Task
from cutgap.views.progress import watch_suite

Jobs = Annotated[int, Parameter(help="Number of processes.")]
Dask = Annotated[str | None, Parameter(help="Address of a dask scheduler to run on.")]
Resume = Annotated[bool, Parameter(help="Skip runs that the folder holds already.")]

DASK_IN_FLIGHT = 1000
"""Most runs handed to a cluster at a time: enough for any number of workers, and not the whole suite."""


def require_one_place(jobs: int, dask: str | None) -> None:
    """Raise ``ValueError`` when the place to run is not clear."""
    if jobs < 1:
        raise ValueError(f"--jobs: expected at least 1, got {jobs}")
    if dask is not None and jobs > 1:
        raise ValueError("--jobs and --dask: give one of them")


def say_what_is_there(folder: Folder, tasks: Sequence[Task]) -> None:
    """Say on stderr what became of earlier results, and how many of the tasks are finished."""
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


def run_all(tasks: Sequence[Task], folder: Folder, jobs: int, dask: str | None) -> tuple[list[Failure], bool]:
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
