"""Tables that pages of the documentation show; their figures are read from records of runs."""

from collections.abc import Iterable, Sequence

from IPython.display import Markdown

from cutgap.benchmark.records import Record
from cutgap.benchmark.table import gap_table


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


def _bound(value: float | None, proved: bool, certified: bool) -> str:
    if value is None:
        return "-"
    return f"{'= ' if proved else ''}{value:.2f}{'' if certified else ' claimed'}"


def _figure(value: float | None, digits: int, factor: float = 1.0) -> str:
    return "-" if value is None else f"{factor * value:.{digits}f}"


def _is_number(text: str) -> bool:
    return text == "-" or text.lstrip("=<> ").replace(".", "", 1).replace("-", "", 1).isdigit()
