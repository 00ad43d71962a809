from dataclasses import replace

import numpy as np
import pytest
from oracles.entry_tours import best_plan
from oracles.random_instances import random_instance
from oracles.random_rows import random_row

from cutgap.heuristics import entry_search
from cutgap.heuristics.effort import SearchEffort
from cutgap.instances import Contour, Head, Instance, Machine, Rules, check, evaluate

QUICK = SearchEffort(rounds_per_contour=50)
ALONE = (
    Rules("travel"),
    Rules(),
    Rules("travel", parts_in_one_go=True),
    Rules("travel", neighbours_only=True),
    Rules("travel", clear_rapids=True),
    Rules("travel", backward_price=1.5),
)
TOGETHER = Rules("travel", parts_in_one_go=True, neighbours_only=True, clear_rapids=True, backward_price=0.5)


@pytest.mark.parametrize("home", [True, False])
@pytest.mark.parametrize("rules", [*ALONE, TOGETHER], ids=str)
def test_keeps_every_rule_and_finds_nearly_all_optima(rules, home):
    found = tried = 0
    for seed in range(24):
        rng = np.random.default_rng([seed, 3])
        sheet = random_row(rng, 5, entries=3, home=home, slender=seed % 2 == 0)
        best = best_plan(sheet, rules)
        plan = entry_search(sheet, rules, rng=rng, parameters=QUICK)
        violations = {violation.constraint for violation in check(sheet, rules, plan)}
        if best is None:
            assert violations
            assert violations <= {"clear rapids", "neighbours only"}
            continue
        assert not violations
        tried += 1
        least = evaluate(sheet, best.plan).objective(rules)
        value = evaluate(sheet, plan).objective(rules)
        assert value >= least * (1 - 1e-12)
        found += value <= least * (1 + 1e-12)
    assert tried >= 8
    assert found >= 0.95 * tried


@pytest.mark.parametrize("metric", ["euclidean", "chebyshev", "matrix"])
@pytest.mark.parametrize("precedence", [0.0, 0.3])
def test_precedence_and_any_metric_against_brute_force(metric, precedence):
    rules, found, tried = Rules("travel"), 0, 40
    for seed in range(tried):
        rng = np.random.default_rng([seed, 4])
        instance = random_instance(
            rng, seed % 6, heads=1, homes=None, metric=metric, entries=3, precedence=precedence
        )
        plan = entry_search(instance, rules, rng=rng, parameters=QUICK)
        assert not check(instance, rules, plan)
        least = best_plan(instance, rules).value if instance.contours else 0.0
        value = evaluate(instance, plan).objective(rules)
        assert value >= least - 1e-9
        found += value <= least + 1e-9
    assert found >= 0.95 * tried


def test_parts_that_the_precedence_forbids_to_cut_in_one_go_break_that_rule_alone():
    rng = np.random.default_rng(5)
    points = rng.uniform(0, 100, (4, 1, 3))
    contours = tuple(Contour(str(i), points[i], 1.0, f"part {i % 2}", "inner") for i in range(4))
    instance = Instance("interleaved", contours, (Head("h"),), precedence=((0, 1), (1, 2)))
    rules = Rules("travel", parts_in_one_go=True)
    plan = entry_search(instance, rules, rng=rng, parameters=QUICK)
    assert {violation.constraint for violation in check(instance, rules, plan)} == {"parts in one go"}


def random_nest(contours=20, **options):
    return random_instance(
        np.random.default_rng(8), contours, layout="uniform", heads=1, entries=6, precedence=0.05, **options
    )


def test_same_seed_same_plan_and_another_seed_another_way():
    nest, seen = random_nest(), []
    plans = [
        entry_search(nest, Rules("travel"), rng=np.random.default_rng(s), watch=seen.append, parameters=QUICK)
        for s in (4, 4, 5)
    ]
    assert plans[0] == plans[1]
    values = [progress.value for progress in seen]
    assert len(set(values)) > 3


def test_progress_falls_to_the_value_of_the_plan():
    nest, rules, seen = random_nest(), Rules(), []
    plan = entry_search(nest, rules, rng=np.random.default_rng(3), watch=seen.append, parameters=QUICK)
    values = [progress.value for progress in seen]
    assert values == sorted(values, reverse=True)
    assert values[-1] == evaluate(nest, plan).objective(rules)


def test_progress_has_no_value_while_rules_are_broken():
    hidden = [random_row(np.random.default_rng([seed, 3]), 5, slender=True) for seed in range(12)]
    rules = Rules("travel", clear_rapids=True)
    impossible = next(sheet for sheet in hidden if best_plan(sheet, rules) is None)
    seen = []
    entry_search(impossible, rules, rng=np.random.default_rng(0), watch=seen.append, parameters=QUICK)
    assert [progress.value for progress in seen] == [None] * len(seen) != []


def test_stops_with_the_best_plan_so_far():
    nest, rules = random_nest(30), Rules("travel")

    def interrupt(progress):
        seen.append(progress.value)
        if len(seen) == 2:
            raise KeyboardInterrupt

    seen = []
    plan = entry_search(nest, rules, rng=np.random.default_rng(0), watch=interrupt)
    assert evaluate(nest, plan).objective(rules) == seen[1] < seen[0]
    stopped = entry_search(nest, rules, rng=np.random.default_rng(0), time_limit=0.0)
    assert evaluate(nest, stopped).objective(rules) == seen[0]
    assert not check(nest, rules, stopped)


@pytest.mark.parametrize("home", [True, False])
@pytest.mark.parametrize("contours", [0, 1, 2, 5])
def test_coincident_points_and_few_contours(contours, home):
    place = np.full((3, 3), 7.0)
    head = Head("h", np.full(3, 7.0) if home else None)
    instance = Instance("heap", tuple(Contour(str(i), place, 0.0) for i in range(contours)), (head,))
    plan = entry_search(instance, Rules("travel"), rng=np.random.default_rng(0))
    assert not check(instance, Rules("travel"), plan)
    assert evaluate(instance, plan).total_travel_mm == 0.0


def test_more_effort_is_not_worse():
    nest, rules = random_nest(40), Rules("travel")
    values = [
        evaluate(
            nest, entry_search(nest, rules, rng=np.random.default_rng(1), parameters=SearchEffort(n))
        ).total_travel_mm
        for n in (0, 50)
    ]
    assert values[1] < values[0]


def test_what_is_not_supported_is_named():
    rng = np.random.default_rng(0)
    with pytest.raises(ValueError, match="one head, got 2"):
        entry_search(random_instance(rng, 4), Rules("travel"), rng=rng)
    nest = random_nest(4)
    with pytest.raises(ValueError, match="via points"):
        entry_search(nest, Rules(via_points=True), rng=rng)
    with pytest.raises(ValueError, match="geometry"):
        entry_search(nest, Rules(clear_rapids=True), rng=rng)
    lengths = rng.uniform(0, 9, (nest.node_count, nest.node_count))
    bare = replace(nest, machine=Machine(metric="matrix"), matrix=lengths, located=False)
    with pytest.raises(ValueError, match="coordinates"):
        entry_search(bare, Rules("travel", backward_price=1.0), rng=rng)
    with pytest.raises(ValueError, match="rounds_per_contour"):
        SearchEffort(rounds_per_contour=-1)
