"""The audit as people see it: tables on the terminal, and one self-contained HTML page with a plot."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from itertools import groupby
from string import Template

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from rich.table import Table
from rich.text import Text

from cutgap.benchmark.audit import UNITS, AuditRow, Overall, balance_of_optima, overall
from cutgap.benchmark.published import published_table
from cutgap.benchmark.records import Record
from cutgap.benchmark.runner import Failure
from cutgap.benchmark.wording import describe
from cutgap.instances import Rules
from cutgap.views.pages import definition, html_table, view_text
from cutgap.views.plots import HEAD_COLOURS, PAGE_WIDTH, UNCUT
from cutgap.views.svg import inline_svg, page_style
from cutgap.views.tables import output

LIMITS = (
    "The published coordinates are missing. Each published part is one draw from the same ranges, so a rank or "
    "a gap for one size says little; only what all sizes share is evidence.",
    "A gap here is implied, not proved: the optimum of the published part itself is not known.",
    "v_jump = 150 mm/s follows from the table to 0.4 %; v_cut = 40 mm/s and t_aux = 1 s are a loose estimate. "
    "Least travel does not depend on them; makespan does, makespan at equal work hardly.",
    "Via points are modelled as: each head cuts the leftmost hole of its range first. Whether every published "
    "plan keeps this is not known, so both models are shown.",
    "The optima keep the heads' ranges apart (partition gap at least 0). Published plans with overlap (marked "
    "*) are free of this limit and can lie below such an optimum.",
    "Published task balancing also asks for an imbalance of at most 0.5 s where it can, which the optima need "
    "not keep. A limit can only raise the optimum: a part of its implied gap may be the price of balance.",
    "The travel of a plan of least makespan is what that plan happens to travel, no lower limit. Least travel "
    "(option --travel) is one, but has no regard for balance: one head can get most of the work.",
)
"""What the comparison cannot show."""
CAN_SHOW = (
    "The published figures among the optima of parts that are drawn alike: how far from the optimum the "
    "published methods are on average, within the errors given."
)
MARKERS = ("o", "s", "^")
NOTE = "* published plan overlaps; rank: share of optima below the published figure; ± one standard error"


@dataclass(frozen=True, slots=True)
class AuditRun:
    """What was asked for: parts of each size, limit of a run in s, and how many runs were planned."""

    parts: int
    time_limit: float | None
    planned: int


def headings(methods: Sequence[str]) -> list[str]:
    """Return the headings of an audit table."""
    start = ["holes", "parts", "mean", "s.d.", "5 %", "50 %", "95 %"]
    return [*start, *(each for method in methods for each in (method, "rank %", "implied gap %"))]


def table_lines(rows: Sequence[AuditRow], totals: Sequence[Overall]) -> list[list[str]]:
    """Return the cells of one audit table: a line for each size, then the overall gaps."""
    digits = 0 if UNITS[rows[0].figure] == "mm" else 1
    lines = []
    for holes, group in groupby(rows, key=lambda row: row.holes):
        of_size = list(group)
        first = of_size[0]
        spread = "" if first.deviation is None else f"{first.deviation:.{digits}f}"
        figures = [f"{each:.{digits}f}" for each in (first.p05, first.p50, first.p95)]
        line = [str(holes), str(first.parts), f"{first.mean:.{digits}f}", spread, *figures]
        for row in of_size:
            star = "*" if row.overlaps else ""
            rank = f"{row.rank_percent:.0f}"
            line += [f"{row.published:.{digits}f}{star}", rank, gap_text(row.gap, row.gap_error)]
        lines.append(line)
    last = ["all", *[""] * 6]
    for total in totals:
        last += ["", "", gap_text(total.gap, total.gap_error)]
    return [*lines, last]


def gap_text(gap: float, error: float | None) -> str:
    """Return a gap in percent with its standard error."""
    return f"{100 * gap:.1f}" if error is None else f"{100 * gap:.1f} ± {100 * error:.1f}"


def print_audit(rows: Sequence[AuditRow], records: Sequence[Record]) -> None:
    """Print a table for each model and figure, then what they can and cannot show."""
    console = output()
    for title, group, totals in _tables(rows):
        table = Table(title=Text(title), title_justify="left")
        for heading in headings([total.method for total in totals]):
            table.add_column(Text(heading), justify="right")
        lines = table_lines(group, totals)
        for line in lines[:-1]:
            table.add_row(*[Text(cell) for cell in line])
        table.add_section()
        table.add_row(*[Text(cell) for cell in lines[-1]], style="bold")
        console.print(table)
    for text in (NOTE, *_remarks(rows, records), CAN_SHOW, *LIMITS):
        console.print(Text(text))


def _tables(rows: Sequence[AuditRow]) -> list[tuple[str, list[AuditRow], list[Overall]]]:
    """Return title, rows and overall gaps of each table."""
    found = []
    for (rules, figure), group in groupby(rows, key=lambda row: (row.rules, row.figure)):
        chosen = list(group)
        found.append((f"{figure} [{UNITS[figure]}]; optimal: {describe(rules)}", chosen, overall(chosen)))
    return found


def _remarks(rows: Sequence[AuditRow], records: Sequence[Record]) -> list[str]:
    """Return what else is to be known about the figures: balance, runs left out, errors of the source."""
    balance: Mapping[Rules, tuple[float, float]] = balance_of_optima(records)
    remarks = [
        f"Optimal plans ({describe(rules)}): mean imbalance {mean:.1f} s, {100 * share:.0f} % within 0.5 s."
        for rules, (mean, share) in balance.items()
    ]
    left_out = {(row.rules, row.holes): row.unproved for row in rows}
    if any(left_out.values()):
        remarks.append(
            f"{sum(left_out.values())} runs without a proof are left out; they are harder than most."
        )
    sizes = {row.holes for row in rows}
    comments = [row for row in published_table() if row.comment and row.holes in sizes]
    return [*remarks, *(f"Source, part {row.part}, {row.method}: {row.comment}." for row in comments)]


def audit_html(
    run: AuditRun, rows: Sequence[AuditRow], records: Sequence[Record], failures: Sequence[Failure] = ()
) -> str:
    """Return the page of an audit."""
    sections = []
    for number, (title, group, totals) in enumerate(_tables(rows)):
        with page_style(f"audit-{number}"):
            svg = inline_svg(audit_figure(group), f"published figures over the optima: {title}")
        caption = "Band: 5 % to 95 % of the optima of random parts; line: median; hollow: the plan overlaps."
        table = html_table(headings([total.method for total in totals]), [table_lines(group, totals)])
        sections.append(
            f"<h2>{escape(title)}</h2><figure>{svg}<figcaption>{caption}</figcaption></figure>"
            f'<div class="scroll">{table}</div>'
        )
    limit = "none" if run.time_limit is None else f"{run.time_limit:g} s a run"
    versions = {f"{name} {version}" for record in records for name, version in record.versions.items()}
    provenance = [
        ("Parts", f"random parts in the published ranges, seeds 0 to {run.parts - 1} for each number of holes"),
        ("Time limit", limit),
        ("Figures", "Recomputed from instance and plan alone; each plan was checked against every rule."),
        ("Versions", ", ".join(sorted(versions))),
    ]
    return Template(view_text("audit.html")).substitute(
        style=view_text("page.css"),
        warnings=_warnings(run, records, failures),
        lead=escape(CAN_SHOW),
        sections="\n".join(sections),
        note=escape(NOTE),
        limits="\n".join(f"<li>{escape(text)}</li>" for text in LIMITS),
        remarks="\n".join(f"<li>{escape(text)}</li>" for text in _remarks(rows, records)),
        provenance="\n".join(definition(*pair) for pair in provenance),
    )


def _warnings(run: AuditRun, records: Sequence[Record], failures: Sequence[Failure]) -> str:
    lines = [f"Failed: {failure}" for failure in failures]
    if len(records) + len(failures) < run.planned:
        lines.append(f"Stopped early: {len(records)} of {run.planned} runs are finished.")
    return "\n".join(f'<p class="warn">{escape(line)}</p>' for line in lines)


def audit_figure(rows: Sequence[AuditRow]) -> Figure:
    """Draw the published figures of the methods over the band of optima; rows of one table."""
    figure = Figure(figsize=(PAGE_WIDTH, 3.4), layout="constrained")
    axes = figure.add_subplot()
    by_size = {row.holes: row for row in rows}
    sizes = list(by_size)
    bands = list(by_size.values())
    axes.fill_between(
        sizes, [r.p05 for r in bands], [r.p95 for r in bands], color=UNCUT, alpha=0.25, linewidth=0
    )
    axes.plot(
        sizes, [r.p50 for r in bands], color=UNCUT, linewidth=1.2, marker=".", label="optima of random parts"
    )
    for index, method in enumerate(dict.fromkeys(row.method for row in rows)):
        _draw_method(axes, [row for row in rows if row.method == method], index)
    axes.set(xlabel="holes", ylabel=f"{rows[0].figure} [{UNITS[rows[0].figure]}]")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=8)
    return figure


def _draw_method(axes: Axes, rows: Sequence[AuditRow], index: int) -> None:
    colour, marker = HEAD_COLOURS[index], MARKERS[index % len(MARKERS)]
    # Side by side, so that equal figures do not cover each other.
    shift = 0.6 * (index - 1)
    for overlaps in (False, True):
        chosen = [row for row in rows if row.overlaps == overlaps]
        axes.scatter(
            [row.holes + shift for row in chosen],
            [row.published for row in chosen],
            s=26,
            marker=marker,
            facecolors="none" if overlaps else colour,
            edgecolors=colour,
            label=None if overlaps else rows[0].method,
            zorder=3,
        )
