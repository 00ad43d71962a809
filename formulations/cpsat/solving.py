"""The front of the CP-SAT model: starts the search, keeps what it sends, values every plan exactly."""

import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from cutgap.formulations.cpsat.integers import Tours, integers_of
from cutgap.formulations.cpsat.worker import MEBIBYTE, Job, Message, Work, search
from cutgap.instances import Instance, Plan, Result, Rules, Visit, check, conclude, evaluate
from cutgap.instances.check import require_coordinates
from cutgap.instances.progress import Progress, Watch, nobody

WORKERS = 8
GRACE_S = 10.0
"""How long a search that should have ended may take to say its last word."""

POLL_S = 0.1
WORKER = "cutgap.formulations.cpsat.worker"
BROKEN = "the best plan on integers breaks a limit on times by rounding"


def solve_cpsat(
    instance: Instance,
    rules: Rules,
    *,
    time_limit: float | None = None,
    start: Plan | None = None,
    certify: bool = False,
    watch: Watch = nobody,
    workers: int = WORKERS,
    memory_mib: int | None = None,
    isolated: bool = True,
) -> Result:
    """Solve an instance of one or two heads under any rules with CP-SAT, on integers.

    Rapids and work are rounded down, at a scale that the result's reason states, so the bound holds for the
    true problem; plans are valued exactly. The bound, and a claim that no plan exists, are the solver's word.

    Parameters
    ----------
    time_limit
        Seconds after which the best plan and bound so far are returned; Ctrl-C does the same.
    start
        A plan to start from; one that breaks rules is ignored.
    certify
        Without effect: CP-SAT gives no proof, so the result never has a certificate.
    workers
        Threads of the search.
    memory_mib
        Memory limit of the search, MiB; half of the machine's by default.
    isolated
        Whether to search in a child process. Within this process there is no memory limit: CP-SAT ends the
        process when memory runs out. Nor does Ctrl-C stop the search then.

    Raises
    ------
    ValueError
        When there are more than two heads, or the rules need coordinates that are not there.
    """
    require_coordinates(instance, rules)
    if len(instance.heads) > 2:
        name = f"instance {instance.name!r}, method cpsat"
        raise ValueError(f"{name}: needs one or two heads, got {len(instance.heads)}")
    if not instance.contours:
        nothing = Plan(tuple(() for _ in instance.heads))
        return conclude(instance, rules, nothing, method="cpsat", seconds=0.0, lower_bound=0.0)
    memory = default_memory_mib() if memory_mib is None else memory_mib
    run = _Run(instance, rules, time_limit, watch, isolated)
    return run.result(start, workers, memory)


def default_memory_mib() -> int:
    """Return half of the machine's memory, or 4096 MiB where that is unknown."""
    if not hasattr(os, "sysconf"):
        return 4096
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // MEBIBYTE // 2


class _Run:
    """One run: the best allowed plan and the bound, as messages come in."""

    def __init__(
        self, instance: Instance, rules: Rules, time_limit: float | None, watch: Watch, isolated: bool
    ) -> None:
        self.instance, self.rules, self.watch, self.isolated = instance, rules, watch, isolated
        self.started = time.perf_counter()
        self.time_limit = time_limit
        self.data = integers_of(instance, rules)
        self.best: Plan | None = None
        self.value: float | None = None
        self.broken: Plan | None = None  # the last plan, when it breaks a rule by rounding
        self.bound: float | None = None
        self.status = ""

    def result(self, start: Plan | None, workers: int, memory_mib: int) -> Result:
        """Search and return what was found."""
        hint = None
        if start is not None and not check(self.instance, self.rules, start):
            self._offer(start)
            hint = tuple(tuple(self.instance.node(*visit[:2]) for visit in tour) for tour in start.tours)
        job = Job(self.data, self._seconds_left(), workers, memory_mib, hint)
        reason = self._search(job)
        infeasible = self.status == "INFEASIBLE" and self.best is None
        if reason is None and self.broken is not None and self.data.may_break_by_rounding:
            self._search(replace(job, seconds=self._seconds_left(), tight=True))
        return conclude(
            self.instance,
            self.rules,
            None if infeasible else self.best or self.broken,
            method="cpsat",
            seconds=time.perf_counter() - self.started,
            lower_bound=self.bound,
            infeasible=infeasible,
            reason=self._reason(reason, infeasible),
        )

    def _reason(self, reason: str | None, infeasible: bool) -> str:
        scale = f"CP-SAT on integers of {1 / self.data.scale:g} mm"
        if infeasible:
            return f"{scale} claims that there is no plan"
        if reason is None and self.broken is not None and self.best is None:
            reason = BROKEN
        return scale if reason is None else f"{scale}: {reason}"

    def _seconds_left(self) -> float | None:
        if self.time_limit is None:
            return None
        return max(0.0, self.started + self.time_limit - time.perf_counter())

    def _search(self, job: Job) -> str | None:
        """Run a job to its end; return why it ended early."""
        self.status = ""
        try:
            if self.isolated:
                reason = self._search_in_child(job)
            else:
                search(job, self._receive)
                reason = None
        except KeyboardInterrupt:
            return "interrupted"
        if reason is None and self.status not in ("OPTIMAL", "INFEASIBLE"):
            reason = "stopped early"
        return reason

    def _search_in_child(self, job: Job) -> str | None:
        child = Child(job, WORKER)
        try:
            for message in child.messages(None if job.seconds is None else job.seconds + GRACE_S):
                self._receive(message)
        except KeyboardInterrupt:
            child.stop()
            for message in child.messages(GRACE_S):
                self._receive(message)
            raise
        finally:
            child.kill()
        return None if self.status else child.epitaph()

    def _receive(self, message: Message) -> None:
        kind, content = message
        if kind == "plan":
            self._offer_tours(content)
        elif kind == "bound":
            bound = self._value_of(content)
            self.bound = bound if self.bound is None else max(self.bound, bound)
        else:
            self.status = content
        self.watch(Progress(time.perf_counter() - self.started, self.value, self.bound))

    def _value_of(self, integer: int) -> float:
        """Return an objective of the model in the rules' unit."""
        if self.rules.objective == "makespan":
            return integer / self.data.scale / self.instance.machine.v_jump
        return integer / self.data.scale / self.data.price[1]

    def _offer_tours(self, tours: Tours) -> None:
        first, of = self.instance.first_node, self.data.contour_of
        plan = Plan(tuple(tuple(Visit(of[v], v - int(first[of[v]])) for v in tour) for tour in tours))
        self.broken = plan if check(self.instance, self.rules, plan) else None
        if self.broken is None:
            self._offer(plan)

    def _offer(self, plan: Plan) -> None:
        value = evaluate(self.instance, plan).objective(self.rules)
        if self.value is None or value < self.value:
            self.best, self.value = plan, value


class Child:
    """A child process at work on a job, which a module serves; closing its input stops it."""

    def __init__(self, job: Work, module: str) -> None:
        command = [sys.executable, "-m", module]
        self.memory_mib = job.memory_mib
        # In a session of its own, as Ctrl-C is for the parent to handle.
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
            cwd=Path(sys.executable).parent,
        )
        self.timed_out = False
        self._queue: queue.Queue[Message | None] = queue.Queue()
        threading.Thread(target=self._read, daemon=True).start()
        assert self.process.stdin is not None
        # Had it died at once, no message will come.
        with suppress(BrokenPipeError):
            pickle.dump(job, self.process.stdin)
            self.process.stdin.flush()

    def _read(self) -> None:
        assert self.process.stdout is not None
        try:
            while True:
                self._queue.put(pickle.load(self.process.stdout))
        except (EOFError, OSError, pickle.UnpicklingError):
            self._queue.put(None)

    def messages(self, seconds: float | None) -> Iterator[Message]:
        """Yield messages until the child is done, or for so long."""
        deadline = None if seconds is None else time.perf_counter() + seconds
        while deadline is None or time.perf_counter() < deadline:
            try:
                message = self._queue.get(timeout=POLL_S)
            except queue.Empty:
                continue
            if message is None:
                return
            yield message
        self.timed_out = True

    def stop(self) -> None:
        """Ask it to stop."""
        assert self.process.stdin is not None
        with suppress(BrokenPipeError):
            self.process.stdin.close()

    def kill(self) -> None:
        """End it at once, if it has not ended yet."""
        self.stop()
        if self.timed_out:
            self.process.kill()
        try:
            self.process.wait(timeout=GRACE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()

    def epitaph(self) -> str:
        """Return why it ended without a last word."""
        if self.timed_out:
            return "the search did not end in time"
        code = self.process.returncode
        how = f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
        return f"the search died ({how}); its memory limit was {self.memory_mib} MiB"
