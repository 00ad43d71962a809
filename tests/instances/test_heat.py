"""Temperatures by hand, in the limits of the kernel, and its windows by sampling."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cutgap.instances import Contour, Head, Instance, Machine, Material, Plan
from cutgap.instances.generate import generate
from cutgap.instances.heat import curve_distances, lag_window, peak_temperature, rise, rises, temperatures
from cutgap.instances.simulate import start_times

STEEL = Material("steel", 48.0, 480.0, 7850.0, thickness_mm=5.0, power_w=1000.0, ambient_c=20.0)
MACHINE = Machine(v_jump=100.0, v_cut=50.0, t_aux=0.0)


def square(name, x, y, side, starts=((0.0, 0.0),)):
    corners = np.array([[x, y], [x + side, y], [x + side, y + side], [x, y + side]])
    entries = np.array([[x + dx, y + dy, 0.0] for dx, dy in starts])
    return Contour(name, entries, 4.0 * side, geometry=corners)


def plate(*contours, machine=MACHINE, material=STEEL, heads=1):
    return Instance("plate", contours, tuple(Head(f"h{k}") for k in range(heads)), machine, material=material)


def kernel(distance_mm, lag_s):
    """The published formula in SI units, figure by figure."""
    distance, capacity = distance_mm / 1000.0, 480.0 * 7850.0
    spread = 48.0 / capacity
    peak = 1000.0 / (0.05 * 0.005 * math.sqrt(4.0 * math.pi * 48.0 * capacity * lag_s))
    return peak * math.exp(-(distance**2) / (4.0 * spread * lag_s))


def test_the_second_of_two_contours_by_hand():
    instance = plate(square("a", 0.0, 0.0, 10.0), square("b", 16.0, 0.0, 10.0))
    found = rises(instance, Plan.of_contours([[0, 1]]))
    # From the corner (0, 0) to (16, 0) in 0.16 s; the curve of a is 6 mm away.
    assert found[0] == 0.0
    assert found[1] == pytest.approx(kernel(6.0, 0.16), rel=1e-12)
    assert peak_temperature(instance, Plan.of_contours([[0, 1]])) == pytest.approx(20.0 + kernel(6.0, 0.16))


def test_earlier_contours_add_up_and_what_is_cut_between_takes_time():
    contours = (square("a", 0.0, 0.0, 10.0), square("b", 16.0, 0.0, 10.0), square("c", 32.0, 0.0, 10.0))
    found = rises(plate(*contours), Plan.of_contours([[0, 1, 2]]))
    lag_from_a = 0.16 + 40.0 / 50.0 + 0.16
    assert found[2] == pytest.approx(kernel(22.0, lag_from_a) + kernel(6.0, 0.16), rel=1e-12)


def test_the_distance_is_to_the_segment_not_to_its_line():
    instance = plate(square("a", 0.0, 0.0, 10.0), square("b", 13.0, 14.0, 10.0))
    # (13, 14) is 3 mm beside and 4 mm above the corner (10, 10), and only 3 mm from the line x = 10.
    assert curve_distances(instance)[1, 0] == pytest.approx(5.0)


def test_a_start_inside_a_curve_is_warmed_from_its_nearest_side():
    instance = plate(square("a", 0.0, 0.0, 100.0), square("b", 40.0, 30.0, 10.0))
    assert curve_distances(instance)[1, 0] == pytest.approx(30.0)


def test_on_the_curve_the_rise_falls_with_the_square_root_of_time():
    instance = plate(square("a", 0.0, 0.0, 10.0))
    assert rise(instance, 0.0, 4.0) == pytest.approx(rise(instance, 0.0, 1.0) / 2.0)
    assert rise(instance, 0.0, 1.0) == pytest.approx(kernel(0.0, 1.0))


def test_the_limits_of_the_kernel():
    instance = plate(square("a", 0.0, 0.0, 10.0))
    assert rise(instance, 5.0, 0.0) == 0.0
    assert rise(instance, 0.0, 0.0) == np.inf
    assert rise(instance, 5.0, 1e-9) == pytest.approx(0.0)
    assert rise(instance, 1e5, 10.0) == pytest.approx(0.0)


def test_what_a_contour_does_to_itself_does_not_count():
    instance = plate(square("a", 0.0, 0.0, 10.0))
    assert peak_temperature(instance, Plan.of_contours([[0]])) == 20.0


def test_another_head_warms_once_it_is_done():
    contours = (square("a", 0.0, 0.0, 10.0), square("b", 16.0, 0.0, 10.0), square("c", 500.0, 0.0, 10.0))
    instance = plate(*contours, heads=2)
    # Head 0 cuts a from 0 to 0.8 s. Head 1 starts at c, is at b at 0.8 + 4.84 s.
    found = rises(instance, Plan.of_contours([[0], [2, 1]]))
    assert found[1] == pytest.approx(kernel(6.0, 4.84) + kernel(474.0, 4.84), rel=1e-9)
    # Begun at once, neither warms the other.
    assert rises(instance, Plan.of_contours([[0], [1, 2]]))[1] == 0.0


def test_more_power_and_a_thinner_sheet_are_hotter_in_proportion():
    contours = (square("a", 0.0, 0.0, 10.0), square("b", 16.0, 0.0, 10.0))
    plan = Plan.of_contours([[0, 1]])
    base = rises(plate(*contours), plan)[1]
    assert rises(plate(*contours, material=replace(STEEL, power_w=3000.0)), plan)[1] == pytest.approx(3 * base)
    thin = replace(STEEL, thickness_mm=2.5)
    assert rises(plate(*contours, material=thin), plan)[1] == pytest.approx(2 * base)


@pytest.mark.parametrize("seed", range(20))
def test_a_window_holds_the_lags_at_which_the_kernel_is_above(seed):
    rng = np.random.default_rng(seed)
    instance = plate(square("a", 0.0, 0.0, 10.0))
    distance, theta = rng.uniform(0.0, 20.0) * rng.integers(0, 2), rng.uniform(0.5, 60.0)
    lags = np.geomspace(1e-3, 1e5, 4000)
    hot = rise(instance, distance, lags) > theta
    window = lag_window(instance, distance, theta)
    if window is None:
        assert not hot.any()
        return
    assert rise(instance, distance, window[1]) == pytest.approx(theta, rel=1e-6)
    if distance > 0:
        assert rise(instance, distance, window[0]) == pytest.approx(theta, rel=1e-6)
    inside = (lags > window[0] * (1 + 1e-9)) & (lags < window[1] * (1 - 1e-9))
    assert (hot == inside).all()


def test_heat_without_material_or_curves_is_refused():
    bare = Contour("a", np.zeros((1, 3)), 10.0)
    with pytest.raises(ValueError, match="material"):
        peak_temperature(plate(square("a", 0, 0, 1.0), material=None), Plan.of_contours([[0]]))
    with pytest.raises(ValueError, match="geometry"):
        peak_temperature(plate(bare), Plan.of_contours([[0]]))


def test_generated_plates_have_curves_that_stand_apart():
    import shapely

    for kind in ("plate", "dense-plate"):
        instance = generate(kind, holes=30, seed=5)
        shapes = [shapely.Polygon(contour.geometry) for contour in instance.contours]
        assert all(shape.is_valid for shape in shapes)
        assert all(a.distance(b) > 1.0 for i, a in enumerate(shapes) for b in shapes[:i])
        for contour in instance.contours:
            assert {tuple(point[:2]) for point in contour.entry_points} <= {tuple(p) for p in contour.geometry}
            assert 3 <= len(contour.entry_points) <= 8


def test_the_sheet_is_as_warm_as_what_is_done_has_made_it():
    instance = plate(square("a", 0.0, 0.0, 10.0), square("b", 16.0, 0.0, 10.0))
    # a is done at 0.8 s, b at 0.8 + 0.16 + 0.8 s.
    # (13, 5) is 3 mm from both, (30, 0) 20 mm from a and 4 mm from b.
    plan = Plan.of_contours([[0, 1]])
    found = temperatures(instance, plan, [[13.0, 5.0], [30.0, 0.0]], [0.5, 1.0, 3.0])
    assert found[0].tolist() == [20.0, 20.0]
    assert found[1] == pytest.approx([20.0 + kernel(3.0, 0.2), 20.0 + kernel(20.0, 0.2)], rel=1e-12)
    both = [kernel(3.0, 2.2) + kernel(3.0, 1.24), kernel(20.0, 2.2) + kernel(4.0, 1.24)]
    assert found[2] == pytest.approx(np.add(20.0, both), rel=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_start_points_are_as_warm_as_the_sheet_there(seed):
    rng = np.random.default_rng(seed)
    instance = generate("dense-plate", holes=6, seed=seed)
    plan = Plan.of_contours([rng.permutation(6)])
    starts, found = start_times(instance, plan), rises(instance, plan)
    for visit in plan.tours[0]:
        place = instance.points[instance.node(visit.contour, visit.entry), :2]
        warm = temperatures(instance, plan, [place], [starts[visit.contour]])
        assert warm[0, 0] == pytest.approx(20.0 + found[visit.contour], rel=1e-12)
