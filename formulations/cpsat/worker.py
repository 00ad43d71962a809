"""The search itself, in a process of its own: CP-SAT ends the whole process when memory runs out.

Run as a module it reads a ``Job`` from standard input and writes messages to standard output, both pickled.
When its input is closed, by a caller that wants it to stop or that died, it stops.
"""

import contextlib
import os
import pickle
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from ortools.sat.python import cp_model

from cutgap.formulations.cpsat.entries import EntryModel
from cutgap.formulations.cpsat.integers import Integers, Tours

STOP_INTERVAL_S = 0.05
MEBIBYTE = 2**20

Message = tuple[str, Any]
"""``plan`` and its tours, ``bound`` and its integer, ``done`` and the solver's status."""

Send = Callable[[Message], None]


class Work(Protocol):
    """Anything that a child process can be sent to do within a memory limit, MiB."""

    @property
    def memory_mib(self) -> int: ...


@dataclass(frozen=True, slots=True)
class Job:
    """A search to be done: at most ``seconds`` (``None``: any) with ``workers`` threads.

    ``tight`` takes limits on times such that no plan breaks the true ones; its bound says nothing then.
    """

    data: Integers
    seconds: float | None
    workers: int
    memory_mib: int
    start: Tours | None = None
    tight: bool = False


class _Reporter(cp_model.CpSolverSolutionCallback):
    """Sends each better plan."""

    def __init__(self, built: EntryModel, send: Send) -> None:
        super().__init__()
        self._built, self._send = built, send

    def on_solution_callback(self) -> None:
        self._send(("plan", self._built.tours(self)))


def search(job: Job, send: Send, stop: threading.Event | None = None) -> None:
    """Search, sending plans and bounds as they are found, ``done`` at the end."""
    built = EntryModel(job.data, tight=job.tight)
    if job.start is not None:
        built.hint(job.start)
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = job.workers
    # Probing before the search loses plans of two heads under precedence (ortools 9.15): 2 % of tiny sheets.
    solver.parameters.cp_model_probing_level = 0
    # CP-SAT would leave the process without Python's own handler.
    solver.parameters.catch_sigint_signal = False
    # It stops by itself somewhat before the hard limit ends it.
    solver.parameters.max_memory_in_mb = 3 * job.memory_mib // 4
    if job.seconds is not None:
        solver.parameters.max_time_in_seconds = max(0.0, job.seconds)
    if not job.tight:
        solver.best_bound_callback = lambda bound: send(("bound", round(bound)))
    finished = threading.Event()
    if stop is not None:
        threading.Thread(target=stop_when_asked, args=(solver, stop, finished), daemon=True).start()
    status = solver.solve(built.model, _Reporter(built, send))
    finished.set()
    if status == cp_model.MODEL_INVALID:
        raise RuntimeError(f"invalid model: {built.model.validate()}")
    if status == cp_model.OPTIMAL and not job.tight:
        send(("bound", round(solver.best_objective_bound)))
    send(("done", solver.status_name(status)))


def stop_when_asked(solver: cp_model.CpSolver, stop: threading.Event, finished: threading.Event) -> None:
    """Wait for the wish to stop, and stop a search."""
    stop.wait()
    # A request before the search has begun is lost.
    while not finished.wait(STOP_INTERVAL_S):
        solver.stop_search()


def limit_memory(mebibytes: int) -> None:
    """Limit this process's memory, where the system can."""
    if sys.platform == "win32":
        return
    import resource

    with contextlib.suppress(ValueError, OSError):
        resource.setrlimit(resource.RLIMIT_AS, (mebibytes * MEBIBYTE, mebibytes * MEBIBYTE))


def serve(do: Callable[[Any, Send, threading.Event], None]) -> None:
    """Do the job on standard input, and end the process."""
    messages = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # so that nothing else comes between the messages
    job: Work = pickle.load(sys.stdin.buffer)
    limit_memory(job.memory_mib)
    stop, lock = threading.Event(), threading.Lock()

    def wait_for_end() -> None:
        sys.stdin.buffer.read()
        stop.set()

    def send(message: Message) -> None:
        with lock, contextlib.suppress(BrokenPipeError):
            pickle.dump(message, messages)
            messages.flush()

    threading.Thread(target=wait_for_end, daemon=True).start()
    do(job, send, stop)
    messages.close()
    # Without waiting for the thread that still reads.
    os._exit(0)


if __name__ == "__main__":
    serve(search)
