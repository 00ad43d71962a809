"""The command ``play``: a page to step through the run of an exact method."""

import json
import sys
from html import escape
from pathlib import Path
from string import Template
from typing import Annotated, Any

from cyclopts import Parameter

from cutgap.benchmark.methods import AUTO, require_known, run
from cutgap.benchmark.wording import describe
from cutgap.formulations import resolve
from cutgap.instances import Instance, Result, Rules
from cutgap.instances.formats import read_instance, write_atomically
from cutgap.instances.progress import Progress
from cutgap.views.options import (
    DEFAULT_RULES,
    FILE_MACHINE,
    File,
    MachineArguments,
    RuleOptions,
    TimeLimit,
    require_time_limit,
)
from cutgap.views.pages import view_text
from cutgap.views.progress import state_line, watch_run
from cutgap.views.recording import Recorder, names_of

PLAYABLE = ("tour", "gtsp", "free", "split", "contour-dp")
"""Methods that show what they do."""

SCRIPTS = ("player_picture.js", "player_charts.js", "player.js")


def play(
    file: File,
    /,
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"], help="Page to write (.html).")],
    rules: RuleOptions = DEFAULT_RULES,
    method: Annotated[str, Parameter(help=f"auto, or one of {', '.join(PLAYABLE)}.")] = AUTO,
    time_limit: TimeLimit = None,
    machine: MachineArguments = FILE_MACHINE,
) -> int:
    """Write a page, which needs no network, to step through the run of an exact method on one instance.

    With ``auto`` it is the method that ``solve`` begins with. After Ctrl-C the page shows the run until there.
    """
    _require_target(out)
    require_known(method)
    require_time_limit(time_limit)
    instance, asked = read_instance(file, machine.options()), rules.rules()
    if not instance.located:
        raise ValueError(
            f"{file}: it gives lengths but no coordinates, so there is nothing to draw; take solve"
        )
    chosen = resolve_playable(method, instance, asked)
    recorder = Recorder(instance)
    with watch_run(f"{instance.name}, {chosen}", asked.unit) as show:

        def watch(progress: Progress) -> None:
            recorder.watch(progress)
            show(progress)

        result = run(chosen, instance, asked, time_limit=time_limit, watch=watch)
    recorder.finish(result)
    page = player_html(instance, result, recorder)
    write_atomically(out, page)
    state = state_line(None if result.violations else result.value, result.lower_bound, asked.unit)
    print(f"{out}: {instance.name}, {result.method}, {result.status}, {state}")
    if result.reason:
        print(f"cutgap: {result.reason}", file=sys.stderr)
    return 0


def _require_target(out: Path) -> None:
    if out.suffix.lower() != ".html":
        raise ValueError(f"--out {out}: expected a name ending in .html")
    if not out.parent.is_dir():
        raise ValueError(f"{out}: the folder {out.parent} does not exist")


def resolve_playable(method: str, instance: Instance, rules: Rules) -> str:
    """Return the name of a method that shows what it does.

    Raises
    ------
    ValueError
        When the method, or the one that suits, shows nothing.
    """
    name = method if method not in (AUTO, *PLAYABLE) else resolve(method, instance, rules)
    if name not in PLAYABLE:
        why = f"the method {name}" if method != AUTO else f"the method that suits, {name},"
        raise ValueError(f"--method: {why} shows no steps; expected one of {', '.join(PLAYABLE)}")
    return name


def instance_fields(instance: Instance) -> dict[str, Any]:
    """Return what the page draws of an instance: places by node, contours with outlines, homes by head."""
    nodes = [[round(float(x), 2), round(float(y), 2)] for x, y in instance.points[:, :2]]
    sizes = [len(contour.entry_points) for contour in instance.contours]
    return {
        "nodes": nodes,
        "names": names_of(instance),
        "contours": [contour.id for contour in instance.contours],
        "contour_of": [index for index, size in enumerate(sizes) for _ in range(size)],
        "perimeters": [round(float(length), 1) for length in instance.perimeters],
        "outlines": [
            None if contour.geometry is None else contour.geometry.round(1).tolist()
            for contour in instance.contours
        ],
        "homes": [instance.home_node(head) for head in range(len(instance.heads))],
    }


def player_html(instance: Instance, result: Result, recorder: Recorder) -> str:
    """Return the page of a finished run."""
    document = {
        "name": instance.name,
        "method": result.method,
        "unit": result.rules.unit,
        "objective": result.rules.objective,
        "instance": instance_fields(instance),
        **recorder.document(),
    }
    # Within a script element only this would end it.
    data = json.dumps(document, separators=(",", ":"), ensure_ascii=False, allow_nan=False).replace(
        "<", "\\u003c"
    )
    asked = describe(result.rules, len(instance.heads))
    return Template(view_text("player.html")).substitute(
        title=escape(f"{instance.name}: {result.method}, step by step"),
        lead=escape(f"{len(instance.contours)} contours; {asked}."),
        style=view_text("page.css") + view_text("player.css"),
        data=data,
        script="".join(map(view_text, SCRIPTS)),
    )
