"""Scenes of the exact methods: bounds hold, cuts are broken where they say so, and looking changes nothing."""

from itertools import pairwise

import numpy as np
import pytest
from oracles.brute_force import brute_force
from oracles.held_karp import shortest_tour
from oracles.random_instances import random_instance

from cutgap.formulations import solve
from cutgap.formulations.branch_and_cut.wording import legs_around
from cutgap.instances import Rules, evaluate
from cutgap.instances.scene import plan_nodes

SLACK = 1e-6
OVERLAP = Rules(non_overlap=None)


def observed(instance, rules, method, **options):
    """Return the result of a run, and its events with their scenes."""
    events = []

    def watch(progress):
        if progress.scene is not None:
            events.append((progress, progress.scene()))

    return solve(instance, rules, method=method, watch=watch, **options), events


def part(seed, holes, heads=1, entries=1):
    return random_instance(np.random.default_rng(seed), holes, layout="uniform", heads=heads, entries=entries)


CASES = [
    ("tour", part(1, 7), Rules()),
    ("tour", part(2, 7), Rules("travel", via_points=True)),
    ("gtsp", part(3, 6, entries=2), Rules()),
    ("contour-dp", part(4, 6, entries=2), Rules("travel")),
    ("contour-dp", part(5, 7), Rules()),
    ("split", part(6, 7, heads=2), Rules()),
    ("split", part(7, 7, heads=2), Rules("travel", via_points=True)),
    ("free", part(8, 6, heads=2), Rules("weighted", weight=20.0, balance=3.0, non_overlap=None)),
    ("free", part(9, 6, heads=2), Rules()),
]


@pytest.mark.parametrize(("method", "instance", "rules"), CASES)
def test_every_bound_that_is_shown_holds(method, instance, rules):
    optimum = brute_force(instance, rules).value
    result, events = observed(instance, rules, method)
    assert result.value == pytest.approx(optimum, abs=1e-5)
    assert events
    proved = [progress.lower_bound for progress, _ in events if progress.lower_bound is not None]
    assert all(bound <= optimum + SLACK for bound in proved)
    assert proved == sorted(proved)
    assert all(p.value >= optimum - SLACK for p, _ in events if p.value is not None)
    # The best plan that is shown has the value that is told.
    lengths = instance.rapids
    for progress, scene in events:
        if scene.best is not None and rules == Rules("travel"):
            tours = [np.array(tour) for tour in scene.best]
            travel = sum(lengths[tour, np.roll(tour, -1)].sum() for tour in tours)
            assert travel == pytest.approx(progress.value, abs=1e-6)


@pytest.mark.parametrize(("method", "instance", "rules"), CASES)
def test_looking_changes_nothing(method, instance, rules):
    seen, events = observed(instance, rules, method)
    bounds = []
    unseen = solve(instance, rules, method=method, watch=lambda p: bounds.append(p.lower_bound))
    assert (seen.plan, seen.value, seen.lower_bound) == (unseen.plan, unseen.value, unseen.lower_bound)
    shown = [progress.lower_bound for progress, _ in events]
    assert set(shown) <= set(bounds)


def crossing(legs, members, heads=(0, 1)):
    """Return the weight of the legs of some heads with one end in a set."""
    return sum(
        leg.value for leg in legs if leg.head in heads and (leg.start in members) != (leg.end in members)
    )


def sides(row, legs, instance):
    """Return both sides of a cut at a point, found from the legs and the names of the sets alone."""
    sets = {name: frozenset(members) for name, members in row.sets}
    bodies = [members for name, members in sets.items() if name in "SH" or name.startswith("T_")]
    heads = (int(row.tag.split()[1]),) if "connect" in row.tag else (0, 1)
    left = sum(crossing(legs, members, heads) for members in bodies)
    share = {
        v: sum(leg.value for leg in legs if v in (leg.start, leg.end)) / 2 for v in range(instance.node_count)
    }
    if "connect" in row.tag:
        (hole,) = sets["i"]
        return left, crossing(legs, {hole}, heads)
    if "generalised subtour" in row.tag:
        outside = sets.get("C_k", frozenset()) - sets["S"]
        terms = [1.0, 1.0]
        if "C_h" in sets:
            terms[0] = sum(share[v] for v in sets["C_h"] & sets["S"])
        if "C_k" in sets:
            terms[1] = sum(share[v] for v in outside)
        return left, 2.0 * (sum(terms) - 1.0)
    assert "subtour" in row.tag or "blossom" in row.tag or "comb" in row.tag
    teeth = len(bodies) - 1
    return left, 2.0 if teeth == 0 else 3.0 * teeth + 1.0


def tour_legs(instance, plan):
    return [leg for head, tour in enumerate(plan_nodes(instance, plan)) for leg in legs_around(tour, head)]


@pytest.mark.parametrize(
    ("method", "instance", "rules", "kinds"),
    [
        ("tour", part(1, 40), Rules(), {"(2) subtour", "(4) blossom"}),
        ("gtsp", part(13, 14, entries=3), Rules(), {"(3) (G) generalised subtour"}),
        ("free", part(14, 12, heads=2), OVERLAP, {"(connect 0 i S) subtour of one head"}),
    ],
)
def test_cuts_are_broken_by_the_point_and_kept_by_the_best_plan(method, instance, rules, kinds):
    result, events = observed(instance, rules, method)
    best = tour_legs(instance, result.plan)
    tags = set()
    for (_, before), (_, scene) in pairwise(events):
        for row in scene.rows:
            if row.left is None:
                continue
            tags.add(row.tag)
            assert scene.legs == before.legs
            if "generalised comb" in row.tag:  # its right side needs contours that are not among its sets
                assert row.left < row.right
                continue
            left, right = sides(row, scene.legs, instance)
            assert (left, right) == pytest.approx((row.left, row.right), abs=1e-5)
            assert left < right - 1e-5
            kept, asked = sides(row, best, instance)
            assert kept >= asked - 1e-9
    assert kinds <= tags


def test_every_family_of_rows_is_told_at_the_beginning():
    instance = part(14, 6, heads=2)
    rules = Rules("weighted", weight=5.0, balance=50.0, via_points=True, empty_heads=True)
    _, events = observed(instance, rules, "free")
    counts = {row.tag: row.count for row in events[0][1].rows}
    assert counts["(degree)"] == counts["(via)"] == counts["(used)"] == 2 * len(instance.contours)
    assert counts["(balance)"] == counts["(imbalance)"] == counts["(home)"] == 2
    _, events = observed(instance, Rules(), "free")
    assert {row.tag: row.count for row in events[0][1].rows}["(makespan)"] == 2


def test_the_tree_is_one_tree_and_is_closed_at_the_end():
    instance = part(21, 12, heads=2)
    _, events = observed(instance, OVERLAP, "free")
    last, parents = {}, {}
    for _, scene in events:
        for branch in scene.branches:
            assert branch.bound >= last[branch.number].bound - SLACK if branch.number in last else True
            last[branch.number] = branch
            parents[branch.number] = branch.parent
    assert len(last) > 1
    assert [number for number, parent in parents.items() if parent is None] == [0]
    for number, parent in parents.items():
        assert number == 0 or last[parent].state == "divided"
        assert number == 0 or last[number].bound >= last[parent].bound - SLACK
        assert number == 0 or last[number].decision is not None
    limit = events[-1][0].value * instance.machine.v_jump
    left_open = [each for each in last.values() if each.state == "open"]
    assert all(each.bound * instance.machine.v_jump >= limit * (1 - 1e-6) for each in left_open)


def test_thresholds_hold_the_true_times_between_their_bounds():
    instance = part(31, 8, heads=2)
    _, events = observed(instance, Rules(), "split")
    order = np.argsort(instance.points[:8, 0], kind="stable")
    for _, scene in events:
        for threshold in scene.thresholds:
            shares = order[: threshold.count], order[threshold.count :]
            for head, (share, (lower, upper)) in enumerate(zip(shares, threshold.times, strict=True)):
                nodes = [instance.home_node(head), *share.tolist()]
                length = shortest_tour(instance.rapids[np.ix_(nodes, nodes)].tolist())[0] if len(share) else 0.0
                time = length / instance.machine.v_jump + instance.service_times[share].sum()
                assert lower - SLACK <= time <= upper + SLACK
    assert all(len(scene.thresholds) == 9 for _, scene in events)


def test_passes_show_the_walk_that_they_count():
    instance = part(41, 9)
    _, events = observed(instance, Rules("travel"), "contour-dp")
    passes = [scene for _, scene in events if scene.dp is not None and scene.legs]
    assert passes
    for scene in passes:
        dp = scene.dp
        assert sum(dp.visits) == len(instance.contours) == len(dp.states)
        assert min(dp.states) > 0
        assert all(contour not in members for contour, members in enumerate(dp.memories))
        travel = sum(leg.value * instance.rapids[leg.start, leg.end] for leg in scene.legs)
        # (1) of the ascent: what the relaxed walk costs with its prices is the bound that is shown.
        paid = sum(price * (visits - 1) for price, visits in zip(dp.prices, dp.visits, strict=True))
        if "Exact" not in scene.text:
            assert travel + paid == pytest.approx(scene.bound, rel=1e-9)
    assert evaluate(instance, solve(instance, Rules("travel")).plan).total_travel_mm >= passes[-1].bound - SLACK


def test_a_tour_that_rules_on_order_may_forbid_is_no_plan():
    instance = random_instance(np.random.default_rng(51), 6, layout="uniform", heads=1, precedence=0.4)
    _, events = observed(instance, Rules(), "gtsp")
    assert events
    assert all(progress.value is None and scene.best is None for progress, scene in events)
    optimum = brute_force(instance, Rules()).value
    assert all(p.lower_bound <= optimum + SLACK for p, _ in events if p.lower_bound is not None)
