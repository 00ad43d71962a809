"""Divisions of the contours among two heads to start from: balanced ones, and ones all over the sheet."""

import numpy as np

from cutgap.formulations.contour_dp.division import LEFT, RIGHT, Division, Region
from cutgap.instances import Instance, Rules

EACH = 5
"""Most divisions of either kind."""


def first_divisions(instance: Instance, rules: Rules, division: Division, whole: Region) -> list[Region]:
    """Return regions without free contours: those of least work on the busier head, and evenly spread ones."""
    places = [
        (threshold, prefix)
        for threshold in range(whole.low, whole.high + 1)
        for prefix in range(_free_count(division, whole, threshold) + 1)
    ]
    regions = [
        region
        for threshold, prefix in places
        if (region := _division(instance, division, whole, threshold, prefix)) is not None
    ]
    work = instance.service_times

    def busier(region: Region) -> float:
        return float(max(work[region.side == LEFT].sum(), work[region.side == RIGHT].sum()))

    spread = np.linspace(0, len(regions) - 1, EACH).round().astype(int).tolist() if regions else []
    chosen = [*sorted(regions, key=busier)[:EACH], *(regions[i] for i in spread)]
    return list({region.side.tobytes(): region for region in chosen}.values())


def _free_count(division: Division, whole: Region, threshold: int) -> int:
    region = division.narrowed(Region(threshold, threshold, whole.side))
    return 0 if region is None else len(region.free)


def _division(
    instance: Instance, division: Division, whole: Region, threshold: int, prefix: int
) -> Region | None:
    """Return the region of a threshold in which the left head has the ``prefix`` nearest free contours."""
    region = division.narrowed(Region(threshold, threshold, whole.side))
    if region is None:
        return None
    side = region.side.copy()
    near = sorted(region.free, key=lambda contour: _nearness(instance, contour))
    side[near[:prefix]], side[near[prefix:]] = LEFT, RIGHT
    return division.narrowed(Region(threshold, threshold, side))


def _nearness(instance: Instance, contour: int) -> float:
    """Return how much nearer a contour is to the left head's home than to the right head's, mm, negated."""
    nodes = slice(instance.first_node[contour], instance.first_node[contour + 1])
    one, two = (instance.rapids[instance.home_node(head), nodes].min() for head in (0, 1))
    return float(one - two)
