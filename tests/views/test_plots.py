"""Pictures say what the plan says."""

import re
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.collections import PathCollection, PolyCollection
from matplotlib.colors import to_hex
from oracles.random_instances import random_instance

from cutgap.instances import Contour, Head, Instance, Plan, Visit
from cutgap.instances.region import Ellipsoid
from cutgap.views.charts import gap_figure
from cutgap.views.plots import HEAD_COLOURS, MOST_NUMBERED, PAGE_WIDTH, WIDTH, plan_figure
from cutgap.views.svg import inline_svg, page_style


@pytest.fixture
def instance():
    return random_instance(np.random.default_rng(2), 6, layout="uniform")


def lines(figure):
    return figure.axes[0].get_lines()


def drawn_points(figure, colour):
    """Return the points of all lines of a colour."""
    found = [np.column_stack(line.get_data()) for line in lines(figure) if line.get_color() == colour]
    return np.concatenate(found) if found else np.empty((0, 2))


def test_each_head_visits_its_contours_and_its_home(instance):
    plan = Plan.of_contours([(0, 1, 2), (3, 4, 5)])
    figure = plan_figure(instance, plan)
    for head, tour in enumerate(plan.tours):
        nodes = [instance.node(*visit[:2]) for visit in tour] + [instance.home_node(head)]
        points = drawn_points(figure, HEAD_COLOURS[head])
        assert {tuple(point) for point in points} == {tuple(instance.points[node, :2]) for node in nodes}


def test_contours_carry_their_heads_colour_and_perimeter(instance):
    figure = plan_figure(instance, Plan.of_contours([(5, 1, 2), (3, 4, 0)]))
    dots = next(
        each
        for each in figure.axes[0].collections
        if isinstance(each, PathCollection) and len(each.get_offsets()) == 6
    )
    colours = [to_hex(colour).upper() for colour in dots.get_facecolors()]
    assert colours == [HEAD_COLOURS[head] for head in (1, 0, 0, 1, 1, 0)]
    assert (np.argsort(dots.get_sizes()) == np.argsort(instance.perimeters)).all()


def test_the_partition_line_lies_between_the_ranges(instance):
    order = np.argsort(instance.points[:6, 0])
    figure = plan_figure(instance, Plan.of_contours([order[:2], order[2:]]))
    xs = np.sort(instance.points[:6, 0])
    upright = [line.get_xdata() for line in lines(figure) if len(set(line.get_xdata())) == 1]
    assert any(np.allclose(data, (xs[1] + xs[2]) / 2) for data in upright)


def test_regions_that_are_entered_anywhere_are_filled():
    regions = [Ellipsoid(np.array([x, 0.0, 0.0]), 10 * np.eye(3)[:2]) for x in (0.0, 50.0, 100.0)]
    holes = [Contour(f"c{i}", each.centre[None], 63.0, region=each) for i, each in enumerate(regions)]
    instance = Instance("discs", tuple(holes), (Head("h"),))
    touched = Plan(
        (tuple(Visit(i, 0, tuple(region.centre + 10 * np.eye(3)[1])) for i, region in enumerate(regions)),)
    )
    for plan in (touched, Plan.of_contours([range(3)])):
        figure = plan_figure(instance, plan)
        (drawn,) = (each for each in figure.axes[0].collections if len(each.get_paths()) == 3)
        for region, path in zip(regions, drawn.get_paths(), strict=True):
            distances = np.linalg.norm(path.vertices - region.centre[:2], axis=1)
            assert distances == pytest.approx(np.full(len(distances), 10.0))
        assert (len(drawn.get_facecolors()) == 0) == (plan is not touched)
        height = 10.0 if plan is touched else 0.0
        assert set(drawn_points(figure, HEAD_COLOURS[0])[:, 1]) == {height}


def test_instances_without_plan_or_contours_are_drawn(instance):
    assert plan_figure(instance, None).axes
    empty = random_instance(np.random.default_rng(2), 0)
    assert plan_figure(empty, Plan(((), ()))).axes


def test_a_bare_matrix_and_a_foreign_plan_are_refused(instance):
    machine = replace(instance.machine, metric="matrix")
    bare = replace(instance, machine=machine, matrix=instance.rapids, located=False)
    with pytest.raises(ValueError, match="no coordinates"):
        plan_figure(bare, None)
    with pytest.raises(ValueError, match="tours"):
        plan_figure(instance, Plan(((),)))


@pytest.fixture
def plate():
    """Two square parts, each with four entry points, and a home."""
    rings = [np.array([(0, 0), (10, 0), (10, 10), (0, 10)]) + np.array((x, 0.0)) for x in (0, 50)]
    contours = [
        Contour(str(number), np.column_stack((ring, np.zeros(4))), 40, ring="outer", geometry=ring)
        for number, ring in enumerate(rings)
    ]
    return Instance("plate", tuple(contours), (Head("head", np.zeros(3)),))


def test_outlines_entry_points_and_order_are_shown(plate):
    axes = plan_figure(plate, Plan((((1, 2), (0, 3)),))).axes[0]
    (outlines,) = (each for each in axes.collections if type(each) is PolyCollection)
    rings = [path.vertices[:-1].tolist() for path in outlines.get_paths()]
    assert rings == [contour.geometry.tolist() for contour in plate.contours]
    dots = [each.get_offsets() for each in axes.collections if isinstance(each, PathCollection)]
    assert any(np.array_equal(each, plate.points[:8, :2]) for each in dots)
    # Contour 1 is pierced first, at its entry point 2.
    assert any(np.array_equal(each, plate.points[[3, 6], :2]) for each in dots)
    assert [(text.get_text(), tuple(text.xy)) for text in axes.texts] == [("1", (60, 10)), ("2", (0, 10))]


def test_many_contours_are_not_numbered(plate):
    contours = tuple(replace(plate.contours[0], id=str(number)) for number in range(MOST_NUMBERED + 1))
    many = replace(plate, contours=contours)
    assert not plan_figure(many, Plan.of_contours([range(len(contours))])).axes[0].texts


def test_gap_figure_has_a_dot_for_each_run():
    gaps = [("split", (0.0,)), ("k-means", (0.01, 0.03, 0.02)), ("nothing", ())]
    figure = gap_figure(gaps)
    dots = [each.get_offsets()[:, 0] for each in figure.axes[0].collections]
    for found, (_, shares) in zip(dots, gaps, strict=True):
        assert np.allclose(found, 100 * np.array(shares))
    assert [label.get_text() for label in figure.axes[0].get_yticklabels()] == [name for name, _ in gaps]


def test_figures_on_a_page_keep_their_digits():
    with page_style("test"):
        figure = gap_figure([("split", [0.00011, 0.00013])])
        svg = inline_svg(figure, "least gap 0.01234 %")
    assert 'aria-label="least gap 0.01234 %"' in svg
    figure.draw_without_rendering()
    ticks = [label.get_text() for label in figure.axes[0].get_xticklabels()]
    assert len(set(ticks)) == len(ticks) > 2
    shown = re.findall(r"<text[^>]*>([^<]*)<", svg)
    low, high = figure.axes[0].get_xlim()
    places = figure.axes[0].get_xticks()
    assert {tick for tick, place in zip(ticks, places, strict=True) if low <= place <= high} <= set(shown)


def test_no_run_stands_at_the_edge_of_the_distribution_of_gaps():
    figure = gap_figure([("split", [0.0] * 5), ("k-means", [0.0, 0.1, 0.1, 0.2, 0.2])])
    axes = figure.axes[0]
    places = np.concatenate([dots.get_offsets() for dots in axes.collections])
    low, high = axes.get_ylim()
    assert low < places[:, 1].min() - 0.1
    assert places[:, 1].max() + 0.1 < high


@pytest.mark.parametrize("width", [PAGE_WIDTH, WIDTH])
def test_a_legend_stays_below_the_axes(instance, width):
    figure = plan_figure(instance, Plan.of_contours([(0, 1, 2), (3, 4, 5)]), width=width)
    figure.draw_without_rendering()
    legend, label = figure.legends[0].get_window_extent(), figure.axes[0].xaxis.label.get_window_extent()
    assert legend.y1 <= label.y0
    assert legend.x1 <= figure.bbox.x1
