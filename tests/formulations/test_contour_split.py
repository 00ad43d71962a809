"""Two heads with entry points: agrees with listing all plans and with CP-SAT; a stopped run keeps its bound."""

from dataclasses import replace

import numpy as np
import pytest
from oracles.entry_tours import best_plan
from oracles.random_instances import LAYOUTS, random_instance

from cutgap.formulations import choose, solve
from cutgap.formulations.contour_dp import closing, two_head_search
from cutgap.formulations.contour_dp.closing import walk_cost
from cutgap.formulations.contour_dp.division import Division
from cutgap.formulations.contour_dp.two_heads import Price, plan_of_switch_walk, switch_walks
from cutgap.formulations.cpsat.solving import solve_cpsat
from cutgap.instances import Contour, Head, Instance, Machine, Plan, Rules, check, evaluate

OBJECTIVES = (("makespan", 0.0), ("travel", 0.0), ("weighted", 20.0))


def solved(instance, rules, **options):
    result = solve(instance, rules, method="contour-split", **options)
    assert result.plan is None or not check(instance, rules, result.plan)
    return result


def require_optimum(instance, rules, best):
    result = solved(instance, rules)
    if best is None:
        assert (result.status, result.plan) == ("infeasible", None)
        return
    assert result.status == "optimal"
    assert result.value == pytest.approx(best.value, abs=1e-6)


@pytest.mark.parametrize("gap", [0.0, 30.0, None])
@pytest.mark.parametrize("objective", OBJECTIVES, ids=lambda each: each[0])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_agrees_with_brute_force(layout, objective, gap, monkeypatch):
    """With first plans, mostly optimal, the search has only to prove one; without them, to find one."""
    seed = (LAYOUTS.index(layout), OBJECTIVES.index(objective), int(gap or 0), gap is None)
    rng = np.random.default_rng(seed)
    # A search of one row a layer has to grow many times before it is complete.
    monkeypatch.setattr(closing, "FIRST_WIDTH", int(rng.choice([1, 1000])))
    monkeypatch.setattr(two_head_search, "FEW", int(rng.choice([0, 10])))
    for metric in ("euclidean", "chebyshev", "matrix"):
        contours = int(rng.integers(0, 6))
        part = random_instance(rng, contours, layout=layout, metric=metric, entries=2 if contours == 5 else 3)
        name, weight = objective
        rules = Rules(name, weight=weight, non_overlap=gap, empty_heads=bool(rng.integers(2)))
        best = best_plan(part, rules)
        require_optimum(part, rules, best)
        with monkeypatch.context() as patch:
            patch.setattr(two_head_search.TwoHeadSearch, "_first_plans", lambda search, whole: None)
            require_optimum(part, rules, best)


@pytest.mark.parametrize("seed", range(12))
def test_where_longer_tours_may_pay_the_bound_stays_valid(seed):
    rng = np.random.default_rng((seed, 5))
    part = random_instance(rng, 4, entries=2)
    heavy = Rules("weighted", weight=3 * part.machine.v_jump)
    limited = [Rules(name, weight=weight, balance=0.5) for name, weight in OBJECTIVES]
    for rules in (heavy, *limited):
        best = best_plan(part, rules)
        result = solved(part, rules)
        if best is None:
            assert result.plan is None
            continue
        assert result.status != "infeasible"
        assert result.lower_bound <= best.value + 1e-6
        assert result.value is None or result.value >= best.value - 1e-6
        assert (result.status == "optimal") == (result.reason is None)
        if result.status == "optimal":
            assert result.value == pytest.approx(best.value, abs=1e-6)


@pytest.mark.parametrize("objective", OBJECTIVES, ids=lambda each: each[0])
@pytest.mark.parametrize("gap", [0.0, None])
def test_agrees_with_cpsat(objective, gap):
    name, weight = objective
    part = random_instance(np.random.default_rng(len(name)), 7, layout="uniform", entries=3)
    rules = Rules(name, weight=weight, non_overlap=gap)
    result = solved(part, rules)
    assert result.status == "optimal"
    peer = solve_cpsat(part, rules, workers=1, isolated=False)
    assert result.value == pytest.approx(peer.value, rel=1e-6)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("price", [Price(1.0, 0.0), Price(0.01, 0.5)])
def test_a_switch_walk_costs_what_its_plan_does(seed, price):
    rng = np.random.default_rng(seed)
    part = random_instance(rng, 5, entries=3, metric="matrix")
    division = Division(part, Rules("travel", non_overlap=None, empty_heads=True))
    walks = switch_walks(part, division, division.everything, price)
    sizes = np.diff(part.first_node)
    for _ in range(20):
        contours = rng.permutation(5)
        heads = np.sort(rng.integers(0, 2, 5))
        walk = [
            int(rng.choice(walks.first[c] + head * sizes[c] + np.arange(sizes[c])))
            for c, head in zip(contours, heads, strict=True)
        ]
        turn = int((heads == 0).sum())
        walk = np.array([*walk[:turn], len(walks.visits) - 1, *walk[turn:]])
        plan = plan_of_switch_walk(walks, walk)
        assert [len(tour) for tour in plan.tours] == [turn, 5 - turn]
        work = float(part.service_times.sum())
        travel = evaluate(part, plan).total_travel_mm
        assert walk_cost(walks, walk) == pytest.approx(price.travel * travel + price.work * work)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("gap", [0.0, 30.0])
def test_thresholds_hold_just_the_plans_that_keep_non_overlap(seed, gap):
    rng = np.random.default_rng((seed, int(gap)))
    part = random_instance(rng, 4, entries=2)
    rules = Rules("travel", non_overlap=gap, empty_heads=True)
    division = Division(part, rules)
    for _ in range(30):
        tours = [[], []]
        for contour in range(4):
            entry = int(rng.integers(len(part.contours[contour].entry_points)))
            tours[int(rng.integers(2))].append((contour, entry))
        plan = Plan(tuple(map(tuple, tours)))
        nodes = [[part.node(*visit[:2]) for visit in tour] for tour in tours]
        held = any(
            all(division.rank[v] <= upto for v in nodes[0]) and all(division.rank[v] >= since for v in nodes[1])
            for upto, since in zip(division.upto, division.since, strict=True)
        )
        assert held == (not check(part, rules, plan))


def sheet(seed, contours, entries=5):
    """Rings of points, far too many for brute force, homes left and right of them."""
    rng = np.random.default_rng(seed)
    angles = np.linspace(0, 2 * np.pi, entries, endpoint=False)
    ring = np.column_stack((np.cos(angles), np.sin(angles), np.zeros(entries)))
    centres = np.column_stack((rng.uniform(0, 1000, (contours, 2)), np.zeros(contours)))
    sizes = rng.uniform(10, 150, contours)
    parts = tuple(
        Contour(str(i), centre + size * ring, 6 * size)
        for i, (centre, size) in enumerate(zip(centres, sizes, strict=True))
    )
    homes = Head("l", np.array([-100.0, 500.0, 0.0])), Head("r", np.array([1100.0, 500.0, 0.0]))
    return Instance("rings", parts, homes)


@pytest.mark.parametrize("objective", OBJECTIVES, ids=lambda each: each[0])
def test_mirror_shift_and_order_change_nothing(objective):
    part, (name, weight) = sheet(1, 9, entries=4), objective
    rules = Rules(name, weight=weight)
    contours = [
        replace(c, entry_points=c.entry_points * (-1.0, 1.0, 1.0) + (5000.0, 7.0, 0.0)) for c in part.contours
    ]
    heads = [replace(h, home=h.home * (-1.0, 1.0, 1.0) + (5000.0, 7.0, 0.0)) for h in part.heads]
    image = replace(part, contours=tuple(contours[::-1]), heads=tuple(heads[::-1]))
    result = solved(part, rules)
    assert result.status == "optimal"
    assert solved(image, rules).value == pytest.approx(result.value)
    free = solved(part, replace(rules, non_overlap=None), time_limit=20.0)
    assert free.lower_bound <= result.value


def test_a_stopped_run_keeps_plan_and_bound():
    part = sheet(2, 30, entries=6)
    halves = sorted(range(30), key=lambda c: part.contours[c].entry_points[0, 0])
    start = Plan.of_contours([halves[:15], halves[15:]])
    rules = Rules("travel", non_overlap=0.0)
    hurried = solved(part, rules, time_limit=1e-6, start=start)
    assert (hurried.status, hurried.reason) == ("feasible", "time limit")
    assert hurried.value <= evaluate(part, start).total_travel_mm or check(part, rules, start)
    longer = solved(part, rules, time_limit=2.0, start=hurried.plan)
    assert longer.value <= hurried.value
    assert 0 < longer.lower_bound <= longer.value


def test_ctrl_c_keeps_plan_and_bound():
    part, calls = sheet(3, 12), []

    def interrupt(progress):
        calls.append(progress)
        raise KeyboardInterrupt

    result = solved(part, Rules("travel"), watch=interrupt)
    assert (result.status, result.reason, len(calls)) == ("feasible", "interrupted", 1)
    best = solved(part, Rules("travel"))
    assert best.status == "optimal"
    assert result.lower_bound is None or result.lower_bound <= best.value
    assert result.value >= best.value


def test_a_gap_that_no_division_leaves_is_infeasible():
    part = sheet(4, 5)
    result = solved(part, Rules("makespan", non_overlap=2000.0))
    assert (result.status, result.plan) == ("infeasible", None)
    assert "2000 mm" in result.reason
    resting = solved(part, Rules("makespan", non_overlap=2000.0, empty_heads=True))
    assert resting.status == "optimal"
    assert not all(resting.plan.tours)


def test_auto_takes_it_for_two_heads_with_entry_points():
    part = sheet(5, 4)
    assert choose(part, Rules("travel")).method == "contour-split"
    assert choose(part, Rules("travel", non_overlap=None)).method == "contour-split"
    assert choose(part, Rules("travel", via_points=True)).method == "cpsat"
    assert choose(replace(part, precedence=((0, 1),)), Rules("travel")).method == "cpsat"
    homeless = replace(part, heads=(Head("l"), Head("r")))
    assert choose(homeless, Rules("travel")).method == "cpsat"


def test_what_it_does_not_take_is_refused():
    part = sheet(6, 4)
    for other, rules, message in (
        (replace(part, heads=part.heads[:1]), Rules(), "needs two heads, got 1"),
        (replace(part, heads=(part.heads[0], Head("r"))), Rules(), "head 'r' has no home"),
        (part, Rules(via_points=True), "does not take via points"),
        (part, Rules("travel", backward_price=1.0), "does not take the rule backward price"),
        (replace(part, precedence=((0, 1),)), Rules(), "does not take precedence"),
    ):
        with pytest.raises(ValueError, match=message):
            solve(other, rules, method="contour-split")
    bare = Instance(
        "bare", part.contours, part.heads, Machine(metric="matrix"), matrix=np.ones((22, 22)), located=False
    )
    with pytest.raises(ValueError, match="no coordinates"):
        solve(bare, Rules(), method="contour-split")
    assert solve(bare, Rules(non_overlap=None), method="contour-split").status == "optimal"
