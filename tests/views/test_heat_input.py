"""Bad input where heat is asked for: what is wrong, where, and how to mend it; and the least plates."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from cutgap.formulations import solve
from cutgap.instances import Plan, Rules, check
from cutgap.instances.formats import write_instance
from cutgap.instances.formats.json_format import format_instance
from cutgap.instances.generate import generate
from cutgap.instances.process import ENTRY_TOLERANCE_MM, require_entries_on_curves
from cutgap.views.cli import main

PEAK = ["--objective", "peak"]


@pytest.fixture(scope="module")
def plate():
    return generate("dense-plate", holes=4, seed=1)


def moved(plate, distance):
    """Return the plate with entry point 1 of contour 2 moved away from its curve."""
    contour = plate.contours[2]
    middle = contour.geometry.mean(axis=0)
    points = np.array(contour.entry_points)
    outwards = points[1, :2] - middle
    points[1, :2] += distance * outwards / np.linalg.norm(outwards)
    contours = list(plate.contours)
    contours[2] = replace(contour, entry_points=points)
    return replace(plate, contours=tuple(contours))


BAD = {
    "no thickness": (("material", "thickness_mm"), 0, ("material.thickness_mm", "0")),
    "negative conductivity": (("material", "conductivity_w_per_m_k"), -1, ("conductivity_w_per_m_k", "-1")),
    "no cutting speed": (("machine", "v_cut"), 0, ("machine.v_cut", "0")),
    "colder than possible": (("material", "ambient_c"), -300, ("ambient_c", "-273.15", "-300")),
    "no material": (("material",), None, ("material", "missing")),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_files_are_exit_code_2(plate, tmp_path, capsys, case):
    where, value, words = BAD[case]
    document = json.loads(format_instance(plate))
    inner = document
    for name in where[:-1]:
        inner = inner[name]
    if value is None:
        del inner[where[-1]]
    else:
        inner[where[-1]] = value
    path = tmp_path / "plate.json"
    path.write_text(json.dumps(document))
    assert main(["solve", str(path), *PEAK]) == 2
    error = capsys.readouterr().err
    assert all(word in error for word in ("cutgap: ", *words))


def test_a_cold_room_is_allowed_but_no_cap_below_the_coldest():
    plate = replace(generate("dense-plate", holes=2, seed=0))
    cold = replace(plate, material=replace(plate.material, ambient_c=-40.0))
    result = solve(cold, Rules("peak"))
    warm = solve(plate, Rules("peak"))
    assert result.value == pytest.approx(warm.value - plate.material.ambient_c - 40.0)
    with pytest.raises(ValueError, match=r"temperature_cap.*-273\.15.*-300"):
        Rules(temperature_cap=-300.0)


def test_the_gap_of_a_peak_is_a_share_of_its_rise(plate):
    cold = replace(plate, material=replace(plate.material, ambient_c=-40.0))
    result = replace(solve(cold, Rules("peak")), lower_bound=-40.0)
    assert result.value > -40.0
    assert result.gap == 1.0
    half = replace(result, lower_bound=(result.value - 40.0) / 2)
    assert half.gap == pytest.approx(0.5)


@pytest.mark.parametrize("rules", [Rules("peak"), Rules("travel", clear_rapids=True)])
def test_entry_points_off_their_curve_are_named(plate, rules):
    plan = Plan.of_contours([range(4)])
    near = moved(plate, 0.9 * ENTRY_TOLERANCE_MM)
    check(near, rules, plan)
    far = moved(plate, 2.5)
    require_entries_on_curves(replace(far, contours=far.contours[:2]), "the test")
    for call in (lambda: check(far, rules, plan), lambda: solve(far, rules)):
        with pytest.raises(ValueError, match=r"contour '3': entry point 1 at .* off its curve.*move the point"):
            call()
    # Where curves do not matter the point may be anywhere.
    check(far, Rules("travel"), plan)


def test_a_cap_below_the_least_peak_is_infeasible_with_the_bound_that_proves_it(plate, tmp_path, capsys):
    path = tmp_path / "plate.json"
    write_instance(plate, path)
    least = solve(plate, Rules("peak")).value
    cap = (least + plate.material.ambient_c) / 2
    tokens = ["solve", str(path), "--objective", "travel", "--temperature-cap", repr(cap), "--json"]
    assert main(tokens) == 1
    captured = capsys.readouterr()
    fields = json.loads(captured.out)
    assert (fields["status"], fields["plan"]) == ("infeasible", None)
    assert f"least possible peak is {least:.3f} deg C" in fields["reason"]
    assert fields["reason"] in captured.err


@pytest.mark.parametrize("count", [0, 1])
def test_next_to_nothing_to_cut_is_as_warm_as_the_room(plate, tmp_path, capsys, count):
    path = tmp_path / "plate.json"
    write_instance(replace(plate, contours=plate.contours[:count]), path)
    assert main(["solve", str(path), *PEAK, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["value"] == plate.material.ambient_c
    assert main(["pareto", str(path), "--json"]) == 0
    (point,) = json.loads(capsys.readouterr().out)
    assert (point["status"], point["peak_c"]) == ("optimal", plate.material.ambient_c)


def test_coincident_start_points_are_infinitely_hot_and_said_so(plate, tmp_path, capsys):
    first = replace(plate.contours[0], entry_points=plate.contours[0].entry_points[:1])
    path = tmp_path / "plate.json"
    write_instance(replace(plate, contours=(first, replace(first, id="again"))), path)
    assert main(["solve", str(path), *PEAK, "--json"]) == 0
    fields = json.loads(capsys.readouterr().out)
    assert (fields["value"], fields["lower_bound"], fields["gap"]) == ("infinite", None, None)
    out = tmp_path / "results"
    tokens = ["gaps", str(path), *PEAK, "--methods", "heat,plain-ga", "--seeds", "1", "--out", str(out)]
    assert main(tokens) == 0
    # What was written is read again.
    assert main([*tokens, "--resume"]) == 0
    assert "2 of 2 runs are finished already" in capsys.readouterr().err
    assert [row["peak_c"] for row in csv.DictReader((out / "table.csv").open())] == ["inf", "inf"]
