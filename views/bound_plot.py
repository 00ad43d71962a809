"""The picture of a ladder of bounds."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cutgap.formulations.rungs import Rung
from cutgap.views.plots import HEAD_COLOURS, PAGE_WIDTH, UNCUT, WIDTH

KINDS = {"linear": "o", "combinatorial": "s", "semidefinite": "D", "cone": "^", "exact": "*"}
"""Markers of the kinds of relaxations, so that the picture is read without colours."""


def ladder_figure(
    name: str, rungs: Sequence[Rung], value: float | None, unit: str, *, narrow: bool = False
) -> Figure:
    """Draw each bound on a line of its own, with size and time beside it, and the best plan's value.

    Parameters
    ----------
    rungs
        In the order in which they are shown, from below; those without bound are left out.
    value
        The best plan's value in ``unit``; ``None`` when there is none.
    narrow
        Whether the figure is as wide as a phone, without size and time.
    """
    shown = [rung for rung in rungs if rung.bound is not None]
    size = (PAGE_WIDTH if narrow else WIDTH + 1.5, 1.3 + 0.27 * max(1, len(shown)))
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.add_subplot()
    for place, rung in enumerate(shown):
        bound = rung.bound or 0.0
        marker, colour = KINDS[rung.kind], HEAD_COLOURS[list(KINDS).index(rung.kind)]
        solid = rung.certificate is not None
        axes.hlines(place, 0, bound, color=UNCUT, alpha=0.35, linewidth=1.0, zorder=1)
        axes.scatter(
            [bound],
            [place],
            marker=marker,
            s=46,
            color=colour if solid else "white",
            edgecolor=colour,
            label=rung.kind,
            zorder=3,
        )
        if not narrow:
            _annotate(axes, rung, place)
    if value is not None:
        axes.axvline(value, color="black", linewidth=1.0, linestyle="--", label="best plan", zorder=2)
    axes.set_yticks(range(len(shown)), [rung.formulation for rung in shown], fontsize=8)
    bounds = [rung.bound for rung in shown if rung.bound is not None]
    least, top = min(bounds, default=0.0), max([0.0, *bounds] if value is None else [value, *bounds])
    axes.set_xlim(max(0.0, least - 0.15 * (top - least)), top + 0.03 * max(top - least, 1e-9))
    between = "\n" if narrow else "; "
    axes.set_xlabel(f"proved bound [{unit}]{between}an open marker is claimed, not certified")
    axes.set_title(f"{name}: how much each formulation proves", fontsize=10, loc="left")
    axes.spines[["top", "right"]].set_visible(False)
    handles = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    axes.legend(
        handles.values(), handles.keys(), frameon=False, fontsize=8, loc="lower right", bbox_to_anchor=(0.94, 0)
    )
    return figure


def _annotate(axes: Axes, rung: Rung, place: int) -> None:
    """Write size and time to the right of the line of a rung."""
    size = "" if rung.variables is None else f", {rung.variables} variables"
    beside = ("axes fraction", "data")
    axes.annotate(f"{rung.seconds:.2f} s{size}", (1.01, place), xycoords=beside, fontsize=7, va="center")
