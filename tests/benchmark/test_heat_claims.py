"""Readings of the printed temperatures, and the published claim: figures by hand, commands on small plates."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from oracles.random_plates import random_plate

from cutgap.benchmark import heat_claims, heat_readings
from cutgap.benchmark.heat_claims import BEST, VARIANTS, Outcome, ratios, run_plate, verdict
from cutgap.benchmark.heat_readings import (
    RULES,
    Reading,
    all_readings,
    line_distances,
    peak_c,
    plate_by,
    routes,
)
from cutgap.heuristics.dual_coded_fitness import ROOM_C
from cutgap.heuristics.hot_routes import peak_rise
from cutgap.instances import Contour, Head, Instance, Machine, Material, Plan, evaluate
from cutgap.instances.generate import generate

STEEL = Material("steel", 48.0, 480.0, 7850.0, thickness_mm=5.0, power_w=1000.0)


def square(name, x, y):
    corners = np.array([[x, y], [x + 10.0, y], [x + 10.0, y + 10.0], [x, y + 10.0]])
    return Contour(name, np.array([[x, y, 0.0]]), 40.0, geometry=corners)


STEPS = Instance(
    "steps",
    (square("a", 0.0, 0.0), square("b", 13.0, 14.0), square("c", 40.0, 20.0)),
    (Head("h", np.zeros(3)),),
    Machine(v_jump=100.0, v_cut=50.0, t_aux=0.0),
    material=STEEL,
)
IN_ORDER = Plan.of_contours([[0, 1, 2]])


def kernel(distance_mm, seconds, per_second=1.0):
    capacity = 480.0 * 7850.0
    line = 1000.0 / (0.05 * 0.005 * math.sqrt(4.0 * math.pi * 48.0 * capacity * seconds))
    return line * math.exp(-((distance_mm * 1e-3) ** 2) * capacity / (4.0 * 48.0 * per_second * seconds))


def test_the_nearest_line_through_an_edge_by_hand():
    # (13, 14) is 3 mm from x = 10 and 4 mm from y = 10; (40, 20) is 10 mm from y = 10.
    assert line_distances(STEPS)[1:, 0] == pytest.approx([3.0, 10.0])


@pytest.mark.parametrize(
    ("reading", "rise"),
    [
        # Rapids of 19.1 mm and 27.66 mm at 100 mm/s, 0.8 s for each contour; c is 30.41 and 17 mm off.
        (Reading(), lambda j, k: (kernel(5.0, j), kernel(math.hypot(30, 10), j + 0.8 + k) + kernel(17.0, k))),
        (Reading("line"), lambda j, k: (kernel(3.0, j), kernel(10.0, j + 0.8 + k) + kernel(4.0, k))),
        (Reading("zero"), lambda j, k: (kernel(0.0, j), kernel(0.0, j + 0.8 + k) + kernel(0.0, k))),
        (Reading("line", "rapids"), lambda j, k: (kernel(3.0, j), kernel(10.0, j + k) + kernel(4.0, k))),
        (
            Reading("line", "own leg"),
            lambda j, k: (kernel(3.0, j + 0.8), kernel(10.0, j + 0.8) + kernel(4.0, k + 0.8)),
        ),
        (Reading("line", "last rapid"), lambda j, k: (kernel(3.0, j), kernel(10.0, k) + kernel(4.0, k))),
        (
            Reading("line", units="minutes"),
            lambda j, k: (kernel(3.0, j / 60), kernel(10.0, (j + 0.8 + k) / 60) + kernel(4.0, k / 60)),
        ),
        (
            Reading("line", units="a in 1/min"),
            lambda j, k: (kernel(3.0, j, 60), kernel(10.0, j + 0.8 + k, 60) + kernel(4.0, k, 60)),
        ),
    ],
)
def test_peaks_of_readings_by_hand(reading, rise):
    expected = max(rise(math.hypot(13, 14) / 100, math.hypot(27, 6) / 100))
    assert peak_c(STEPS, IN_ORDER, reading) == pytest.approx(ROOM_C + expected, rel=1e-9)


def test_the_plain_reading_is_that_of_evaluate():
    instance = generate("dense-plate", holes=9, seed=1)
    for plan in routes(instance, 0):
        assert peak_c(instance, plan, Reading()) == pytest.approx(evaluate(instance, plan).peak_temperature_c)


@pytest.mark.parametrize("reading", [r for r in all_readings() if r.lag in ("passed", "rapids")], ids=str)
def test_routes_are_made_by_the_same_figures(reading):
    rng = np.random.default_rng(5)
    instance = random_plate(rng, 6)
    plate = plate_by(instance, RULES, reading)
    order, starts = rng.permutation(6), np.zeros(6, dtype=np.int64)
    peak = ROOM_C + peak_rise(plate, order, starts, np.empty(6))
    assert peak == pytest.approx(peak_c(instance, Plan.of_contours([order]), reading), rel=1e-9)


def test_routes_by_other_lags_are_refused():
    with pytest.raises(ValueError, match="passed or rapids, got 'own leg'"):
        plate_by(STEPS, RULES, Reading(lag="own leg"))


def test_ratios_and_verdict_by_hand():
    base = {name: Outcome(1000.0, 80.0) for name in VARIANTS}
    good = {**base, "mu = 4": Outcome(1040.0, 25.0), BEST: Outcome(1000.0, 30.0)}
    far = {**base, "mu = 4": Outcome(1100.0, 10.0), BEST: Outcome(1050.0, 50.0)}
    travel, peak, rise = ratios((good, far), "mu = 4")
    assert travel == pytest.approx([1.04, 1.1])
    assert peak == pytest.approx([0.45, 0.3])
    assert rise == pytest.approx([25 / 80, 1 / 8])
    first, second = verdict((good, far)).splitlines()
    assert first.startswith("mu = 4: at most 5 % more travel on 1 of 2 plates")
    assert first.endswith("half the peak in deg C on 1, half the rise on 1")
    assert second.endswith("half the peak in deg C on 1, half the rise on 1")


def test_the_best_within_5_percent_is_no_hotter_than_the_improved_answer():
    found = run_plate(generate("dense-plate", holes=6, seed=1), 0, Reading())
    assert found[BEST].rise <= found["improved"].rise
    assert found[BEST].travel <= 1.05 * found["improved"].travel
    assert all(a != b for a, b in pairwise(found[name] for name in VARIANTS))


def test_the_commands_print_their_tables(capsys):
    arguments = ["dense-plate", "--plates", "2", "--contours", "6", "--reading", "line, passed, minutes"]
    assert heat_claims.main(arguments) == 0
    text = capsys.readouterr().out
    assert all(name in text for name in (*VARIANTS, BEST, "2 plates, dense-plate, line, passed, minutes"))
    assert heat_readings.main(["--plates", "1"]) == 0
    assert capsys.readouterr().out.count("last rapid") == 9


@pytest.mark.parametrize(
    ("main", "arguments", "message"),
    [
        (heat_claims.main, ["plate", "--reading", "line"], "line,passed,SI"),
        (heat_claims.main, ["plate", "--reading", "line,own leg,SI"], "line,passed,SI"),
        (heat_claims.main, ["plate", "--plates", "0"], "--plates: expected at least 1"),
        (heat_claims.main, ["disc"], "dense-plate"),
        (heat_readings.main, ["--plates", "-1"], "--plates: expected at least 1"),
    ],
)
def test_bad_arguments_are_refused(main, arguments, message, capsys):
    with pytest.raises(SystemExit):
        main(arguments)
    assert message in capsys.readouterr().err


def test_what_is_shared_by_all_plates_is_the_steel_of_the_tests():
    made = generate("plate", holes=1, seed=0).material
    assert replace(made, name="steel") == STEEL
