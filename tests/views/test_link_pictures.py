"""Pictures of plans with links show links, pierces and the way of the head."""

import json

import numpy as np
import pytest
from matplotlib.collections import LineCollection, PathCollection, PolyCollection
from matplotlib.colors import to_hex

from cutgap.instances import Contour, Head, Instance, Link, Machine, Plan, Rules, Visit, check, evaluate
from cutgap.instances.formats import write_instance, write_plan
from cutgap.views.cli import main
from cutgap.views.link_plots import Way, steps_figure
from cutgap.views.plots import HEAD_COLOURS, plan_figure

SIDE = 10.0


@pytest.fixture
def row():
    """Three squares in a row, with entry points at their corners, and a home."""
    rings = [np.array([(0, 0), (1, 0), (1, 1), (0, 1)]) * SIDE + (15.0 * k + 5, 5.0) for k in range(3)]
    contours = [
        Contour(f"c{k}", np.column_stack((ring, np.zeros(4))), 4 * SIDE, geometry=ring)
        for k, ring in enumerate(rings)
    ]
    machine = Machine(v_jump=100.0, v_cut=10.0, t_aux=3.0)
    return Instance("row", tuple(contours), (Head("h", np.zeros(3)),), machine)


@pytest.fixture
def linked():
    """A circle of three single links through one entry point of each contour, and a double link."""
    return Plan(
        ((Visit(0, 0),),),
        (Link(0, 1, 1, 0, 1), Link(1, 0, 2, 0, 1), Link(0, 1, 2, 0, 1), Link(0, 2, 1, 3, 2)),
    )


def segments(figure, dashes):
    """Return the segments of all line collections that are drawn with or without dashes."""
    return [
        segment
        for each in figure.axes[0].collections
        if isinstance(each, LineCollection) and (each.get_linestyle()[0][1] is not None) == dashes
        for segment in each.get_segments()
    ]


def test_links_rapids_and_pierces_are_drawn(row):
    plan = Plan(((Visit(0, 0), Visit(2, 0)),), (Link(0, 1, 1, 0, 2),))
    figure = plan_figure(row, plan)
    solid, dashed = segments(figure, dashes=False), segments(figure, dashes=True)
    link = row.points[[1, 4], :2]
    # Two lines, the white one in the middle of the other.
    assert len(solid) == 2
    assert all(np.array_equal(each, link) for each in solid)
    ways = {tuple(map(tuple, each)) for each in dashed}
    home, first, last = ((0.0, 0.0), (5.0, 5.0), (35.0, 5.0))
    assert ways == {(home, first), (first, last), (last, home)}
    assert [(text.get_text(), tuple(text.xy)) for text in figure.axes[0].texts] == [("1", first), ("2", last)]


def test_single_links_look_different_from_double_ones(row, linked):
    assert not check(row, Rules("travel", links=True), linked)
    figure = plan_figure(row, linked)
    lines = {tuple(map(tuple, each)) for each in segments(figure, dashes=True)}
    for a, b in ((1, 4), (4, 8), (1, 8)):
        assert tuple(map(tuple, row.points[[a, b], :2])) in lines
    assert len(segments(figure, dashes=False)) == 2


def test_joined_contours_carry_the_heads_colour(row, linked):
    figure = plan_figure(row, linked)
    (outlines,) = (each for each in figure.axes[0].collections if isinstance(each, PolyCollection))
    assert {to_hex(colour).upper() for colour in outlines.get_edgecolors()} == {HEAD_COLOURS[0]}


def test_the_way_takes_the_plans_time_and_length(row, linked):
    way, evaluation = Way(row, linked), evaluate(row, linked)
    assert way.ends[-1] == pytest.approx(evaluation.makespan_s)
    assert sum(way.pierced) == 1
    length = sum(np.linalg.norm(np.diff(each.points, axis=0), axis=1).sum() for each in way.until(way.ends[-1]))
    assert length == pytest.approx(evaluation.total_travel_mm + 12 * SIDE)
    rng = np.random.default_rng(4)
    before = np.concatenate([each.points for each in way.until(way.ends[-1])])
    for moment in np.sort(rng.uniform(0, way.ends[-1], 20)):
        now = way.until(moment)
        if now:
            reached = np.concatenate([each.points for each in now])[:-1]
            assert np.array_equal(reached, before[: len(reached)])


@pytest.mark.parametrize("steps", [1, 2, 5])
def test_steps_end_with_all_that_is_cut(row, linked, steps):
    figure = steps_figure(row, linked, steps)
    panels = [axes for axes in figure.axes if axes.get_visible()]
    assert len(panels) == steps
    cut = evaluate(row, linked).link_mm[0] + 12 * SIDE
    assert f"{cut:.0f} mm cut" in panels[-1].get_title("left")
    assert any(isinstance(each, PathCollection) for each in panels[-1].collections)


def test_commands_draw_steps_and_motion(row, linked, tmp_path, capsys):
    write_instance(row, tmp_path / "row.json")
    write_plan(linked, row, tmp_path / "plan.json")
    files = [str(tmp_path / "row.json"), str(tmp_path / "plan.json")]
    assert main(["plot", *files, "--steps", "3", "--out", str(tmp_path / "s.svg")]) == 0
    assert (tmp_path / "s.svg").read_text(encoding="utf-8").count("mm cut") >= 3
    assert main(["plot", *files, "--out", str(tmp_path / "m.gif")]) == 0
    assert (tmp_path / "m.gif").read_bytes()[:3] == b"GIF"
    assert main(["plot", files[0], "--steps", "3", "--out", str(tmp_path / "n.svg")]) == 2
    assert "need a plan" in capsys.readouterr().err


def test_the_table_of_links(row, tmp_path, capsys):
    write_instance(row, tmp_path / "row.json")
    out = tmp_path / "out"
    options = ["--links", "--pierces", "1", "--objective", "travel", "--seeds", "1", "--time-limit", "5"]
    assert main(["gaps", str(tmp_path / "row.json"), *options, "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    for word in ("pierces", "links [mm]", "idle [mm]", "proof", "certified", "euler-bridging", "link-search"):
        assert word in printed
    records = [json.loads(line) for line in (out / "results.jsonl").read_text().splitlines()]
    proved = [each for each in records if each["certificate"] is not None]
    assert [each["result"]["method"] for each in proved] == ["links"]
    for each in proved:
        assert each["certified_bound"] == pytest.approx(each["result"]["lower_bound"], abs=1e-3)
        proof = out / "certificates" / each["certificate"]
        assert main(["verify", str(proof), str(tmp_path / "row.json")]) == 0
    assert "pierces,links_mm" in (out / "table.csv").read_text()
    assert '<path class="link"' in (out / "report.html").read_text(encoding="utf-8")
