"""The oracle of heat, by hand and against the package's evaluation and check."""

from itertools import pairwise, permutations, product

import numpy as np
import pytest

from cutgap.instances import Contour, Head, Instance, Machine, Material, Plan, Rules, Visit, check, evaluate
from oracles.heat import hot_plans
from oracles.random_plates import random_plate

STEEL = Material("steel", 48.0, 480.0, 7850.0, thickness_mm=5.0, power_w=1000.0)


def spike(name, x):
    """A thin triangle with its start at (x, 0)."""
    curve = np.array([[x, 0.0], [x + 1.0, -30.0], [x - 1.0, -30.0]])
    return Contour(name, np.array([[x, 0.0, 0.0]]), 20.0, geometry=curve)


def test_three_starts_in_a_row_by_hand():
    row = Instance(
        "row",
        (spike("a", 0.0), spike("b", 10.0), spike("c", 25.0)),
        (Head("h", np.array([0.0, 0.0, 0.0])),),
        Machine(v_jump=100.0, v_cut=50.0, t_aux=0.0),
        material=STEEL,
    )
    plans = {plan.tour: plan for plan in hot_plans(row).plans}
    assert len(plans) == 6
    in_order = plans[(0, 0), (1, 0), (2, 0)]
    assert in_order.travel == pytest.approx(50.0)
    # From 10 mm beside the tip a plumb line meets the flank, 1 to 30, just below the tip.
    distance = 10.0 * 30.0 / np.hypot(30.0, 1.0) * 1e-3
    line = 1000.0 / (0.05 * 0.005) / np.sqrt(4 * np.pi * 48.0 * 480.0 * 7850.0)
    spread = 4 * 48.0 / (480.0 * 7850.0)

    def rise(metres, seconds):
        return line / np.sqrt(seconds) * np.exp(-(metres**2) / (spread * seconds))

    at_b = rise(distance, 0.1)
    at_c = rise(1.5 * distance, 0.15) + rise(2.5 * distance, 0.1 + 0.4 + 0.15)
    assert in_order.peak == pytest.approx(20.0 + max(at_b, at_c), rel=1e-9)


@pytest.mark.parametrize("seed", range(30))
def test_agrees_with_evaluate_and_check_plan_by_plan(seed):
    rng = np.random.default_rng(seed)
    instance = random_plate(rng, int(rng.integers(1, 5)), entries=2, homes=None, precedence=None, nested=0.6)
    clear = bool(rng.random() < 0.5)
    rules = Rules("peak", clear_rapids=clear)
    found = {plan.tour: plan for plan in hot_plans(instance, clear_rapids=clear).plans}
    sizes = [len(contour.entry_points) for contour in instance.contours]
    for order in permutations(range(len(sizes))):
        for entries in product(*(range(sizes[contour]) for contour in order)):
            tour = tuple(zip(order, entries, strict=True))
            plan = Plan((tuple(Visit(*visit) for visit in tour),))
            assert (tour in found) == (not check(instance, rules, plan))
            if tour in found:
                value = evaluate(instance, plan)
                assert found[tour].travel == pytest.approx(value.total_travel_mm, rel=1e-9)
                assert found[tour].peak == pytest.approx(value.peak_temperature_c, rel=1e-9)


@pytest.mark.parametrize("seed", range(10))
def test_the_best_plans_are_ends_of_the_front_and_a_cap_walks_along_it(seed):
    plans = hot_plans(random_plate(np.random.default_rng((1, seed)), 4))
    front = plans.front()
    assert (front[0], front[-1].peak) == (plans.least_travel(), plans.least_peak().peak)
    assert all(a.travel < b.travel and a.peak > b.peak for a, b in pairwise(front))
    for plan in front:
        assert plans.least_travel(plan.peak) == plan
    assert plans.least_travel(front[-1].peak - 1e-3) is None
    for plan in plans.plans:
        assert any(best.travel <= plan.travel and best.peak <= plan.peak for best in front)
