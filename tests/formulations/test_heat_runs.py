"""Runs of visits that overheat: every combination of their points does, and points alone are told exactly."""

from itertools import product

import numpy as np
import pytest
from oracles.heat_plates import tied_plate

from cutgap.formulations.heat.plates import plan_of, plate_of
from cutgap.formulations.heat.runs import least_rise_at, overheats, rise_from, widened
from cutgap.instances import Rules
from cutgap.instances.heat import rises


def drawn(seed):
    """Return a plate with its instance, and one point of each contour in some order."""
    rng = np.random.default_rng(seed)
    instance = tied_plate(rng, int(rng.integers(2, 6)), points=3)
    plate = plate_of(instance, Rules("travel"))
    order = rng.permutation(len(instance.contours))
    return instance, plate, [int(plate.first[c]) + int(rng.integers(3)) for c in order]


def last_rise(instance, plate, points):
    return rises(instance, plan_of(plate, np.array(points)))[int(plate.contour_of[points[-1]])]


@pytest.mark.parametrize("seed", range(30))
def test_one_point_of_each_contour_is_told_exactly(seed):
    instance, plate, points = drawn(seed)
    rise = last_rise(instance, plate, points)
    choices = np.array(points[:-1])[:, None]
    assert least_rise_at(plate, points[-1], choices, np.ones(len(choices), dtype=int)) == pytest.approx(rise)
    assert rise_from(plate, np.array(points), 0, len(points) - 1) == pytest.approx(rise)


@pytest.mark.parametrize("seed", range(60))
@pytest.mark.parametrize("share", [0.5, 0.999])
def test_all_combinations_of_a_run_overheat(seed, share):
    instance, plate, points = drawn(seed)
    rise = last_rise(instance, plate, points)
    cap = share * min(rise, 1e3)
    run = widened(plate, points, cap)
    assert all(point in each for point, each in zip(points, run, strict=True))
    for combination in product(*run):
        assert last_rise(instance, plate, combination) > cap


@pytest.mark.parametrize("seed", range(60))
def test_sets_of_which_a_combination_is_cool_are_no_run(seed):
    instance, plate, points = drawn(seed)
    rng = np.random.default_rng(seed)
    sets = []
    for point in points:
        first = int(plate.first[plate.contour_of[point]])
        sets.append((first + rng.permutation(3)[: rng.integers(1, 4)]).tolist())
    coolest = min(last_rise(instance, plate, each) for each in product(*sets))
    if np.isfinite(coolest):
        assert not overheats(plate, sets, coolest * (1.0 + 1e-9) + 1e-9)
