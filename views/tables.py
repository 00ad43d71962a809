"""Tables on the terminal."""

import sys
from collections.abc import Sequence

from rich.console import Console
from rich.table import Table
from rich.text import Text

from cutgap.benchmark.table import TableRow, summarise
from cutgap.benchmark.wording import describe_all
from cutgap.views.columns import columns, summary_headings, summary_rows

PLAIN_WIDTH = 260
"""Width of tables that go to a file or pipe."""


def output() -> Console:
    """Return a console on stdout that wraps lines on a terminal only."""
    return Console(width=None if sys.stdout.isatty() else PLAIN_WIDTH, highlight=False)


def print_gaps(rows: Sequence[TableRow]) -> None:
    """Print the gap table, the plans that break rules, and a summary of the methods."""
    console = output()
    if not rows:
        return
    asked = dict.fromkeys(row.rules for row in rows)
    heads = max(row.best.heads for row in rows)
    units = ", ".join(dict.fromkeys(rules.unit for rules in asked))
    console.print(_gap_table(rows, f"{describe_all(asked, heads)} [{units}]"))
    _print_notes(console, rows)
    console.print(_summary_table(rows))


def _gap_table(rows: Sequence[TableRow], title: str) -> Table:
    table = Table(title=Text(title), title_justify="left")
    shown = columns(rows)
    for column in shown:
        table.add_column(Text(column.heading), justify="right" if column.numeric else "left")
    before = None
    for row in rows:
        if before is not None and before != row.best.instance_hash:
            table.add_section()
        before = row.best.instance_hash
        table.add_row(*[Text(column.cell(row)) for column in shown], style="bold" if row.gap == 0 else None)
    return table


def _print_notes(console: Console, rows: Sequence[TableRow]) -> None:
    for row in rows:
        if row.note:
            console.print(Text(f"{row.instance}, {row.method}: {row.note}"))


def _summary_table(rows: Sequence[TableRow]) -> Table:
    table = Table(title=Text("methods over all parts"), title_justify="left")
    summaries = summarise(rows)
    for heading in summary_headings(summaries):
        table.add_column(Text(heading), justify="left" if heading in ("asked", "method") else "right")
    for line in summary_rows(summaries):
        table.add_row(*[Text(cell) for cell in line])
    return table
