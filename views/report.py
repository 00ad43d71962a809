"""The report: one self-contained HTML page with table, plans, gap distributions and definitions.

Without scripts it is plain tables and pictures; with them tables are sorted, rows filtered and plans compared.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from string import Template

from cutgap.benchmark.folder import CERTIFICATES, INSTANCES
from cutgap.benchmark.methods import is_exact
from cutgap.benchmark.records import Record
from cutgap.benchmark.runner import Failure
from cutgap.benchmark.table import Summary, TableRow, summarise
from cutgap.benchmark.trade_off import slack
from cutgap.benchmark.wording import describe_all, question
from cutgap.instances import Instance, Rules
from cutgap.views.charts import gap_figure
from cutgap.views.columns import (
    Column,
    columns,
    percent,
    seconds,
    several,
    summary_headings,
    summary_name,
    summary_rows,
)
from cutgap.views.pages import definition, html_table, text_class, view_text
from cutgap.views.report_plans import by_part, data_attributes, drawn_plans, plan_id, plans
from cutgap.views.svg import inline_svg, page_style

MOST_WARNINGS = 4
"""Failures that are in sight; more stand behind a click."""


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
    count = "1 part" if len(instances) == 1 else f"{len(instances)} parts"
    return template.substitute(
        style=view_text("page.css") + view_text("report.css"),
        title=escape(f"Optimality gaps: {run.suite}"),
        lead=escape(f"{count}; asked for: {describe_all(run.rules, run.heads)}."),
        warnings=_warnings(run, records, failures),
        cards=_cards(run, records, rows, summaries),
        summary_table=html_table(summary_headings(summaries), [summary_rows(summaries)]),
        gap_plot=_gap_plot(summaries),
        table=_part_table(shown, rows, records, drawn_plans(rows, instances)),
        plans=plans(rows, instances),
        certificates=_certificates(records),
        definitions="\n".join(definition(column.heading, column.definition) for column in shown),
        provenance="\n".join(definition(*pair) for pair in _provenance(run, records, rows)),
        script=view_text("report.js"),
    )


def _warnings(run: Run, records: Sequence[Record], failures: Sequence[Failure]) -> str:
    lines = [f"Failed: {failure}" for failure in failures]
    if len(records) + len(failures) < run.planned:
        lines.insert(0, f"Stopped early: {len(records)} of {run.planned} runs are finished.")
    said = [f'<p class="warn">{escape(line)}</p>' for line in lines]
    rest = said[MOST_WARNINGS:]
    if rest:
        said[MOST_WARNINGS:] = [
            f'<details><summary class="warn">{len(rest)} more</summary>{"".join(rest)}</details>'
        ]
    return "\n".join(said)


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


def _part_table(
    shown: Sequence[Column], rows: Sequence[TableRow], records: Sequence[Record], drawn: set[str]
) -> str:
    head = "".join(f"<th{text_class(column.heading)}>{escape(column.heading)}</th>" for column in shown)
    bodies = []
    for group in by_part(rows):
        lines = []
        for row in group:
            kind = ' class="best"' if row.gap == 0 else ""
            plan = f' data-plan="{plan_id(row)}"' if plan_id(row) in drawn else ""
            proof = _proof(row, records)
            cells = "".join(f"<td{text_class(c.heading)}>{_cell(c, row, proof)}</td>" for c in shown)
            lines.append(f"<tr{kind}{data_attributes(row)}{plan}>{cells}</tr>")
            if row.note:
                note = f'<td colspan="{len(shown)}">{escape(row.note)}</td>'
                lines.append(f'<tr class="note"{data_attributes(row)}>{note}</tr>')
        bodies.append("<tbody>" + "\n".join(lines) + "</tbody>")
    return f'<table id="parts"><thead><tr>{head}</tr></thead>{"".join(bodies)}</table>'


def _cell(column: Column, row: TableRow, proof: str | None) -> str:
    text = escape(column.cell(row))
    if proof is None or column.heading not in ("bound", f"{row.rules.objective} bound"):
        return text
    # Beside a figure stands what other rules prove of it too, which may be more than this certificate proves.
    beside = {"travel bound": row.travel, "peak bound": row.peak}.get(column.heading)
    least, known = (beside and beside.lower_bound) or 0.0, row.lower_bound or 0.0
    return text if least > known + slack(known) else _link(proof, text)


def _link(certificate: str, text: str) -> str:
    return f'<a href="{CERTIFICATES}/{escape(certificate)}">{text}</a>'


def _proof(row: TableRow, records: Sequence[Record]) -> str | None:
    """Return the certificate that proves the bound of a row, whichever run it comes from."""
    if row.lower_bound is None:
        return None
    least = row.lower_bound - slack(row.lower_bound)
    return next(
        (
            each.certificate
            for each in records
            if each.certificate is not None
            and (each.instance_hash, each.result.rules) == (row.best.instance_hash, row.rules)
            and (each.result.lower_bound or 0.0) >= least
        ),
        None,
    )


def _certificates(records: Sequence[Record]) -> str:
    """List the certificates, each with the command that proves its bound again."""
    proofs = [(each, each.certificate) for each in records if each.certificate is not None]
    if not proofs:
        return "<p>No run left a certificate: a bound, where there is one, is a solver's claim.</p>"
    several_asked = len({question(each.result.rules) for each, _ in proofs}) > 1
    items = []
    for each, name in proofs:
        result = each.result
        asked = f" ({question(result.rules)})" if several_asked else ""
        known = "" if result.lower_bound is None else f": {result.lower_bound:.2f} {result.rules.unit}"
        text = escape(f"{each.instance}, {result.method}{asked}{known}")
        command = f"cutgap verify {CERTIFICATES}/{name} {INSTANCES}/{each.instance_hash}.json"
        items.append(f"<li>{_link(name, text)}<code>{escape(command)}</code></li>")
    lead = (
        "In the folder of this page, each command proves a bound again in exact arithmetic, without a solver."
    )
    return f'<p>{lead}</p><ul class="proofs">{"".join(items)}</ul>'


def _gap_plot(summaries: Sequence[Summary]) -> str:
    if not any(summary.gaps for summary in summaries):
        return "<p>No gap is known: no method proved a bound.</p>"
    with page_style("gaps"):
        figure = gap_figure([(summary_name(each, summaries), each.gaps) for each in summaries])
        svg = inline_svg(figure, "gap of each run, by method")
    caption = (
        "Gap: (value - bound) / value, of temperatures both above the ambient. "
        "Dot: a run with an allowed plan; diamond: their mean; line: from the least gap to the largest."
    )
    return f"<figure>{svg}<figcaption>{caption}</figcaption></figure>"


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
