"""The oracle of links, by hand and against ``evaluate``, ``check`` and the trajectory of plans."""

import time
from itertools import chain, combinations, pairwise, permutations, product

import numpy as np
import pytest

from cutgap.instances import Contour, Head, Instance, Link, Machine, Plan, Rules, Visit, check, evaluate
from cutgap.instances.links.clearance import blocked
from cutgap.instances.links.trajectory import trajectory
from oracles.linked_strokes import is_allowed, least_value, plan_count, strokes_of, value
from oracles.random_outlines import random_outlines


def box(name, x, y, entries):
    """A square of 10 mm; entry points are numbers of corners, counter-clockwise from the lower left one."""
    corners = np.array([[x, y], [x + 10, y], [x + 10, y + 10], [x, y + 10]], dtype=float)
    return Contour(name, np.column_stack((corners, np.zeros(4)))[entries], 40.0, geometry=corners)


def row(*contours, t_aux=7.0):
    machine = Machine(v_jump=100.0, v_cut=10.0, t_aux=t_aux)
    return Instance("row", contours, (Head("head", np.zeros(3)),), machine)


def test_two_boxes_by_hand():
    pair = row(box("a", 10, 0, [0]), box("b", 24, 0, [0]))
    travel, one = Rules("travel", links=True), Rules("travel", links=True, pierces=1)
    assert least_value(pair, travel) == 48.0
    # The link leads along the edge of the first: once and back by a rapid, or twice.
    assert least_value(pair, one) == 48.0
    assert plan_count(pair, one) == 2 + 2  # passed once: from either end; twice: from either point
    assert plan_count(pair, travel) == 4 + 2
    timed = Rules("makespan", links=True)
    assert least_value(pair, timed) == pytest.approx(8 + 7 + 1.4 + 0.34)
    assert least_value(row(*pair.contours, t_aux=0.5), timed) == pytest.approx(8 + 2 * 0.5 + 0.48)


def test_what_no_link_reaches_has_its_own_stroke():
    hole = Contour("hole", np.array([[12.0, 2.0, 0.0]]), 4.0, geometry=np.array([[12, 2], [16, 2], [12, 6]]))
    plate = row(box("plate", 10, 0, [0, 1]), hole)
    assert least_value(plate, Rules("travel", links=True, pierces=1)) is None
    assert plan_count(plate, Rules("travel", links=True)) == 4


@pytest.mark.parametrize("seed", range(12))
def test_agrees_with_evaluate_and_check_plan_by_plan(seed):
    rng = np.random.default_rng(seed)
    contours = int(rng.integers(1, 4))
    instance = random_outlines(rng, contours, entries=2 if contours < 3 else 1, nested=0.5)
    rules = random_rules(rng)
    given = strokes_of(instance, rules)
    allowed, least = 0, []
    for visits, links in all_plans(instance):
        plan = Plan((tuple(Visit(*visit) for visit in visits),), tuple(Link(*link) for link in links))
        assert is_allowed(given, visits, links) == (not check(instance, rules, plan))
        if is_allowed(given, visits, links):
            allowed += 1
            least.append(evaluate(instance, plan).objective(rules))
            assert value(given, visits, links) == pytest.approx(least[-1], rel=1e-12)
    assert allowed == plan_count(instance, rules)
    found = least_value(instance, rules)
    assert found == (pytest.approx(min(least), rel=1e-12) if least else None)


def random_rules(rng):
    objective = str(rng.choice(["travel", "makespan"]))
    return Rules(objective, links=True, pierces=[None, 1, 2][int(rng.integers(3))])


def all_plans(instance):
    """Yield visits and links: any contours in any order from any entry point, any links."""
    places = [(c, e) for c, contour in enumerate(instance.contours) for e in range(len(contour.entry_points))]
    pairs = [(*a, *b) for a, b in combinations(places, 2) if a[0] != b[0]]
    orders = chain.from_iterable(permutations(places, k) for k in range(len(instance.contours) + 1))
    for visits in list(orders):
        for passes in product(range(3), repeat=len(pairs)):
            yield list(visits), [(*pair, k) for pair, k in zip(pairs, passes, strict=True) if k]


@pytest.mark.parametrize("seed", range(12))
def test_random_plans_agree_and_can_be_made(seed):
    """On larger sheets, plans by chance: the trajectory is continuous and as long as the plan's value says."""
    rng = np.random.default_rng((1, seed))
    instance = random_outlines(rng, 4, entries=3, nested=0.3)
    rules = Rules("travel", links=True)
    given = strokes_of(instance, rules)
    pairs = list(given.links)
    made = 0
    for _ in range(150):
        chosen = rng.permutation(len(pairs))[: int(rng.integers(0, 5))]
        links = [link_of(given, *pairs[k], int(rng.integers(1, 3))) for k in chosen]
        starts = [entry_of(given, node) for node in rng.permutation(len(given.of)).tolist()]
        visits = starts[: int(rng.integers(1, 5))]
        plan = Plan((tuple(Visit(*visit) for visit in visits),), tuple(Link(*link) for link in links))
        assert is_allowed(given, visits, links) == (not check(instance, rules, plan))
        if not is_allowed(given, visits, links):
            continue
        made += 1
        length = value(given, visits, links)
        assert length == pytest.approx(evaluate(instance, plan).total_travel_mm, rel=1e-12)
        phases = trajectory(instance, plan)
        for before, after in pairwise(phases):
            np.testing.assert_allclose(before.points[-1], after.points[0])
        cut = sum(np.hypot(*np.diff(p.points, axis=0).T).sum() for p in phases if p.kind == "cut")
        assert cut == pytest.approx(instance.perimeters.sum())
    assert made > 0


def entry_of(given, node):
    contour = given.of[node]
    return contour, node - given.of.index(contour)


def link_of(given, u, v, passes):
    return (*entry_of(given, u), *entry_of(given, v), passes)


@pytest.mark.parametrize("seed", range(20))
def test_clear_links_agree(seed):
    instance = random_outlines(np.random.default_rng((2, seed)), 5, entries=3, nested=0.5)
    given = strokes_of(instance, Rules(links=True))
    pairs = [(u, v) for u, v in combinations(range(len(given.of)), 2) if given.of[u] != given.of[v]]
    clear = ~blocked(instance, *np.transpose(pairs)) if pairs else []
    assert [pair for pair, is_clear in zip(pairs, clear, strict=True) if is_clear] == list(given.links)


def test_four_outlines_take_a_second():
    instance = random_outlines(np.random.default_rng(3), 4, entries=2, nested=0.0)
    begun = time.process_time()
    least_value(instance, Rules(links=True))
    plan_count(instance, Rules(links=True))
    assert time.process_time() - begun < 2.0
