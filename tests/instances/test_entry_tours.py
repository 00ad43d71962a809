from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.random_instances import random_instance
from oracles.random_rows import random_row

from cutgap.instances import Plan, Rules, Visit, check, evaluate
from cutgap.instances.entry_tours import EntrySearch, best_entries, entry_task, search_entries

SEEDS = st.integers(0, 2**32 - 1)
RULES = st.sampled_from(
    [
        Rules("travel"),
        Rules("travel", backward_price=2.0),
        Rules("travel", clear_rapids=True, neighbours_only=True),
    ]
)


@settings(deadline=None, max_examples=60)
@given(SEEDS, st.booleans(), RULES)
def test_best_entries_are_the_best_of_all(seed, home, rules):
    rng = np.random.default_rng(seed)
    sheet = random_row(rng, 4, entries=3, home=home, slender=bool(rng.random() < 0.5))
    order = rng.permutation(4).tolist()
    found = best_entries(entry_task(sheet, rules), order)
    assert sorted(visit.contour for visit in found.visits) == [0, 1, 2, 3]

    entries = [range(len(sheet.contours[c].entry_points)) for c in order]
    plans = [Plan((tuple(map(Visit, order, chosen)),)) for chosen in product(*entries)]
    # The order may break the precedence, which is not what is asked here.
    allowed = [
        evaluate(sheet, plan).objective(rules)
        for plan in plans
        if {violation.constraint for violation in check(sheet, rules, plan)} <= {"precedence"}
    ]
    assert found.cost == pytest.approx(evaluate(sheet, Plan((found.visits,))).objective(rules))
    assert (found.barred == 0) == bool(allowed)
    if allowed:
        assert found.cost == pytest.approx(min(allowed))


@settings(deadline=None, max_examples=30)
@given(SEEDS, st.booleans(), st.sampled_from([0.0, 0.2]))
def test_pieces_do_not_change_what_is_found(seed, home, precedence):
    rng = np.random.default_rng(seed)
    instance = random_instance(rng, 12, heads=1, homes=home, entries=4, precedence=precedence)
    task = entry_task(instance, Rules("travel"))
    search = EntrySearch(task, 60, rng=np.random.default_rng(seed))
    while not search.over:
        search.run(int(rng.integers(1, 30)))
    whole = search_entries(task, rounds=60, rng=np.random.default_rng(seed))
    assert search.best == whole
    plan = Plan((whole.visits,))
    assert not check(instance, Rules("travel"), plan)
    assert evaluate(instance, plan).total_travel_mm == pytest.approx(whole.cost)
    assert whole.cost <= search.cost * (1 + 1e-9)


@pytest.mark.parametrize("order", [[0, 1], [0, 1, 1], [0, 1, 3], [[0, 1, 2]]])
def test_an_order_that_is_none_is_refused(order):
    task = entry_task(random_instance(np.random.default_rng(1), 3, heads=1), Rules("travel"))
    with pytest.raises(ValueError, match="each of 3 contours once"):
        best_entries(task, order)


def test_tasks_of_no_contour_or_two_heads_are_refused():
    rng = np.random.default_rng(1)
    with pytest.raises(ValueError, match="at least one contour"):
        entry_task(random_instance(rng, 0, heads=1), Rules("travel"))
    with pytest.raises(ValueError, match="one head"):
        entry_task(random_instance(rng, 3), Rules("travel"))
