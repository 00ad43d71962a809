"""Methods side by side in one run, on the same machine: ``python -m cutgap.benchmark.peers NAME``.

    non-overlap   makespan without overlap, random parts: the threshold search and one CP-SAT model
    overlap       overlap allowed, random parts: branch and cut and the same model in CP-SAT
    structured    makespan without overlap on grids, bolt circles, clusters, columns, with certificates
    sizes         makespan without overlap on large random parts, with certificates

A ratio of seconds compares with a run that may have stopped at its limit; it is then marked ``>``. A bound of
CP-SAT is its claim; what a certificate proves is in the column ``proved gap``.
"""

import argparse
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from time import perf_counter

from rich.console import Console
from rich.table import Table

from cutgap.benchmark.methods import warm_up
from cutgap.formulations import solve
from cutgap.formulations.certificate import verify
from cutgap.instances import Instance, Machine, Result, Rules
from cutgap.instances.formats.json_format import format_instance
from cutgap.instances.generate import generate

FAST = Machine(v_jump=500.0, v_cut=50.0, t_aux=1.0)
"""The machine of the published comparison; rapids weigh less in it than with the default one."""

PEER_LIMIT_S = 120.0
STRUCTURED = ("grid", "staggered-grid", "bolt-circles", "clusters", "columns", "b-pillars", "door-panel")
SIZES = ((200, 60.0), (1000, 300.0))
"""Number of holes and limit in s."""

OVERLAP_RULES = (
    Rules("makespan", non_overlap=None),
    Rules("travel", non_overlap=None, balance=0.5),
)
Row = list[str]


@dataclass(frozen=True, slots=True)
class Options:
    """What the command line asks for; ``holes`` and ``limit_s`` replace a benchmark's own when given."""

    machine: Machine
    seed: int
    holes: tuple[int, ...]
    limit_s: float | None


def part(kind: str, holes: int | None, options: Options) -> Instance:
    """Return a part on the machine asked for."""
    return replace(generate(kind, holes=holes, seed=options.seed), machine=options.machine)


def run_peer(instance: Instance, rules: Rules, method: str, limit_s: float | None) -> Result:
    """Solve after a warm-up, so that loading and compiling do not count."""
    warm_up(method, rules, instance)
    return solve(instance, rules, method=method, time_limit=limit_s)


def non_overlap(options: Options) -> Iterator[Row]:
    """Threshold search against CP-SAT."""
    for holes in options.holes or (45, 60, 75, 90):
        yield from against_cpsat(part("random", holes, options), Rules(), "split", options)


def overlap(options: Options) -> Iterator[Row]:
    """Branch and cut against CP-SAT, both with the limit."""
    for holes in options.holes or (30, 45):
        for rules in OVERLAP_RULES:
            yield from against_cpsat(part("random", holes, options), rules, "free", options)


def against_cpsat(instance: Instance, rules: Rules, method: str, options: Options) -> Iterator[Row]:
    """Yield a row for each of the two methods, the second with its ratios to the first."""
    limit = PEER_LIMIT_S if options.limit_s is None else options.limit_s
    ours = run_peer(instance, rules, method, limit)
    yield [*peer_cells(instance, ours), "", ""]
    theirs = run_peer(instance, rules, "cpsat", limit)
    stopped = theirs.gap is None or theirs.gap > GAP_CLOSED
    times = f"{'> ' if stopped else ''}{theirs.seconds / ours.seconds:.1f}"
    gaps = ""
    if ours.gap is not None and theirs.gap is not None and ours.gap > GAP_CLOSED:
        gaps = f"{theirs.gap / ours.gap:.2f}"
    yield [*peer_cells(instance, theirs), times, gaps]


GAP_CLOSED = 1e-6
"""A gap up to this counts as closed in a comparison: CP-SAT's integers leave about as much."""


def peer_cells(instance: Instance, result: Result) -> Row:
    """Return part, objective, method, value, bound, gap, seconds."""
    return [instance.name, result.rules.objective, result.method, *figures(result)]


def figures(result: Result) -> Row:
    """Return value, bound, gap in % and seconds as text."""
    gap = "-" if result.gap is None else f"{100 * result.gap:.4f}"
    return [number(result.value), number(result.lower_bound), gap, f"{result.seconds:.2f}"]


def number(value: float | None) -> str:
    """Return a figure as text."""
    return "-" if value is None else f"{value:.4f}"


def structured(options: Options) -> Iterator[Row]:
    """Structured parts with certificates."""
    for kind in STRUCTURED:
        yield certified(part(kind, None, options), options.limit_s)


def sizes(options: Options) -> Iterator[Row]:
    """Large parts with certificates."""
    for holes, limit in SIZES:
        if not options.holes or holes in options.holes:
            yield certified(part("random", holes, options), options.limit_s or limit)


def certified(instance: Instance, limit_s: float | None) -> Row:
    """Solve with a certificate; the seconds contain writing it, and the verification is timed again."""
    warm_up("split", Rules(), instance)
    start = perf_counter()
    result = solve(instance, Rules(), method="split", time_limit=limit_s, certify=True)
    seconds = perf_counter() - start
    cells = [instance.name, str(len(instance.contours)), *figures(result)[:3], f"{seconds:.2f}"]
    if result.certificate is None:
        return [*cells, "no certificate", "-"]
    document = format_instance(instance)
    start = perf_counter()
    verdict = verify(result.certificate, document)
    checked = f"{perf_counter() - start:.2f}"
    return [*cells, "-" if verdict.gap is None else f"{100 * float(verdict.gap):.4f}", checked]


PEER_COLUMNS = (
    "part",
    "objective",
    "method",
    "value",
    "bound",
    "gap %",
    "seconds",
    "times slower",
    "gap ratio",
)
PROOF_COLUMNS = ("part", "holes", "value", "bound", "gap %", "seconds", "proved gap %", "verify s")
BENCHMARKS: dict[str, tuple[tuple[str, ...], Callable[[Options], Iterator[Row]]]] = {
    "non-overlap": (PEER_COLUMNS, non_overlap),
    "overlap": (PEER_COLUMNS, overlap),
    "structured": (PROOF_COLUMNS, structured),
    "sizes": (PROOF_COLUMNS, sizes),
}
"""Columns and rows of each benchmark."""


def print_rows(title: str, columns: Sequence[str], rows: Iterable[Row]) -> None:
    """Print rows as they come on stderr, and the whole table on stdout."""
    table = Table(title=title)
    for column in columns:
        left = column in ("part", "instance", "objective", "method", "published")
        table.add_column(column, justify="left" if left else "right")
    for row in rows:
        table.add_row(*row)
        print("  ".join(row), file=sys.stderr, flush=True)
    console = Console()
    # A file has no width of its own.
    (console if console.is_terminal else Console(width=160)).print(table)


def main(arguments: list[str] | None = None) -> int:
    """Run the benchmark that the command line names, and print its table."""
    parser = argparse.ArgumentParser(prog="python -m cutgap.benchmark.peers", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("name", choices=list(BENCHMARKS))
    parser.add_argument("--default-machine", action="store_true", help="default speeds, not 500 and 50 mm/s")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--holes", type=int, nargs="+", default=[], help="only these numbers of holes")
    parser.add_argument("--limit", type=float, default=None, help="time limit in s")
    given = parser.parse_args(arguments)
    machine = Machine() if given.default_machine else FAST
    columns, rows = BENCHMARKS[given.name]
    found = rows(Options(machine, given.seed, tuple(given.holes), given.limit))
    print_rows(f"{given.name}, seed {given.seed}", columns, found)
    return 0


if __name__ == "__main__":
    sys.exit(main())
