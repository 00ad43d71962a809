"""The oracle of entry points agrees with the plainest enumeration, and with brute force where it applies."""

from itertools import permutations, product

import numpy as np
import pytest

from cutgap.instances import Rules
from oracles.brute_force import brute_force
from oracles.entry_tours import best_plan, broken_rules, value_of
from oracles.problem import plain_problem
from oracles.random_instances import random_instance
from oracles.random_sheets import random_sheet


def every_plan(sizes, heads):
    for assigned in product(range(heads), repeat=len(sizes)):
        shares = [[c for c, head in enumerate(assigned) if head == each] for each in range(heads)]
        for orders in product(*(permutations(share) for share in shares)):
            for entries in product(*map(range, sizes)):
                yield tuple(tuple((c, entries[c]) for c in order) for order in orders)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("heads", [1, 2])
def test_agrees_with_the_plainest_enumeration(heads, seed):
    rng = np.random.default_rng((heads, seed))
    instance = random_sheet(rng, int(rng.integers(1, 4)), heads=heads, homes=None, entries=2, nested=0.9)
    flags = [bool(each) for each in rng.random(5) < 0.5]
    rules = Rules("travel", 0.0, [None, 0.0][int(rng.integers(2))], None, *flags, backward_price=1.0)
    problem = plain_problem(instance)
    sizes = [len(contour.entry_points) for contour in instance.contours]
    allowed = [tours for tours in every_plan(sizes, heads) if not broken_rules(instance, rules, tours)]
    best = best_plan(instance, rules)
    assert (best is None) == (not allowed)
    if best is not None:
        assert best.value == pytest.approx(min(value_of(problem, rules, tours) for tours in allowed), rel=1e-12)
        assert not broken_rules(instance, rules, best.tours)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("heads", [1, 2])
def test_agrees_with_brute_force_without_process_rules(heads, seed):
    rng = np.random.default_rng((5, heads, seed))
    instance = random_instance(
        rng, int(rng.integers(0, 5)), heads=heads, homes=None, entries=2, precedence=0.3 if heads == 1 else 0.0
    )
    rules = Rules("travel", non_overlap=0.0, via_points=bool(rng.random() < 0.5), empty_heads=True)
    best, expected = best_plan(instance, rules), brute_force(instance, rules)
    assert (best is None) == (expected is None)
    assert best is None or best.value == pytest.approx(expected.value, rel=1e-12, abs=1e-9)
