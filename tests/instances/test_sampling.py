"""Entry points sampled on curves, and points that move along them."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
import shapely

from cutgap.instances import Contour, Head, Instance, Machine, Plan, evaluate
from cutgap.instances.polish import nearest_between, polished
from cutgap.instances.region import Ellipsoid
from cutgap.instances.sampling import curve_of, sampled


def random_curve(rng, centre):
    """A star-shaped polygon, mostly not convex."""
    angles = np.sort(rng.uniform(0, 2 * np.pi, 7))
    return centre + rng.uniform(3, 15, (7, 1)) * np.column_stack((np.cos(angles), np.sin(angles)))


def random_sheet(seed, count, home=False):
    rng = np.random.default_rng(seed)
    contours = [Contour("point", np.array([[50.0, 50.0, 2.0]]), 0.0)]
    for i in range(count - 1):
        centre = np.array([*rng.uniform(0, 100, 2), 2.0])
        region, geometry = Ellipsoid(centre, np.array([[rng.uniform(2, 15), 0, 0], [0, 5, 0]])), None
        if i % 2:
            region, geometry = None, random_curve(rng, centre[:2])
        contours.append(Contour(f"c{i}", centre[None], 1.0, geometry=geometry, region=region))
    return Instance("sheet", tuple(contours), (Head("h", np.array([0.0, 0, 9]) if home else None),))


@pytest.mark.parametrize("count", [1, 2, 5, 8])
def test_samples_lie_on_the_curve_and_twice_as_many_contain_them(count):
    instance = random_sheet(1, 5)
    once, twice = sampled(instance, count), sampled(instance, 2 * count)
    for contour, few, many in zip(instance.contours, once.contours, twice.contours, strict=True):
        if contour.region is None and contour.geometry is None:
            assert (few.entry_points == contour.entry_points).all()
            continue
        assert few.entry_points.shape == (count, 3)
        assert few.entry_points == pytest.approx(many.entry_points[::2])
        if contour.geometry is not None:
            ring = shapely.LinearRing(contour.geometry)
            assert ring.length / count == pytest.approx(
                max(
                    np.diff(
                        [*sorted(map(ring.project, map(shapely.Point, few.entry_points[:, :2]))), ring.length]
                    )
                )
            )
            assert max(ring.distance(shapely.Point(p)) for p in few.entry_points[:, :2]) < 1e-9
        else:
            place = (few.entry_points - contour.region.centre) @ np.linalg.pinv(contour.region.axes)
            assert np.linalg.norm(place, axis=1) == pytest.approx(np.ones(count))


def test_what_cannot_be_sampled_is_refused():
    instance = random_sheet(0, 3)
    with pytest.raises(ValueError, match=r"count: expected at least 1.*got 0"):
        sampled(instance, 0)
    with pytest.raises(ValueError, match="matrix"):
        sampled(replace(instance, machine=Machine(metric="matrix"), matrix=np.zeros((3, 3))), 2)
    two = Contour("two", np.zeros((2, 3)), 1.0)
    with pytest.raises(ValueError, match=r"'two'.*no curve"):
        sampled(replace(instance, contours=(two,)), 2)
    slanted = Contour("slanted", np.array([[0.0, 0, 0], [1, 0, 1]]), 1.0, geometry=np.eye(3)[:, :2])
    with pytest.raises(ValueError, match=r"'slanted'.*differ in z"):
        curve_of(slanted)


@pytest.mark.parametrize("seed", range(20))
def test_the_way_over_a_curve_is_shortest(seed):
    rng = np.random.default_rng(seed)
    curve = np.column_stack((random_curve(rng, np.zeros(2)), rng.normal(size=7)))
    before, after = rng.uniform(-30, 30, (2, 3))
    shares = np.linspace(0, 1, 2001)[:, None, None]
    points = (curve + shares * (np.roll(curve, -1, axis=0) - curve)).reshape(-1, 3)
    ways = np.linalg.norm(points - before, axis=1) + np.linalg.norm(points - after, axis=1)
    found = nearest_between(curve, before, after)
    way = np.linalg.norm(found - before) + np.linalg.norm(found - after)
    assert ways.min() - 1e-3 <= way <= ways.min() + 1e-9
    assert np.linalg.norm(points - found, axis=1).min() < 0.02


@pytest.mark.parametrize(("seed", "home"), [*product(range(4), (False, True))])
def test_polished_plans_are_no_longer_than_the_best_samples(seed, home):
    instance = random_sheet(seed, 4, home)
    plan = Plan.of_contours([range(4)])
    better = polished(instance, plan)
    value = evaluate(instance, better).total_travel_mm
    fine = sampled(instance, 8)
    entries = product(*(range(len(contour.entry_points)) for contour in fine.contours))
    best = min(evaluate(fine, Plan((tuple(enumerate(each)),))).total_travel_mm for each in entries)
    # The samples are on the curves, from which the polylines of ellipses are a little away.
    assert value <= best + 0.01
    assert value < evaluate(instance, plan).total_travel_mm
    assert [visit.contour for visit in better.tours[0]] == [0, 1, 2, 3]
    for visit in better.tours[0]:
        contour = instance.contours[visit.contour]
        if contour.geometry is not None:
            assert shapely.LinearRing(contour.geometry).distance(shapely.Point(visit.point[:2])) < 1e-9
        if contour.region is not None:
            assert contour.region.contains(np.array(visit.point), 1e-9)
    again = evaluate(instance, polished(instance, better)).total_travel_mm
    assert again == pytest.approx(value, rel=1e-9)
