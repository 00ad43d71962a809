"""Plans and other points held in a model: allowed plans are kept at their value, all else is cut off."""

from dataclasses import replace

import numpy as np
import pytest
from fixed_points import Held, all_plans, point_of
from oracles.random_instances import random_instance
from oracles.random_sheets import random_sheet

from cutgap.formulations.compact.programme import assemble
from cutgap.formulations.compact.tours import RELAXATIONS, ROUNDS, TOUR_FORMULATIONS
from cutgap.instances import Contour, Head, Instance, Machine, Plan, Rules, check, evaluate

EXACT = [name for name in TOUR_FORMULATIONS if name not in (*RELAXATIONS, ROUNDS)]

ORDER = {"parts_in_one_go": True, "neighbours_only": True, "clear_rapids": True}
ALONE = {
    "none": {},
    "non-overlap": {"non_overlap": 30.0},
    "touching": {"non_overlap": 0.0},
    "balance": {"balance": 3.0},
    "via points": {"via_points": True},
    "weighted": {"objective": "weighted", "weight": 400.0},
    "empty heads": {"empty_heads": True},
    "backward price": {"objective": "travel", "backward_price": 1.5},
    **{name: {name: True} for name in ORDER},
    "together": {**ORDER, "objective": "travel", "backward_price": 0.5},
}


def rules_of(name: str) -> Rules:
    return Rules(**{"non_overlap": None, **ALONE[name]})


def assert_keeps_what_is_allowed(instance: Instance, rules: Rules, formulation: str, rng) -> None:
    """Where all that matters of a closed tour is the way around, its first contour is 0."""
    held = Held(assemble(instance, rules, formulation, integer=False))
    ordered = rules.via_points or rules.process or instance.precedence
    turned = len(instance.heads) == 1 and instance.heads[0].home is None and not ordered
    plans = [plan for plan in all_plans(instance) if not turned or plan.tours[0][0].contour == 0]
    some = [plans[k] for k in rng.permutation(len(plans))[:80]]
    allowed = [plan for plan in some if not check(instance, rules, plan)]
    broken = [plan for plan in some if plan not in allowed]
    for plan in allowed[:8] + broken[:8]:
        outcome = held.at_plan(plan)
        kept = outcome is not None and outcome.state == "optimal"
        assert kept == (plan in allowed), (formulation, plan)
        if outcome is not None and kept:
            assert outcome.value == pytest.approx(evaluate(instance, plan).objective(rules), abs=1e-5)


@pytest.mark.parametrize("heads", [1, 2])
@pytest.mark.parametrize("name", ALONE)
def test_a_plan_is_kept_when_it_is_allowed_and_only_then(name, heads):
    """Polygons, as a tie in time between two heads passes the models."""
    for seed in range(3):
        rng = np.random.default_rng((heads, list(ALONE).index(name), seed))
        instance = random_sheet(
            rng, 4 - seed % 3 // heads, entries=2, heads=heads, homes=None, shape="polygons", nested=0.7
        )
        formulation = EXACT[(seed + list(ALONE).index(name)) % len(EXACT)]
        assert_keeps_what_is_allowed(instance, rules_of(name), formulation, rng)


@pytest.mark.parametrize("formulation", EXACT)
@pytest.mark.parametrize("heads", [1, 2])
def test_every_formulation_keeps_all_plans(heads, formulation):
    """Also with few contours, where big-M and lifted rows have special cases, and with ties."""
    for contours in range(1, 5):
        rng = np.random.default_rng((heads, contours, 5))
        instance = random_instance(rng, contours, heads=heads, homes=None, precedence=0.3 if heads == 1 else 0)
        rules = Rules("travel", non_overlap=None, empty_heads=True, via_points=contours % 2 == 0)
        assert_keeps_what_is_allowed(instance, rules, formulation, rng)


BROKEN = {
    "apart": ("non-overlap", {"non_overlap": 30.0}, ("apart",)),
    "balance": ("balance", {"balance": 1.0}, ("balance",)),
    "via": ("via points", {"via_points": True}, ("via",)),
    "one-go": ("parts in one go", {"parts_in_one_go": True}, ("one-go",)),
    "clear": ("clear rapids", {"clear_rapids": True}, ("clear", "late-clear")),
    "precedence": ("precedence", {}, ("precedence", "late")),
}


BETWEEN_HEADS = ("apart", "balance")


@pytest.mark.parametrize(
    ("family", "heads"), [(name, n) for name in BROKEN for n in (1, 2) if n == 2 or name not in BETWEEN_HEADS]
)
def test_a_family_alone_cuts_off_what_breaks_its_rule(family, heads):
    """The plan is kept without the family, so it is the family that cuts it off."""
    constraint, asked, families = BROKEN[family]
    rules = Rules(**{"non_overlap": None, "empty_heads": True, **asked})
    found = 0
    for seed in range(20):
        rng = np.random.default_rng((heads, seed))
        instance = random_sheet(
            rng, 4, entries=2, heads=heads, shape="polygons", nested=0.8, precedence=family == "precedence"
        )
        plans = list(all_plans(instance))
        broken = [
            plan
            for plan in (plans[k] for k in rng.permutation(len(plans))[:60])
            if {each.constraint for each in check(instance, rules, plan)} == {constraint}
        ]
        programme = assemble(instance, rules, EXACT[seed % len(EXACT)], integer=False)
        with_it, without = Held(programme), Held(programme, families)
        for plan in broken[:3]:
            # A rapid that crosses the contour which it leaves is there in no model.
            if without.at_plan(plan) is None:
                continue
            found += 1
            assert without.keeps(plan)
            assert not with_it.keeps(plan)
        if found >= 6:
            return
    raise AssertionError("no plan breaks the rule alone")


@pytest.mark.parametrize("family", ["precedence", "late", "clear", "late-clear"])
def test_positions_and_times_are_both_needed(family):
    """Each of the two families cuts off a plan that the other one lets pass."""
    clear = "clear" in family
    rules = Rules(non_overlap=None, empty_heads=True, clear_rapids=clear)
    for seed in range(30):
        rng = np.random.default_rng((7, seed))
        instance = random_sheet(rng, 4, entries=1, heads=2, shape="polygons", nested=0.8, precedence=not clear)
        if family in ("precedence", "clear"):
            instance = timeless(instance)
        programme = assemble(instance, rules, "single-commodity", integer=False)
        with_it, without = Held(programme), Held(programme, [family])
        plans = list(all_plans(instance))
        some = [plans[k] for k in rng.permutation(len(plans))[:40]]
        needed = [plan for plan in some if without.keeps(plan) and not with_it.keeps(plan)]
        if needed:
            assert all(check(instance, rules, plan) for plan in needed)
            return
    raise AssertionError("the family is never needed")


def timeless(instance: Instance) -> Instance:
    """Nothing takes time, so that only positions tell what comes first."""
    nodes = instance.node_count
    return replace(
        instance,
        contours=tuple(replace(contour, perimeter=0.0) for contour in instance.contours),
        machine=replace(instance.machine, t_aux=0.0, metric="matrix"),
        matrix=np.zeros((nodes, nodes)),
    )


def tiny(heads: int, count: int = 4) -> Instance:
    places = ((0.0, 0.0), (30.0, 0.0), (0.0, 40.0), (30.0, 40.0))[:count]
    contours = tuple(Contour(f"c{i}", [[*place, 0.0]], 40.0) for i, place in enumerate(places))
    homes = tuple(Head(f"h{i}", [10.0 + i, -20.0, 0.0]) for i in range(heads))
    return Instance("tiny", contours, homes, Machine(v_jump=50.0, t_aux=1.0))


@pytest.mark.parametrize("formulation", EXACT)
@pytest.mark.parametrize("heads", [1, 2])
def test_tour_formulations_cut_off_cycles(heads, formulation):
    """Head 0 goes to contour 0 and back, and around the others: only the tour formulation minds."""
    instance, rules = tiny(heads), Rules(non_overlap=None, empty_heads=True)
    home = instance.home_node(0)
    legs = {(home, 0), (0, home)}
    for cycle in ({(1, 2), (2, 3), (3, 1)}, {(1, 2), (2, 1), (3, 0), (home, 3)}):
        mine = legs | cycle if len(cycle) == 3 else {(0, home)} | cycle
        for name, state in ((formulation, "infeasible"), ("assignment", "optimal")):
            programme = assemble(instance, rules, name, integer=False)
            points = [point_of(programme, head, mine if head == 0 else ()) for head in range(heads)]
            assert Held(programme).at(points).state == state


POINTS = {
    # Names of families, and legs of heads 0 and 1 ("a" and "b" are the homes) that only these cut off.
    "cut-once": ({("a", 0), (0, "a")}, {("b", 1), (1, 2), (2, "b")}),
    "cut-once twice": ({("a", 0), (0, 3), (3, "a")}, {("b", 0), (0, 1), (1, 2), (2, "b")}),
    "continuity": ({("a", 0), (0, 3), (0, "a")}, {("b", 1), (1, 2), (2, "b")}),
    "leave-once": ({("a", 0), (0, "a"), ("a", 3), (3, "a")}, {("b", 1), (1, 2), (2, "b")}),
    "leave-once none": (set(), {("b", 0), (0, 1), (1, 2), (2, 3), (3, "b")}),
}


@pytest.mark.parametrize("case", POINTS)
def test_families_of_the_problem_cut_off_points_that_are_no_plans(case):
    instance = tiny(2)
    names = {"a": instance.home_node(0), "b": instance.home_node(1)}
    programme = assemble(instance, Rules(non_overlap=None), "assignment", integer=False)
    points = [
        point_of(programme, head, {tuple(names.get(end, end) for end in leg) for leg in legs})
        for head, legs in enumerate(POINTS[case])
    ]
    assert Held(programme).at(points).state == "infeasible"
    assert Held(programme, [case.split()[0]]).at(points).state == "optimal"


@pytest.mark.parametrize(("family", "objective"), [("makespan", "makespan"), ("imbalance", "weighted")])
def test_without_its_family_the_objective_is_too_small(family, objective):
    instance = tiny(2)
    rules = Rules(objective, 10.0 if objective == "weighted" else 0.0, non_overlap=None)
    programme = assemble(instance, rules, "mtz", integer=False)
    for tours in ([[0], [1, 2, 3]], [[1, 2, 3], [0]]):
        plan = Plan.of_contours(tours)
        value = evaluate(instance, plan).objective(rules)
        assert Held(programme).at_plan(plan).value == pytest.approx(value)
        assert Held(programme, [family]).at_plan(plan).value < value - 1.0


@pytest.mark.parametrize("formulation", EXACT)
def test_tour_formulations_know_the_depot(formulation):
    """All contours in one cycle without a way from home: even without ``leave-once`` no tour."""
    programme = assemble(tiny(1, 3), Rules(), formulation, integer=False)
    point = point_of(programme, 0, {(0, 1), (1, 2), (2, 0)})
    assert Held(programme, ["leave-once"]).at([point]).state == "infeasible"
