"""One head and several entry points: agrees with brute force and dynamic programming, and is certified."""

from dataclasses import replace

import numpy as np
import pytest
from oracles.brute_force import brute_force
from oracles.entry_tours import best_plan
from oracles.held_karp import shortest_generalized_tour
from oracles.random_instances import LAYOUTS, random_instance
from oracles.random_sheets import random_sheet

from cutgap.formulations import solve
from cutgap.formulations.certificate import verify
from cutgap.instances import Contour, Head, Instance, Machine, Plan, Rules, Visit, check
from cutgap.instances.formats.json_format import format_instance


def symmetric(instance):
    """The instance with the matrix and its transpose added up: no triangle inequality, zeros stay likely."""
    if instance.matrix is None:
        return instance
    return replace(instance, matrix=np.maximum(0.0, instance.matrix + instance.matrix.T - 150.0))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("metric", ["euclidean", "chebyshev", "matrix"])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_agrees_with_brute_force(layout, metric, seed):
    rng = np.random.default_rng((seed, LAYOUTS.index(layout), len(metric)))
    contours = int(rng.integers(0, 6))
    options = {"layout": layout, "heads": 1, "homes": None, "metric": metric}
    part = symmetric(random_instance(rng, contours, entries=3 if contours < 5 else 2, **options))
    rules = Rules(str(rng.choice(["makespan", "travel", "weighted"])))
    best = brute_force(part, rules)
    result = solve(part, rules, method="gtsp", certify=True)
    assert (result.status, result.method) == ("optimal", "gtsp")
    assert result.value == pytest.approx(best.value, abs=1e-6)
    assert check(part, rules, result.plan) == []
    assert result.certificate is not None
    verdict = verify(result.certificate, format_instance(part))
    assert best.value - 1e-4 <= float(verdict.bound) <= best.value * (1 + 1e-12)
    assert float(verdict.value) == pytest.approx(best.value, abs=1e-6)


def clustered(rng, contours, points):
    """An instance whose contours are small squares of points."""
    part = random_instance(rng, contours, layout="uniform", heads=1, homes=True)
    around = [contour.entry_points + rng.uniform(0, 300, (points, 3)) for contour in part.contours]
    pairs = zip(part.contours, around, strict=True)
    return replace(part, contours=tuple(replace(contour, entry_points=each) for contour, each in pairs))


@pytest.mark.parametrize("seed", range(3))
def test_agrees_with_dynamic_programming(seed):
    part = clustered(np.random.default_rng(seed), 9, 3)
    nodes = [*(range(3 * i, 3 * i + 3) for i in range(9)), range(27, 28)]
    length = shortest_generalized_tour(part.rapids.tolist(), nodes)
    result = solve(part, Rules("travel"), method="gtsp")
    assert result.status == "optimal"
    assert result.value == pytest.approx(length)


def test_agrees_with_the_method_for_single_entries():
    part = random_instance(np.random.default_rng(3), 40, layout="uniform", heads=1, homes=True)
    values = [solve(part, Rules("travel"), method=method).value for method in ("gtsp", "tour")]
    assert values[0] == pytest.approx(values[1])


def drawn_matrix(rng):
    """An instance of whole lengths or quarters without triangle inequality, many of them equal, some zero."""
    sizes, home = rng.integers(1, int(rng.integers(2, 6)), int(rng.integers(5, 9))), bool(rng.integers(2))
    count = int(sizes.sum()) + home
    upper = np.triu(rng.integers(0, int(rng.choice([3, 20, 1000])), (count, count)), 1)
    matrix = (upper + upper.T) * float(rng.choice([1.0, 0.25, 3.0]))
    contours = tuple(Contour(f"c{i}", np.zeros((size, 3)), 1.0) for i, size in enumerate(sizes))
    head = Head("h", np.zeros(3) if home else None)
    return Instance("drawn", contours, (head,), Machine(metric="matrix"), (), matrix, located=False)


def test_random_matrices_are_solved_and_certified():
    """Some need branching, some end at a fixing, some at a point that is a tour."""
    kinds = set()
    for seed in range(120):
        part = drawn_matrix(np.random.default_rng(seed))
        nodes = [*map(range, part.first_node[:-1], part.first_node[1:])]
        nodes += [] if part.home_node(0) is None else [range(part.home_node(0), part.node_count)]
        length = shortest_generalized_tour(part.rapids.tolist(), nodes)
        result = solve(part, Rules("travel"), method="gtsp", certify=True)
        assert (result.status, result.value) == ("optimal", pytest.approx(length)), seed
        verdict = verify(result.certificate, format_instance(part))
        assert length - 1e-3 <= verdict.bound <= length
        kinds |= {kind for node in result.certificate["proof"].get("nodes", []) for kind in node}
    assert {"branch", "fix", "leaf"} <= kinds


def test_a_stopped_run_keeps_plan_and_bound():
    part = clustered(np.random.default_rng(2), 60, 5)
    result = solve(part, Rules("travel"), method="gtsp", time_limit=1e-3, certify=True)
    assert (result.status, result.reason) == ("feasible", "stopped early")
    assert 0 <= result.lower_bound <= result.value
    assert result.certificate is not None


def test_progress_speaks_the_objective_s_unit():
    part = clustered(np.random.default_rng(4), 12, 4)
    states = []
    result = solve(part, Rules(), method="gtsp", watch=states.append)
    bounds = [state.lower_bound for state in states if state.lower_bound is not None]
    assert bounds
    assert all(bound <= result.value * (1 + 1e-9) for bound in bounds)
    assert states[-1].value == pytest.approx(result.value)


def test_a_start_counts():
    """A plan that is optimal already is kept, and a plan that breaks the rules is not looked at."""
    part = clustered(np.random.default_rng(5), 6, 3)
    best = solve(part, Rules("travel"), method="gtsp")
    assert solve(part, Rules("travel"), method="gtsp", start=best.plan).value == best.value
    broken = Plan(((Visit(0),),))
    assert solve(part, Rules("travel"), method="gtsp", start=broken).value == pytest.approx(best.value)


@pytest.mark.parametrize(
    ("options", "rules", "message"),
    [
        ({"heads": 2}, {}, "one head"),
        ({"metric": "matrix"}, {}, "symmetric"),
        ({}, {"via_points": True}, "via points"),
    ],
)
def test_what_it_does_not_take_is_refused(options, rules, message):
    part = random_instance(np.random.default_rng(0), 4, **{"heads": 1, "entries": 2, **options})
    with pytest.raises(ValueError, match=message):
        solve(part, Rules("travel", **rules), method="gtsp")


@pytest.mark.parametrize("seed", range(12))
def test_rules_on_order_are_left_out_of_the_bound_and_kept_by_the_plan(seed):
    rng = np.random.default_rng(seed)
    sheet = random_sheet(rng, 5, homes=None, entries=2)
    price = float(rng.choice([0.0, 2.0]))
    rules = Rules("travel", parts_in_one_go=True, clear_rapids=bool(rng.integers(2)), backward_price=price)
    best, result = best_plan(sheet, rules), solve(sheet, rules, method="gtsp", certify=True)
    free = best_plan(replace(sheet, precedence=()), Rules("travel"))
    assert result.lower_bound == pytest.approx(free.value, abs=1e-6)
    assert verify(result.certificate, format_instance(sheet)).bound <= free.value + 1e-6
    if best is None:
        assert result.violations
    else:
        assert result.value == pytest.approx(best.value, abs=1e-6)


def test_a_closed_tour_starts_at_its_leftmost_point():
    part = clustered(np.random.default_rng(6), 7, 2)
    part = replace(part, heads=(replace(part.heads[0], home=None),))
    rules = Rules("travel", via_points=True)
    result = solve(part, rules, method="gtsp")
    assert result.status == "optimal"
    assert check(part, rules, result.plan) == []
