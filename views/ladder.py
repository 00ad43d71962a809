"""The command ``ladder``."""

import csv
import io
import json as json_library
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cutgap.benchmark.wording import describe
from cutgap.formulations.rungs import Rung, optimum, require_rungs
from cutgap.formulations.rungs import ladder as climb
from cutgap.instances import Instance, Result, Rules
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

COLUMNS = (
    "formulation",
    "kind",
    "variables",
    "constraints",
    "nonzeros",
    "bound",
    "gap_percent",
    "seconds",
    "proof",
)
CERTIFIED, CLAIMED = "certified", "claimed"


def ladder(
    file: File,
    /,
    *,
    rules: RuleOptions = DEFAULT_RULES,
    formulations: Annotated[
        str | None, Parameter(help="Relaxations, commas between; by default all that there are.")
    ] = None,
    time_limit: TimeLimit = 60.0,
    out: Annotated[Path | None, Parameter(help="File for the table (.csv).")] = None,
    certificates: Annotated[Path | None, Parameter(help="Folder for a proof of each bound.")] = None,
    plot: Annotated[Path | None, Parameter(help="Picture of the ladder (.png, .svg, .pdf).")] = None,
    machine: MachineArguments = FILE_MACHINE,
    json: Json = False,
) -> int:
    """Show the bounds of all formulations on one instance, side by side.

    The time limit is for each of them. The gap is that to the best plan known, the optimum where it is proved.
    Ctrl-C shows what is there.
    """
    require_time_limit(time_limit)
    names = None if formulations is None else [name.strip() for name in formulations.split(",")]
    require_rungs(names or [])
    _require_targets(out, plot)
    instance = read_instance(file, machine.options())
    asked = rules.rules()
    best, rungs = _climb(instance, asked, names, time_limit)
    rows = [_row(rung, best) for rung in rungs]
    if out is not None:
        write_atomically(out, _csv(rows))
    if certificates is not None:
        _write_certificates(certificates, rungs)
    if plot is not None:
        _draw(instance, best, rungs, plot)
    if json:
        print(json_library.dumps(_document(best, rungs, rows), indent=2, allow_nan=False))
    else:
        _print(instance, best, rows)
    for rung in rungs:
        if rung.note is not None:
            print(f"cutgap: {rung.formulation}: {rung.note}", file=sys.stderr)
    return 0 if any(rung.bound is not None for rung in rungs) else 1


def _require_targets(out: Path | None, plot: Path | None) -> None:
    """Refuse names that cannot be written before the work, not after it."""
    if out is not None and out.suffix.lower() != ".csv":
        raise ValueError(f"--out {out}: expected a name ending in .csv")
    if plot is not None:
        require_picture_name(plot)
    for path in (out, plot):
        if path is not None and not path.parent.is_dir():
            raise ValueError(f"{path}: the folder {path.parent} does not exist")


def _climb(
    instance: Instance, rules: Rules, names: Sequence[str] | None, time_limit: float | None
) -> tuple[Result | None, list[Rung]]:
    """Return the exact method's result, ``None`` when stopped before, and the rungs, lowest bound first."""
    best, exact, rungs = None, None, []
    try:
        with watch_run(f"{instance.name}, ladder", rules.unit) as watch:
            best, exact = optimum(instance, rules, time_limit=time_limit, watch=watch)
            for rung in climb(instance, rules, names=names, time_limit=time_limit, watch=watch):
                rungs.append(rung)
    except KeyboardInterrupt:
        pass  # the rungs that are done are shown
    rungs.sort(key=lambda rung: -1.0 if rung.bound is None else rung.bound)
    return best, rungs if exact is None else [*rungs, exact]


def _row(rung: Rung, best: Result | None) -> dict[str, object]:
    value = None if best is None or best.violations else best.value
    gap = rung.gap(value)
    proof = "" if rung.bound is None else CLAIMED if rung.certificate is None else CERTIFIED
    return {
        "formulation": rung.formulation,
        "kind": rung.kind,
        "variables": rung.variables,
        "constraints": rung.constraints,
        "nonzeros": rung.nonzeros,
        "bound": rung.bound,
        "gap_percent": None if gap is None else 100 * gap,
        "seconds": rung.seconds,
        "proof": proof,
    }


def _csv(rows: Sequence[dict[str, object]]) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _document(
    best: Result | None, rungs: Sequence[Rung], rows: Sequence[dict[str, object]]
) -> dict[str, object]:
    return {
        "status": None if best is None else str(best.status),
        "value": None if best is None or best.violations else best.value,
        "unit": None if best is None else best.rules.unit,
        "rungs": [row | {"note": rung.note} for rung, row in zip(rungs, rows, strict=True)],
    }


def _write_certificates(folder: Path, rungs: Sequence[Rung]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for rung in rungs:
        if rung.certificate is not None:
            text = json_library.dumps(rung.certificate, separators=(",", ":"))
            write_atomically(folder / f"{rung.formulation}.json", text)


def _print(instance: Instance, best: Result | None, rows: Sequence[dict[str, object]]) -> None:
    from rich.table import Table
    from rich.text import Text

    title = f"{instance.name}: bounds"
    if best is not None:
        title = f"{instance.name}: {describe(best.rules, len(instance.heads))} [{best.rules.unit}]"
    table = Table(title=Text(title), title_justify="left")
    for column in COLUMNS:
        words = {"gap_percent": "gap [%]", "seconds": "time [s]"}.get(column, column)
        table.add_column(Text(words), justify="left" if column in ("formulation", "kind", "proof") else "right")
    # Why the others have no bound is said below the table.
    for row in rows:
        if row["bound"] is not None:
            table.add_row(*[_cell(column, row[column]) for column in COLUMNS])
    output().print(table)
    if best is not None and best.value is not None and not best.violations:
        print(f"best plan {best.value:.3f} {best.rules.unit}, {best.status}")


def _cell(column: str, value: object) -> str:
    if value is None:
        return "-"
    digits = {"bound": 3, "gap_percent": 3, "seconds": 2}.get(column)
    return str(value) if digits is None else f"{value:.{digits}f}"


def _draw(instance: Instance, best: Result | None, rungs: Sequence[Rung], path: Path) -> None:
    from cutgap.views.bound_plot import ladder_figure
    from cutgap.views.plots import save  # slow to load, and seldom asked for

    value = None if best is None or best.violations else best.value
    unit = "" if best is None else best.rules.unit
    save(ladder_figure(instance.name, rungs, value, unit), path)
