"""Charts: the distribution of gaps, and fronts of travel against imbalance or peak."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure

from cutgap.instances import Result
from cutgap.instances.result import OPTIMALITY_TOLERANCE
from cutgap.views.plots import HEAD_COLOURS, PAGE_WIDTH, UNCUT, WIDTH


def gap_figure(gaps: Sequence[tuple[str, Sequence[float]]]) -> Figure:
    """Draw the gaps of each method: a dot for each run, their mean as a diamond, and their range as a line.

    Parameters
    ----------
    gaps
        Method and the gaps of its runs, as shares; methods without gaps keep an empty line.
    """
    figure = Figure(figsize=(PAGE_WIDTH, 0.7 + 0.45 * len(gaps)), layout="constrained")
    axes = figure.add_subplot()
    positions = range(len(gaps), 0, -1)
    for position, (_, shares) in zip(positions, gaps, strict=True):
        percents = 100 * np.asarray(shares)
        # Even steps up and down instead of random ones: the picture is the same each time.
        offsets = 0.22 * (np.arange(len(percents)) % 5 - 2) / 2
        axes.scatter(
            percents, position + offsets, s=14, color=HEAD_COLOURS[0], alpha=0.6, linewidths=0, zorder=3
        )
        if len(percents):
            ends = [percents.min(), percents.max()]
            axes.plot(ends, [position] * 2, color=UNCUT, linewidth=1.3, marker="|", markersize=13, zorder=2)
            axes.plot(percents.mean(), position, color=HEAD_COLOURS[1], marker="D", markersize=6.5, zorder=4)
    axes.set_yticks(list(positions), [method for method, _ in gaps])
    axes.set_ylim(0.5, len(gaps) + 0.5)
    axes.set_xlabel("gap to the proved bound [%]")
    axes.set_xlim(left=-0.02 * max((100 * max(shares) for _, shares in gaps if shares), default=1.0))
    axes.grid(axis="x", color=UNCUT, alpha=0.25, linewidth=0.7)
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.tick_params(axis="y", length=0)
    return figure


def front_figure(name: str, results: Sequence[Result]) -> Figure:
    """Draw travel against imbalance: plans as dots, proved bounds as ticks at the limits they hold for."""
    figure = Figure(figsize=(WIDTH, 4.2), layout="constrained")
    axes = figure.add_subplot()
    shown = sorted(
        (result for result in results if result.evaluation is not None),
        key=lambda result: np.inf if result.rules.balance is None else result.rules.balance,
    )
    imbalances = [result.evaluation.imbalance_s for result in shown if result.evaluation is not None]
    travel = [result.evaluation.total_travel_mm for result in shown if result.evaluation is not None]
    # The least travel that is known under each limit: a plan is of use from its imbalance on.
    stairs = sorted(zip(imbalances, travel, strict=True))
    if stairs:
        least = np.minimum.accumulate([length for _, length in stairs])
        ends = [x for x, _ in stairs]
        axes.step(ends, least, where="post", color=HEAD_COLOURS[0], alpha=0.4, linewidth=1.2, zorder=2)
    axes.scatter(imbalances, travel, s=26, color=HEAD_COLOURS[0], zorder=3, label="plan")
    known = [
        (x if result.rules.balance is None else result.rules.balance, result.lower_bound)
        for x, result in zip(imbalances, shown, strict=True)
        if result.lower_bound is not None
    ]
    axes.scatter(
        [x for x, _ in known],
        [bound for _, bound in known],
        marker="_",
        s=160,
        color=HEAD_COLOURS[1],
        zorder=4,
        label="proved bound under a limit",
    )
    axes.set_xlabel("imbalance of a plan, or its limit [s]")
    axes.set_ylabel("travel [mm]")
    axes.set_title(f"{name}: least travel under a limit on imbalance", fontsize=10, loc="left")
    axes.grid(color=UNCUT, alpha=0.25, linewidth=0.7)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False)
    return figure


MARKERS = ("o", "s", "^", "D", "v", "P")
"""Of heuristics, so that they are told apart without colours."""


def heat_front_figure(
    name: str, results: Sequence[Result], others: Sequence[Result] = (), *, complete: bool = False
) -> Figure:
    """Draw travel against peak: the front as a staircase, and how much below it is not proved to be empty.

    Parameters
    ----------
    results
        Points of a front, each for rules with a cap, within which no plan travels less than its bound.
    others
        Plans of heuristics.
    complete
        Whether the points were found one after the other, each below the cap that the one before sets.
    """
    figure = Figure(figsize=(WIDTH, 4.6), layout="constrained")
    axes = figure.add_subplot()
    points = [
        (peak, evaluation.total_travel_mm, each)
        for each in results
        if (evaluation := each.evaluation) is not None
        and (peak := evaluation.peak_temperature_c) is not None
        and np.isfinite(peak)
        and not each.violations
    ]
    points.sort(key=lambda point: point[0])
    drawn = _scatter_others(axes, others)
    right = max([*(peak for peak, _, _ in points), *drawn], default=1.0)
    left = min([*(peak for peak, _, _ in points), *drawn], default=0.0)
    right += 0.05 * max(right - left, 1.0)
    if points:
        xs, ys = [peak for peak, _, _ in points], [travel for _, travel, _ in points]
        stairs = np.minimum.accumulate([*ys, ys[-1]])
        axes.step([*xs, right], stairs, where="post", color=HEAD_COLOURS[0], linewidth=1.3, zorder=2)
        proved = [_is_proved(each) for _, _, each in points]
        for known, label in ((True, "proved to be optimal"), (False, "best plan known")):
            chosen = [place for place, each in enumerate(proved) if each is known]
            if chosen:
                axes.scatter(
                    [xs[place] for place in chosen],
                    [ys[place] for place in chosen],
                    s=22,
                    facecolors=HEAD_COLOURS[0] if known else "white",
                    edgecolors=HEAD_COLOURS[0],
                    zorder=4,
                    label=label,
                )
    axes.set_xlim(left - 0.05 * max(right - left, 1.0), right)
    if points:
        closed = complete and all(each.plan is not None and _is_proved(each) for each in results)
        _shade_unproved(axes, points, complete=complete, closed=closed)
    axes.set(xlabel="peak temperature of start points [deg C]", ylabel="travel [mm]")
    axes.set_title(f"{name}: least travel under a temperature cap", fontsize=10, loc="left")
    axes.grid(color=UNCUT, alpha=0.25, linewidth=0.7)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=8)
    return figure


def _scatter_others(axes: Axes, others: Sequence[Result]) -> list[float]:
    """Draw the plans of heuristics that keep the rules; return their peaks."""
    methods: dict[str, list[tuple[float, float]]] = {}
    for each in others:
        evaluation = each.evaluation
        if evaluation is None or each.violations or evaluation.peak_temperature_c is None:
            continue
        if np.isfinite(evaluation.peak_temperature_c):
            place = (evaluation.peak_temperature_c, evaluation.total_travel_mm)
            methods.setdefault(each.method, []).append(place)
    for number, (method, places) in enumerate(methods.items()):
        axes.scatter(
            [peak for peak, _ in places],
            [travel for _, travel in places],
            s=20,
            marker=MARKERS[number % len(MARKERS)],
            facecolors="none",
            edgecolors=HEAD_COLOURS[1 + number % (len(HEAD_COLOURS) - 1)],
            zorder=3,
            label=method,
        )
    return [peak for places in methods.values() for peak, _ in places]


def _shade_unproved(
    axes: Axes, points: Sequence[tuple[float, float, Result]], *, complete: bool, closed: bool
) -> None:
    """Shade where an unknown plan may lie that no drawn one beats: above all bounds, below the staircase."""
    (left, right), top = axes.get_xlim(), axes.get_ylim()[1]
    peaks = [peak for peak, _, _ in points]
    # Of a complete front each bound holds for all plans cooler than the next point.
    caps = [*peaks[1:], np.inf] if complete else [_cap(each) for _, _, each in points]
    breaks = sorted({left, right, *(x for x in (*peaks, *caps) if left < x < right)})
    label: str | None = "not proved to be empty"
    for start, end in pairwise(breaks):
        middle = (start + end) / 2
        known = [travel for peak, travel, _ in points if peak <= middle]
        bounds = [
            each.lower_bound
            for cap, (_, _, each) in zip(caps, points, strict=True)
            if cap >= middle and each.lower_bound is not None
        ]
        upper, lower = min(known, default=top), max(bounds, default=0.0)
        if lower >= upper * (1.0 - 1e-6) or (closed and not known):
            continue
        axes.fill_between(
            [start, end],
            lower,
            upper,
            facecolor=to_rgba(UNCUT, 0.18),
            edgecolor=to_rgba(UNCUT, 0.5),
            linewidth=0,
            hatch="///",
            zorder=0,
            label=label,
        )
        label = None
    axes.set_ylim(top=top)


def _cap(result: Result) -> float:
    return np.inf if result.rules.temperature_cap is None else result.rules.temperature_cap


def _is_proved(result: Result) -> bool:
    return result.gap is not None and result.gap <= OPTIMALITY_TOLERANCE
