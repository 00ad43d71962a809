"""What nests for flame cutting promise: shapes, gaps, link points; a seed names a nest for good."""

import numpy as np
import pytest
import shapely

from cutgap.instances.formats.json_format import format_instance
from cutgap.instances.generate import generate
from cutgap.instances.generate.flame import GAPS, MARGIN, SIDES
from cutgap.instances.instance import FLAME
from cutgap.instances.links.clearance import require_shapes
from cutgap.instances.links.near import unreachable
from cutgap.instances.links.points import MOST
from cutgap.instances.suites import load_suite


@pytest.mark.parametrize(("shapes", "seed"), [(0, 1), (1, 1), (7, 2), (20, 1), (40, 3)])
def test_nests_keep_their_gaps(shapes, seed):
    nest = generate("flame", holes=shapes, seed=seed)
    areas = [shapely.Polygon(curve) for curve in require_shapes(nest)]
    assert (len(areas), nest.machine) == (shapes, FLAME)
    for number, area in enumerate(areas):
        left, low, right, top = area.bounds
        assert min(left, low) >= MARGIN
        assert max(right - left, top - low) <= SIDES[1]
        others = areas[:number] + areas[number + 1 :]
        assert all(area.distance(other) >= GAPS[0] - 1e-2 for other in others)
    assert all(1 <= len(contour.entry_points) <= MOST for contour in nest.contours)


def test_a_seed_names_a_nest():
    one, again, other = (format_instance(generate("flame", holes=12, seed=seed)) for seed in (4, 4, 5))
    assert one == again != other


def test_curves_are_whole_micrometres_and_link_points_nanometres():
    """Link points lie inside slanted edges: a micrometre off, they would be off the curve."""
    nest = generate("flame", holes=12, seed=4)
    for contour in nest.contours:
        assert (contour.geometry == np.round(contour.geometry, 3)).all()
        assert (contour.entry_points == np.round(contour.entry_points, 6)).all()


@pytest.mark.parametrize("number", range(3))
def test_the_shipped_nests_are_dense_and_can_be_cut_in_one_stroke(number):
    nest = load_suite("flame108")[number]
    areas = np.array([shapely.Polygon(curve) for curve in require_shapes(nest)])
    assert unreachable(nest) == []
    distances = shapely.distance(areas[:, None], areas[None])
    nearest = np.sort(distances, axis=1)[:, 1]
    assert np.median(nearest) <= GAPS[1]
    concave = shapely.area(areas) < 0.95 * shapely.area(shapely.convex_hull(areas))
    assert 0.3 <= concave.mean() <= 0.8
