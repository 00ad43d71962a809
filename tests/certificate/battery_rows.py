"""Checks of rows, leaves, fixing and 1-trees."""

import copy
from dataclasses import asdict
from functools import cache
from itertools import combinations, product
from typing import Any

import numpy as np
import pytest

from certificate.battery import battery
from certificate.plans import SLACK, all_plans, excess, tour_points, two_heads_point
from certificate.producer import Prover, subsets, tour_rows, two_heads_rows
from certificate.samples import (
    WEIGHTED,
    document_of,
    instance_of,
    sample,
    symmetric,
)
from cutgap.instances import Instance, Rules

RULES = (
    Rules(non_overlap=None, empty_heads=True),
    Rules(non_overlap=50.0, via_points=True),
    Rules(**WEIGHTED, non_overlap=None, via_points=True),
    Rules(**WEIGHTED, non_overlap=0.0, balance=10.0),
    Rules("travel", non_overlap=None, balance=15.0, empty_heads=True),
)


@cache
def plans_of(instance: Instance, rules: Rules) -> list[Any]:
    return list(all_plans(instance, rules))


@cache
def small_instances() -> list[tuple[Instance, int]]:
    """Instances, and a scale for each."""
    return [
        (instance_of(0, 4, "uniform"), 1),
        (instance_of(1, 4, "grid"), 1000),
        (instance_of(2, 4, "line"), 1),
        (instance_of(3, 4, "uniform", metric="chebyshev"), 1000),
        (symmetric(instance_of(4, 4, "uniform", metric="matrix")), 1),
        (instance_of(5, 1, "uniform"), 1000),
    ]


@battery
def rows_of_two_heads_hold_and_are_tight(api: Any) -> None:
    tight: set[str] = set()
    for (instance, scale), rules in product(small_instances(), RULES):
        problem = api.problem_of(document_of(instance))
        exact = api.rules_of(asdict(rules), problem)
        relaxation = api.TwoHeadsRelaxation(problem, exact, scale, 8, costless=False)
        plans = plans_of(instance, rules)
        if not plans:
            continue
        points = np.array([two_heads_point(relaxation, plan, evaluation) for plan, evaluation in plans])
        upper = np.array(relaxation.start.upper, dtype=float)
        upper[relaxation.endless] = np.inf
        assert (points >= relaxation.start.lower).all()
        assert (points <= upper).all()
        names = two_heads_rows(problem, rules)
        over = excess(relaxation, [relaxation.row(name) for name in names], points)
        assert (over >= -SLACK).all(), names[int(over.min(axis=1).argmin())]
        # Rows of times are tight but for what floors lose.
        slack = {"balance": 4 * relaxation.slack, "imbalance": 4 * relaxation.slack, "makespan": 10}
        tight |= {
            f"{name[0]} {name[1]}" if name[0] == "makespan" else name[0]
            for name, each in zip(names, over.min(axis=1), strict=True)
            if each <= slack.get(name[0], 0)
        }
        if len(problem.ids) == 4 and rules == RULES[0]:
            # Without rules on ranges each row of paths is tight for some plan.
            paths = {"degree", "home", "connect", "visit", "comb", "used"}
            assert all(low == 0 for name, low in zip(names, over.min(axis=1), strict=True) if name[0] in paths)
        unit = scale * (float(problem.v_jump) if rules.objective == "makespan" else 1)
        true = np.array([evaluation.objective(rules) for _, evaluation in plans]) * unit
        worth = points @ np.array(relaxation.costs, dtype=float) / 8 / relaxation.factor
        assert (worth <= true + SLACK * max(1, scale)).all()
        assert (worth >= true - 12).all()
    families = "degree home used connect visit comb imbalance balance order via"
    assert {*families.split(), "makespan 0", "makespan 1"} <= tight


@battery
def rows_of_times_leave_room_for_floors(api: Any) -> None:
    for seed in range(3):
        instance = instance_of(seed, 4, "uniform")
        problem = api.problem_of(document_of(instance))
        for plan, evaluation in list(all_plans(instance, Rules(non_overlap=None)))[::7]:
            limit = Rules(**WEIGHTED, non_overlap=None, balance=evaluation.imbalance_s + 1e-9)
            exact = api.rules_of(asdict(limit), problem)
            relaxation = api.TwoHeadsRelaxation(problem, exact, 1, 1, costless=False)
            point = two_heads_point(relaxation, plan, evaluation)
            sign = 1 if evaluation.time_s[0] > evaluation.time_s[1] else -1
            for family in ("balance", "imbalance"):
                rows = [relaxation.row([family, sign]), relaxation.row([family, -sign])]
                over = excess(relaxation, rows, point[None])
                assert (over >= -SLACK).all()
                # The row with the sign of the difference is tight but for twice the slack.
                assert over[0, 0] <= 2 * relaxation.slack + 1


@battery
def contours_at_the_gap_may_be_divided(api: Any) -> None:
    document = copy.deepcopy(sample("two heads").document)
    for contour, x in zip(document["contours"], (0.1, 0.3, 0.3, 0.5), strict=True):
        contour["entry_points"][0][0] = x
    problem = api.problem_of(document)
    exact = api.rules_of(asdict(Rules(non_overlap=0.2)), problem)
    relaxation = api.TwoHeadsRelaxation(problem, exact, 1, 1, costless=False)
    assert not relaxation.row(["order", 0, 1]).equality
    assert relaxation.row(["order", 1, 2]).equality
    with pytest.raises(api.Refused, match="left of"):
        relaxation.row(["order", 1, 0])


def sevens(api: Any) -> tuple[Any, list[int]]:
    """A relaxation of 7 nodes with via points, and the places of the leftmost contours."""
    instance = instance_of(1, 6, "grid", heads=1)
    problem = api.problem_of(document_of(instance))
    relaxation = api.tour_relaxation(problem, 0, list(range(6)), True, 10, 2)
    return relaxation, relaxation.leftmost


@battery
def rows_of_a_tour_hold_and_are_tight(api: Any) -> None:
    relaxation, leftmost = sevens(api)
    problem = api.problem_of(document_of(instance_of(1, 6, "grid", heads=1)))
    assert leftmost == [i + 1 for i, x in enumerate(problem.xs) if x == min(problem.xs)]
    names = [["degree", v] for v in range(7)] + [["cut", [s]] for s in subsets(range(7)) if len(s) < 7]
    # Combs over 6 and 7 nodes: teeth of two, one of three, handles of three and four.
    for a, b, c, d, e, f in ((0, 1, 2, 3, 4, 5), (6, 3, 1, 0, 2, 4), (5, 0, 6, 4, 1, 3)):
        rest = [v for v in range(7) if v not in (a, b, c, d, e, f)]
        names.append(["cut", [[a, b, c], [a, d], [b, e], [c, f]]])
        names.append(["cut", [[a, b, c, *rest], [a, d], [b, e], [c, f]]])
        names.append(["cut", [[a, b, c], [a, d, *rest], [b, e], [c, f]]])
    orders, points = tour_points(relaxation, 7)
    over = excess(relaxation, [relaxation.row(name) for name in names], points)
    assert (over.min(axis=1) == 0).all()
    via = excess(relaxation, [relaxation.row(["via"])], points)[0] >= 0
    assert via.tolist() == [bool({order[0], order[-1]} & set(leftmost)) for order in orders]


@battery
def combs_need_an_odd_number_of_teeth(api: Any) -> None:
    teeth = [[0, 4], [1, 5], [2, 6], [3, 7]]
    assert api.relaxation.cut_sets([[0, 1, 2], *teeth[:3]], 8)[1] == 10
    with pytest.raises(api.Refused, match="4 teeth"):
        api.relaxation.cut_sets([[0, 1, 2, 3], *teeth], 8)


@battery
def fixing_keeps_cheaper_tours(api: Any) -> None:
    relaxation, _ = sevens(api)
    rng = np.random.default_rng(1)
    prover = Prover(relaxation, tour_rows(7, False), 7)
    pairs, _ = prover.duals(relaxation.start)
    _, points = tour_points(relaxation, 7)
    costs = points @ np.array(relaxation.costs, dtype=float)
    fixed = np.zeros(2, dtype=int)
    for _ in range(200):
        share = rng.uniform(0.3, 1.3)
        trail = api.proof.Trail(relaxation.start)
        target = int(np.quantile(costs, rng.random() / 2)) + 1
        multipliers = [(prover.rows[i], int(y * share * rng.uniform(0.7, 1.3))) for i, y in pairs]
        value, reduced = api.leaf_value(relaxation, trail.bounds, multipliers)
        api.proof._fix(trail, value, reduced, target)
        bounds = trail.bounds
        if value >= target:
            assert (costs >= target).all()
            assert trail.crossed
            trail.undo(0)
            continue
        within = ((points >= bounds.lower) & (points <= bounds.upper)).all(axis=1)
        assert (within | (costs >= target)).all()
        fixed += [sum(bounds.lower), len(bounds.upper) - sum(bounds.upper)]
        trail.undo(0)
        assert not trail.crossed
        assert trail.bounds.upper == relaxation.start.upper
    assert (fixed > 0).all()


@battery
def no_multipliers_prove_too_much(api: Any) -> None:
    """Random ones, and the best of an LP with random changes kept while the value rises."""
    rng = np.random.default_rng(2)
    tours, _ = sevens(api)
    orders, points = tour_points(tours, 7)
    costs = points @ np.array(tours.costs, dtype=float)
    allowed = [bool({order[0], order[-1]} & set(tours.leftmost)) for order in orders]
    climb(api, rng, tours, tour_rows(7, True), 7, float(costs[allowed].min()))
    for number, rules in enumerate(RULES):
        instance = instance_of(number, 4, "uniform")
        problem = api.problem_of(document_of(instance))
        relaxation = api.TwoHeadsRelaxation(problem, api.rules_of(asdict(rules), problem), 100, 2**20, False)
        best = min(evaluation.objective(rules) for _, evaluation in all_plans(instance, rules))
        unit = 100 * 2**20 * relaxation.factor * (float(problem.v_jump) if number < 2 else 1)
        climb(api, rng, relaxation, two_heads_rows(problem, rules), 4, best * unit)


def climb(api: Any, rng: Any, relaxation: Any, names: Any, count: int, least: float) -> None:
    prover = Prover(relaxation, names, count)
    start = dict(prover.duals(relaxation.start)[0])
    multipliers = [start.get(i, 0) for i in range(len(names))]
    best = value_of(api, relaxation, prover.rows, multipliers)
    assert best is not None
    assert best > 0.5 * least
    for step in range(150):
        changed = list(multipliers)
        for i in rng.integers(0, len(names), 3):
            size = int(10 ** rng.uniform(0, 6 if step % 2 else 9))
            changed[i] += int(rng.integers(-size, size + 1))
        value = value_of(api, relaxation, prover.rows, changed)
        if value is not None and value >= best:
            best, multipliers = value, changed
    assert best <= least * (1 + 1e-9) + 1


def value_of(api: Any, relaxation: Any, rows: Any, multipliers: list[int]) -> int | None:
    try:
        value, _ = api.leaf_value(relaxation, relaxation.start, list(zip(rows, multipliers, strict=True)))
    except api.Refused:
        return None
    return int(value)


@battery
def wrong_signs_are_refused(api: Any) -> None:
    relaxation, _ = sevens(api)
    cut, degree = relaxation.row(["cut", [[1, 2]]]), relaxation.row(["degree", 0])
    assert api.leaf_value(relaxation, relaxation.start, [(degree, -1)])[0] == -2
    with pytest.raises(api.Refused, match="multiplier"):
        api.leaf_value(relaxation, relaxation.start, [(cut, -1)])
    problem = api.problem_of(sample("two heads").document)
    rules = api.rules_of(sample("two heads").certificate["rules"], problem)
    two_heads = api.TwoHeadsRelaxation(problem, rules, 1, 1, costless=False)
    with pytest.raises(api.Refused, match="reduced cost"):
        api.leaf_value(two_heads, two_heads.start, [(two_heads.row(["makespan", 0]), 2)])


@battery
def one_trees_are_minimal(api: Any) -> None:
    rng = np.random.default_rng(3)
    for count, via, _ in product((4, 5, 6), (False, True), range(3)):
        lengths = rng.integers(0, 100, (count, count))
        lengths = (lengths + lengths.T).tolist()
        potentials = [int(p) for p in rng.integers(-50, 50, count)]
        firsts = sorted(int(v) for v in rng.choice(np.arange(1, count), 2, replace=False)) if via else []

        def rows(u: int, others: list[int], lengths: Any = lengths) -> list[int]:
            return [lengths[u][v] for v in others]

        cost = {
            (u, v): 3 * lengths[u][v] - potentials[u] - potentials[v] for u, v in combinations(range(count), 2)
        }
        legs = [
            cost[0, u] + cost[0, v]
            for u, v in combinations(range(1, count), 2)
            if not via or u in firsts or v in firsts
        ]
        edges = list(combinations(range(1, count), 2))
        trees = [t for t in combinations(edges, count - 2) if spans(t, count)]
        least = min(legs) + min(sum(cost[e] for e in tree) for tree in trees)
        assert api.one_tree_value(rows, potentials, firsts, 3) == least + 2 * sum(potentials)


def spans(tree: Any, count: int) -> bool:
    joined = {1}
    for _ in range(count):
        joined |= {v for edge in tree for v in edge if set(edge) & joined}
    return len(joined) == count - 1
