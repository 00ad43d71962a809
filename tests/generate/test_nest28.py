"""The nest has the published boxes and perimeters, lies on its sheet, and its curves are sound."""

from itertools import combinations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from cutgap.instances.generate import generate
from cutgap.instances.generate.packing import pack
from cutgap.instances.process import adjacent_parts

SEEDS = st.integers(0, 2**32 - 1)

# Table 1 of Li et al. (2019): pieces, perimeter in m, box in mm.
PUBLISHED = [
    *[(1, 0.867, 314, 181), (1, 0.865, 317, 144), (1, 0.748, 280, 120), (1, 1.114, 337, 315)],
    *[(1, 3.217, 575, 575), (1, 2.06, 756, 205), (2, 0.688, 280, 104), (1, 0.918, 280, 205)],
    *[(1, 0.929, 303, 191), (1, 1.113, 313, 303), (1, 1.055, 386, 201), (1, 1.123, 335, 281)],
    *[(1, 1.138, 315, 280), (1, 1.42, 348, 400), (1, 1.361, 369, 353), (1, 1.395, 353, 370)],
    *[(1, 1.482, 494, 280), (1, 3.571, 1122, 430), (2, 1.279, 573, 92), (1, 1.516, 520, 309)],
    *[(1, 1.457, 378, 416), (1, 1.981, 665, 352), (1, 3.231, 1010, 350), (1, 4.032, 1130, 630)],
    *[(1, 1.344, 359, 313), (1, 1.37, 424, 295)],
]


def parts_of(nest):
    """Contours of each part, the outline last, in the order of the published table."""
    parts = {}
    for contour in nest.contours:
        parts.setdefault(contour.part, []).append(contour)
    return list(parts.values())


@given(SEEDS)
@settings(max_examples=15)
def test_parts_have_the_published_boxes_and_perimeters(seed):
    parts = parts_of(generate("nest28", seed=seed))
    expected = [row[1:] for row in PUBLISHED for _ in range(row[0])]
    assert len(parts) == len(expected) == 28
    for contours, (perimeter, width, height) in zip(parts, expected, strict=True):
        assert [c.ring for c in contours] == ["inner"] * (len(contours) - 1) + ["outer"]
        box = np.ptp(contours[-1].geometry, axis=0)
        assert sorted(box) == sorted((width, height))
        assert sum(c.perimeter for c in contours) == pytest.approx(1000 * perimeter, abs=0.01)
        curves = sum(float(shapely.length(shapely.linearrings(c.geometry))) for c in contours)
        assert curves == pytest.approx(1000 * perimeter, rel=5e-4)


@given(SEEDS)
@settings(max_examples=15)
def test_parts_lie_apart_on_the_sheet_and_rings_inside_their_part(seed):
    parts = parts_of(generate("nest28", seed=seed))
    outlines = [shapely.Polygon(contours[-1].geometry) for contours in parts]
    assert all(outline.is_valid for outline in outlines)
    assert shapely.box(10, 10, 2990, 1790).covers(shapely.MultiPolygon(outlines))
    assert min(a.distance(b) for a, b in combinations(outlines, 2)) >= 10 - 1e-9
    for contours, outline in zip(parts, outlines, strict=True):
        rings = [shapely.Polygon(c.geometry) for c in contours[:-1]]
        assert all(ring.is_valid and outline.contains(ring) for ring in rings)
        assert all(outline.exterior.distance(ring) > 15 for ring in rings)
        assert all(a.distance(b) > 15 for a, b in combinations(rings, 2))


@given(SEEDS)
@settings(max_examples=15)
def test_contours_are_entered_at_vertices_and_inner_rings_come_first(seed):
    nest = generate("nest28", seed=seed)
    for contour in nest.contours:
        vertices = set(map(tuple, contour.geometry.tolist()))
        places = [tuple(point) for point in contour.entry_points[:, :2].tolist()]
        assert len(set(places)) == len(places)
        assert vertices.issuperset(places)
        least, most = (6, 16) if contour.ring == "outer" else (4, 8)
        assert least <= len(places) <= most
        assert (contour.entry_points[:, 2] == 0).all()
    pairs = {
        (a, b)
        for a, inner in enumerate(nest.contours)
        for b, outer in enumerate(nest.contours)
        if inner.part == outer.part and (inner.ring, outer.ring) == ("inner", "outer")
    }
    assert set(nest.precedence) == pairs
    assert len(pairs) == 19
    assert [head.home.tolist() for head in nest.heads] == [[0, 0, 0]]


def test_nests_of_different_seeds_differ_in_shapes_and_places():
    first, second = (generate("nest28", seed=seed) for seed in (0, 1))
    corners = [{tuple(c.geometry.min(axis=0)) for c in nest.contours} for nest in (first, second)]
    assert len(corners[0] & corners[1]) < 5
    sizes = [[len(c.geometry) for c in nest.contours if c.ring == "outer"] for nest in (first, second)]
    assert sizes[0] != sizes[1]


def test_every_part_has_neighbours_and_most_parts_are_none():
    adjacent = adjacent_parts(generate("nest28", seed=5))
    assert adjacent.any(axis=1).all()
    assert adjacent.mean() < 0.5


@given(SEEDS, st.integers(1, 12))
@settings(max_examples=30)
def test_packed_boxes_lie_on_the_sheet_and_apart(seed, count):
    rng = np.random.default_rng(seed)
    boxes = rng.integers(1, 40, (count, 2))
    side = int(np.ceil(1.5 * max(boxes.max(), np.sqrt(boxes.prod(axis=1).sum()))))
    places, turned = pack(boxes, (side, side), rng)
    ends = places + np.where(turned[:, None] == 1, boxes[:, ::-1], boxes)
    assert (places >= 0).all()
    assert (ends <= side).all()
    for a, b in combinations(range(count), 2):
        assert ((ends[a] <= places[b]) | (ends[b] <= places[a])).any()


def test_boxes_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match="packing: found no way to put 2 boxes on 10 x 10 mm"):
        pack(np.array([[6, 6], [6, 6]]), (10, 10), np.random.default_rng(0))
