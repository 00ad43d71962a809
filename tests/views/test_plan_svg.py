"""Small drawings say what the plan says."""

import re
from itertools import pairwise

import numpy as np
import pytest
from oracles.random_instances import random_instance

from cutgap.instances import Contour, Head, Instance, Plan
from cutgap.instances.plan import Link
from cutgap.views.plan_svg import WIDTH, plan_svg, sheet_of, sheet_svg


@pytest.fixture
def instance():
    return random_instance(np.random.default_rng(12), 6, layout="uniform")


def paths(svg, kind):
    """Return the points of the paths of a kind."""
    found = re.findall(rf'<path class="{kind}" d="([^"]*)"', svg)
    return [np.array(re.findall(r"(-?[\d.]+),(-?[\d.]+)", d), dtype=float) for d in found]


def test_dots_stand_where_each_head_pierces_in_its_order(instance):
    orders = ((3, 0, 5), (1, 4, 2))
    sheet = sheet_of(instance, "sheet")
    svg = plan_svg(sheet, Plan.of_contours(orders), "label")
    points = np.array([contour.entry_points[0] for contour in instance.contours])
    for found, order in zip(paths(svg, "dots"), orders, strict=True):
        assert found == pytest.approx(sheet.on_paper(points[list(order)]), abs=0.051)
    for rapid, dots in zip(paths(svg, "rapid"), paths(svg, "dots"), strict=True):
        assert np.array_equal(rapid, dots)
    assert re.findall(r"<text[^>]*>(\d+)</text>", svg) == ["1", "2", "3"] * 2
    assert 'href="#sheet"' in svg
    assert 'id="sheet"' in sheet_svg(sheet)


def test_a_sheet_keeps_proportions_and_tells_its_scale(instance):
    sheet = sheet_of(instance, "sheet")
    (a, b), (c, d) = sheet.on_paper(instance.points)[:2], instance.points[:2, :2]
    assert np.linalg.norm(a - b) == pytest.approx(sheet.scale * np.linalg.norm(c - d))
    # Upwards on the sheet is upwards on the screen, where y points down.
    assert (a[1] < b[1]) == (c[1] > d[1])
    places = sheet.on_paper(instance.points)
    assert (places >= 0).all()
    assert (places <= (WIDTH, sheet.height)).all()
    bar, length = re.search(r"h([\d.]+)m0,-3v6.*>([\d.]+) mm<", sheet_svg(sheet)).groups()
    assert float(bar) == pytest.approx(float(length) * sheet.scale, abs=0.051)


def test_ranges_that_overlap_are_told_from_those_that_do_not(instance):
    by_x = np.argsort(instance.points[:6, 0])
    sheet = sheet_of(instance, "sheet")
    apart = plan_svg(sheet, Plan.of_contours((by_x[:3], by_x[3:])), "label")
    mixed = plan_svg(sheet, Plan.of_contours((by_x[::2], by_x[1::2])), "label")
    assert ('class="partition"' in apart, 'class="overlap"' in apart) == (True, False)
    assert ('class="partition"' in mixed, 'class="overlap"' in mixed) == (False, True)


def test_outlines_lose_only_points_that_fall_together():
    angles = np.linspace(0, 2 * np.pi, 5000, endpoint=False)
    ring = np.column_stack((np.cos(angles), np.sin(angles)))
    entries = np.column_stack((ring[:1], np.zeros(1)))
    far = Contour("far", np.array([(300.0, 0.0, 0.0)]), 1.0)
    contour = Contour("disc", entries, 2 * np.pi, ring="outer", geometry=ring)
    instance = Instance("one", (contour, far), (Head("head", np.zeros(3)),))
    sheet = sheet_of(instance, "sheet")
    (curve,) = paths(sheet_svg(sheet), "outline")
    assert all(not np.array_equal(a, b) for a, b in pairwise(curve))
    on_paper = sheet.on_paper(ring)
    nearest = [np.abs(curve - point).max(axis=1).min() for point in on_paper]
    assert max(nearest) <= 0.051
    assert len(curve) < 300


@pytest.mark.parametrize("places", [[], [(5.0, 7.0)], [(0.0, 0.0), (90.0, 0.0)], [(0.0, 0.0), (0.0, 90.0)]])
def test_sheets_without_width_or_height_are_drawn(places):
    contours = (Contour(str(n), np.array([(x, y, 0.0)]), 1.0) for n, (x, y) in enumerate(places))
    instance = Instance("flat", tuple(contours), (Head("head"),))
    sheet = sheet_of(instance, "sheet")
    assert sheet.scale < WIDTH
    assert sheet_svg(sheet).count("<circle") == len(places)
    svg = plan_svg(sheet, Plan.of_contours([range(len(places))]), "label")
    assert len(paths(svg, "dots")) == min(1, len(places))
    assert "nan" not in svg


def test_links_are_drawn_and_a_foreign_plan_is_refused(instance):
    sheet = sheet_of(instance, "sheet")
    linked = Plan(Plan.of_contours(((0, 2, 4), (3, 5))).tours, (Link(0, 0, 1, 0),))
    (ends,) = paths(plan_svg(sheet, linked, "label"), "link")
    assert ends == pytest.approx(sheet.on_paper(instance.points[[0, 1]]), abs=0.051)
    with pytest.raises(ValueError, match="tours"):
        plan_svg(sheet, Plan(((),)), "label")
