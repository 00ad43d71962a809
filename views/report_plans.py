"""The report's plans: one figure for each row with a plan, with value, bound and gap beside the drawing."""

from collections.abc import Mapping, Sequence
from html import escape
from itertools import groupby

from cutgap.benchmark.table import TableRow
from cutgap.benchmark.wording import question
from cutgap.instances import Instance
from cutgap.views.columns import NOTHING, bound, number, percent, row_name
from cutgap.views.pages import definition
from cutgap.views.plan_svg import Sheet, plan_svg, sheet_of, sheet_svg

DRAWN_PARTS = 12
"""Parts whose plans are drawn; a page with the plans of hundreds would not open on a phone."""


def by_part(rows: Sequence[TableRow]) -> list[list[TableRow]]:
    """Return the rows of each part."""
    return [list(group) for _, group in groupby(rows, key=lambda row: row.best.instance_hash)]


def data_attributes(row: TableRow) -> str:
    """Return what the page's filters ask of a row or a plan."""
    fields = {"part": row.instance, "method": row.method, "asked": question(row.rules)}
    return "".join(f' data-{name}="{escape(text)}"' for name, text in fields.items())


def plan_id(row: TableRow) -> str:
    """Return the id of the figure of a row's plan."""
    return f"plan-{row.best.key}"


def drawn_plans(rows: Sequence[TableRow], instances: Mapping[str, Instance]) -> set[str]:
    """Return the ids of the plans that are drawn."""
    return {
        plan_id(row)
        for group in by_part(rows)[:DRAWN_PARTS]
        for row in group
        if row.best.result.plan is not None and instances[row.best.instance_hash].located
    }


def plans(rows: Sequence[TableRow], instances: Mapping[str, Instance]) -> str:
    """Return the figures of all parts that are drawn."""
    ids = drawn_plans(rows, instances)
    parts = by_part(rows)
    figures = [
        _part_plans(group, instances[group[0].best.instance_hash], f"sheet-{place}", ids)
        for place, group in enumerate(parts[:DRAWN_PARTS])
    ]
    few = f"<p>The first {DRAWN_PARTS} of {len(parts)} parts are drawn.</p>" if len(parts) > DRAWN_PARTS else ""
    return few + '<div class="plans">' + "\n".join(figures) + "</div>"


def _part_plans(rows: Sequence[TableRow], instance: Instance, sheet_id: str, ids: set[str]) -> str:
    """Draw the plans of a part, the best one in sight and the others behind a click."""
    drawn = [row for row in rows if plan_id(row) in ids]
    if not drawn:
        return f"<p>{escape(instance.name)}: no plan to draw.</p>"
    # Values of different questions do not compare: the best of what is asked first is shown.
    asked = drawn[0].rules
    first = min(drawn, key=lambda row: (row.rules != asked, row.value is None, row.value or 0.0))
    sheet = sheet_of(instance, sheet_id)
    figures = [_plan_figure(row, rows, sheet) for row in drawn if row is not first]
    rest = ""
    if figures:
        names = ", ".join(row_name(row, rows) for row in drawn if row is not first)
        rest = (
            f"<details><summary>{escape(instance.name)}: {escape(names)}</summary>"
            f'<div class="plans">{"".join(figures)}</div></details>'
        )
    return f"<div>{sheet_svg(sheet)}{_plan_figure(first, rows, sheet)}{rest}</div>"


def _plan_figure(row: TableRow, rows: Sequence[TableRow], sheet: Sheet) -> str:
    plan = row.best.result.plan
    assert plan is not None
    title = f"{row.instance}, {row_name(row, rows)}"
    unit = row.rules.unit
    figures = [
        ("value", NOTHING if row.value is None else f"{number(row.value, 2)} {unit}"),
        ("bound", NOTHING if row.lower_bound is None else f"{bound(row)} {unit}"),
        ("gap", NOTHING if row.gap is None else f"{percent(row.gap)} %"),
    ]
    boxes = "".join(f"<div>{definition(*pair)}</div>" for pair in figures)
    note = f'<p class="warn">{escape(row.note)}</p>' if row.note else ""
    value = "" if row.value is None else f' data-value="{row.value:.10g}" data-unit="{unit}"'
    caption = f"<figcaption>{escape(title)}</figcaption>"
    drawing = plan_svg(sheet, plan, f"plan of {title}")
    attributes = f'class="plan" id="{plan_id(row)}"{data_attributes(row)}{value}'
    return f'<figure {attributes}>{caption}{drawing}<dl class="figures">{boxes}</dl>{note}</figure>'
