"""The reference's procedure by hand on squares, and what it leaves to ``check``."""

import numpy as np
import pytest

from cutgap.heuristics import HEURISTICS
from cutgap.heuristics.euler_bridging import euler_bridging, spanning_forest
from cutgap.instances import Contour, Head, Instance, Link, Machine, Plan, Rules, Visit, check, evaluate
from cutgap.instances.links.clearance import blocked
from cutgap.instances.links.trajectory import trajectory

ONE_STROKE = Rules("travel", links=True, pierces=1)


def square(name: str, x: float, y: float, side: float = 10.0) -> Contour:
    """A square by its lower left corner; entry points are its corners, counter-clockwise from there."""
    corners = np.array([[x, y], [x + side, y], [x + side, y + side], [x, y + side]])
    return Contour(name, np.column_stack((corners, np.zeros(4))), 4 * side, geometry=corners)


def sheet(*squares: Contour, precedence: tuple[tuple[int, int], ...] = ()) -> Instance:
    """Squares, one head at the origin."""
    return Instance("squares", squares, (Head("head", np.zeros(3)),), Machine(), precedence)


def bridged(instance: Instance, rules: Rules = ONE_STROKE) -> Plan:
    return euler_bridging(instance, rules, rng=np.random.default_rng(0))


def names(instance: Instance, plan: Plan) -> set[str]:
    return {violation.constraint for violation in check(instance, ONE_STROKE, plan)}


CROSS = sheet(
    square("middle", 20, 20),
    square("right", 33, 20),
    square("left", 5, 21),
    square("above", 20, 34),
    square("far", 33, 42),
)
"""From the middle: right 3 mm, up 4 mm, left 5.1 mm; "far" is nearer to "above" than to "right"."""


def test_prim_takes_the_nearest_contour_first_and_the_stroke_starts_near_the_home() -> None:
    plan = bridged(CROSS)
    # Of the two shortest links, along the lower edges and along the upper ones, the first by number is taken.
    assert plan.links[:2] == (Link(0, 1, 1, 0), Link(0, 2, 3, 1))
    assert [(link.contour, link.to_contour) for link in plan.links[2:]] == [(3, 4), (0, 2)]
    assert plan.tours == ((Visit(2, 0),),)
    assert evaluate(CROSS, plan).link_mm[0] == pytest.approx(2 * (3 + 4 + np.hypot(3, 2) + np.hypot(5, 1)))
    assert not check(CROSS, ONE_STROKE, plan)


def test_the_way_takes_bridges_first() -> None:
    cuts = [phase.contour for phase in trajectory(CROSS, bridged(CROSS)) if phase.kind == "cut"]
    # Counter-clockwise from the lower left: on each outline up to the link, over it, back, and on.
    assert cuts == [2, 0, 1, 0, 3, 4, 3, 0, 2]


def test_a_blocked_link_is_replaced_by_the_best_clear_one() -> None:
    # A bar between two squares: the straight links from corner to corner lead through it.
    bar = np.array([[14.0, -1.0], [15.0, -1.0], [15.0, 11.0], [14.0, 11.0]])
    across = Contour("bar", np.column_stack((bar, np.zeros(4)))[2:], 26.0, geometry=bar)
    nest = sheet(square("a", 0, 0), square("b", 19, 0), across)
    assert blocked(nest, [1], [4]).all()
    assert {frozenset((link.contour, link.to_contour)) for link in spanning_forest(nest)} == {
        frozenset((0, 2)),
        frozenset((1, 2)),
    }
    # Only the bar's upper corners are entry points.
    nodes = [(nest.node(*link[:2]), nest.node(*link[2:4])) for link in spanning_forest(nest)]
    clear = [
        (float(np.linalg.norm(nest.points[i] - nest.points[j])), {i, j})
        for i in range(8)
        for j in (8, 9)
        if not blocked(nest, [i], [j])[0]
    ]
    for link in nodes:
        own = [(length, ends) for length, ends in clear if min(ends) // 4 == min(link) // 4]
        assert set(link) == min(own, key=lambda each: each[0])[1]


def test_what_no_link_reaches_gets_a_stroke_of_its_own_and_check_says_so() -> None:
    nested = sheet(square("outline", 5, 5, 30), square("hole", 15, 15), square("beside", 37, 5))
    plan = bridged(nested)
    assert [visit.contour for visit in plan.tours[0]] == [0, 1]
    assert names(nested, plan) == {"pierces"}
    assert not check(nested, Rules("travel", links=True), plan)
    # What lies in a hole is linked to it.
    inner = sheet(square("outline", 5, 5, 30), square("hole", 15, 15), square("core", 18, 18, 4))
    assert [link[:1] + link[2:3] for link in bridged(inner).links] == [(1, 2)]


def test_a_stroke_waits_for_what_is_to_be_cut_first() -> None:
    nested = sheet(square("outline", 5, 5, 30), square("hole", 15, 15), precedence=((1, 0),))
    plan = bridged(nested)
    assert [visit.contour for visit in plan.tours[0]] == [1, 0]
    assert names(nested, plan) == {"pierces"}


def test_one_contour_and_none() -> None:
    assert bridged(sheet(square("alone", 3, 4))) == Plan(((Visit(0, 0),),))
    assert bridged(sheet()) == Plan(((),))


def test_links_have_to_be_asked_for() -> None:
    with pytest.raises(ValueError, match="the rules allow no links"):
        bridged(CROSS, Rules("travel"))


@pytest.mark.parametrize("seed", range(4))
def test_a_random_grid_against_prim_over_all_clear_links(seed: int) -> None:
    rng = np.random.default_rng(seed)
    squares = [
        square(f"{i}", *(15 * np.array(divmod(i, 4)) + rng.uniform(0, 4, 2)).tolist()) for i in range(12)
    ]
    nest = sheet(*squares)
    plan = bridged(nest)
    assert not check(nest, ONE_STROKE, plan)
    first, second = np.triu_indices(48, 1)
    apart = first // 4 != second // 4
    first, second = first[apart], second[apart]
    clear = ~blocked(nest, first, second)
    lengths = np.linalg.norm(nest.points[first] - nest.points[second], axis=1)
    least, tree = 0.0, list(range(12))
    for place in np.argsort(lengths):  # Kruskal over all clear links
        one, other = tree[first[place] // 4], tree[second[place] // 4]
        if clear[place] and one != other:
            least += lengths[place]
            tree = [one if each == other else each for each in tree]
    assert evaluate(nest, plan).link_mm[0] == pytest.approx(2 * least)


def test_who_applies_where_links_are_allowed() -> None:
    def applying(rules: Rules) -> set[str]:
        return {name for name, each in HEURISTICS.items() if each.applies(CROSS, rules)}

    ours = applying(ONE_STROKE)
    assert "euler-bridging" in ours
    assert "entry-search" not in ours
    assert applying(Rules("makespan", links=True)) == ours | {"entry-search"}
    assert not applying(Rules("travel")) & ours
