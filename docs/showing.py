"""Tables and pictures that pages of the documentation show; figures are read from records of runs."""

import base64
import html
import io
from collections.abc import Iterable, Sequence
from itertools import combinations

import numpy as np
from IPython.display import HTML, Markdown
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from shapely import MultiPoint

from cutgap.benchmark.records import Record
from cutgap.benchmark.table import gap_table
from cutgap.instances import Instance, Plan
from cutgap.views.plots import plan_figure

SHOWN = 1e-6
"""Edges below this value are not drawn, those that lack no more of 1 are whole."""
BORDER = "#0072B2"
INCH = 115
"""Pixels of the page to an inch of a figure; the picture has twice as many, for dense screens."""


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
    return picture(plan_figure(instance, plan, title=title), f"Plan: {title}")


def picture(figure: Figure, description: str) -> HTML:
    """Return a figure, with its description for those who do not see it."""
    image = io.BytesIO()
    figure.savefig(image, format="png", dpi=2 * INCH)
    # A notebook also shows figures that pyplot holds open at the end of a cell.
    plt.close(figure)
    data = base64.b64encode(image.getvalue()).decode("ascii")
    return HTML(
        f'<img class="picture" width="{figure.get_figwidth() * INCH:.0f}" alt="{html.escape(description)}"'
        f' src="data:image/png;base64,{data}">'
    )


def point(
    places: np.ndarray, x: np.ndarray, title: str, sets: Iterable[tuple[str, Iterable[int]]] = ()
) -> HTML:
    """Return the picture of a fractional solution: edges at 1 are solid, others dashed and labelled.

    Parameters
    ----------
    places
        Shape (n, 2), mm; the last one is the home.
    x
        Shape (n, n), symmetric: the value of each edge.
    sets
        Sets of nodes to draw a border around, by name.
    """
    width, height = np.ptp(places, axis=0)
    figure = Figure(figsize=(5.6, 5.0 * height / width + 0.6), layout="constrained")
    axes = figure.subplots()
    axes.set_aspect("equal")
    axes.set(xlabel="x [mm]", ylabel="y [mm]")
    axes.set_title(title, loc="left", fontsize=10)
    for i, j in combinations(range(len(places)), 2):
        if x[i, j] > SHOWN:
            _edge(axes, places[[i, j]], float(x[i, j]))
    for name, members in sets:
        border = np.array(MultiPoint(places[list(members)]).convex_hull.buffer(0.06 * width).exterior.coords)
        axes.plot(border[:, 0], border[:, 1], color=BORDER, linewidth=1.2, linestyle=":")
        top = border[border[:, 1].argmax()]
        axes.text(top[0], top[1], name, color=BORDER, ha="center", va="bottom")
    for node, (place_x, place_y) in enumerate(places):
        marker = "s" if node == len(places) - 1 else "o"
        axes.scatter(place_x, place_y, s=170, marker=marker, color="white", edgecolors="black", zorder=3)
        axes.text(place_x, place_y, str(node), fontsize=8, ha="center", va="center_baseline", zorder=4)
    return picture(figure, f"Point of a linear program: {title}")


def _edge(axes: Axes, ends: np.ndarray, value: float) -> None:
    """Draw an edge between the rows of ``ends``."""
    whole = value > 1.0 - SHOWN
    axes.plot(ends[:, 0], ends[:, 1], color="black", linewidth=1.6, linestyle="-" if whole else (0, (4, 3)))
    if not whole:
        x, y = ends.mean(axis=0)
        ground = {"facecolor": "white", "edgecolor": "none", "pad": 0.6}
        axes.text(x, y, f"{value:.2g}", fontsize=8, ha="center", va="center", bbox=ground)


def _bound(value: float | None, proved: bool, certified: bool) -> str:
    if value is None:
        return "-"
    return f"{'= ' if proved else ''}{value:.2f}{'' if certified else ' claimed'}"


def _figure(value: float | None, digits: int, factor: float = 1.0) -> str:
    return "-" if value is None else f"{factor * value:.{digits}f}"


def _is_number(text: str) -> bool:
    if text == "-":
        return True
    try:
        float(text.lstrip("=<> "))
    except ValueError:
        return False
    return True
