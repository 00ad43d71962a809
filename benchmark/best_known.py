"""Published values of public instances, to stand next to ours in a gap table.

``best_known.csv`` has one row for each instance and method. The suite is the one that ``find_suite`` reads the
instance with; an empty field is not published. Sources:

GTSPLIB
    Best known values, as collected since Fischetti, Salazar, Toth (1997), with lengths rounded as TSPLIB says.
Ural Federal University
    Laser nests of a CAM system: the heuristic PCGLNS (2.5 to 5 s), and Gurobi 9.0.1 on 8 threads, started from
    its plan and stopped after 70 000 s. Of the nest 34 only the heuristic's value is published.
"""

import csv
import io
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from cutgap.instances import Instance


@dataclass(frozen=True, slots=True)
class PublishedRun:
    """One row of the table; values and bounds in mm of travel.

    Attributes
    ----------
    sets, nodes
        Size of the instance, home included.
    lower_bound, seconds
        ``None`` when not published.
    """

    suite: str
    instance: str
    sets: int
    nodes: int
    method: str
    value: float
    lower_bound: float | None
    seconds: float | None
    source: str


@dataclass(frozen=True, slots=True)
class BestKnown:
    """The best that is published about an instance: least value, and greatest bound if any, with sources."""

    value: float
    lower_bound: float | None
    sources: tuple[str, ...]


@cache
def published_runs() -> tuple[PublishedRun, ...]:
    """Return all published runs."""
    text = files("cutgap.benchmark").joinpath("best_known.csv").read_text(encoding="utf-8")
    return tuple(
        PublishedRun(
            suite=row["suite"],
            instance=row["instance"],
            sets=int(row["sets"]),
            nodes=int(row["nodes"]),
            method=row["method"],
            value=float(row["value"]),
            lower_bound=float(row["lower_bound"]) if row["lower_bound"] else None,
            seconds=float(row["seconds"]) if row["seconds"] else None,
            source=row["source"],
        )
        for row in csv.DictReader(io.StringIO(text))
    )


def best_known(suite: str, instances: Iterable[Instance]) -> dict[str, BestKnown]:
    """Return what is published about instances of a suite, by name; their size tells namesakes apart."""
    runs: dict[tuple[str, int, int], list[PublishedRun]] = defaultdict(list)
    for run in published_runs():
        if run.suite == suite:
            runs[run.instance, run.sets, run.nodes].append(run)
    found: dict[str, BestKnown] = {}
    for instance in instances:
        homes = sum(head.home is not None for head in instance.heads)
        group = runs.get((instance.name, len(instance.contours) + homes, instance.node_count))
        if group:
            found[instance.name] = BestKnown(
                value=min(run.value for run in group),
                lower_bound=max((b for run in group if (b := run.lower_bound) is not None), default=None),
                sources=tuple(f"{run.method} ({run.source})" for run in group),
            )
    return found
