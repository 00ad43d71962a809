"""The command ``pareto``."""

import json as json_library
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from cutgap.benchmark.fronts import heuristic_front, require_heuristic
from cutgap.formulations.certify import proved_bound, proves
from cutgap.formulations.heat.exact import fits
from cutgap.formulations.heat.front import heat_front
from cutgap.formulations.pareto import pareto_front
from cutgap.instances import Instance, Result, Rules
from cutgap.instances.formats import read_instance, write_atomically
from cutgap.instances.heat import has_heat
from cutgap.views.figures import json_number
from cutgap.views.options import (
    DEFAULT_RULES,
    FILE_MACHINE,
    File,
    Json,
    MachineArguments,
    RuleOptions,
    Seed,
    TimeLimit,
    parse_names,
    require_picture_name,
    require_seed,
    require_time_limit,
)
from cutgap.views.progress import watch_run
from cutgap.views.tables import output

Against = Literal["imbalance", "peak"]
PEAK_COLUMNS = {
    "method": "method",
    "status": "status",
    "travel_mm": "travel [mm]",
    "peak_c": "peak [deg C]",
    "lower_bound_mm": "bound [mm]",
    "proof": "proof",
    "seconds": "time [s]",
}
IMBALANCE_COLUMNS = {
    "limit_s": "limit [s]",
    "status": "status",
    "travel_mm": "travel [mm]",
    "imbalance_s": "imbalance [s]",
    "makespan_s": "makespan [s]",
    "lower_bound_mm": "bound [mm]",
    "proof": "proof",
    "seconds": "time [s]",
}
WORDS = ("method", "status", "proof")
"""Columns that hold words."""


def pareto(
    file: File,
    /,
    *,
    against: Annotated[
        Against | None,
        Parameter(help="What travel is traded for; peak where the instance has a material and one head."),
    ] = None,
    limits: Annotated[
        str | None, Parameter(help="Limits on imbalance in s, commas between; by default spread out.")
    ] = None,
    points: Annotated[
        int, Parameter(help="Number of points, when no limits are given; small plates get all there are.")
    ] = 8,
    methods: Annotated[
        str | None, Parameter(help="Heuristics, commas between, whose plans are shown beside a front of peaks.")
    ] = None,
    seed: Seed = 0,
    rules: RuleOptions = DEFAULT_RULES,
    time_limit: TimeLimit = 60.0,
    certificates: Annotated[Path | None, Parameter(help="Folder for a proof of each point.")] = None,
    plot: Annotated[Path | None, Parameter(help="Picture of the front (.png, .svg, .pdf).")] = None,
    machine: MachineArguments = FILE_MACHINE,
    json: Json = False,
) -> int:
    """Show how much travel each limit on imbalance, or on peak temperature, costs, with proved bounds.

    The time limit is for each point; with peaks it is for the whole front.
    """
    require_time_limit(time_limit)
    require_seed(seed)
    if points < 2:
        raise ValueError(f"--points: expected at least 2, got {points}")
    if plot is not None:
        require_picture_name(plot)
    instance = read_instance(file, machine.options())
    chosen = against or ("peak" if has_heat(instance) and len(instance.heads) == 1 else "imbalance")
    names = parse_names(methods, "--methods")
    if chosen == "peak" and limits is not None:
        raise ValueError("--limits: are on imbalance; add --against imbalance, or leave them out")
    if chosen == "imbalance" and names:
        raise ValueError("--methods: heuristics are shown beside a front of peaks; add --against peak")
    for name in names:
        require_heuristic(name)
    asked = rules.rules()
    if chosen == "peak":
        results = _peak_front(instance, asked, points, time_limit, certificates is not None)
        others = [each for name in names for each in heuristic_front(name, instance, asked, seed, time_limit)]
    else:
        results, others = _imbalance_front(instance, asked, limits, points, time_limit), []
    if certificates is not None:
        _write_certificates(certificates, results)
    if plot is not None:
        _draw(instance, chosen, results, others, plot)
    rows = [_row(instance, result, chosen) for result in [*results, *others]]
    if json:
        print(json_library.dumps(rows, indent=2, allow_nan=False))
    else:
        _print(instance, rows, chosen)
    for result in results:
        if result.plan is None and result.reason:
            print(f"cutgap: {result.reason}", file=sys.stderr)
    return 0 if results and all(result.plan is not None for result in results) else 1


def _imbalance_front(
    instance: Instance, asked: Rules, limits: str | None, points: int, time_limit: float | None
) -> list[Result]:
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
    return results


def _peak_front(
    instance: Instance, asked: Rules, points: int, time_limit: float | None, certify: bool
) -> list[Result]:
    free = replace(asked, weight=0.0)
    with watch_run(f"{instance.name}, pareto", "mm") as watch:
        return heat_front(instance, free, points=points, time_limit=time_limit, certify=certify, watch=watch)


def _write_certificates(folder: Path, results: Sequence[Result]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for number, result in enumerate(results):
        if result.certificate is not None:
            text = json_library.dumps(result.certificate, separators=(",", ":"))
            write_atomically(folder / f"point-{number}.json", text)
    if results and not any(result.certificate is not None for result in results):
        print("cutgap: no certificate: the bounds of this front are the solver's claims", file=sys.stderr)


def _limit(text: str) -> float:
    try:
        return float(text)
    except ValueError as error:
        raise ValueError(f"--limits: expected numbers in s with commas between, got {text!r}") from error


def _row(instance: Instance, result: Result, against: Against) -> dict[str, object]:
    evaluation = result.evaluation
    figures: dict[str, object] = {
        "status": str(result.status),
        "travel_mm": None if evaluation is None else evaluation.total_travel_mm,
    }
    if against == "peak":
        figures = {"method": result.method, **figures}
        peak = None if evaluation is None else evaluation.peak_temperature_c
        figures["peak_c"] = None if peak is None else json_number(peak)
    else:
        figures = {"limit_s": result.rules.balance, **figures}
        figures["imbalance_s"] = None if evaluation is None else evaluation.imbalance_s
        figures["makespan_s"] = None if evaluation is None else evaluation.makespan_s
    return figures | {
        "lower_bound_mm": result.lower_bound,
        "certified": _is_certified(instance, result),
        "seconds": result.seconds,
    }


def _is_certified(instance: Instance, result: Result) -> bool:
    """Whether the certificate proves the bound, and not less."""
    proof = result.certificate
    return proof is not None and proves(proved_bound(proof, instance), result.lower_bound)


def _print(instance: Instance, rows: Sequence[dict[str, object]], against: Against) -> None:
    from rich.table import Table
    from rich.text import Text

    limit = "temperatures of start points" if against == "peak" else "imbalance"
    table = Table(title=Text(f"{instance.name}: least travel under a limit on {limit}"))
    columns = PEAK_COLUMNS if against == "peak" else IMBALANCE_COLUMNS
    for name, heading in columns.items():
        table.add_column(Text(heading), justify="left" if name in WORDS else "right")
    for row in rows:
        table.add_row(*[_cell(row, name) for name in columns])
    output().print(table)


def _cell(row: dict[str, object], name: str) -> str:
    if name == "proof":
        return "-" if row["lower_bound_mm"] is None else "certified" if row["certified"] else "claimed"
    value = row[name]
    if value is None:
        return "none" if name == "limit_s" else "-"
    return value if isinstance(value, str) else f"{value:.{3 if name == 'limit_s' else 2}f}"


def _draw(
    instance: Instance, against: Against, results: Sequence[Result], others: Sequence[Result], path: Path
) -> None:
    from cutgap.views.charts import front_figure, heat_front_figure
    from cutgap.views.plots import save

    if against == "peak":
        complete = fits(instance.first_node)
        save(heat_front_figure(instance.name, results, others, complete=complete), path)
    else:
        save(front_figure(instance.name, results), path)
