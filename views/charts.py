"""Charts: the distribution of gaps, and fronts of travel against imbalance or peak."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from cutgap.instances import Result
from cutgap.views.plots import HEAD_COLOURS, UNCUT, WIDTH


def gap_figure(gaps: Sequence[tuple[str, Sequence[float]]]) -> Figure:
    """Draw the gaps of each method: a dot for each run over a box of quartiles.

    Parameters
    ----------
    gaps
        Method and the gaps of its runs, as shares; methods without gaps keep an empty line.
    """
    figure = Figure(figsize=(WIDTH, 0.7 + 0.55 * len(gaps)), layout="constrained")
    axes = figure.add_subplot()
    positions = range(len(gaps), 0, -1)
    for position, (_, shares) in zip(positions, gaps, strict=True):
        percents = 100 * np.asarray(shares)
        # Even steps up and down instead of random ones: the picture is the same each time.
        offsets = 0.22 * (np.arange(len(percents)) % 5 - 2) / 2
        axes.scatter(
            percents, position + offsets, s=9, color=HEAD_COLOURS[0], alpha=0.6, linewidths=0, zorder=3
        )
    boxes = [100 * np.asarray(shares) for _, shares in gaps]
    line = {"color": UNCUT, "linewidth": 1.1}
    axes.boxplot(
        boxes,
        positions=list(positions),
        orientation="horizontal",
        widths=0.62,
        showfliers=False,
        boxprops=line,
        whiskerprops=line,
        capprops=line,
        medianprops={"color": HEAD_COLOURS[1], "linewidth": 1.8},
    )
    axes.set_yticks(list(positions), [method for method, _ in gaps])
    axes.set_xlabel("gap to the proved bound [%]")
    axes.set_xlim(left=min(0.0, -0.02 * max((float(b.max()) for b in boxes if len(b)), default=1.0)))
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
    axes.step(imbalances, travel, where="pre", color=HEAD_COLOURS[0], alpha=0.4, linewidth=1.2, zorder=2)
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
        label="proved bound",
    )
    axes.set_xlabel("imbalance [s]")
    axes.set_ylabel("travel [mm]")
    axes.set_title(f"{name}: least travel under a limit on imbalance", fontsize=10)
    axes.grid(color=UNCUT, alpha=0.25, linewidth=0.7)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False)
    return figure
