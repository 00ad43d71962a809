"""Method ``regions``: against all orders of a conic model, under moves of the plate, and its certificates."""

from dataclasses import replace

import numpy as np
import pytest
from oracles.random_regions import random_plate, random_region
from oracles.region_tours import shortest_in_any_order, shortest_in_order

from cutgap.formulations import METHODS, solve
from cutgap.formulations.certificate import verify
from cutgap.formulations.front_door import FREE_ENTRIES
from cutgap.formulations.regions.interior_point import bound_of, shortest
from cutgap.formulations.regions.shapes import shapes_of
from cutgap.instances import Contour, Head, Instance, Machine, Plan, Rules, Status, check, evaluate
from cutgap.instances.formats.json_format import format_instance
from cutgap.instances.free_entries import region_of
from cutgap.instances.region import Ellipsoid, point_region

FREE = Rules("travel", free_entries=True)


def optimum(instance):
    regions = [region_of(instance, contour) for contour in range(len(instance.contours))]
    home = instance.heads[0].home
    if home is not None:
        return shortest_in_any_order([*regions, point_region(home)], instance.precedence)
    return shortest_in_any_order(regions)


@pytest.mark.parametrize("seed", range(14))
def test_agrees_with_all_orders(seed):
    rng = np.random.default_rng(seed)
    home = seed % 4 != 3
    plate = random_plate(rng, 5, flat=seed % 3 > 0, home=home, precedence=0.3 if home and seed % 2 else 0.0)
    result = solve(plate, FREE, certify=True)
    assert result.status is Status.OPTIMAL
    assert check(plate, FREE, result.plan) == []
    assert result.value == pytest.approx(optimum(plate), rel=1e-6, abs=1e-6)
    verdict = verify(result.certificate, format_instance(plate))
    assert float(verdict.bound) == pytest.approx(result.lower_bound, abs=2e-6)
    assert float(verdict.value) == pytest.approx(result.value, rel=1e-8, abs=1e-8)


@pytest.mark.parametrize("seed", range(20))
def test_a_tour_in_order_is_shortest_and_any_multipliers_give_a_bound(seed):
    rng = np.random.default_rng(seed)
    regions = [random_region(rng, flat=bool(seed % 2)) for _ in range(int(rng.integers(2, 9)))]
    shapes = shapes_of(regions)
    order = np.arange(len(regions))
    p = np.empty((len(regions), shapes.centres.shape[1]))
    u = np.empty_like(p)
    bound, value = shortest(shapes, order, np.inf, 1e-10, 1e-10, p, u)
    expected, _ = shortest_in_order(regions)
    assert value == pytest.approx(expected, rel=1e-6, abs=1e-6)
    assert bound == pytest.approx(value, rel=1e-8, abs=1e-8)
    assert bound_of(shapes, order, u) == pytest.approx(bound, rel=1e-12, abs=1e-12)
    for _ in range(20):
        other = rng.normal(size=u.shape) + u * rng.choice([0.0, 3.0])
        other /= np.maximum(1.0, np.linalg.norm(other, axis=1, keepdims=True))
        assert bound_of(shapes, order, other) <= value + 1e-9
    heights = [] if p.shape[1] == 3 else [shapes.heights[0]]
    for region, point in zip(regions, p, strict=True):
        assert region.contains(np.append(point, heights), 1e-9)


def disc(name, x, y, radius):
    centre = np.array([x, y, 0.0])
    return Contour(name, centre[None], 1.0, region=Ellipsoid(centre, radius * np.eye(3)[:2]))


def plate_of(*contours, home=(0.0, 0.0, 0.0), **options):
    return Instance("plate", contours, (Head("head", None if home is None else np.array(home)),), **options)


@pytest.mark.parametrize(
    ("plate", "value"),
    [
        (plate_of(), 0.0),
        (plate_of(home=None), 0.0),
        (plate_of(disc("a", 5.0, 0.0, 1.0)), 8.0),
        (plate_of(disc("a", 5.0, 0.0, 1.0), home=None), 0.0),
        (plate_of(disc("a", 5.0, 0.0, 1.0), disc("b", -5.0, 0.0, 2.0), home=None), 14.0),
        (plate_of(disc("a", 5.0, 0.0, 6.0), disc("b", 0.0, 5.0, 6.0)), 0.0),  # the home is inside of both
        (plate_of(disc("a", 5.0, 0.0, 1.0), disc("b", 5.0, 0.0, 1.0), disc("c", 5.0, 0.0, 3.0)), 8.0),
        (plate_of(disc("a", 5.0, 0.0, 1.0), disc("b", 7.0, 0.0, 1.0)), 12.0),  # they touch
        (plate_of(disc("a", 3.0, 0.0, 1.0), disc("b", 9.0, 0.0, 1.0), precedence=((1, 0),)), 16.0),
    ],
)
def test_small_cases(plate, value):
    result = solve(plate, FREE, certify=True)
    assert result.status is Status.OPTIMAL
    assert result.value == pytest.approx(value, abs=1e-8)
    if plate.contours:
        verify(result.certificate, format_instance(plate))


def transformed(plate, matrix, shift, order):
    """The plate turned and stretched by ``matrix`` and moved, its contours in another order."""

    def change(contour):
        points = contour.entry_points @ matrix + shift
        curve = None if contour.geometry is None else contour.geometry @ matrix[:2, :2] + shift[:2]
        region = contour.region
        if region is not None:
            region = Ellipsoid(region.centre @ matrix + shift, region.axes @ matrix)
        return replace(contour, entry_points=points, geometry=curve, region=region)

    places = np.argsort(order)
    head = replace(plate.heads[0], home=plate.heads[0].home @ matrix + shift)
    pairs = tuple((int(places[a]), int(places[b])) for a, b in plate.precedence)
    return replace(
        plate, contours=tuple(change(plate.contours[k]) for k in order), heads=(head,), precedence=pairs
    )


@pytest.mark.parametrize("seed", range(6))
def test_moves_of_the_plate_change_nothing(seed):
    rng = np.random.default_rng(seed)
    plate = random_plate(rng, 9, flat=seed % 2 == 0, precedence=0.1 * (seed % 3))
    angle, factor = rng.uniform(0, 2 * np.pi), float(rng.choice([0.01, 1.0, 100.0]))
    turn = np.array([[np.cos(angle), np.sin(angle), 0], [-np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]])
    other = transformed(plate, factor * turn, factor * rng.normal(size=3) * 10, rng.permutation(9))
    one, changed = solve(plate, FREE), solve(other, FREE)
    assert changed.value == pytest.approx(factor * one.value, rel=1e-8)
    assert changed.lower_bound == pytest.approx(factor * one.lower_bound, rel=1e-8, abs=1e-8)


def test_objectives_are_those_of_the_tour():
    plate = random_plate(np.random.default_rng(5), 6)
    travel = solve(plate, FREE)
    makespan = solve(plate, Rules("makespan", free_entries=True), certify=True)
    weighted = solve(plate, Rules("weighted", weight=3.0, free_entries=True), certify=True)
    assert evaluate(plate, makespan.plan).total_travel_mm == pytest.approx(travel.value, rel=1e-8)
    assert makespan.lower_bound == pytest.approx(makespan.value, rel=1e-8)
    assert weighted.value == pytest.approx(travel.value, rel=1e-8)
    for result in (makespan, weighted):
        verify(result.certificate, format_instance(plate))


def scattered(count, seed=0):
    rng = np.random.default_rng(seed)
    places = rng.uniform(0, 100, (count, 2))
    return plate_of(*(disc(str(k), *place, 1.0) for k, place in enumerate(places)))


def test_a_stopped_run_keeps_its_plan_and_a_valid_bound():
    plate = scattered(40)
    result = solve(plate, FREE, time_limit=0.3, certify=True)
    assert result.status is Status.FEASIBLE
    assert result.reason == "stopped early"
    assert 0 < result.lower_bound < result.value
    assert check(plate, FREE, result.plan) == []
    verdict = verify(result.certificate, format_instance(plate))
    assert float(verdict.bound) == pytest.approx(result.lower_bound, abs=1e-5)


def test_ctrl_c_stops_with_what_is_known():
    plate = scattered(40)
    seen = []

    def interrupt(progress):
        seen.append(progress)
        if len(seen) == 3:
            raise KeyboardInterrupt

    result = solve(plate, FREE, watch=interrupt)
    assert result.status is Status.FEASIBLE
    assert result.lower_bound <= result.value
    assert check(plate, FREE, result.plan) == []


def test_progress_closes_in():
    seen = []
    result = solve(scattered(12), Rules("makespan", free_entries=True), watch=seen.append)
    assert all(progress.lower_bound <= progress.value for progress in seen)
    assert seen[-1].value == pytest.approx(result.value)


def test_a_good_start_is_used():
    plate = scattered(40)
    best = solve(plate, FREE, time_limit=1.0).plan
    again = solve(plate, FREE, time_limit=0.01, start=best)
    assert again.value <= evaluate(plate, best).total_travel_mm + 1e-6


BENT = np.array([[0.0, 0.0], [9.0, 0.0], [1.0, 1.0], [0.0, 9.0]])
TWO = Instance("two", (disc("a", 5.0, 0.0, 1.0),), (Head("l", np.zeros(3)), Head("r", np.ones(3))))


@pytest.mark.parametrize(
    ("plate", "rules", "message"),
    [
        (plate_of(disc("a", 5.0, 0.0, 1.0)), Rules("travel"), "ask for free entries"),
        (TWO, FREE, "needs one head, got 2"),
        (plate_of(disc("a", 1.0, 0.0, 1.0), machine=Machine(metric="chebyshev")), FREE, "Euclidean rapids"),
        (plate_of(disc("a", 1.0, 0.0, 1.0)), replace(FREE, via_points=True), "does not take via points"),
        (plate_of(disc("a", 1.0, 0.0, 1.0)), replace(FREE, backward_price=1.0), "take backward price"),
        (
            plate_of(disc("a", 1.0, 0.0, 1.0), disc("b", 2.0, 0.0, 1.0), home=None, precedence=((0, 1),)),
            FREE,
            "precedence with a home alone",
        ),
        (plate_of(Contour("a", np.zeros((1, 3)), 1.0, geometry=BENT)), FREE, "not convex"),
    ],
)
def test_what_it_does_not_take_is_refused(plate, rules, message):
    with pytest.raises(ValueError, match=message):
        METHODS["regions"](plate, rules)


@pytest.mark.parametrize("method", [name for name in METHODS if name not in FREE_ENTRIES])
def test_other_methods_refuse_free_entries(method):
    """Their bounds hold for given entry points alone."""
    with pytest.raises(ValueError, match="take regions"):
        solve(plate_of(disc("a", 5.0, 0.0, 1.0)), FREE, method=method)


def test_a_plan_of_given_entries_is_worth_its_points():
    """A plan without points of its own is one with free entries too, as its entry points are in the regions."""
    plate = scattered(8)
    tour = Plan.of_contours([range(8)])
    assert check(plate, FREE, tour) == []
    result = solve(plate, FREE)
    assert result.value < evaluate(plate, tour).total_travel_mm
