"""Pictures of a plate from above: contours and the tours of a plan."""

from itertools import pairwise
from pathlib import Path
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from cutgap.instances import Contour, Instance, Plan, Visit
from cutgap.instances.arrays import Floats
from cutgap.instances.evaluate import require_known
from cutgap.instances.free_entries import pinned
from cutgap.instances.links.strokes import Stroke, strokes
from cutgap.instances.simulate import tour_nodes
from cutgap.views.link_plots import draw_strokes, link_handles
from cutgap.views.options import require_picture_name

HEAD_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""Okabe and Ito's colours, which stay apart for colour-blind readers."""
UNCUT = "#808080"
WIDTH = 7.0
"""Width of figures in inches."""
PAGE_WIDTH = 4.8
"""The same on pages: as wide as a phone, so that letters keep their size there."""
DASHED, DOTTED = (0, (4, 3)), (0, (1, 2))
DOT_AREA = (8.0, 60.0)
"""Area of the smallest and the largest dot, square points."""
FILL = 0.12
"""Opacity of regions that may be entered anywhere."""
OUTLINE_CORNERS = 90
"""Corners of the polyline that is drawn for an ellipse."""
LEGEND_COLUMN = 1.4
"""Width of a column of a legend, inches."""
MOST_NUMBERED = 40
"""Contours of a tour that are numbered; more numbers cannot be read."""
NUMBER_OFFSET = (5, 5)
"""Points from a place to its number, which then clears dots and the ring around the first contour."""
MOST_CLEAR = 100
"""Contours that are drawn with lines and dots of full size; more get finer ones."""


def save(figure: Figure, path: Path) -> None:
    """Write a figure; the suffix names the format, errors are those of ``require_picture_name``."""
    require_picture_name(path)
    figure.savefig(path, dpi=160)


def plan_figure(
    instance: Instance, plan: Plan | None, *, via_points: bool = False, title: str = "", width: float = WIDTH
) -> Figure:
    """Draw the contours from above and, with a plan, the tour of each head.

    Parameters
    ----------
    instance
        Must carry coordinates.
    plan
        ``None`` draws contours and homes alone.
    via_points
        Whether the first contour of a tour is a via point; it is marked either way.
    width
        Of the figure, inches.

    Raises
    ------
    ValueError
        When the instance carries no coordinates, or the plan does not fit it.
    """
    if not instance.located:
        raise ValueError(f"instance {instance.name!r} has a matrix but no coordinates: nothing to draw")
    if plan is not None:
        require_known(instance, plan)
    free = plan is not None and any(visit.point is not None for tour in plan.tours for visit in tour)
    if plan is not None:
        instance, plan = pinned(instance, plan)
    handles = _legend_handles(instance, plan, via_points)
    columns = max(1, int(width / LEGEND_COLUMN))
    # Margins in inches: to have them found by a layout engine takes as long as all the drawing.
    left, right, below, above = 0.7, 0.15, 0.6 + 0.2 * -(-len(handles) // columns), 0.3
    height = _drawing_height(instance, width) + below + above
    figure = Figure(figsize=(width, height))
    axes = figure.add_axes(
        (left / width, below / height, 1 - (left + right) / width, 1 - (below + above) / height)
    )
    axes.set_aspect("equal", anchor="W")
    axes.set(xlabel="x [mm]", ylabel="y [mm]")
    axes.set_title(title or instance.name, loc="left", fontsize=10)
    axes.margins(0.06)
    _draw_contours(axes, instance, plan, filled=free)
    if plan is not None:
        for head, (tour, made) in enumerate(zip(plan.tours, strokes(instance, plan), strict=True)):
            if plan.links:
                draw_strokes(axes, instance, head, made, _colour(head))
                _mark_pierces(axes, instance, made, _colour(head))
            else:
                _draw_tour(axes, instance, head, tour)
        _draw_partition(axes, instance, plan)
    _draw_homes(axes, instance)
    if handles:
        figure.legend(handles=handles, loc="lower left", ncols=columns, frameon=False, fontsize=8)
    return figure


def _drawing_height(instance: Instance, limit: float) -> float:
    """Return the height in inches, without margins, that suits the instance's proportions."""
    curves = [outline(contour) for contour in instance.contours]
    places = np.concatenate([instance.points[:, :2], *(curve for curve in curves if curve is not None)])
    if len(places) == 0:
        return limit / 2
    width, height = np.ptp(places, axis=0)
    return float(np.clip(limit * height / width if width > 0 else limit, 2.0, limit))


def outline(contour: Contour) -> Floats | None:
    """Return the curve that is drawn, a closed polyline of shape (k, 2); of a region in space its shadow."""
    if contour.geometry is not None or contour.region is None:
        return contour.geometry
    return contour.region.boundary(OUTLINE_CORNERS)[:, :2]


def _fineness(instance: Instance) -> float:
    """Return a factor of line widths and dot sizes, at most 1."""
    return float(np.clip((MOST_CLEAR / max(1, len(instance.contours))) ** 0.5, 0.4, 1.0))


def _colour(head: int) -> str:
    return HEAD_COLOURS[head % len(HEAD_COLOURS)]


def _draw_contours(axes: Axes, instance: Instance, plan: Plan | None, *, filled: bool) -> None:
    """Draw outlines where there are any, entry points to choose from, and dots where contours are pierced.

    Outlines are filled when the contours may be entered anywhere inside.
    Dots without an outline are sized by perimeter; without a plan they stand at entry point 0.
    """
    owner = {
        visit.contour: (head, visit.entry)
        for head, tour in enumerate(plan.tours if plan is not None else ())
        for visit in tour
    }
    joined = {
        contour: head
        for head, made in enumerate(strokes(instance, plan) if plan is not None else ())
        for stroke in made
        for contour in stroke.contours
    }
    largest = max(float(instance.perimeters.max(initial=0.0)), 1e-9)
    fineness = _fineness(instance)
    points, areas, colours = [], [], []
    for index, contour in enumerate(instance.contours):
        head, entry = owner.get(index, (-1, 0))
        cutter = joined.get(index, head)
        colours.append(_colour(cutter) if cutter >= 0 else UNCUT)
        points.append(contour.entry_points[entry, :2])
        curve = outline(contour)
        share = contour.perimeter / largest if curve is None else 0.25 * fineness**2
        # Where there is a choice and none is made, no entry point stands out.
        chosen = head >= 0 or curve is None
        areas.append(DOT_AREA[0] + share * (DOT_AREA[1] - DOT_AREA[0]) if chosen else 0.0)
    if points:
        xs, ys = np.transpose(points)
        axes.scatter(xs, ys, s=areas, c=colours, linewidths=0, zorder=3)
    _draw_outlines(axes, instance, colours, filled=filled)


def _draw_outlines(axes: Axes, instance: Instance, colours: list[str], *, filled: bool) -> None:
    """Draw the curves, and small dots at the entry points of contours that leave a choice."""
    fineness = _fineness(instance)
    outlined = [(each, outline(contour)) for each, contour in enumerate(instance.contours)]
    shown = [(each, curve) for each, curve in outlined if curve is not None]
    edges = [colours[each] for each, _ in shown]
    curves = [curve for _, curve in shown]
    faces = [to_rgba(colour, FILL) for colour in edges] if filled else "none"
    axes.add_collection(PolyCollection(curves, facecolors=faces, edgecolors=edges, linewidths=1.4 * fineness))
    choices = [contour.entry_points[:, :2] for contour in instance.contours if len(contour.entry_points) > 1]
    if choices:
        xs, ys = np.concatenate(choices).T
        axes.scatter(
            xs, ys, s=6 * float(np.clip(MOST_CLEAR / len(xs), 0.15, 1.0)), c=UNCUT, linewidths=0, zorder=1.5
        )


def _draw_tour(axes: Axes, instance: Instance, head: int, tour: tuple[Visit, ...]) -> None:
    """Draw the rapids with an arrow in the middle of each; those from and to the home are dashed."""
    nodes = tour_nodes(instance, head, tour)
    if not nodes:
        return
    points, colour = instance.points[nodes, :2], _colour(head)
    if instance.home_node(head) is None:
        inner = points
    else:
        inner = points[1:-1]
        for ends in (points[:2], points[-2:]):
            axes.plot(ends[:, 0], ends[:, 1], color=colour, linewidth=1.0, linestyle=DASHED, zorder=2)
    fineness = _fineness(instance)
    # Thinner than what is cut.
    width = fineness * (1.1 if all(outline(contour) is None for contour in instance.contours) else 0.7)
    axes.plot(inner[:, 0], inner[:, 1], color=colour, linewidth=width, zorder=2)
    _draw_arrows(axes, points, colour, fineness)
    if len(tour) <= MOST_NUMBERED:
        _draw_numbers(axes, instance.points[[instance.node(*visit[:2]) for visit in tour], :2], colour)
    axes.scatter(inner[0, 0], inner[0, 1], s=130, facecolors="none", edgecolors=colour, zorder=4)


def _mark_pierces(axes: Axes, instance: Instance, made: tuple[Stroke, ...], colour: str) -> None:
    """Mark and number where strokes begin."""
    if not made:
        return
    points = instance.points[[stroke.start for stroke in made], :2]
    axes.scatter(points[:, 0], points[:, 1], s=60, facecolors="white", edgecolors=colour, zorder=4)
    if len(made) <= MOST_NUMBERED:
        _draw_numbers(axes, points, colour)


def _draw_numbers(axes: Axes, points: Floats, colour: str) -> None:
    """Number the contours of a tour from 1, beside the points where they are pierced."""
    for number, point in enumerate(points, start=1):
        axes.annotate(
            str(number),
            tuple(point),
            # The first one has a ring around it.
            xytext=(6, 6) if number == 1 else (3, 3),
            textcoords="offset points",
            fontsize=7,
            color=colour,
            path_effects=[withStroke(linewidth=2.0, foreground="white")],
            zorder=6,
        )


def _draw_arrows(axes: Axes, points: Floats, colour: str, fineness: float) -> None:
    legs = np.diff(points, axis=0)
    lengths = np.linalg.norm(legs, axis=1)
    moved = lengths > 0
    middles, legs = (points[:-1] + legs / 2)[moved], legs[moved] / lengths[moved, None]
    # A head without a shaft, of fixed size on paper: the line below is the shaft.
    axes.quiver(
        middles[:, 0],
        middles[:, 1],
        legs[:, 0],
        legs[:, 1],
        angles="xy",
        pivot="mid",
        units="inches",
        scale_units="inches",
        scale=12.0 / fineness,
        width=0.014 * fineness,
        headwidth=5.5,
        headlength=6.0,
        headaxislength=6.0,
        minlength=0,
        color=colour,
        zorder=2.5,
    )


def _draw_partition(axes: Axes, instance: Instance, plan: Plan) -> None:
    """Draw the line half way between neighbouring ranges; where they overlap, shade the overlap."""
    nodes = [[instance.node(*visit[:2]) for visit in tour] for tour in plan.tours if tour]
    xs = [instance.points[each, 0].tolist() for each in nodes]
    for left, right in pairwise(xs):
        if max(left) <= min(right):
            middle = (max(left) + min(right)) / 2
            axes.axvline(middle, color=UNCUT, linewidth=1.2, linestyle=DOTTED, zorder=1)
        else:
            axes.axvspan(min(right), max(left), color=UNCUT, alpha=0.18, linewidth=0, zorder=0)


def _draw_homes(axes: Axes, instance: Instance) -> None:
    for head in range(len(instance.heads)):
        node = instance.home_node(head)
        if node is not None:
            x, y = instance.points[node, :2]
            axes.scatter(x, y, s=70, marker="s", color=_colour(head), edgecolors="white", zorder=5)


def _legend_handles(instance: Instance, plan: Plan | None, via_points: bool) -> list[Line2D]:
    handles = []
    if plan is not None:
        for index, head in enumerate(instance.heads):
            name = head.id if head.id.startswith("head") else f"head {head.id}"
            handles.append(Line2D([], [], color=_colour(index), label=name))
        first = "pierce" if plan.links else "via point" if via_points else "first contour"
        handles += link_handles(_colour(0)) if plan.links else []
        handles.append(_mark("o", first, filled=False))
        if sum(map(bool, plan.tours)) > 1:
            handles.append(Line2D([], [], color=UNCUT, linestyle=DOTTED, label="partition (band: overlap)"))
    if any(head.home is not None for head in instance.heads):
        handles.append(_mark("s", "home", filled=True))
    return handles


def _mark(marker: Literal["o", "s"], label: str, *, filled: bool) -> Line2D:
    fill = UNCUT if filled else "none"
    return Line2D([], [], color=UNCUT, marker=marker, markerfacecolor=fill, linestyle="none", label=label)
