"""Tables and pictures that pages of the documentation show; figures are read from records of runs."""

import base64
import html
import io
from collections.abc import Iterable, Sequence

from IPython.display import HTML, Markdown

from cutgap.benchmark.records import Record
from cutgap.benchmark.table import gap_table
from cutgap.instances import Instance, Plan
from cutgap.views.plots import plan_figure


def table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> Markdown:
    """Return a table in Markdown; numbers are set to the right."""
    lines = [list(map(str, row)) for row in rows]
    numeric = [bool(lines) and all(_is_number(line[i]) for line in lines) for i in range(len(header))]
    rule = ["--:" if each else "---" for each in numeric]
    return Markdown("\n".join("| " + " | ".join(line) + " |" for line in [list(header), rule, *lines]))


def gaps(records: Iterable[Record]) -> Markdown:
    """Return the gap table of ``cutgap gaps``: ``=`` marks an optimum whose certificate was verified."""
    return table(
        ["part", "N", "method", "runs", "value", "bound", "gap %", "mean gap %", "mean s"],
        [
            (
                row.instance,
                row.contours,
                row.method,
                row.runs,
                _figure(row.value, 2),
                _bound(row.lower_bound, row.proved and row.certified, row.certified),
                _figure(row.gap, 3, 100),
                _figure(row.mean_gap, 3, 100),
                _figure(row.seconds, 2),
            )
            for row in gap_table(records)
        ],
    )


def plan(instance: Instance, plan: Plan | None, title: str) -> HTML:
    """Return the picture of a plan, with its title for those who do not see it."""
    image = io.BytesIO()
    plan_figure(instance, plan, title=title).savefig(image, format="png", dpi=130)
    data = base64.b64encode(image.getvalue()).decode("ascii")
    return HTML(
        f'<img class="plan-picture" alt="Plan: {html.escape(title)}" src="data:image/png;base64,{data}">'
    )


def _bound(value: float | None, proved: bool, certified: bool) -> str:
    if value is None:
        return "-"
    return f"{'= ' if proved else ''}{value:.2f}{'' if certified else ' claimed'}"


def _figure(value: float | None, digits: int, factor: float = 1.0) -> str:
    return "-" if value is None else f"{factor * value:.{digits}f}"


def _is_number(text: str) -> bool:
    return text == "-" or text.lstrip("=<> ").replace(".", "", 1).replace("-", "", 1).isdigit()
