"""Runs tasks over any executor and hands back records as they finish."""

from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from dataclasses import dataclass
from itertools import islice

from cutgap.benchmark.executors import SerialExecutor
from cutgap.benchmark.interrupts import noted_interrupts
from cutgap.benchmark.methods import run, warm_up
from cutgap.benchmark.records import Record, make_record
from cutgap.benchmark.tasks import Task
from cutgap.instances.progress import Watch, nobody


@dataclass(frozen=True, slots=True)
class Failure:
    """A task that raised an error; it leaves no record, so that a later run tries it again."""

    task: Task
    error: str

    def __str__(self) -> str:
        return f"{self.task.method} on {self.task.instance.name!r}, seed {self.task.seed}: {self.error}"


def run_task(task: Task, watch: Watch = nobody) -> Record:
    """Run one task in this process.

    Raises
    ------
    ValueError
        When the method refuses the instance or the rules, or its result does not fit its plan.
    """
    warm_up(task.method, task.rules, task.instance)
    result = run(
        task.method,
        task.instance,
        task.rules,
        seed=task.seed,
        time_limit=task.time_limit,
        certify=True,
        watch=watch,
    )
    return make_record(task, result)


def run_tasks(
    tasks: Iterable[Task],
    executor: Executor,
    *,
    in_flight: int = 1,
    watch: Watch = nobody,
) -> Iterator[Record | Failure]:
    """Run tasks and yield a record, or the failure, of each as it finishes.

    Parameters
    ----------
    executor
        Where they run; ``SerialExecutor`` also reports the state of the run to ``watch``.
    in_flight
        Most tasks handed to the executor at a time.

    Notes
    -----
    On Ctrl-C the runs that are done are still yielded, then ``KeyboardInterrupt`` goes on.
    """
    waiting = iter(tasks)
    running: dict[Future[Record], Task] = {}
    extra = (watch,) if isinstance(executor, SerialExecutor) else ()
    with noted_interrupts() as interrupts:
        try:
            while True:
                for task in islice(waiting, in_flight - len(running)):
                    future = executor.submit(run_task, task, *extra)
                    # A run that was cut short is no record; a later one does it in full.
                    interrupts.raise_if_seen()
                    running[future] = task
                if not running:
                    return
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    yield _outcome(running.pop(future), future)
        except KeyboardInterrupt:
            for future in [each for each in running if each.done() and not each.cancelled()]:
                yield _outcome(running.pop(future), future)
            raise
        finally:
            for future in running:
                future.cancel()


def _outcome(task: Task, future: Future[Record]) -> Record | Failure:
    error = future.exception()
    if error is None:
        return future.result()
    return Failure(task, f"{type(error).__name__}: {error}")
