"""Pictures of heat under one plan: the sheet at a moment, as steps or in motion, and start points in time."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.contour import QuadContourSet
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from cutgap.instances import Instance, Plan
from cutgap.instances.arrays import Floats
from cutgap.instances.evaluate import require_known
from cutgap.instances.heat import peak_temperature, require_heat, rises, temperatures
from cutgap.instances.simulate import start_times
from cutgap.views.plots import HEAD_COLOURS, UNCUT, WIDTH

GRID = 160
"""Points along the longer side at which the sheet's temperature is computed."""
FRAME_GRID = 80
"""The same for a frame of an animation."""
FRAMES, FRAMES_PER_SECOND = 48, 8
MARGIN = 0.06
"""Of the longer side, around what is cut."""
SHADES, SCALE = 14, 3.0
"""Shades of temperature, about; their scale ends at so many times the start points' greatest rise."""
WARMTH = "YlOrRd"
"""Colours that grow darker all the way, so that grey prints read the same."""
MOST_NAMED = 40
"""Contours that are named by their turn."""


def hottest_pierce(instance: Instance, plan: Plan) -> tuple[int, float]:
    """Return the contour whose start is hottest when it is pierced, and when that is, s.

    Raises
    ------
    ValueError
        When nothing is cut, or temperatures cannot be told.
    """
    require_known(instance, plan)
    require_heat(instance)
    found = rises(instance, plan)
    if not found:
        raise ValueError(f"instance {instance.name!r}: the plan cuts nothing, so no heat can be shown")
    hottest = max(found, key=lambda contour: found[contour])
    return hottest, start_times(instance, plan)[hottest]


def heat_figure(instance: Instance, plan: Plan, moments: Sequence[float] = ()) -> Figure:
    """Draw the sheet's temperature at moments in s, one panel each; by default at the hottest pierce."""
    shown = list(moments) or [hottest_pierce(instance, plan)[1]]
    sheet = _Sheet(instance, plan, GRID if len(shown) == 1 else FRAME_GRID)
    columns = min(len(shown), 3 if sheet.shape > 0.8 else 2)
    rows = -(-len(shown) // columns)
    figure = Figure(figsize=sheet.size(rows, columns), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False).ravel().tolist()
    for axes, moment in zip(panels, shown, strict=False):
        drawn = sheet.draw(axes, moment)
    for axes in panels[len(shown) :]:
        axes.set_visible(False)
    bar = figure.colorbar(drawn, ax=panels, shrink=0.9, extend="max")
    bar.set_label("temperature [deg C]")
    figure.suptitle(sheet.title, fontsize=10)
    return figure


def step_moments(instance: Instance, plan: Plan, steps: int) -> list[float]:
    """Return moments at which contours are pierced, evenly spread over the order, the hottest among them."""
    _, hottest = hottest_pierce(instance, plan)
    starts = sorted(start_times(instance, plan).values())
    chosen = {starts[k] for k in np.linspace(0, len(starts) - 1, min(steps, len(starts))).round().astype(int)}
    if hottest not in chosen:
        chosen.remove(min(chosen, key=lambda moment: abs(moment - hottest)))
        chosen.add(hottest)
    return sorted(chosen)


def save_animation(instance: Instance, plan: Plan, path: Path) -> None:
    """Write the sheet's temperature in motion as .gif; the last frame is the end of the last cut."""
    hottest_pierce(instance, plan)
    sheet = _Sheet(instance, plan, FRAME_GRID)
    # Frames keep the layout of the first: room for wider labels.
    figure = Figure(figsize=sheet.size(1, 1), layout=ConstrainedLayoutEngine(w_pad=0.12, h_pad=0.06))
    axes = figure.add_subplot()
    bar = figure.colorbar(sheet.draw(axes, 0.0), ax=axes, shrink=0.9, extend="max")
    bar.set_label("temperature [deg C]")
    figure.suptitle(sheet.title, fontsize=10)

    def draw(frame: int) -> list[Line2D]:
        axes.clear()
        sheet.draw(axes, sheet.end * frame / (FRAMES - 1))
        return []

    animation = FuncAnimation(figure, draw, frames=FRAMES, blit=False)
    animation.save(path, writer=PillowWriter(fps=FRAMES_PER_SECOND), dpi=80)


class _Sheet:
    """What the panels of a picture share: the grid, the scale, when what is cut."""

    def __init__(self, instance: Instance, plan: Plan, grid: int) -> None:
        self.instance, self.plan = instance, plan
        self.starts = start_times(instance, plan)
        self.turns = {visit.contour: turn for tour in plan.tours for turn, visit in enumerate(tour, start=1)}
        self.places = {
            visit.contour: instance.points[instance.node(visit.contour, visit.entry), :2]
            for tour in plan.tours
            for visit in tour
        }
        service = instance.service_times
        self.ends = {contour: start + float(service[contour]) for contour, start in self.starts.items()}
        self.end = max(self.ends.values())
        self.curves = [c.geometry for c in instance.contours if c.geometry is not None]
        points = np.concatenate(self.curves)
        low, high = points.min(axis=0), points.max(axis=0)
        longer = max(float((high - low).max()), 1e-9)
        self.low, self.high = low - MARGIN * longer, high + MARGIN * longer
        size = self.high - self.low
        self.shape = float(size[1] / size[0])
        counts = np.maximum(2, np.ceil(grid * size / size.max()).astype(int))
        self.xs, self.ys = (np.linspace(self.low[k], self.high[k], counts[k]) for k in (0, 1))
        hottest, moment = hottest_pierce(instance, plan)
        peak, ambient = peak_temperature(instance, plan), require_heat(instance).ambient_c
        # Beside a fresh cut the sheet is far hotter than this: the scale is that of start points.
        rise = peak - ambient if np.isfinite(peak) and peak > ambient + 1.0 else 1.0
        self.shades = MaxNLocator(SHADES).tick_values(ambient, ambient + SCALE * rise)
        self.title = (
            f"{instance.name}: peak of start points {peak:.1f} deg C, {self._name(hottest)}, "
            f"after {moment:.2f} s"
        )

    def size(self, rows: int, columns: int) -> tuple[float, float]:
        """Return width and height in inches that suit the sheet's proportions."""
        width = WIDTH if columns == 1 else WIDTH + 3.0
        panel = (width - 1.3) / columns - 0.6
        return width, rows * (float(np.clip(panel * self.shape, 0.8, 6.0)) + 0.85) + 0.45

    def _name(self, contour: int) -> str:
        return f"turn {self.turns[contour]} (contour {self.instance.contours[contour].id})"

    def draw(self, axes: Axes, moment: float) -> QuadContourSet:
        """Draw one moment and return what a colour bar is made for."""
        x, y = np.meshgrid(self.xs, self.ys)
        field = temperatures(self.instance, self.plan, np.column_stack([x.ravel(), y.ravel()]), [moment])
        # Infinite on a curve at the end of its cut: beyond the scale is all that can be shown.
        # What is as cold as the ambient gets the first shade, which by rounding may begin above it.
        least = self.shades[0] + 1e-6 * (self.shades[1] - self.shades[0])
        warm = np.clip(field.reshape(x.shape), least, self.shades[-1] + 1.0)
        drawn = axes.contourf(x, y, warm, levels=self.shades, cmap=WARMTH, extend="max")
        lines = self.shades[2:-1:2]
        isotherms = axes.contour(x, y, warm, levels=lines, colors="black", linewidths=0.5, alpha=0.6)
        axes.clabel(isotherms, fmt="%g", fontsize=6)
        self._outlines(axes, moment)
        self._turns(axes, moment)
        axes.set_aspect("equal")
        axes.set(xlim=(self.low[0], self.high[0]), ylim=(self.low[1], self.high[1]))
        axes.set(xlabel="x [mm]", ylabel="y [mm]")
        axes.set_title(self._caption(moment), loc="left", fontsize=8)
        return drawn

    def _caption(self, moment: float) -> str:
        done = sum(end <= moment for end in self.ends.values())
        text = f"{moment:.2f} s: {done} of {len(self.instance.contours)} done"
        pierced = [contour for contour, start in self.starts.items() if start == moment]
        if pierced:
            place = self.places[pierced[0]]
            warmth = float(temperatures(self.instance, self.plan, [place], [moment])[0, 0])
            # On a line of its own, for narrow panels.
            text += f"\n{self._name(pierced[0])} pierced at {warmth:.1f} deg C"
        return text

    def _outlines(self, axes: Axes, moment: float) -> None:
        """Draw what is done as full lines, the contour being cut thick, and what is to come dashed."""
        kinds: dict[tuple[str, float], list[Floats]] = {}
        for index, contour in enumerate(self.instance.contours):
            if contour.geometry is None:
                continue
            start, end = self.starts.get(index, np.inf), self.ends.get(index, np.inf)
            kind = ("solid", 1.0) if end <= moment else ("solid", 2.4) if start <= moment else ("dashed", 0.8)
            kinds.setdefault(kind, []).append(contour.geometry)
        for (style, width), curves in kinds.items():
            axes.add_collection(
                PolyCollection(
                    curves, facecolors="none", edgecolors="black", linestyles=style, linewidths=width
                )
            )

    def _turns(self, axes: Axes, moment: float) -> None:
        """Number the contours by their turn, and mark where each is pierced."""
        for contour, place in self.places.items():
            if self.starts[contour] == moment:
                axes.scatter(place[0], place[1], s=70, marker="*", color="white", edgecolors="black", zorder=5)
            if len(self.places) <= MOST_NAMED:
                curve = self.instance.contours[contour].geometry
                middle = place if curve is None else (curve.min(axis=0) + curve.max(axis=0)) / 2
                axes.annotate(
                    str(self.turns[contour]),
                    tuple(middle),
                    fontsize=7,
                    ha="center",
                    va="center",
                    path_effects=[withStroke(linewidth=1.5, foreground="white")],
                )


def warming_figure(instance: Instance, plan: Plan, cap: float | None = None) -> Figure:
    """Draw the temperature of each start point in time, up to the moment when it is pierced.

    Parameters
    ----------
    cap
        A temperature cap to be drawn, deg C.
    """
    hottest, moment = hottest_pierce(instance, plan)
    found, starts = rises(instance, plan), start_times(instance, plan)
    ambient, end = require_heat(instance).ambient_c, max(starts.values())
    times = np.linspace(0.0, max(end, 1e-9), 600)
    figure = Figure(figsize=(WIDTH, 4.2), layout="constrained")
    axes = figure.add_subplot()
    visits = [visit for tour in plan.tours for visit in tour]
    places = [instance.points[instance.node(visit.contour, visit.entry), :2] for visit in visits]
    warmth = temperatures(instance, plan, places, times)
    for column, visit in enumerate(visits):
        before = times <= starts[visit.contour]
        chosen = visit.contour == hottest
        axes.plot(
            np.append(times[before], starts[visit.contour]),
            np.append(warmth[before, column], ambient + found[visit.contour]),
            color=HEAD_COLOURS[1] if chosen else UNCUT,
            linewidth=1.8 if chosen else 0.7,
            zorder=3 if chosen else 2,
        )
    pierced = ambient + np.array([found[visit.contour] for visit in visits])
    axes.scatter([starts[v.contour] for v in visits], pierced, s=16, color="black", zorder=4)
    finite = pierced[np.isfinite(pierced)]
    top = max([ambient + 1.0, *finite.tolist(), *([] if cap is None else [cap])])
    axes.set_ylim(ambient - 0.04 * (top - ambient), ambient + 1.15 * (top - ambient))
    axes.set_xlim(-0.02 * end, 1.02 * end if end > 0 else 1.0)
    name, peak = instance.contours[hottest].id, ambient + found[hottest]
    hottest_label = f"the hottest: contour {name}, {peak:.1f} deg C after {moment:.2f} s"
    handles = [
        Line2D([], [], color=UNCUT, linewidth=0.9, label="start point until it is pierced"),
        Line2D([], [], color=HEAD_COLOURS[1], linewidth=1.8, label=hottest_label),
        Line2D([], [], color="black", marker="o", markersize=4, linestyle="none", label="pierced"),
    ]
    if cap is not None:
        axes.axhline(cap, color="black", linestyle="--", linewidth=1.0, zorder=1)
        handles.append(Line2D([], [], color="black", linestyle="--", label=f"cap {cap:g} deg C"))
    axes.set(xlabel="time since the start [s]", ylabel="temperature [deg C]")
    axes.set_title(f"{instance.name}: how warm start points are when they are pierced", fontsize=10, loc="left")
    axes.spines[["top", "right"]].set_visible(False)
    figure.legend(handles=handles, loc="outside lower center", ncols=2, frameon=False, fontsize=8)
    return figure
