"""Pictures of plans with links: strokes from above, the way of the head step by step or in motion.

Links that are passed twice are drawn as two lines side by side, those that are passed once dotted, rapids
dashed; what is cut so far is bold. None of it is told apart by colour alone.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import AbstractPathEffect
from matplotlib.patheffects import Stroke as Stroked

from cutgap.instances import Instance, Plan
from cutgap.instances.arrays import Floats
from cutgap.instances.evaluate import require_known
from cutgap.instances.links.strokes import Stroke, link_ends
from cutgap.instances.links.trajectory import Phase, trajectory

DASHED, DOTTED = (0, (4, 3)), (0, (1, 0.8))
DONE, AHEAD = 1.8, 0.5
"""Widths of lines for what is cut and for what is to come, points."""
FRAMES, FRAMES_PER_SECOND = 60, 10
PANEL, MARGIN = 3.6, 0.04
"""Width of a panel, inches; margin, a share of the longer side."""


def draw_strokes(axes: Axes, instance: Instance, head: int, made: Sequence[Stroke], colour: str) -> None:
    """Draw the links and rapids of a head."""
    passed: dict[int, list[Floats]] = {1: [], 2: []}
    for stroke in made:
        for link in stroke.links:
            passed[link.passes].append(instance.points[list(link_ends(instance, link)), :2])
    axes.add_collection(
        LineCollection(passed[1], colors=colour, linewidths=2.0, linestyles=[DOTTED], zorder=2.2)
    )
    axes.add_collection(LineCollection(passed[2], colors=colour, linewidths=2.8, zorder=2.2))
    # A white core makes two lines of one.
    axes.add_collection(LineCollection(passed[2], colors="white", linewidths=1.0, zorder=2.3))
    home = instance.home_node(head)
    if made:
        last = made[-1].end
        sources = [last if home is None else home, *(stroke.end for stroke in made)]
        targets = [*(stroke.start for stroke in made), *([] if home is None else [home])]
        # There and back is drawn once: dashes over dashes look like a line.
        ways = {frozenset(way): way for way in zip(sources, targets, strict=False)}
        legs = [instance.points[list(way), :2] for way in ways.values()]
        axes.add_collection(
            LineCollection(legs, colors=colour, linewidths=1.0, linestyles=[DASHED], zorder=2.1)
        )


def link_handles(colour: str) -> list[Line2D]:
    """Return what a legend says about links."""
    return [
        Line2D([], [], color=colour, linewidth=2.0, linestyle=DOTTED, label="link, passed once"),
        Line2D([], [], color=colour, linewidth=2.8, label="link, passed twice", path_effects=_doubled(colour)),
        Line2D([], [], color=colour, linewidth=1.0, linestyle=DASHED, label="rapid"),
    ]


def _doubled(colour: str) -> list[AbstractPathEffect]:
    return [Stroked(linewidth=2.8, foreground=colour), Stroked(linewidth=1.0, foreground="white")]


class Way:
    """The way of the only head in time, as pictures need it.

    Attributes
    ----------
    phases, ends
        Its pieces, and when each is over, s; pierces take their time before the cut that they begin.
    """

    def __init__(self, instance: Instance, plan: Plan) -> None:
        require_known(instance, plan)
        self.instance = instance
        self.phases = trajectory(instance, plan)
        if not self.phases:
            raise ValueError(f"instance {instance.name!r}: the plan cuts nothing, so no steps can be shown")
        self.pierced = [
            each.kind != "rapid" and (k == 0 or self.phases[k - 1].kind == "rapid")
            for k, each in enumerate(self.phases)
        ]
        home, machine = instance.home_node(0), instance.machine
        self.home = None if home is None else instance.points[home, :2]
        times = [
            _length(each.points) / (machine.v_jump if each.kind == "rapid" else machine.v_cut)
            for each in self.phases
        ]
        self.waits = machine.t_aux * np.array(self.pierced)
        self.ends = np.cumsum(np.array(times) + self.waits)
        self.times = np.array(times)
        points = np.concatenate([each.points for each in self.phases])
        curves = [each.geometry for each in instance.contours if each.geometry is not None]
        self.curves = curves
        points = np.concatenate([points, *curves])
        low, high = points.min(axis=0), points.max(axis=0)
        pad = MARGIN * max(float((high - low).max()), 1e-9)
        self.low, self.high = low - pad, high + pad
        self.shape = float(np.divide(*(self.high - self.low)[::-1]))

    def until(self, moment: float) -> list[Phase]:
        """Return the phases up to a moment in s, the last one as far as it has come."""
        begun = self.ends - self.times
        made = [each for each, end in zip(self.phases, self.ends, strict=True) if end <= moment]
        number = len(made)
        if number < len(self.phases) and moment > begun[number]:
            share = (moment - begun[number]) / self.times[number]
            now = self.phases[number]
            made.append(Phase(now.kind, now.contour, _part(now.points, share)))
        return made

    def draw(self, axes: Axes, moment: float) -> None:
        """Draw one moment: what is cut so far bold, what is to come thin."""
        made = self.until(moment)
        axes.add_collection(
            PolyCollection(self.curves, facecolors="none", edgecolors="black", linewidths=AHEAD, alpha=0.6)
        )
        links = [each.points for each in self.phases if each.kind == "link"]
        axes.add_collection(LineCollection(links, colors="black", linewidths=AHEAD, alpha=0.6))
        for kind, style in (("cut", "solid"), ("link", "solid"), ("rapid", DASHED)):
            lines = [each.points for each in made if each.kind == kind]
            width = 0.9 if kind == "rapid" else DONE
            axes.add_collection(
                LineCollection(lines, colors="black", linewidths=width, linestyles=[style], zorder=2)
            )
        pierces = [each.points[0] for each, lit in zip(self.phases, self.pierced, strict=True) if lit]
        for number, (x, y) in enumerate(pierces[: sum(self.pierced[: max(1, len(made))])], start=1):
            axes.scatter(x, y, s=36, facecolors="white", edgecolors="black", zorder=4)
            axes.annotate(str(number), (x, y), fontsize=5, ha="center", va="center", zorder=5)
        place = made[-1].points[-1] if made else self.phases[0].points[0]
        axes.scatter(place[0], place[1], s=40, marker="x", color="black", zorder=6)
        if self.home is not None:
            axes.scatter(self.home[0], self.home[1], s=24, marker="s", color="black", zorder=3)
        axes.set_aspect("equal")
        axes.set(xlim=(self.low[0], self.high[0]), ylim=(self.low[1], self.high[1]), xticks=[], yticks=[])
        done = sum(_length(each.points) for each in made if each.kind != "rapid")
        axes.set_title(f"{moment:.1f} s, {done:.0f} mm cut", loc="left", fontsize=8)


def steps_figure(instance: Instance, plan: Plan, steps: int) -> Figure:
    """Draw the way in so many panels, evenly spread over its time; the last one is its end.

    Raises
    ------
    ValueError
        When the plan cuts nothing, has several heads, or strokes that cannot be made (``trajectory``).
    """
    way = Way(instance, plan)
    columns = min(steps, 3)
    rows = -(-steps // columns)
    height = float(np.clip(PANEL * way.shape, 0.8, 6.0)) + 0.3
    figure = Figure(figsize=(PANEL * columns, rows * height + 0.3), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False).ravel().tolist()
    for axes, moment in zip(panels, np.linspace(0.0, way.ends[-1], steps + 1)[1:], strict=False):
        way.draw(axes, float(moment))
    for axes in panels[steps:]:
        axes.set_visible(False)
    figure.suptitle(instance.name, fontsize=10)
    return figure


def save_motion(instance: Instance, plan: Plan, path: Path) -> None:
    """Write the way in motion as .gif; errors as for ``steps_figure``."""
    way = Way(instance, plan)
    figure = Figure(figsize=(6.0, float(np.clip(6.0 * way.shape, 1.5, 7.0)) + 0.5), layout="constrained")
    axes = figure.add_subplot()

    def draw(frame: int) -> list[Line2D]:
        axes.clear()
        way.draw(axes, float(way.ends[-1]) * frame / (FRAMES - 1))
        return []

    animation = FuncAnimation(figure, draw, frames=FRAMES, blit=False)
    animation.save(path, writer=PillowWriter(fps=FRAMES_PER_SECOND), dpi=80)


def _length(points: Floats) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def _part(points: Floats, share: float) -> Floats:
    """Return a polyline's beginning, up to a share of its length."""
    marks = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    at = share * marks[-1]
    end = [np.interp(at, marks, points[:, axis]) for axis in (0, 1)]
    return np.vstack((points[marks < at], end))
