"""On dense plates heat matters: a short route is more than twice as hot as it has to be."""

import math

import numpy as np
import pytest

from cutgap.heuristics import entry_search
from cutgap.heuristics.dual_coded_operators import random_shift
from cutgap.heuristics.hot_routes import barred_steps, peak_rise, plan_of_route, plate_of, random_route
from cutgap.instances import Rules, check, evaluate
from cutgap.instances.generate import generate

RULES = Rules("travel", clear_rapids=True)


def cool_plan(instance, rng, steps):
    """Anneal the peak over shifts of the order and changes of starts."""
    plate = plate_of(instance, RULES)
    count = len(instance.contours)
    sizes = np.diff(instance.first_node)
    order, starts, room = np.zeros(count, np.int64), np.zeros(count, np.int64), np.empty(count)
    random_route(plate, order, starts, rng)
    now = lowest = peak_rise(plate, order, starts, room)
    best = order, starts
    for step in range(steps):
        new_order, new_starts = order.copy(), starts.copy()
        if rng.random() < 0.6:
            random_shift(new_order, rng)
        contour = rng.integers(count)
        new_starts[contour] = rng.integers(sizes[contour])
        if barred_steps(plate, new_order, new_starts, 0) > 0:
            continue
        rise = peak_rise(plate, new_order, new_starts, room)
        heat = 10.0 * (1.0 - step / steps) ** 2 + 1e-9
        if rng.random() < math.exp(min(0.0, (now - rise) / heat)):
            order, starts, now = new_order, new_starts, rise
            if now < lowest:
                lowest, best = now, (order, starts)
    return plan_of_route(*best)


@pytest.mark.parametrize("holes", [6, 8, 10, 12])
@pytest.mark.parametrize("seed", range(2))
def test_a_shortest_route_is_more_than_twice_as_hot_as_it_has_to_be(holes, seed):
    instance = generate("dense-plate", holes=holes, seed=seed)
    cool = cool_plan(instance, np.random.default_rng(seed), 20_000)
    short = entry_search(instance, RULES, rng=np.random.default_rng(0))
    assert not check(instance, RULES, cool)
    assert not check(instance, RULES, short)
    rises = [
        evaluate(instance, plan).peak_temperature_c - instance.material.ambient_c for plan in (short, cool)
    ]
    assert rises[0] > 2.0 * rises[1]


def test_on_the_published_plate_the_published_constants_leave_next_to_no_heat():
    instance = generate("plate", seed=1)
    plan = entry_search(instance, RULES, rng=np.random.default_rng(0))
    # Contours stand tens of cm apart, and heat goes 5 cm while one is cut.
    assert rise_of(instance, plan) < 1.0


def rise_of(instance, plan):
    return evaluate(instance, plan).peak_temperature_c - instance.material.ambient_c
