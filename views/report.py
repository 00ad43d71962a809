"""The report: one self-contained HTML page with table, plans, gap distributions and definitions."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from itertools import groupby
from string import Template

from cutgap.benchmark.methods import is_exact
from cutgap.benchmark.records import Record
from cutgap.benchmark.runner import Failure
from cutgap.benchmark.table import Summary, TableRow, summarise
from cutgap.benchmark.wording import describe_all
from cutgap.instances import Instance, Rules
from cutgap.views.charts import gap_figure
from cutgap.views.columns import (
    Column,
    columns,
    percent,
    row_name,
    seconds,
    several,
    summary_headings,
    summary_name,
    summary_rows,
)
from cutgap.views.pages import definition, html_table, text_class, view_text
from cutgap.views.plots import plan_figure
from cutgap.views.svg import inline_svg, page_style

DRAWN_PARTS = 12
"""Parts whose plans are drawn; a page with the plans of hundreds would not open on a phone."""


@dataclass(frozen=True, slots=True)
class Run:
    """What was run: suite, rules, methods, seeds, limit in s, runs planned, most heads of a part."""

    suite: str
    rules: tuple[Rules, ...]
    methods: tuple[str, ...]
    seeds: int
    time_limit: float | None
    planned: int
    heads: int = 2


def report_html(
    run: Run,
    records: Sequence[Record],
    rows: Sequence[TableRow],
    instances: Mapping[str, Instance],
    failures: Sequence[Failure] = (),
) -> str:
    """Return the page.

    Parameters
    ----------
    run
        What was asked for.
    records, rows
        What is finished, and the table made of it.
    instances
        By hash; their plans are drawn.
    failures
        Runs that raised an error.
    """
    template = Template(view_text("report.html"))
    shown = columns(rows)
    summaries = summarise(rows)
    return template.substitute(
        style=view_text("page.css"),
        title=escape(f"Optimality gaps: {run.suite}"),
        lead=escape(f"{len(instances)} parts; asked for: {describe_all(run.rules, run.heads)}."),
        warnings=_warnings(run, records, failures),
        cards=_cards(run, records, rows, summaries),
        summary_table=html_table(summary_headings(summaries), [summary_rows(summaries)]),
        gap_plot=_gap_plot(summaries),
        table=_part_table(shown, rows),
        plans=_plans(rows, instances),
        definitions="\n".join(definition(column.heading, column.definition) for column in shown),
        provenance="\n".join(definition(*pair) for pair in _provenance(run, records, rows)),
    )


def _warnings(run: Run, records: Sequence[Record], failures: Sequence[Failure]) -> str:
    lines = [f"Failed: {failure}" for failure in failures]
    if len(records) + len(failures) < run.planned:
        lines.append(f"Stopped early: {len(records)} of {run.planned} runs are finished.")
    return "\n".join(f'<p class="warn">{escape(line)}</p>' for line in lines)


def _cards(run: Run, records: Sequence[Record], rows: Sequence[TableRow], summaries: Sequence[Summary]) -> str:
    parts = {(row.best.instance_hash, row.rules) for row in rows}
    proved = {(row.best.instance_hash, row.rules) for row in rows if row.proved}
    plans = [record for record in records if record.result.plan is not None]
    broken = sum(bool(record.result.violations) for record in plans)
    cards = [
        (f"{len(proved)} of {len(parts)}", f"{'problems' if several(rows) else 'parts'} with a proven optimum")
    ]
    heuristics = [
        (mean, each) for each in summaries if not is_exact(each.method) and (mean := each.spread[1]) is not None
    ]
    if heuristics:
        mean, best = min(heuristics, key=lambda pair: pair[0])
        name = summary_name(best, summaries)
        cards.append((f"{percent(mean)} %", f"mean gap of {name}, the least of the heuristics"))
        mean, worst = max(heuristics, key=lambda pair: pair[0])
        if worst is not best:
            name = summary_name(worst, summaries)
            cards.append((f"{percent(mean)} %", f"mean gap of {name}, the largest"))
    cards.append((str(len(plans)), f"plans checked, of which {broken} break a rule"))
    total = sum(record.result.seconds for record in records)
    cards.append((f"{seconds(total)} s", f"in {len(records)} of {run.planned} runs"))
    return "\n".join(
        f'<div class="card"><b>{escape(figure)}</b><span>{escape(text)}</span></div>' for figure, text in cards
    )


def _part_table(shown: Sequence[Column], rows: Sequence[TableRow]) -> str:
    head = "".join(f"<th{text_class(column.heading)}>{escape(column.heading)}</th>" for column in shown)
    bodies = []
    for _, group in groupby(rows, key=lambda row: row.best.instance_hash):
        lines = []
        for row in group:
            kind = ' class="best"' if row.gap == 0 else ""
            cells = "".join(f"<td{text_class(c.heading)}>{escape(c.cell(row))}</td>" for c in shown)
            lines.append(f"<tr{kind}>{cells}</tr>")
            if row.note:
                lines.append(f'<tr class="note"><td colspan="{len(shown)}">{escape(row.note)}</td></tr>')
        bodies.append("<tbody>" + "\n".join(lines) + "</tbody>")
    return f"<table><thead><tr>{head}</tr></thead>{''.join(bodies)}</table>"


def _gap_plot(summaries: Sequence[Summary]) -> str:
    if not any(summary.gaps for summary in summaries):
        return "<p>No gap is known: no method proved a bound.</p>"
    with page_style("gaps"):
        figure = gap_figure([(summary_name(each, summaries), each.gaps) for each in summaries])
        svg = inline_svg(figure, "gap of each run, by method")
    caption = "A dot for each run with an allowed plan; box: quartiles and median; whiskers: 1.5 box lengths."
    return f"<figure>{svg}<figcaption>{caption}</figcaption></figure>"


def _plans(rows: Sequence[TableRow], instances: Mapping[str, Instance]) -> str:
    parts = [list(group) for _, group in groupby(rows, key=lambda row: row.best.instance_hash)]
    blocks = [_part_plans(group, instances) for group in parts[:DRAWN_PARTS]]
    if len(parts) > DRAWN_PARTS:
        blocks.insert(0, f"<p>The first {DRAWN_PARTS} of {len(parts)} parts are drawn.</p>")
    return "\n".join(blocks)


def _part_plans(rows: Sequence[TableRow], instances: Mapping[str, Instance]) -> str:
    """Draw the plans of a part, the best one in sight and the others behind a click."""
    instance = instances[rows[0].best.instance_hash]
    drawn = [row for row in rows if row.best.result.plan is not None] if instance.located else []
    if not drawn:
        return f"<p>{escape(instance.name)}: no plan to draw.</p>"
    # Values of different questions do not compare: the best of what is asked first is shown.
    asked = drawn[0].rules
    first = min(drawn, key=lambda row: (row.rules != asked, row.value is None, row.value or 0.0))
    others = [_plan_figure(row, instance, rows) for row in drawn if row is not first]
    rest = ""
    if others:
        names = ", ".join(row_name(row, rows) for row in drawn if row is not first)
        rest = (
            f"<details><summary>{escape(instance.name)}: {escape(names)}</summary>"
            f'<div class="plans">{"".join(others)}</div></details>'
        )
    return _plan_figure(first, instance, rows) + rest


def _plan_figure(row: TableRow, instance: Instance, rows: Sequence[TableRow]) -> str:
    result = row.best.result
    name = f"{row.instance}, {row_name(row, rows)}"
    with page_style(row.best.key):
        figure = plan_figure(instance, result.plan, via_points=result.rules.via_points, title=name)
        svg = inline_svg(figure, f"plan of {escape(name)}")
    return f"<figure>{svg}<figcaption>{escape(_plan_caption(row))}</figcaption></figure>"


def _plan_caption(row: TableRow) -> str:
    if row.note:
        return row.note
    text = f"{row.rules.objective} {row.value:.2f} {row.rules.unit}"
    if row.gap is None:
        return f"{text}, no bound"
    return f"{text}, proven optimum" if row.gap == 0 else f"{text}, gap {percent(row.gap)} %"


def _provenance(run: Run, records: Sequence[Record], rows: Sequence[TableRow]) -> list[tuple[str, str]]:
    """Return what is needed to make the page again; nothing of it tells of a machine but the times."""
    versions: dict[str, set[str]] = {}
    for record in records:
        for name, version in record.versions.items():
            versions.setdefault(name, set()).add(version)
    limit = "none" if run.time_limit is None else f"{run.time_limit:g} s a run"
    names = {record.instance_hash: record.instance for record in records}
    sources = sorted({source for row in rows if row.published is not None for source in row.published.sources})
    return [
        ("Suite", run.suite),
        ("Rules", describe_all(run.rules, run.heads)),
        ("Methods", ", ".join(run.methods)),
        ("Seeds", f"0 to {run.seeds - 1} for each heuristic; exact methods do not depend on the seed"),
        ("Time limit", limit),
        ("Figures", "Recomputed from instance and plan alone; each plan was checked against every rule."),
        ("Gaps", "Against the best bound proved by an exact method for the same instance and rules."),
        *([("Published values", ", ".join(sources))] if sources else []),
        ("Versions", ", ".join(f"{name} {' / '.join(sorted(found))}" for name, found in versions.items())),
        ("Instances (hash of the content)", ", ".join(f"{name} {key}" for key, name in names.items())),
    ]
