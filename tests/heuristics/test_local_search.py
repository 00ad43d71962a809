import numpy as np
import pytest
from heuristics_parts import FOR_TWO_HEADS, RULES, random_part
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.brute_force import AllPlans
from oracles.random_instances import random_instance

from cutgap.heuristics import HEURISTICS, local_search
from cutgap.heuristics.local_search import LocalSearchParameters
from cutgap.heuristics.side_search import adapt_tour, search_side
from cutgap.heuristics.sides import side_tour
from cutgap.heuristics.task_balancing import task_balancing
from cutgap.instances import Contour, Head, Instance, Rules, check, evaluate

SEEDS = st.integers(0, 2**32 - 1)
QUICK = LocalSearchParameters(kicks=60, survey_kicks=5, finalists=4, reassignments=30)
TRIED_RULES = (
    *RULES,
    Rules(non_overlap=None, via_points=True),
    Rules(non_overlap=None, objective="weighted", weight=50.0),
    Rules(non_overlap=None, empty_heads=True, objective="travel"),
)


@settings(deadline=None, max_examples=40)
@given(SEEDS, st.integers(0, 6), st.sampled_from(TRIED_RULES), st.sampled_from(["euclidean", "chebyshev"]))
def test_never_better_than_brute_force_and_allowed_where_a_plan_is(seed, holes, rules, metric):
    rng = np.random.default_rng(seed)
    part = random_instance(rng, holes, homes=None, metric=metric)
    plan = local_search(part, rules, rng=rng, parameters=QUICK)
    best = AllPlans(part).best(rules)
    violations = check(part, rules, plan)
    if best is None:
        assert violations
        return
    assert not violations
    assert evaluate(part, plan).objective(rules) >= best.value - 1e-9 * max(1.0, best.value)


@pytest.mark.parametrize("rules", TRIED_RULES, ids=str)
def test_finds_the_optimum_of_most_tiny_parts(rules):
    found = tried = 0
    for seed in range(12):
        rng = np.random.default_rng([seed, 77])
        part = random_instance(rng, 5)
        best = AllPlans(part).best(rules)
        if best is None:
            continue
        plan = local_search(part, rules, rng=rng, parameters=QUICK)
        tried += 1
        found += evaluate(part, plan).objective(rules) <= best.value + 1e-9 * max(1.0, best.value)
    assert tried >= 6
    assert found >= 0.9 * tried


@pytest.mark.parametrize("via_points", [False, True])
@pytest.mark.parametrize("metric", ["euclidean", "matrix"])
def test_side_tours_are_mostly_optimal_on_tiny_parts(via_points, metric):
    rules = Rules(objective="travel", via_points=via_points)
    found = 0
    for seed in range(20):
        rng = np.random.default_rng([seed, 5])
        part = random_instance(rng, 5, heads=1, homes=None, metric=metric)
        side = search_side(part, rules, 0, range(5), kicks=200, rng=rng)
        best = AllPlans(part).best(rules).value
        assert side.travel_mm >= best - 1e-9
        found += side.travel_mm <= best + 1e-9
    # Arbitrary asymmetric lengths leave only moves that keep the direction: not all optima are in reach.
    assert found >= (18 if metric == "matrix" else 20)


@pytest.mark.parametrize("heads", [1, 2, 3])
def test_any_number_of_heads_where_overlap_is_allowed(heads):
    rng = np.random.default_rng(heads)
    part, rules = random_part(rng, 20, heads=heads), Rules(non_overlap=None)
    quick = local_search(part, rules, rng=np.random.default_rng(0), parameters=QUICK)
    none = LocalSearchParameters(kicks=60, reassignments=0)
    without = local_search(part, rules, rng=np.random.default_rng(0), parameters=none)
    assert not check(part, rules, quick)
    assert evaluate(part, quick).makespan_s <= evaluate(part, without).makespan_s


def test_two_heads_share_a_column_of_equal_x():
    # All x are equal: any partition keeps a gap of 0, and the best one is by y, which no order by x can find.
    ys = [0.0, 100.0, 10.0, 110.0]
    contours = tuple(Contour(f"{i}", np.array([[50.0, y, 0.0]]), 0.0) for i, y in enumerate(ys))
    heads = (Head("top", np.array([50.0, 105.0, 0.0])), Head("bottom", np.array([50.0, 5.0, 0.0])))
    part, rules = Instance("column", contours, heads), Rules(objective="travel")
    plan = local_search(part, rules, rng=np.random.default_rng(1))
    assert evaluate(part, plan).total_travel_mm == pytest.approx(40.0)


def test_not_worse_than_task_balancing():
    for seed in range(3):
        rng = np.random.default_rng(seed)
        part, rules = random_part(rng, 30), Rules(via_points=True)
        local, published = (
            evaluate(part, method(part, rules, rng=np.random.default_rng(seed))).makespan_s
            for method in (local_search, task_balancing)
        )
        assert local <= published


@pytest.mark.parametrize("name", FOR_TWO_HEADS)
def test_same_seed_same_plan(name):
    part = random_part(np.random.default_rng(9), 14, tied=True)
    first, second = (HEURISTICS[name](part, Rules(), rng=np.random.default_rng(4)) for _ in range(2))
    assert first == second


@pytest.mark.parametrize("name", FOR_TWO_HEADS)
def test_progress_ends_at_the_value_of_the_plan(name):
    part, rules, seen = random_part(np.random.default_rng(3), 12), Rules(), []
    plan = HEURISTICS[name](part, rules, rng=np.random.default_rng(3), watch=seen.append)
    values = [progress.value for progress in seen]
    assert evaluate(part, plan).objective(rules) == pytest.approx(values[-1])


@pytest.mark.parametrize("rules", [Rules(), Rules(non_overlap=None)])
def test_stops_with_the_best_plan_so_far(rules):
    part = random_part(np.random.default_rng(5), 25)

    def interrupt(progress):
        if seen:
            raise KeyboardInterrupt
        seen.append(progress.value)

    seen = []
    plan = local_search(part, rules, rng=np.random.default_rng(0), watch=interrupt)
    assert not check(part, rules, plan)
    assert evaluate(part, plan).objective(rules) <= seen[0]
    stopped = local_search(part, rules, rng=np.random.default_rng(0), time_limit=0.0)
    assert not check(part, rules, stopped)


@pytest.mark.parametrize("name", FOR_TWO_HEADS)
def test_what_is_not_supported_is_named(name):
    rng, method = np.random.default_rng(0), HEURISTICS[name]
    with pytest.raises(ValueError, match="two heads"):
        method(random_part(rng, 5, heads=3), Rules(), rng=rng)
    with pytest.raises(ValueError, match="entry points"):
        method(random_instance(np.random.default_rng(2), 5, entries=3), Rules(), rng=rng)
    with pytest.raises(ValueError, match="precedence"):
        method(random_instance(rng, 5, precedence=0.9), Rules(), rng=rng)
    bare = random_instance(rng, 4, metric="matrix")
    bare = Instance("bare", bare.contours, bare.heads, bare.machine, (), bare.matrix, located=False)
    with pytest.raises(ValueError, match="coordinates"):
        method(bare, Rules(), rng=rng)


def test_bare_matrix_is_planned_where_overlap_is_allowed():
    given_part = random_instance(np.random.default_rng(3), 5, metric="matrix", layout="uniform")
    part = Instance(
        "bare", given_part.contours, given_part.heads, given_part.machine, (), given_part.matrix, located=False
    )
    rules = Rules(objective="travel", non_overlap=None)
    plan = local_search(part, rules, rng=np.random.default_rng(0))
    assert evaluate(part, plan).objective(rules) == pytest.approx(AllPlans(given_part).best(rules).value)


@given(SEEDS, st.integers(0, 12))
def test_adapted_tours_have_the_asked_contours(seed, holes):
    rng = np.random.default_rng(seed)
    part = random_part(rng, holes)
    old, new = (rng.permutation(holes)[: int(rng.integers(holes + 1))] for _ in range(2))
    adapted = adapt_tour(part, 0, old.tolist(), new)
    assert sorted(adapted) == sorted(new)
    side = side_tour(part, 0, adapted)
    assert side.time_s >= side.travel_mm / part.machine.v_jump


@pytest.mark.parametrize("field", ["kicks", "survey_kicks", "finalists", "reassignments"])
def test_bad_parameters_are_named(field):
    with pytest.raises(ValueError, match=field):
        LocalSearchParameters(**{field: -1})
