"""Matplotlib figures as inline SVG that follows the page's light or dark colours and needs no network."""

import io
import re
from contextlib import AbstractContextManager
from html import escape
from typing import Any

import matplotlib
from matplotlib.figure import Figure

from cutgap.views.plots import HEAD_COLOURS, UNCUT

INK = "#010203"
"""Stands for the page's text colour until the SVG is finished; no figure uses it otherwise."""

STYLE: dict[str, Any] = {
    "svg.fonttype": "none",
    "font.family": "sans-serif",
    "text.color": INK,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "savefig.transparent": True,
}


def page_style(name: str) -> AbstractContextManager[None]:
    """Return a context in which figures for a page are made; ``name`` keeps the ids of figures apart."""
    style: dict[Any, Any] = {**STYLE, "svg.hashsalt": name}
    return matplotlib.rc_context(style)


def inline_svg(figure: Figure, label: str) -> str:
    """Return a figure made within ``page_style`` as an SVG element, ``label`` being its text for readers."""
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    svg = text.getvalue()
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    # HTML knows the namespaces of inline SVG; as texts they would look like addresses.
    svg = re.sub(r'\s+xmlns(:\w+)?="[^"]*"', "", svg).replace("xlink:href", "href")
    # The page sets size and fonts; ids of groups would repeat from figure to figure.
    svg = re.sub(r'(<svg[^>]*?) width="[^"]*" height="[^"]*"', r"\1", svg, count=1)
    svg = re.sub(r' font-family: [^;"]*;', "", svg)
    svg = re.sub(r'<g id="[^"]*">', "<g>", svg)
    # White stands for the ground: halos of numbers, rims of squares, open markers.
    variables = {
        INK: "currentColor",
        "#000000": "currentColor",
        "#ffffff": "var(--ground)",
        UNCUT: "var(--grey)",
    }
    variables |= {colour: f"var(--head-{index})" for index, colour in enumerate(HEAD_COLOURS)}
    for colour, variable in variables.items():
        svg = svg.replace(colour.lower(), variable)
    return _shortened(svg).replace("<svg", f'<svg role="img" aria-label="{escape(label)}"', 1)


def _shortened(svg: str) -> str:
    """Round places to a tenth of a point, which is not seen, and drop line breaks: the page is halved.

    Texts stand between tags, and keep all their digits.
    """

    def rounded(tag: re.Match[str]) -> str:
        return re.sub(r"-?\d+\.\d{2,}", lambda match: f"{float(match[0]):z.1f}".removesuffix(".0"), tag[0])

    return re.sub(r"\s*\n\s*", " ", re.sub(r"<[^>]*>", rounded, svg))
