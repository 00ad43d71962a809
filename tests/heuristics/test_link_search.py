"""Links for any number of pierces: never worse than what it starts from, and better where that is known."""

from dataclasses import replace

import numpy as np
import pytest

from cutgap.heuristics import entry_search, euler_bridging, link_search
from cutgap.heuristics.effort import SearchEffort
from cutgap.heuristics.link_rings import new_rings
from cutgap.heuristics.link_sheet import chosen_nodes, plan_of_rings, rings_of, sheet_of
from cutgap.instances import Contour, Head, Instance, Machine, Plan, Rules, Visit, check, evaluate
from cutgap.instances.links.trajectory import trajectory
from cutgap.instances.progress import Progress

QUICK = SearchEffort(rounds_per_contour=200)
ONE_STROKE = Rules("travel", links=True, pierces=1)
FREE = Rules("makespan", links=True)


def outline(name: str, corners: list[tuple[float, float]]) -> Contour:
    """A polygon that may be entered at its corners."""
    curve = np.array(corners, dtype=float)
    length = float(np.linalg.norm(curve - np.roll(curve, 1, axis=0), axis=1).sum())
    return Contour(name, np.column_stack((curve, np.zeros(len(curve)))), length, geometry=curve)


def square(name: str, x: float, y: float, side: float = 10.0) -> Contour:
    return outline(name, [(x, y), (x + side, y), (x + side, y + side), (x, y + side)])


def sheet(*contours: Contour, t_aux: float = 1.0, precedence: tuple[tuple[int, int], ...] = ()) -> Instance:
    machine = Machine(v_jump=150.0, v_cut=40.0, t_aux=t_aux)
    return Instance("sheet", contours, (Head("head", np.zeros(3)),), machine, precedence)


def grid(seed: int, count: int = 9, t_aux: float = 1.0, gap: float = 8.0) -> Instance:
    """Squares in rows of three, each moved a little."""
    rng = np.random.default_rng(seed)
    places = [(10 + gap) * np.array(divmod(i, 3)) + rng.uniform(0, gap - 1, 2) for i in range(count)]
    return sheet(*(square(f"{i}", *place.tolist()) for i, place in enumerate(places)), t_aux=t_aux)


def found(instance: Instance, rules: Rules, seed: int = 0) -> Plan:
    plan = link_search(instance, rules, rng=np.random.default_rng(seed), parameters=QUICK)
    assert not check(instance, rules, plan)
    return plan


def value(instance: Instance, rules: Rules, plan: Plan) -> float:
    return evaluate(instance, plan).objective(rules)


@pytest.mark.parametrize("pierces", [1, 3, None])
@pytest.mark.parametrize("objective", ["travel", "makespan"])
@pytest.mark.parametrize("seed", range(4))
def test_never_worse_than_one_stroke_nor_than_a_tour(seed, objective, pierces):
    nest = grid(seed, t_aux=[0.0, 0.05, 0.5, 80.0][seed])
    rules = Rules(objective, links=True, pierces=pierces)
    ours = value(nest, rules, found(nest, rules, seed))
    assert ours <= value(nest, rules, euler_bridging(nest, rules, rng=np.random.default_rng(seed))) + 1e-9
    if pierces is None:
        assert ours <= value(nest, rules, entry_search(nest, rules, rng=np.random.default_rng(seed))) + 1e-9


def test_more_pierces_never_cost_more():
    nest = grid(1, t_aux=0.05)
    values = [
        value(nest, rules, found(nest, rules)) for rules in (replace(FREE, pierces=k) for k in (1, 2, 4, 9))
    ]
    assert values == sorted(values, reverse=True)
    assert values[-1] < values[0]


@pytest.mark.parametrize("rules", [ONE_STROKE, FREE, Rules("makespan", links=True, pierces=2)])
def test_the_seed_makes_the_plan(rules):
    nest = grid(2)
    assert found(nest, rules, 5) == found(nest, rules, 5)


def pointing(name: str, centre: float, distance: float, angle: float) -> Contour:
    """A long triangle whose tip lies at a distance and an angle, in degrees, from a centre and points at it."""
    outward = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    side = np.array([-outward[1], outward[0]])
    tip = centre + distance * outward
    return outline(
        name, [tuple(tip + step) for step in (0 * side, 40 * outward - 5 * side, 40 * outward + 5 * side)]
    )


def test_a_circle_of_single_links_beats_the_doubled_tree():
    nest = sheet(*(pointing(f"{angle}", 60.0, 4.0, angle) for angle in (90, 210, 330)))
    tree = evaluate(nest, euler_bridging(nest, ONE_STROKE, rng=np.random.default_rng(0))).link_mm[0]
    plan = found(nest, ONE_STROKE)
    side = 4 * np.sqrt(3)  # of the triangle of the tips: all three sides once, or two of them twice
    assert tree == pytest.approx(4 * side)
    assert evaluate(nest, plan).link_mm[0] == pytest.approx(3 * side)
    assert [link.passes for link in plan.links] == [1, 1, 1]


def test_a_stroke_that_ends_elsewhere_pays():
    # Tips around the home: from there to the first, on from tip to tip, back from the last, each link once.
    nest = sheet(*(pointing(f"{angle}", 0.0, 30.0, angle) for angle in (0, 30, 60)))
    plan = found(nest, ONE_STROKE)
    assert [link.passes for link in plan.links] == [1, 1]
    assert value(nest, ONE_STROKE, plan) == pytest.approx(2 * 30 + 2 * 60 * np.sin(np.radians(15)))
    phases = trajectory(nest, plan)
    assert phases[0].points[1].tolist() != phases[-1].points[0].tolist()


def test_flame_pierces_once_and_laser_often_on_the_same_sheet():
    pierces = {}
    for t_aux in (80.0, 0.5):
        nest = grid(3, t_aux=t_aux, gap=40.0)
        plan = found(nest, FREE)
        pierces[t_aux] = evaluate(nest, plan).pierces[0]
    assert pierces[80.0] == 1
    assert pierces[0.5] >= 5


def test_what_must_be_cut_first_is_cut_first():
    holes = [square(f"hole {i}", 15 + 50 * i, 15) for i in range(3)]
    outlines = [square(f"outline {i}", 5 + 50 * i, 5, 30) for i in range(3)]
    nest = sheet(*outlines, *holes, precedence=((3, 0), (4, 1), (5, 2)))
    for rules in (FREE, Rules("travel", links=True)):
        plan = found(nest, rules)
        assert value(nest, rules, plan) <= value(
            nest, rules, entry_search(nest, rules, rng=np.random.default_rng(0))
        )


def test_too_few_pierces_are_left_to_check():
    nested = sheet(square("outline", 5, 5, 30), square("hole", 15, 15))
    plan = link_search(nested, ONE_STROKE, rng=np.random.default_rng(0), parameters=QUICK)
    assert {violation.constraint for violation in check(nested, ONE_STROKE, plan)} == {"pierces"}


def test_one_contour_and_none():
    assert found(sheet(square("alone", 3, 4)), ONE_STROKE) == Plan(((Visit(0, 0),),))
    assert found(sheet(), FREE) == Plan(((),))


def test_a_time_limit_and_a_watch():
    seen: list[Progress] = []
    nest, rng = grid(4), np.random.default_rng(0)
    plan = link_search(nest, ONE_STROKE, rng=rng, time_limit=0.0, watch=seen.append)
    assert plan == euler_bridging(nest, ONE_STROKE, rng=rng)
    values = [progress.value for progress in seen]
    assert values == sorted(values, reverse=True)
    assert values[-1] == value(nest, ONE_STROKE, plan)


def test_cycles_and_plans_are_the_same():
    nest = grid(5)
    reference = euler_bridging(nest, FREE, rng=np.random.default_rng(0))
    nodes = chosen_nodes(nest, set())
    made = sheet_of(nest, FREE, nodes, reference)
    again = plan_of_rings(made, nodes, nest, rings_of(made, nodes, nest, reference), 0.0)
    assert value(nest, FREE, again) == pytest.approx(value(nest, FREE, reference))
    assert plan_of_rings(made, nodes, nest, new_rings(made), 0.0) == Plan(((),))


def test_many_entry_points_are_thinned_but_keep_what_is_wanted():
    angles = np.linspace(0, 2 * np.pi, 800, endpoint=False)
    rings = [
        outline(f"{i}", list(zip(30 * i + 10 * np.cos(angles), 10 * np.sin(angles), strict=True)))
        for i in range(3)
    ]
    nest = sheet(*rings)
    nodes = chosen_nodes(nest, {400})
    assert 400 in nodes
    assert nodes[-1] == nest.node_count - 1
    assert len(nodes) <= 1502
    # The facing points of neighbours are kept: they make the shortest links.
    assert {0, 1200} <= set(nodes.tolist())


@pytest.mark.parametrize("rounds", [-1, True, 2.0])
def test_wrong_efforts_are_refused(rounds):
    with pytest.raises(ValueError, match="rounds_per_contour"):
        SearchEffort(rounds_per_contour=rounds)
