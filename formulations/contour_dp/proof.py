"""Certificates of the dynamic programme: prices and memories, from which the checker computes the bound again.

Any stage of the ascent proves the bound, since the checker's programme is exact; stages with small memories
make its relaxation short and its exact part long. The one that promises the least work is taken.
"""

from collections.abc import Sequence

import numpy as np

from cutgap.formulations.certify import MULTIPLIERS_UNUSED, SCALE, Certificate, certificate_of
from cutgap.formulations.contour_dp.ascent import Relaxed, Stage, possible
from cutgap.formulations.contour_dp.closing import Closing
from cutgap.formulations.contour_dp.search import MOST_CONTOURS, search
from cutgap.formulations.contour_dp.walks import Walks
from cutgap.instances import Instance, Plan, Rules

WHOLE_SCALE = 1000
"""Units per mm where all lengths are whole: the integers then stay small, and quick."""

MOST_ROWS = 300_000
"""Rows that the exact part of a proof may have."""

MOST_WORK = 1e8
"""Rows times points of a proof beyond which there is none; a million takes the checker about a second."""


def contour_certificate(
    instance: Instance,
    rules: Rules,
    plan: Plan | None,
    bound: float,
    step: float,
    closings: Sequence[Closing],
) -> Certificate | None:
    """Return a verified certificate that no plan costs less than ``bound`` mm; ``None`` if it is too long.

    ``step`` is 1 where all lengths are whole, so that the bound is proved from a step below.
    """
    scale = WHOLE_SCALE if step > 0.0 else SCALE
    limit = bound - step * (1.0 - 1e-6)
    stages = [cheapest_stage(each, limit) for each in closings]
    if any(stage is None for stage in stages):
        return None
    walks = [
        walk_item(instance, each.walks, stage, scale)
        for each, stage in zip(closings, stages, strict=True)
        if stage is not None
    ]
    walks = walks or stays(instance)
    work = (
        float(instance.service_times.sum()) * instance.machine.v_jump if rules.objective == "makespan" else 0.0
    )

    def claim(margin: float) -> tuple[int, dict[str, object]]:
        kept = 0.0 if step > 0.0 and rules.objective != "makespan" else margin
        return max(0, int(np.floor((bound + work - kept) * scale))), {"kind": "contour-dp", "walks": walks}

    return certificate_of(instance, rules, plan, MULTIPLIERS_UNUSED, claim, scale)


def stays(instance: Instance) -> list[dict[str, object]]:
    """Return the items of walks without contours: from a home, or from each entry point of the only contour."""
    firsts: list[object] = [[c.id, entry] for c in instance.contours for entry in range(len(c.entry_points))]
    hints = {"prices": [0] * len(instance.contours), "memories": [[]] * len(instance.contours)}
    return [{"first": first, **hints} for first in firsts or [None]]


def walk_item(instance: Instance, walks: Walks, stage: Stage, scale: int) -> dict[str, object]:
    """Return a stage as in a certificate: over all contours of the instance, by number."""
    prices = [0] * len(instance.contours)
    memories: list[list[int]] = [[] for _ in instance.contours]
    numbers = walks.contours.tolist()
    for contour, price, members in zip(numbers, stage.prices, stage.members, strict=True):
        prices[contour] = round(price * scale)
        memories[contour] = [numbers[member] for member in members]
    first = None
    if walks.prefix:
        visit = walks.prefix[0]
        first = [instance.contours[visit.contour].id, visit.entry]
    return {"first": first, "prices": prices, "memories": memories}


def cheapest_stage(closing: Closing, limit: float) -> Stage | None:
    """Return the stage with which the checker has the least to do; ``None`` if each is too much, or not known.

    The checker extends a row of the relaxed part to all points, one of the exact part to half of them.
    """
    best, least = None, MOST_WORK
    if closing.walks.count > MOST_CONTOURS:
        return None
    for stage in closing.ascent.found.stages:
        found = Relaxed(limit, -np.inf, possible(closing.walks), [stage])
        result = search(closing.walks, found, MOST_ROWS)
        work = (result.relaxed_rows + result.rows / 2) * len(closing.walks.end)
        if result.complete and work < least:
            best, least = stage, work
    return best
