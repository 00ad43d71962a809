"""Progress on stderr, only when it is a terminal: incumbent, bound, gap and time of what runs."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from time import perf_counter

from rich.console import Console, Group
from rich.live import Live
from rich.progress import BarColumn, MofNCompleteColumn, TaskID, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bar
from rich.text import Text

from cutgap.benchmark.records import Record
from cutgap.benchmark.runner import Failure
from cutgap.benchmark.tasks import Task
from cutgap.benchmark.trade_off import gap_to
from cutgap.instances.progress import Progress, Watch, nobody

REFRESH_PER_SECOND = 8


def state_line(value: float | None, lower_bound: float | None, unit: str) -> str:
    """Return incumbent, bound and gap as text; what is not there yet is left out."""
    parts = []
    if value is not None:
        parts.append(f"incumbent {value:.2f} {unit}")
    if lower_bound is not None:
        parts.append(f"bound {lower_bound:.2f} {unit}")
    # Of deg C it would be a share of where the scale begins.
    if value is not None and lower_bound is not None and unit != "deg C":
        parts.append(f"gap {100 * gap_to(value, lower_bound):.3f} %")
    return ", ".join(parts)


class RunLine:
    """The line of one run; its time goes on between events."""

    def __init__(self, label: str, unit: str) -> None:
        self._label, self._unit = label, unit
        self._start = perf_counter()
        self._value: float | None = None
        self._bound: float | None = None
        self._message = ""

    def watch(self, progress: Progress) -> None:
        """Take an event; an event that says nothing of value or bound leaves them."""
        self._value = self._value if progress.value is None else progress.value
        self._bound = self._bound if progress.lower_bound is None else progress.lower_bound
        self._message = progress.message

    def __rich__(self) -> Text:
        state = state_line(self._value, self._bound, self._unit)
        seconds = f"{perf_counter() - self._start:.1f} s"
        return Text(" · ".join(part for part in (self._label, state, seconds, self._message) if part))


@contextmanager
def watch_run(label: str, unit: str) -> Iterator[Watch]:
    """Show one run while the context lasts."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield nobody
        return
    line = RunLine(label, unit)
    with Live(line, console=console, refresh_per_second=REFRESH_PER_SECOND, transient=True):
        yield line.watch


class SuiteView:
    """A bar over the runs of a suite, and a line for the present run (in one process) or the last one."""

    def __init__(self, tasks: Sequence[Task], *, one_by_one: bool) -> None:
        self._tasks, self._one_by_one, self._done = tasks, one_by_one, 0
        self._bar = Bar(
            TextColumn("runs"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), auto_refresh=False
        )
        self._bar_id: TaskID = self._bar.add_task("runs", total=len(tasks))
        self._line: RunLine | Text = Text("")
        self._next_line()

    def _next_line(self) -> None:
        if self._one_by_one and self._done < len(self._tasks):
            task = self._tasks[self._done]
            self._line = RunLine(f"{task.instance.name}, {task.method}", task.rules.unit)

    def watch(self, progress: Progress) -> None:
        """Take an event of the present run."""
        if isinstance(self._line, RunLine):
            self._line.watch(progress)

    def advance(self, outcome: Record | Failure) -> None:
        """Count a run as finished."""
        self._done += 1
        self._bar.advance(self._bar_id)
        if self._one_by_one:
            self._next_line()
        elif isinstance(outcome, Record):
            result = outcome.result
            value = None if result.violations else result.value
            state = state_line(value, result.lower_bound, result.rules.unit)
            self._line = Text(f"last: {outcome.instance}, {result.method} · {state} · {result.seconds:.1f} s")

    def __rich__(self) -> Group:
        return Group(self._bar, self._line)


@contextmanager
def watch_suite(tasks: Sequence[Task], *, one_by_one: bool) -> Iterator[SuiteView]:
    """Show the runs of a suite while the context lasts.

    Parameters
    ----------
    tasks
        What runs, in this order.
    one_by_one
        Whether they run one after the other in this process, and so report to ``SuiteView.watch``.
    """
    view = SuiteView(tasks, one_by_one=one_by_one)
    console = Console(stderr=True)
    if not console.is_terminal:
        yield view
        return
    with Live(view, console=console, refresh_per_second=REFRESH_PER_SECOND, transient=True):
        yield view
