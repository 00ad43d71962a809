"""The ant colony step by step, by hand where that is possible, and its plans under all process rules."""

from itertools import chain, combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.brute_force import brute_force
from oracles.random_instances import random_instance
from oracles.square_parts import square_parts

from cutgap.heuristics.ant_colony import (
    AntColonyParameters,
    Colony,
    ant_colony,
    attraction,
    closed_tours,
    leg_sums,
    sheet_of,
    update_pheromone,
)
from cutgap.heuristics.ant_paths import Sheet, candidates, choose, cut_contour, make_tour, new_ant
from cutgap.instances import Contour, Head, Instance, Rules, check, evaluate
from cutgap.instances.process import adjacent_parts, contours_in, crossings, part_of

SEEDS = st.integers(0, 2**32 - 1)
FEW = AntColonyParameters(ants=5, iterations=6)
PROCESS = ("parts_in_one_go", "neighbours_only", "clear_rapids")
SUBSETS = list(chain.from_iterable(combinations(PROCESS, size) for size in range(4)))


def rules_of(subset, price=0.1):
    return Rules("travel", backward_price=price, **dict.fromkeys(subset, True))


def test_chances_are_those_of_the_source():
    """(9) and (10) in plain Python, for a made-up Allow of three cities."""
    points = np.array([[100.0, 0, 0], [400.0, 300, 0], [200.0, 0, 0], [100.0, 50, 0]])
    contours = tuple(Contour(f"{i}", point[None], 0.0) for i, point in enumerate(points))
    instance = Instance("four", contours, (Head("head"),))
    parameters = AntColonyParameters(pheromone_exponent=0.5, length_exponent=2.0, x_exponent=1.5)
    pheromone = {1: 0.3, 2: 1.0, 3: 2.5}
    length = {1: (300.0**2 + 300.0**2) ** 0.5, 2: 100.0, 3: 50.0}
    x = {1: 400.0, 2: 200.0, 3: 100.0}
    delta = {j: (1 / x[j]) / sum(1 / other for other in x.values()) for j in x}
    numerator = {j: pheromone[j] ** 0.5 * (1 / length[j]) ** 2 * delta[j] ** 1.5 for j in x}
    expected = np.array([numerator[j] / sum(numerator.values()) for j in (1, 2, 3)])

    factors = attraction(instance, Rules("travel", backward_price=0.1), parameters)[0]
    weights = np.array([1.0, 0.3, 1.0, 2.5]) ** 0.5 * factors
    assert weights[1:] / weights[1:].sum() == pytest.approx(expected)
    without = attraction(instance, Rules("travel"), parameters)[0]
    assert without[1:] == pytest.approx([1 / length[j] ** 2 for j in (1, 2, 3)])

    rng, turns = np.random.default_rng(6), 15_000
    chosen = [choose(weights, np.array([1, 2, 3]), rng) for _ in range(turns)]
    counts, hoped = np.bincount(chosen, minlength=4)[1:], turns * expected
    # Chi square with 2 degrees of freedom exceeds 18.4 once in 10 000 times.
    assert ((counts - hoped) ** 2 / hoped).sum() < 18.4


def test_pheromone_is_updated_as_by_hand():
    """Three cities, two ants with tours 0 1 2 and 0 2 1, lengths 10 and 20, theta 0.75, Q 40, e 0.5."""
    pheromone = np.full((3, 3), 2.0)
    parameters = AntColonyParameters(persistence=0.75, elite=0.5)
    tours = np.array([[0, 1, 2, 0], [0, 2, 1, 0]])
    update_pheromone(pheromone, tours, np.array([10.0, 20.0]), 40.0, parameters)
    # Unused 0.75 * 2; the second tour adds 0.25 * 40 / 20; the first 0.25 * 40 / 10, and half of it again.
    assert pheromone.tolist() == [[1.5, 3.0, 2.0], [2.0, 1.5, 3.0], [3.0, 2.0, 1.5]]


@pytest.mark.parametrize("price", [0.0, 700.0])
def test_a_tour_deposits_by_its_length_and_the_rules_it_dropped(price):
    """One ant, one iteration: 0.9 + 0.1 * 1.5 * Q / (L + price * dropped) on its rapids, 0.9 elsewhere."""
    parameters = AntColonyParameters(ants=1, deposit_mm=50.0, elite=0.5, dropped_price_mm=price)
    dropped = set()
    for seed in range(40):
        instance, rules = square_parts(np.random.default_rng(seed), 3, 3), rules_of(PROCESS)
        colony = Colony(instance, rules, parameters)
        colony.iterate(np.random.default_rng(seed))
        plan = colony.plan()
        tour = [instance.node(*visit[:2]) for visit in plan.tours[0]]
        nodes = [colony.sheet.start, *tour, colony.sheet.start]
        expected = np.full_like(colony.pheromone, 0.9)
        counted = evaluate(instance, plan).total_travel_mm + price * colony.dropped
        expected[nodes[:-1], nodes[1:]] += 0.1 * 1.5 * 50.0 / counted
        assert colony.pheromone == pytest.approx(expected)
        dropped.add(colony.dropped > 0)
    assert dropped == {False, True}


@given(SEEDS, st.sampled_from(SUBSETS), st.booleans())
@settings(max_examples=60)
def test_candidates_are_those_that_the_rules_allow(seed, subset, home):
    rng = np.random.default_rng(seed)
    instance, rules = square_parts(rng, 2, 2, home=home, entries=3), rules_of(subset)
    sheet, parts, crossed = sheet_of(instance, rules), part_of(instance), crossings(instance)
    ant, cut, city = new_ant(sheet), [], sheet.start
    for _ in range(int(rng.integers(len(instance.contours)))):
        count = candidates(sheet, ant, city, 3)
        city = int(rng.choice(ant.allow[:count]))
        cut_contour(sheet, ant, city)
        cut.append(int(sheet.owner[city]))

    def allowed(contour, node):
        if contour in cut or any(b == contour and a not in cut for a, b in instance.precedence):
            return False
        if not cut:
            return True
        if parts[contour] != parts[cut[-1]]:
            unfinished = [c for c, part in enumerate(parts) if part == parts[cut[-1]] and c not in cut]
            if rules.parts_in_one_go and unfinished:
                return False
            if rules.neighbours_only and not adjacent_parts(instance)[parts[cut[-1]], parts[contour]]:
                return False
        return not (rules.clear_rapids and set(contours_in(crossed[city, node])) & set(cut))

    nodes = [
        instance.node(contour, entry)
        for contour, each in enumerate(instance.contours)
        for entry in range(len(each.entry_points))
        if allowed(contour, instance.node(contour, entry))
    ]
    assert ant.allow[: candidates(sheet, ant, city, 0)].tolist() == nodes


def trap(*, crossing, adjacent=True):
    """Contours 0, 1 and 2 with cities 0; 1 and 2; 3. A city of 1 in ``crossing`` sees 3 behind contour 0."""
    crossed = np.zeros((4, 4, 1), dtype=np.uint64)
    crossed[0, 3] = 1
    crossed[crossing, 3] = 1
    words = np.zeros((3, 1), dtype=np.uint64)
    neighbours = np.ones((3, 3), dtype=bool)
    neighbours[1, 2] = adjacent
    weights = np.array(
        [[0, 1, 1e-9, 1], [0, 0, 0, 1], [0, 0, 0, 1], [1, 1, 1, 0], [1, 1e-12, 1e-12, 1e-12], [1, 1, 1, 1]],
        dtype=float,
    )
    sheet = Sheet(
        lengths=np.ones((6, 5)),
        first_node=np.array([0, 1, 3, 4]),
        owner=np.array([0, 1, 1, 2]),
        parts=np.arange(3),
        before=words,
        outside=words,
        crossed=crossed,
        adjacent=neighbours,
        in_one_go=False,
        start=4,
    )
    tour = np.empty(3, dtype=np.int64)
    return make_tour(sheet, weights, tour, np.random.default_rng(0)), tour.tolist()


def test_an_ant_steps_back_out_of_a_trap():
    # The far likelier city 1 leads nowhere; step 3 takes the other city of the same contour instead.
    assert trap(crossing=[1]) == (0, [0, 2, 3])


def test_without_a_way_out_the_ant_crosses_what_is_cut():
    # Both cities are tried, then step 4 goes on from the last one.
    assert trap(crossing=[1, 2]) == (1, [0, 2, 3])


def test_without_neighbours_the_ant_goes_to_any_part():
    assert trap(crossing=[], adjacent=False) == (1, [0, 2, 3])


@given(SEEDS, st.sampled_from(SUBSETS), st.booleans(), st.sampled_from([0.0, 0.1]))
@settings(max_examples=60)
def test_plans_keep_the_rules_but_where_every_ant_was_stuck(seed, subset, home, price):
    rng = np.random.default_rng(seed)
    instance = square_parts(rng, int(rng.integers(1, 4)), 2, home=home)
    rules = rules_of(subset, price)
    colony = Colony(instance, rules, FEW)
    for _ in range(FEW.iterations):
        colony.iterate(rng)
    broken = {violation.constraint for violation in check(instance, rules, colony.plan())}
    assert bool(broken) == (colony.dropped > 0)
    assert broken <= {"clear rapids", "neighbours only"}
    if not {"clear_rapids", "neighbours_only"} & set(subset):
        assert not broken
    value = evaluate(instance, colony.plan()).objective(rules)
    assert colony.best_value == pytest.approx(value)


def test_some_ants_get_stuck_and_some_do_not():
    dropped = []
    for seed in range(30):
        rng = np.random.default_rng(seed)
        colony = Colony(square_parts(rng, 3, 3), rules_of(PROCESS), AntColonyParameters(ants=1))
        colony.iterate(rng)
        dropped.append(colony.dropped)
    assert min(dropped) == 0 < max(dropped)


def test_a_part_that_waits_for_another_is_not_begun():
    # b lies in a hole of a, so b comes first; a's own small hole would be free at once.
    names = [("a-small", "a"), ("a-large", "a"), ("a", "a"), ("b", "b")]
    contours = tuple(
        Contour(name, np.array([[10.0 * i + 1, 0, 0]]), 1.0, part=part) for i, (name, part) in enumerate(names)
    )
    instance = Instance(
        "nested", contours, (Head("head", np.zeros(3)),), precedence=((0, 2), (1, 2), (3, 1), (3, 2))
    )
    rules = Rules("travel", parts_in_one_go=True)
    plan = ant_colony(instance, rules, rng=np.random.default_rng(0), parameters=FEW)
    assert check(instance, rules, plan) == []


@given(SEEDS, st.integers(0, 6), st.booleans())
@settings(max_examples=40)
def test_values_are_never_below_the_optimum_and_often_reach_it(seed, holes, homes):
    rng = np.random.default_rng(seed)
    instance = random_instance(rng, holes, heads=1, homes=homes, entries=2, precedence=0.2)
    rules = Rules("travel", empty_heads=True)
    plan = ant_colony(instance, rules, rng=rng, parameters=AntColonyParameters(ants=20, iterations=30))
    assert check(instance, rules, plan) == []
    value, best = evaluate(instance, plan).objective(rules), brute_force(instance, rules).value
    assert best - 1e-6 <= value <= 1.25 * best + 1e-6


def test_the_colony_learns():
    """Later iterations make shorter tours than the first, in which all pheromone is equal."""
    instance, rules = square_parts(np.random.default_rng(1), 5, 4), Rules("travel", parts_in_one_go=True)
    colony, rng = Colony(instance, rules, AntColonyParameters(length_exponent=1.0)), np.random.default_rng(1)
    best = []
    for _ in range(60):
        colony.best, colony.best_value = None, np.inf
        colony.iterate(rng)
        best.append(colony.best_value)
    assert np.mean(best[-5:]) < 0.8 * np.mean(best[:5])


def test_points_that_coincide_and_lie_at_zero_do_no_harm():
    points = np.array([[0.0, 0, 0], [0, 0, 0], [-5.0, 0, 0], [-5.0, 0, 0]])
    contours = tuple(Contour(f"{i}", point[None], 0.0) for i, point in enumerate(points))
    for home in (None, np.zeros(3)):
        instance = Instance("zeros", contours, (Head("head", home),))
        rules = Rules("travel", backward_price=1.0)
        parameters = AntColonyParameters(ants=4, iterations=9, pheromone_exponent=10, length_exponent=10)
        plan = ant_colony(instance, rules, rng=np.random.default_rng(0), parameters=parameters)
        assert evaluate(instance, plan).total_travel_mm == 10.0


def test_a_bare_matrix_is_planned():
    given_part = random_instance(np.random.default_rng(3), 5, heads=1, metric="matrix", layout="uniform")
    bare = Instance(
        "bare", given_part.contours, given_part.heads, given_part.machine, (), given_part.matrix, located=False
    )
    plan = ant_colony(bare, Rules("travel"), rng=np.random.default_rng(0))
    assert evaluate(bare, plan).total_travel_mm == pytest.approx(brute_force(given_part, Rules("travel")).value)


def test_same_seed_same_plan_and_progress_ends_at_its_value():
    instance, rules = square_parts(np.random.default_rng(4), 3, 2), rules_of(PROCESS[:2])
    seen = []
    first, second = (
        ant_colony(instance, rules, rng=np.random.default_rng(8), parameters=FEW, watch=seen.append)
        for _ in range(2)
    )
    assert first == second
    values = [progress.value for progress in seen[: len(seen) // 2]]
    assert sorted(values, reverse=True) == values
    assert evaluate(instance, first).objective(rules) == values[-1]


def test_stops_with_the_best_plan_so_far():
    instance, rules = square_parts(np.random.default_rng(4), 3, 2), rules_of(PROCESS[:2])

    def interrupt(progress):
        seen.append(progress.value)
        raise KeyboardInterrupt

    seen = []
    plan = ant_colony(instance, rules, rng=np.random.default_rng(0), watch=interrupt)
    assert evaluate(instance, plan).objective(rules) == seen[0]
    stopped = ant_colony(instance, rules, rng=np.random.default_rng(0), time_limit=0.0)
    assert stopped == plan


@given(SEEDS, st.sampled_from(SUBSETS), st.booleans())
@settings(max_examples=25)
def test_polish_never_makes_a_plan_worse(seed, subset, home):
    rng = np.random.default_rng(seed)
    instance, rules = square_parts(rng, 3, 2, home=home), rules_of(subset)
    plain, polished = (
        ant_colony(
            instance,
            rules,
            rng=np.random.default_rng(seed),
            parameters=AntColonyParameters(ants=2, iterations=2, polish=polish),
        )
        for polish in (False, True)
    )
    assert [v.contour for v in plain.tours[0]] == [v.contour for v in polished.tours[0]]
    broken = [len(check(instance, rules, plan)) for plan in (plain, polished)]
    values = [evaluate(instance, plan).objective(rules) for plan in (plain, polished)]
    assert (broken[1], values[1]) <= (broken[0], values[0] + 1e-9)


def test_nothing_to_cut_is_an_empty_plan():
    instance = Instance("none", (), (Head("head", np.zeros(3)),))
    assert ant_colony(instance, Rules("travel"), rng=np.random.default_rng(0)).tours == ((),)


def test_closed_tours_end_where_they_begin():
    tours = np.array([[1, 0, 2]])
    for home, closed, length in ((np.zeros(3), [3, 1, 0, 2, 3], 60.0), (None, [1, 0, 2, 1], 40.0)):
        contours = tuple(Contour(f"{i}", np.array([[10.0 * i, 0, 0]]), 0.0) for i in range(3))
        instance = Instance("three", contours, (Head("head", home),))
        assert closed_tours(instance, tours).tolist() == [closed]
        assert leg_sums(instance.rapids, closed_tours(instance, tours)) == length


def test_what_is_not_supported_is_named():
    rng = np.random.default_rng(0)
    with pytest.raises(ValueError, match="expected one head, got 2"):
        ant_colony(random_instance(rng, 3), Rules(), rng=rng)
    one = random_instance(rng, 3, heads=1)
    with pytest.raises(ValueError, match="via points"):
        ant_colony(one, Rules(via_points=True), rng=rng)
    with pytest.raises(ValueError, match="no geometry"):
        ant_colony(one, Rules(clear_rapids=True), rng=rng)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        *[("ants", 0), ("iterations", 1.5), ("pheromone_exponent", -1), ("length_exponent", 11)],
        *[("x_exponent", float("nan")), ("persistence", 1.0), ("elite", 1.0), ("deposit_mm", 0.0)],
        ("dropped_price_mm", -1.0),
    ],
)
def test_bad_parameters_are_named(field, value):
    with pytest.raises(ValueError, match=f"ant colony, {field}: expected"):
        AntColonyParameters(**{field: value})
