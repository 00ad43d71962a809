"""The command ``pareto``."""

import json as json_library
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cutgap.formulations.pareto import pareto_front
from cutgap.instances import Instance, Result
from cutgap.instances.formats import read_instance, write_atomically
from cutgap.views.options import (
    DEFAULT_RULES,
    FILE_MACHINE,
    File,
    Json,
    MachineArguments,
    RuleOptions,
    TimeLimit,
    require_picture_name,
    require_time_limit,
)
from cutgap.views.progress import watch_run
from cutgap.views.tables import output

HEADINGS = (
    "limit [s]",
    "status",
    "travel [mm]",
    "imbalance [s]",
    "makespan [s]",
    "bound [mm]",
    "proof",
    "time [s]",
)


def pareto(
    file: File,
    /,
    *,
    limits: Annotated[
        str | None, Parameter(help="Limits on imbalance in s, commas between; by default spread out.")
    ] = None,
    points: Annotated[int, Parameter(help="Number of points, when no limits are given.")] = 8,
    rules: RuleOptions = DEFAULT_RULES,
    time_limit: TimeLimit = 60.0,
    certificates: Annotated[Path | None, Parameter(help="Folder for a proof of each point.")] = None,
    plot: Annotated[Path | None, Parameter(help="Picture of the front (.png, .svg, .pdf).")] = None,
    machine: MachineArguments = FILE_MACHINE,
    json: Json = False,
) -> int:
    """Show how much travel each limit on imbalance costs, every point with its proved bound.

    The time limit is for each point.
    """
    require_time_limit(time_limit)
    if points < 2:
        raise ValueError(f"--points: expected at least 2, got {points}")
    if plot is not None:
        require_picture_name(plot)
    instance = read_instance(file, machine.options())
    asked = rules.rules()
    chosen = None if limits is None else [_limit(text) for text in limits.split(",")]
    results: list[Result] = []
    try:
        with watch_run(f"{instance.name}, pareto", "mm") as watch:
            for result in pareto_front(
                instance, asked, limits=chosen, points=points, time_limit=time_limit, watch=watch
            ):
                results.append(result)
    except KeyboardInterrupt:
        pass  # the points that are done are shown
    if certificates is not None:
        certificates.mkdir(parents=True, exist_ok=True)
        for number, result in enumerate(results):
            if result.certificate is not None:
                text = json_library.dumps(result.certificate, separators=(",", ":"))
                write_atomically(certificates / f"point-{number}.json", text)
    if plot is not None:
        _draw(instance, results, plot)
    rows = [_row(result) for result in results]
    if json:
        print(json_library.dumps(rows, indent=2, allow_nan=False))
    else:
        _print(instance, rows)
    return 0 if results and all(result.plan is not None for result in results) else 1


def _limit(text: str) -> float:
    try:
        return float(text)
    except ValueError as error:
        raise ValueError(f"--limits: expected numbers in s with commas between, got {text!r}") from error


def _row(result: Result) -> dict[str, object]:
    evaluation = result.evaluation
    return {
        "limit_s": result.rules.balance,
        "status": str(result.status),
        "travel_mm": None if evaluation is None else evaluation.total_travel_mm,
        "imbalance_s": None if evaluation is None else evaluation.imbalance_s,
        "makespan_s": None if evaluation is None else evaluation.makespan_s,
        "lower_bound_mm": result.lower_bound,
        "certified": result.certificate is not None,
        "seconds": result.seconds,
    }


def _print(instance: Instance, rows: list[dict[str, object]]) -> None:
    from rich.table import Table

    table = Table(title=f"{instance.name}: least travel under a limit on imbalance")
    for heading in HEADINGS:
        table.add_column(heading, justify="left" if heading in ("status", "proof") else "right")
    for row in rows:
        names = ("travel_mm", "imbalance_s", "makespan_s", "lower_bound_mm")
        figures = ["-" if row[name] is None else f"{row[name]:.2f}" for name in names]
        limit = "none" if row["limit_s"] is None else f"{row['limit_s']:.3f}"
        proof = "certified" if row["certified"] else "claimed"
        table.add_row(limit, str(row["status"]), *figures, proof, f"{row['seconds']:.2f}")
    output().print(table)


def _draw(instance: Instance, results: list[Result], path: Path) -> None:
    from cutgap.views.charts import front_figure
    from cutgap.views.plots import save

    save(front_figure(instance.name, results), path)
