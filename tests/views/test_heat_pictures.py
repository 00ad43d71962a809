"""Pictures of heat say what the model says, and the commands that make them refuse what makes no sense."""

import json
from dataclasses import replace
from fractions import Fraction
from itertools import combinations

import numpy as np
import pytest
from matplotlib.collections import PathCollection
from matplotlib.contour import QuadContourSet

from cutgap.formulations import solve
from cutgap.formulations.heat import exact
from cutgap.instances import Plan, Rules, conclude, evaluate
from cutgap.instances.formats import write_instance, write_plan
from cutgap.instances.generate import generate
from cutgap.instances.heat import rises, temperatures
from cutgap.instances.simulate import start_times
from cutgap.instances.suites import load_suite
from cutgap.views.charts import heat_front_figure
from cutgap.views.cli import main
from cutgap.views.heat_plots import heat_figure, hottest_pierce, step_moments, warming_figure

TRAVEL = Rules("travel")


@pytest.fixture(scope="module")
def plate():
    return generate("dense-plate", holes=6, seed=4)


@pytest.fixture(scope="module")
def plan():
    return Plan.of_contours([range(6)])


@pytest.fixture
def files(tmp_path, plate, plan):
    write_instance(plate, tmp_path / "plate.json")
    write_plan(plan, plate, tmp_path / "plan.json")
    return str(tmp_path / "plate.json"), str(tmp_path / "plan.json")


def test_the_hottest_pierce_is_the_peak(plate, plan):
    contour, moment = hottest_pierce(plate, plan)
    place = plate.points[plate.node(contour), :2]
    peak = evaluate(plate, plan).peak_temperature_c
    assert temperatures(plate, plan, [place], [moment])[0, 0] == pytest.approx(peak)
    title = heat_figure(plate, plan)._suptitle.get_text()
    assert f"{peak:.1f} deg C" in title
    assert f"contour {plate.contours[contour].id}" in title


@pytest.mark.parametrize("steps", [1, 2, 4, 6, 9])
def test_steps_are_pierces_and_the_hottest_is_among_them(plate, plan, steps):
    moments = step_moments(plate, plan, steps)
    assert len(moments) == min(steps, 6)
    assert set(moments) <= set(start_times(plate, plan).values())
    assert hottest_pierce(plate, plan)[1] in moments
    figure = heat_figure(plate, plan, moments)
    panels = [axes for axes in figure.axes if axes.get_visible() and axes.get_xlabel() == "x [mm]"]
    assert len(panels) == len(moments)
    assert all(
        f"{moment:.2f} s" in axes.get_title("left") for axes, moment in zip(panels, moments, strict=True)
    )


def test_start_points_in_time_end_at_their_pierce(plate, plan):
    axes = warming_figure(plate, plan, cap=33.0).axes[0]
    (dots,) = (each.get_offsets() for each in axes.collections if isinstance(each, PathCollection))
    starts, found = start_times(plate, plan), rises(plate, plan)
    ambient = plate.material.ambient_c
    assert np.allclose(dots, [[starts[k], ambient + found[k]] for k in range(6)])
    curves = [line.get_xydata() for line in axes.get_lines()]
    assert all(any(np.allclose(curve[-1], dot) for curve in curves) for dot in dots)
    assert any(set(curve[:, 1]) == {33.0} for curve in curves)


def front_of(plate, orders, share):
    """Return results of orders under caps at their own peaks, bounded by a share of their travel."""
    found = []
    for order in orders:
        plan = Plan.of_contours([order])
        figures = evaluate(plate, plan)
        rules = replace(TRAVEL, temperature_cap=figures.peak_temperature_c)
        bound = share * figures.total_travel_mm
        found.append(conclude(plate, rules, plan, method="test", seconds=0.0, lower_bound=bound))
    return found


def test_a_front_is_a_staircase_over_its_bounds(plate):
    rng = np.random.default_rng(0)
    drawn = front_of(plate, [rng.permutation(6) for _ in range(60)], 0.9)
    drawn.sort(key=lambda each: each.value)
    front, coolest = [], np.inf
    for each in drawn:
        if each.evaluation.peak_temperature_c < coolest:
            coolest = each.evaluation.peak_temperature_c
            front.append(each)
    assert len(front) > 2
    front[0] = replace(front[0], rules=TRAVEL)
    figure = heat_front_figure("plate", front, drawn[-3:])
    axes = figure.axes[0]
    (stairs,) = axes.get_lines()
    assert [x for x in stairs.get_xdata()][:-1] == sorted(e.evaluation.peak_temperature_c for e in front)
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == ["test", "best plan known", "not proved to be empty"]
    shades = [each.get_paths()[0].vertices[:, 1] for each in axes.collections if each.get_hatch()]
    assert min(each.min() for each in shades) == pytest.approx(0.9 * front[0].value)


def test_a_proved_front_has_nothing_shaded(plate):
    front = front_of(plate, [range(6)], 1.0)
    axes = heat_front_figure("plate", front, complete=True).axes[0]
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["proved to be optimal"]


@pytest.mark.parametrize(
    "options", [["--heat"], ["--at", "1.5"], ["--steps", "3"], ["--over-time", "--temperature-cap", "40"]]
)
def test_plot_writes_pictures_of_heat(files, tmp_path, options):
    out = tmp_path / "heat.png"
    assert main(["plot", *files, *options, "--out", str(out)]) == 0
    assert out.read_bytes().startswith(b"\x89PNG")


def test_titles_of_panels_stay_apart(plate):
    plan = Plan.of_contours([range(6)])
    figure = heat_figure(plate, plan, step_moments(plate, plan, 3))
    figure.draw_without_rendering()
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    places = [
        axes._left_title.get_window_extent() for axes, title in zip(figure.axes, titles, strict=True) if title
    ]
    assert len(places) == 3
    assert not any(one.overlaps(other) for one, other in combinations(places, 2))


def test_a_sheet_that_is_cold_is_shaded():
    # A low peak: the scale begins at the ambient, by rounding a little above it.
    plate = next(each for each in load_suite("small-plates") if each.name == "small-plate-08-1")
    plan = solve(plate, Rules("peak"), method="heat").plan
    figure = heat_figure(plate, plan, step_moments(plate, plan, 6)[:1])
    (shades,) = [
        each for each in figure.axes[0].collections if isinstance(each, QuadContourSet) and each.filled
    ]
    assert shades.levels[0] == pytest.approx(plate.material.ambient_c)
    assert len(shades.get_paths()[0].vertices) > 0


def test_heat_in_motion(files, tmp_path, monkeypatch):
    from PIL import Image

    monkeypatch.setattr("cutgap.views.heat_plots.FRAMES", 4)
    out = tmp_path / "heat.gif"
    assert main(["plot", *files, "--heat", "--out", str(out)]) == 0
    with Image.open(out) as picture:
        assert picture.n_frames == 4


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (["--heat", "--over-time"], "one of them"),
        (["--at", "1", "--steps", "2"], "one of them"),
        (["--at", "-1"], "--at"),
        (["--at", "nan"], "--at"),
        (["--steps", "0"], "--steps"),
        (["--temperature-cap", "40"], "--over-time"),
    ],
)
def test_what_cannot_be_drawn_is_refused(files, tmp_path, capsys, options, word):
    assert main(["plot", *files, *options, "--out", str(tmp_path / "out.png")]) == 2
    assert word in capsys.readouterr().err


def test_heat_needs_a_plan_a_material_and_a_picture_that_moves_only_as_a_whole(files, tmp_path, plate, capsys):
    out = ["--out", str(tmp_path / "out.gif")]
    assert main(["plot", *files, "--over-time", *out]) == 2
    assert main(["plot", *files, "--at", "1", *out]) == 2
    capsys.readouterr()
    assert main(["plot", files[0], "--heat", *out]) == 2
    assert "plan" in capsys.readouterr().err
    write_instance(replace(plate, material=None), tmp_path / "plate.json")
    assert main(["plot", *files, "--heat", *out]) == 2
    assert "material" in capsys.readouterr().err


def test_pareto_shows_the_exact_front_and_the_plans_of_heuristics(files, tmp_path, capsys):
    picture = tmp_path / "front.svg"
    tokens = ["pareto", files[0], "--methods", "dual-coded-ga,entry-search", "--plot", str(picture), "--json"]
    assert main(tokens) == 0
    rows = json.loads(capsys.readouterr().out)
    front = [row for row in rows if row["method"] == "heat"]
    assert {row["method"] for row in rows} == {"heat", "dual-coded-ga", "entry-search"}
    assert all(row["status"] == "optimal" for row in front)
    for row in rows:
        # No plan is below the staircase.
        cooler = [each["travel_mm"] for each in front if each["peak_c"] <= row["peak_c"] + 1e-6]
        assert cooler
        assert row["travel_mm"] >= min(cooler) - 1e-6
    assert picture.read_text().startswith("<?xml")


def test_pareto_proves_each_point(files, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(exact, "FIRST_SECONDS", 0.0)
    folder = tmp_path / "proofs"
    write_instance(generate("dense-plate", holes=4, seed=4), files[0])
    assert main(["pareto", files[0], "--certificates", str(folder), "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert len(list(folder.iterdir())) == len(rows) > 1
    assert all(row["certified"] for row in rows)
    for number, row in enumerate(rows):
        assert main(["verify", str(folder / f"point-{number}.json"), files[0], "--json"]) == 0
        assert float(Fraction(json.loads(capsys.readouterr().out)["lower_bound"])) == pytest.approx(
            row["travel_mm"]
        )


def test_pareto_of_a_plate_may_still_be_against_imbalance_and_says_what_does_not_fit(files, capsys):
    for tokens in (
        ["--limits", "1"],
        ["--against", "imbalance", "--methods", "plain-ga"],
        ["--methods", "heat"],
        ["--seed", "-1"],
    ):
        assert main(["pareto", files[0], *tokens]) == 2
        assert capsys.readouterr().err.startswith("cutgap: ")


def test_pareto_under_a_cap_that_nothing_keeps_says_why(files, capsys):
    assert main(["pareto", files[0], "--temperature-cap", "20"]) == 1
    assert "cap of 20" in capsys.readouterr().err
