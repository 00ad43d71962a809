"""The best entry points for a given order against all choices of entry points."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.problem import plain_problem, tour_length
from oracles.random_instances import random_instance
from oracles.square_parts import square_parts

from cutgap.instances import Plan, Rules, Visit, check, evaluate
from cutgap.instances.entry_choice import best_entries

SEEDS = st.integers(0, 2**32 - 1)


def all_tours(instance, order):
    choices = product(*(range(len(instance.contours[c].entry_points)) for c in order))
    return [tuple(map(Visit, order, entries)) for entries in choices]


@given(SEEDS, st.integers(1, 5), st.sampled_from(["euclidean", "chebyshev", "matrix"]), st.booleans())
@settings(max_examples=60)
def test_no_choice_is_shorter(seed, holes, metric, homes):
    rng = np.random.default_rng(seed)
    instance = random_instance(rng, holes, heads=2, homes=homes, metric=metric, entries=4)
    order, head = rng.permutation(holes)[: int(rng.integers(1, holes + 1))].tolist(), int(rng.integers(2))
    tour = best_entries(instance, Rules("travel"), order, head)
    assert [visit.contour for visit in tour] == order
    problem = plain_problem(instance)
    least = min(tour_length(problem, head, other) for other in all_tours(instance, order))
    assert tour_length(problem, head, tour) == pytest.approx(least, abs=1e-9)


@given(SEEDS, st.booleans(), st.booleans(), st.sampled_from([0.0, 0.3, 5.0]))
@settings(max_examples=60)
def test_no_choice_is_better_under_clear_rapids_and_a_price(seed, home, clear, price):
    rng = np.random.default_rng(seed)
    instance = square_parts(rng, 2, 2, holes=0.3, home=home, entries=3)
    rules = Rules("travel", clear_rapids=clear, backward_price=price)
    order = rng.permutation(len(instance.contours)).tolist()
    tour = best_entries(instance, rules, order)
    values = [
        evaluate(instance, Plan((other,))).objective(rules)
        for other in all_tours(instance, order)
        if "clear rapids" not in {violation.constraint for violation in check(instance, rules, Plan((other,)))}
    ]
    if tour is None:
        assert not values
        return
    plan = Plan((tour,))
    assert "clear rapids" not in {violation.constraint for violation in check(instance, rules, plan)}
    assert evaluate(instance, plan).objective(rules) == pytest.approx(min(values), abs=1e-9)


def test_both_answers_occur_under_clear_rapids():
    rng, rules = np.random.default_rng(0), Rules("travel", clear_rapids=True)
    answers = []
    for _ in range(40):
        instance = square_parts(rng, 2, 2, holes=0.3, entries=3)
        answers.append(best_entries(instance, rules, rng.permutation(len(instance.contours))) is None)
    assert 0 < sum(answers) < 40


def test_no_contours_need_no_points():
    assert best_entries(square_parts(np.random.default_rng(0), 2, 1), Rules("travel"), []) == ()


@pytest.mark.parametrize(
    ("order", "message"),
    [([0, 0], "order: names a contour more than once"), ([0, 9], "order: no contour 9 among 2")],
)
def test_bad_orders_are_named(order, message):
    with pytest.raises(ValueError, match=message):
        best_entries(square_parts(np.random.default_rng(0), 2, 1, holes=0.0), Rules("travel"), order)
