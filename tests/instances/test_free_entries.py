"""Free entries: which region a contour has, plans with points of their own, and what check says of them."""

import operator
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles.random_instances import random_instance, random_plan

from cutgap.instances import Contour, Head, Instance, Machine, Plan, Rules, Visit, check, evaluate
from cutgap.instances.formats.json_format import format_plan, parse_plan
from cutgap.instances.free_entries import is_convex, pinned, region_of
from cutgap.instances.region import Ellipsoid, Hull
from cutgap.instances.simulate import start_times

FREE = Rules("travel", free_entries=True)
SQUARE = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])
DISC = Ellipsoid(np.array([5.0, 5.0, 0.0]), np.diag([5.0, 5.0, 0.0])[:2])


def sheet(*contours, **options):
    return Instance("sheet", contours, (Head("head", np.zeros(3)),), **options)


def hole(name="a", points=((0.0, 0.0, 0.0),), **options):
    return Contour(name, np.array(points), 40.0, **options)


def test_the_region_of_a_contour():
    assert region_of(sheet(hole(geometry=SQUARE, region=DISC)), 0) is DISC
    curved = region_of(sheet(hole(points=((0.0, 0.0, 2.0), (5.0, 0.0, 2.0)), geometry=SQUARE)), 0)
    assert isinstance(curved, Hull)
    assert curved.vertices.tolist() == [[0, 0, 2], [10, 0, 2], [10, 10, 2], [0, 10, 2]]
    point = region_of(sheet(hole(points=((1.0, 2.0, 3.0),))), 0)
    assert isinstance(point, Hull)
    assert point.vertices.tolist() == [[1, 2, 3]]


@pytest.mark.parametrize(
    ("contour", "message"),
    [
        (hole(geometry=SQUARE[[0, 1, 3, 2]]), "contour 'a': not convex: take its hull with hull=True"),
        (hole(points=np.eye(3)), "contour 'a': 3 entry points and no region"),
        (hole(points=np.eye(3), geometry=SQUARE), "contour 'a': its entry points differ in z, from 0 to 1 mm"),
    ],
)
def test_a_contour_without_a_convex_region_is_refused(contour, message):
    with pytest.raises(ValueError, match=message):
        region_of(sheet(contour), 0)


def test_a_hull_may_be_asked_for():
    bent = np.array([[0.0, 0.0], [10.0, 0.0], [1.0, 1.0], [0.0, 10.0]])
    assert not is_convex(bent)
    assert region_of(sheet(hole(geometry=bent)), 0, hull=True).contains(np.array([4.0, 4.0, 0.0]))


@pytest.mark.parametrize("turns", [1, 2])
def test_convex_curves(turns):
    angles = np.linspace(0, turns * 2 * np.pi, 5 * 7, endpoint=False)
    circle = np.column_stack((np.cos(angles), np.sin(angles)))
    assert is_convex(circle) == (turns == 1)
    assert is_convex(np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]))


@given(st.integers(0, 2**32 - 1))
def test_a_plan_with_points_is_worth_what_its_pinned_plan_is(seed):
    """Points equal to entry points change no figure; others give those of an instance made of them."""
    rng = np.random.default_rng(seed)
    part = random_instance(rng, 4, entries=2)
    plan = random_plan(rng, part)
    same = Plan(
        tuple(
            tuple(Visit(c, 0, tuple(part.contours[c].entry_points[e])) for c, e, *_ in tour)
            for tour in plan.tours
        )
    )
    assert evaluate(part, same) == evaluate(part, plan)
    assert start_times(part, same) == start_times(part, plan)
    moved = {visit.contour: tuple(rng.normal(size=3).tolist()) for tour in plan.tours for visit in tour}
    own = Plan(tuple(tuple(Visit(c, 0, moved[c]) for c, *_ in tour) for tour in plan.tours))
    rebuilt = replace(
        part,
        contours=tuple(
            replace(contour, entry_points=np.array([moved[c]])) if c in moved else contour
            for c, contour in enumerate(part.contours)
        ),
    )
    orders = Plan.of_contours([[visit.contour for visit in tour] for tour in plan.tours])
    assert evaluate(part, own) == evaluate(rebuilt, orders)
    assert all(map(operator.is_, pinned(part, plan), (part, plan)))


def test_points_must_be_in_their_regions_and_be_asked_for():
    part = sheet(hole(region=DISC, points=((5.0, 5.0, 0.0),)), hole("b", geometry=SQUARE))

    def broken(rules, *visits):
        return [violation.constraint for violation in check(part, rules, Plan((visits,)))]

    inside, outside = (5.0, 0.0, 0.0), (5.0, -0.001, 0.0)
    assert broken(FREE, Visit(0, 0, inside), Visit(1, 0, inside)) == []
    assert broken(FREE, Visit(0), Visit(1)) == []
    assert broken(FREE, Visit(0, 0, outside), Visit(1)) == ["entry in region"]
    assert broken(FREE, Visit(0, 0, inside), Visit(1, 0, outside)) == ["entry in region"]
    assert broken(Rules("travel"), Visit(0, 0, inside), Visit(1)) == ["entry points"]
    away = check(part, FREE, Plan(((Visit(0, 0, (5.0, -3.0, 4.0)), Visit(1)),)))
    assert away[0].amount == pytest.approx(np.hypot(3.0, 4.0))


def test_an_entry_point_outside_the_region_is_no_free_entry():
    """Else a bound on tours through the regions would not hold for the plan."""
    part = sheet(hole(region=DISC))
    assert [v.constraint for v in check(part, FREE, Plan(((Visit(0),),)))] == ["entry in region"]
    assert check(part, Rules("travel"), Plan(((Visit(0),),))) == []


def test_a_matrix_knows_no_free_points():
    part = sheet(hole(), machine=Machine(metric="matrix"), matrix=np.zeros((2, 2)))
    plan = Plan(((Visit(0, 0, (1.0, 2.0, 3.0)),),))
    with pytest.raises(ValueError, match="has a matrix"):
        evaluate(part, plan)
    with pytest.raises(ValueError, match="has a matrix"):
        check(part, FREE, Plan(((Visit(0),),)))


def test_a_plan_keeps_its_points_in_a_file():
    part = sheet(hole(region=DISC))
    plan = Plan(((Visit(0, 0, (0.1, 0.2, -0.0)),),))
    again = parse_plan(format_plan(plan, part), part)
    assert again == plan
    assert np.signbit(again.tours[0][0].point[2])


@pytest.mark.parametrize("point", [(1.0, 2.0), (1.0, 2.0, np.inf), ((1.0, 2.0, 3.0),)])
def test_what_is_no_point_is_refused(point):
    with pytest.raises(ValueError, match="plan, contour 0, point"):
        Plan(((Visit(0, 0, point),),))
