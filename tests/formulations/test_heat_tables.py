"""The tables under the heat search: least rises hold for every plan within a limit on travel."""

from itertools import pairwise, permutations

import numpy as np
import pytest
from oracles.heat_plates import tied_plate

from cutgap.formulations.heat.plates import plate_of
from cutgap.formulations.heat.tables import no_warmth, rooms, travel_table, warm_of, warm_table
from cutgap.instances import Plan, Rules, evaluate
from cutgap.instances.heat import rises

CONTOURS = 5


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("share", [0.0, 0.1, 0.4, 1.0])
def test_no_plan_within_the_limit_is_cooler_than_the_table(seed, share):
    instance = tied_plate(np.random.default_rng(seed), CONTOURS, points=1)
    plans = [Plan.of_contours([order]) for order in permutations(range(CONTOURS))]
    travel = [evaluate(instance, plan).total_travel_mm for plan in plans]
    limit = float(np.quantile(travel, share))
    plate = plate_of(instance, Rules("travel"))
    bare = travel_table(plate, plate.back.min(axis=1), no_warmth(), np.inf)
    room = rooms(plate, bare, limit - float(plate.out.min()), instance.machine.v_jump)
    warm = warm_table(plate, room)
    within = [plan for plan, length in zip(plans, travel, strict=True) if length <= limit]
    assert within
    for plan in within:
        found, cut = rises(instance, plan), 0
        for one, other in pairwise(visit.contour for visit in plan.tours[0]):
            cut |= 1 << one
            assert warm_of(warm, plate, one, other, cut) <= found[other] * (1 + 1e-9)


def test_two_contours_leave_nothing_to_bound():
    instance = tied_plate(np.random.default_rng(1), 2, points=2)
    plate = plate_of(instance, Rules("travel"))
    warm = warm_table(plate, rooms(plate, np.zeros((4, 4)), np.inf, 1.0))
    for first, second in ((0, 2), (1, 3), (2, 1)):
        contours = [int(plate.contour_of[first]), int(plate.contour_of[second])]
        entries = [first - int(plate.first[contours[0]]), second - int(plate.first[contours[1]])]
        plan = Plan((tuple(zip(contours, entries, strict=True)),))
        rise = rises(instance, plan)[contours[1]]
        assert warm_of(warm, plate, first, second, 1 << contours[0]) == pytest.approx(rise, rel=1e-5)
