"""What the HTML pages share."""

from collections.abc import Sequence
from html import escape
from importlib.resources import files


def view_text(name: str) -> str:
    """Return a text file of this folder: a template or the style sheet."""
    return files("cutgap.views").joinpath(name).read_text(encoding="utf-8")


def definition(term: str, text: str) -> str:
    """Return a term and what it means, for a list of definitions."""
    return f"<dt>{escape(term)}</dt><dd>{escape(text)}</dd>"


def html_table(headings: Sequence[str], groups: Sequence[Sequence[Sequence[str]]]) -> str:
    """Return a table whose cells are text; groups of rows are set apart by a line."""
    head = "".join(f"<th{text_class(heading)}>{escape(heading)}</th>" for heading in headings)
    bodies = []
    for group in groups:
        lines = []
        for cells in group:
            pairs = zip(headings, cells, strict=True)
            lines.append("<tr>" + "".join(f"<td{text_class(h)}>{escape(c)}</td>" for h, c in pairs) + "</tr>")
        bodies.append("<tbody>" + "\n".join(lines) + "</tbody>")
    return f"<table><thead><tr>{head}</tr></thead>{''.join(bodies)}</table>"


def text_class(heading: str) -> str:
    """Return the class of columns that hold words; figures need none."""
    return ' class="text"' if heading in ("part", "asked", "method") else ""
