"""Strokes over links: figures by hand on squares."""

from collections import Counter
from itertools import pairwise

import networkx
import numpy as np
import pytest

from cutgap.instances import Contour, Head, Instance, Link, Machine, Plan, Rules, Visit, check, evaluate
from cutgap.instances.formats.json_format import format_plan, parse_plan
from cutgap.instances.links.clearance import blocked
from cutgap.instances.links.strokes import groups, link_ends, strokes
from cutgap.instances.links.trajectory import trajectory

ONE_STROKE = Rules("travel", links=True, pierces=1)
MACHINE = Machine(v_jump=100.0, v_cut=10.0, t_aux=7.0)


def square(name: str, x: float, y: float, side: float = 10.0) -> Contour:
    """A square by its lower left corner; entry points are its corners, counter-clockwise from there."""
    corners = np.array([[x, y], [x + side, y], [x + side, y + side], [x, y + side]])
    return Contour(name, np.column_stack((corners, np.zeros(4))), 4 * side, geometry=corners)


def sheet(*squares: Contour, precedence: tuple[tuple[int, int], ...] = ()) -> Instance:
    """Squares, one head at the origin."""
    return Instance("squares", squares, (Head("head", np.zeros(3)),), MACHINE, precedence)


ROW = sheet(square("a", 0, 10), square("b", 14, 10), square("c", 30, 10))
"""Three squares, 4 and 6 mm apart, 10 mm above the home."""

TREE = Plan(((Visit(0, 0),),), (Link(0, 1, 1, 0), Link(1, 2, 2, 3)))
OPEN = Plan(((Visit(0, 0),),), (Link(0, 1, 1, 0), Link(1, 1, 2, 0, 1)))


def names(instance: Instance, rules: Rules, plan: Plan) -> set[str]:
    return {violation.constraint for violation in check(instance, rules, plan)}


def test_a_doubled_tree_is_one_stroke_that_ends_where_it_starts() -> None:
    evaluation = evaluate(ROW, TREE)
    assert evaluation.link_mm == (20.0,)
    assert evaluation.travel_mm == (20.0 + 20.0,)
    assert evaluation.time_s == (pytest.approx(20 / 100 + (120 + 20) / 10 + 7),)
    assert evaluation.pierces == (1,)
    assert check(ROW, ONE_STROKE, TREE) == []


def test_a_stroke_may_end_elsewhere() -> None:
    plan = Plan(((Visit(0, 0),),), (Link(0, 0, 1, 0, 1), Link(1, 0, 2, 0, 1)))
    assert blocked(ROW, [0, 4], [4, 8]).tolist() == [False, False]  # along the lower edges
    (stroke,) = strokes(ROW, plan)[0]
    assert (stroke.start, stroke.end) == (0, 8)
    back = np.hypot(30, 10)
    assert evaluate(ROW, plan).travel_mm == (pytest.approx(10 + 14 + 16 + back),)
    assert check(ROW, ONE_STROKE, plan) == []


def test_an_odd_number_of_links_at_a_node_is_refused() -> None:
    assert "even nodes" in names(ROW, ONE_STROKE, OPEN)
    with pytest.raises(ValueError, match="odd number of links"):
        trajectory(ROW, OPEN)


def test_a_link_through_a_part_is_refused() -> None:
    plan = Plan(((Visit(0, 0),),), (Link(0, 1, 2, 0), Link(0, 1, 1, 0)))
    assert blocked(ROW, [1, 0], [8, 6]).tolist() == [False, True]
    assert names(ROW, ONE_STROKE, plan) == set()
    across = Plan(((Visit(0, 0),),), (Link(0, 2, 2, 0), Link(0, 1, 1, 0)))
    assert names(ROW, ONE_STROKE, across) == {"clear links"}


def test_what_is_not_linked_is_not_cut() -> None:
    plan = Plan(((Visit(0, 0),),), TREE.links[:1])
    assert names(ROW, ONE_STROKE, plan) == {"each contour once"}
    two = Plan(((Visit(0, 0), Visit(2, 0)),), TREE.links[:1])
    assert names(ROW, ONE_STROKE, two) == {"pierces"}
    assert names(ROW, Rules("travel", links=True), two) == set()
    assert evaluate(ROW, two).travel_mm == (pytest.approx(10 + 30 + np.hypot(30, 10) + 8),)
    twice = Plan(((Visit(0, 0), Visit(2, 0)),), TREE.links)
    assert "each contour once" in names(ROW, Rules("travel", links=True), twice)


def test_a_sheet_without_contours_has_a_plan_without_strokes() -> None:
    nothing, plan = sheet(), Plan(((),))
    assert check(nothing, ONE_STROKE, plan) == []
    assert evaluate(nothing, plan).travel_mm == (0.0,)
    assert trajectory(nothing, plan) == ()


def test_links_have_to_be_asked_for() -> None:
    assert names(ROW, Rules("travel"), TREE) == {"no links"}
    repeated = Plan(TREE.tours, (*TREE.links, TREE.links[0]))
    assert names(ROW, ONE_STROKE, repeated) == {"each link once"}


def test_a_trajectory_takes_bridges_first() -> None:
    phases = trajectory(ROW, TREE)
    assert [phase.kind for phase in phases] == [
        *("rapid", "cut", "link", "cut", "link", "cut", "link", "cut", "link", "cut", "rapid")
    ]
    assert [phase.contour for phase in phases if phase.kind == "cut"] == [0, 1, 2, 1, 0]
    assert_continuous(ROW, TREE)


def assert_continuous(instance: Instance, plan: Plan) -> None:
    """The way is without breaks from home to home and cuts each contour over its whole length."""
    phases = trajectory(instance, plan)
    for before, after in pairwise(phases):
        np.testing.assert_allclose(before.points[-1], after.points[0])
    np.testing.assert_allclose([phases[0].points[0], phases[-1].points[-1]], np.zeros((2, 2)))
    lengths = np.zeros(len(instance.contours))
    for phase in phases:
        if phase.contour is not None:
            lengths[phase.contour] += np.linalg.norm(np.diff(phase.points, axis=0), axis=1).sum()
    np.testing.assert_allclose(lengths, instance.perimeters)


def test_a_circle_of_single_links_is_a_stroke() -> None:
    squares = sheet(square("a", 0, 0), square("b", 14, 0), square("c", 7, 14))
    plan = Plan(((Visit(0, 0),),), (Link(0, 2, 1, 3, 1), Link(1, 3, 2, 0, 1), Link(0, 2, 2, 0, 1)))
    assert check(squares, ONE_STROKE, plan) == []
    assert_continuous(squares, plan)


def test_a_hole_cannot_be_linked_to_the_outside() -> None:
    nested = sheet(square("outline", 0, 0, 30), square("hole", 10, 10, 10), square("inside", 13, 13, 4))
    assert blocked(nested, [0, 4], [4, 8]).tolist() == [True, False]
    with pytest.raises(ValueError, match="'b' overlap"):
        check(sheet(square("a", 0, 0), square("b", 5, 5)), ONE_STROKE, Plan(((),)))


def test_the_last_piece_of_a_contour_decides_precedence() -> None:
    for pairs, fine in ((((2, 0),), True), (((0, 2),), False)):
        ordered = sheet(*ROW.contours, precedence=pairs)
        assert names(ordered, ONE_STROKE, TREE) == (set() if fine else {"precedence"})


def test_plans_with_links_survive_a_file() -> None:
    assert parse_plan(format_plan(TREE, ROW), ROW) == TREE


@pytest.mark.parametrize(
    ("rules", "message"),
    [
        (Rules("travel", links=True, clear_rapids=True), "do not go with clear rapids"),
        (Rules("weighted", links=True), "objectives travel and makespan"),
    ],
)
def test_rules_that_do_not_go_with_links(rules: Rules, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        check(ROW, rules, TREE)


def test_wrong_links_are_refused() -> None:
    with pytest.raises(ValueError, match="expected 1 or 2, got 3"):
        Plan(((),), (Link(0, 0, 1, 0, 3),))
    with pytest.raises(ValueError, match="leads to the contour itself"):
        Plan(((),), (Link(0, 0, 0, 1),))
    with pytest.raises(ValueError, match="goes with links"):
        Rules(pierces=1)
    bent = Contour("bow", np.zeros((1, 3)), 4.0, geometry=np.array([[0, 0], [1, 1], [1, 0], [0, 1]]))
    with pytest.raises(ValueError, match=r"'bow'.*simple closed curve: Self-intersection"):
        check(sheet(bent), ONE_STROKE, Plan(((),)))
    loose = Contour("far", np.array([[5.0, 5.0, 0.0]]), 4.0, geometry=np.array([[0, 0], [1, 0], [0, 1]]))
    with pytest.raises(ValueError, match="off its curve"):
        check(sheet(loose), ONE_STROKE, Plan(((),)))


def test_entry_points_at_one_place_leave_the_contour_whole() -> None:
    corners = square("a", 5, 5).geometry
    assert corners is not None
    twice = [np.array([[x, 10.0, 0.0]] * 2) for x in (15.0, 20.0)]
    one, other = (
        Contour(n, p, 40.0, geometry=corners + np.array([x, 0]))
        for n, p, x in zip("ab", twice, (0, 15), strict=True)
    )
    instance = sheet(one, other)
    for plan in (
        Plan(((Visit(0, 0),),), (Link(0, 1, 1, 0),)),
        Plan(((Visit(0, 1),),), (Link(0, 0, 1, 0, 1), Link(0, 1, 1, 0, 1))),
    ):
        assert_continuous(instance, plan)


def grid(rng: np.random.Generator, gap: float) -> Instance:
    """Up to 3 x 3 squares, apart or touching; their curves begin anywhere and turn either way."""
    made = []
    for place in np.ndindex(*rng.integers(1, 4, 2)):
        each = square(str(len(made)), *((10 + gap) * np.array(place)).tolist())
        assert each.geometry is not None
        curve = np.roll(each.geometry[:: 1 if rng.random() < 0.5 else -1], rng.integers(4), axis=0)
        made.append(Contour(each.id, each.entry_points, 40.0, geometry=curve))
    return sheet(*made)


def random_links(
    instance: Instance, rng: np.random.Generator
) -> tuple[tuple[Link, ...], tuple[int, int] | None]:
    """Doubled links, closed walks of single ones, and sometimes one open walk, whose ends are returned."""
    nodes = range(len(instance.points) - 1)
    pairs = [(a, b) for a in nodes for b in nodes if a // 4 < b // 4]
    pairs = [(a, b) for a, b in pairs if np.linalg.norm(instance.points[a] - instance.points[b]) <= 12]
    if not pairs:
        return (), None
    barred = blocked(instance, *zip(*pairs, strict=True)).tolist()
    graph = networkx.Graph(pair for pair, bad in zip(pairs, barred, strict=True) if not bad)
    doubled = {tuple(sorted(edge)) for edge in graph.edges if rng.random() < 0.15}
    single: set[tuple[int, ...]] = set()
    ends = None
    for closed in [True] * int(rng.integers(4)) + [False] * int(rng.integers(2)):
        way = [int(rng.choice(list(graph)))]
        for _ in range(int(rng.integers(2, 8))):
            way.append(int(rng.choice(list(graph[way[-1]]))))
        if closed:
            way += networkx.shortest_path(graph, way[-1], way[0])[1:]
        elif way[0] != way[-1]:
            ends = (way[0], way[-1])
        for step in pairwise(way):
            single ^= {tuple(sorted(step))}
    links = [
        Link(a // 4, a % 4, b // 4, b % 4, 1 if (a, b) in single else 2) for a, b in sorted(single | doubled)
    ]
    return tuple(links), ends


@pytest.mark.parametrize("seed", range(40))
def test_any_even_graph_of_links_is_walked_once(seed: int) -> None:
    rng = np.random.default_rng(seed)
    instance = grid(rng, rng.choice([0.0, 4.0]))
    links, ends = random_links(instance, rng)
    leaders = groups(instance, links)
    starts = {leader: 4 * leader + int(rng.integers(4)) for leader in leaders}
    if ends is not None:
        starts[leaders[ends[0] // 4]] = ends[0]
    plan = Plan((tuple(Visit(node // 4, node % 4) for node in starts.values()),), links)
    assert check(instance, Rules("travel", links=True), plan) == []
    assert_continuous(instance, plan)
    passes = Counter(
        tuple(sorted(map(tuple, phase.points.tolist())))
        for phase in trajectory(instance, plan)
        if phase.kind == "link"
    )
    asked: Counter[tuple[tuple[float, ...], ...]] = Counter()
    for link in links:
        places = (instance.points[node, :2].tolist() for node in link_ends(instance, link))
        asked[tuple(sorted(map(tuple, places)))] += link.passes
    assert passes == asked
