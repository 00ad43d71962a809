"""Spread of balanced bisections: below brute force, near the solver's value, tight where theory says so."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from oracles.random_instances import random_instance

from cutgap.formulations.certificate import verify_bisection
from cutgap.formulations.relaxations.bisection import MOST_CONTOURS, bisection
from cutgap.instances import Contour, Head, Instance, Machine
from cutgap.instances.formats.json_format import format_instance


def part_of(points, perimeters):
    contours = tuple(
        Contour(f"c{i}", np.array([point], dtype=float), float(perimeter))
        for i, (point, perimeter) in enumerate(zip(points, perimeters, strict=True))
    )
    return Instance("part", contours, (Head("h"),), Machine(v_cut=1.0, t_aux=0.0))


def least_spread(part, limit):
    """The least spread within the limit, as k-means counts it: size times squares around the centre."""
    points = np.array([contour.entry_points[0] for contour in part.contours]).reshape(-1, 3)
    work, best = part.service_times, None
    for sides in product((False, True), repeat=len(points)):
        left = np.array(sides, dtype=bool)
        if abs(work[left].sum() - work[~left].sum()) <= limit + 1e-9:
            parts = [points[left], points[~left]]
            spread = sum(len(each) * ((each - each.mean(axis=0)) ** 2).sum() for each in parts if len(each))
            best = spread if best is None else min(best, spread)
    return best


@pytest.mark.parametrize("layout", ["uniform", "grid", "line", "equal points"])
@pytest.mark.parametrize("limit", [0.0, 0.4, 3.0, 50.0])
def test_no_division_is_more_compact(layout, limit):
    for seed, holes in enumerate((0, 1, 2, 5, 9)):
        part = random_instance(np.random.default_rng(seed), holes, layout=layout)
        bound, best = bisection(part, limit), least_spread(part, limit)
        proved = verify_bisection(bound.certificate, format_instance(part)).bound
        if bound.bound is None:
            assert proved is None
            assert best is None
            continue
        assert 0 <= bound.bound <= proved
        assert best is None or bound.bound <= best * (1 + 1e-12) + 1e-9


@pytest.mark.parametrize("count", [2, 4])
def test_equal_distances_split_evenly(count):
    """Vertices of a simplex within 3D: Q = d (J - I) has s'Qs >= -d n, met by even halves."""
    corners = [[0, 0, 0], [2, 2, 0], [2, 0, 2], [0, 2, 2]][:count]
    part = part_of(corners, [1] * count)
    bound = bisection(part, 0.0).bound
    assert bound == pytest.approx(least_spread(part, 0.0), rel=1e-6, abs=1e-6)


def test_balance_makes_halves_less_compact():
    """A cluster of three and one of one: within the limit 0 one has to cross."""
    part = part_of([[0, 0, 0], [0, 0, 0], [0, 0, 0], [10, 0, 0]], [1] * 4)
    loose, tight = (bisection(part, limit) for limit in (2.0, 0.0))
    assert loose.bound == pytest.approx(0, abs=1e-6)
    assert least_spread(part, 0.0) == pytest.approx(100)
    assert tight.bound == pytest.approx(100, rel=1e-3)  # a limit of 0 leaves no interior


def test_scaling_and_moving():
    part = random_instance(np.random.default_rng(8), 8, layout="uniform")
    moved = replace(
        part,
        contours=tuple(replace(c, entry_points=2 * c.entry_points + 500.0) for c in part.contours),
    )
    assert bisection(moved, 2.0).bound == pytest.approx(4 * bisection(part, 2.0).bound, rel=1e-6)


def test_one_contour_outweighs_the_rest():
    points = [[0, 0, 0], [5, 0, 0], [0, 5, 0]]
    part = part_of(points, [9, 1, 2])
    outweighed = bisection(part, 5.9)
    assert outweighed.bound is None
    assert verify_bisection(outweighed.certificate, format_instance(part)).bound is None
    assert 0 < bisection(part, 6.1).bound <= least_spread(part, 6.1) == pytest.approx(50)


def test_the_size_is_that_of_the_program():
    bound = bisection(random_instance(np.random.default_rng(0), 6, layout="uniform"), 1.0)
    assert bound.variables == 15
    assert bound.constraints == 21 + 1
    assert bound.nonzeros == 15 + 15


def test_what_does_not_apply_is_refused():
    part = random_instance(np.random.default_rng(0), 4, metric="matrix")
    with pytest.raises(ValueError, match="needs coordinates"):
        bisection(part, 1.0)
    several = random_instance(np.random.default_rng(0), 6, entries=3)
    with pytest.raises(ValueError, match="one entry point"):
        bisection(several, 1.0)
    plain = random_instance(np.random.default_rng(0), 4)
    for limit in (-1.0, float("nan")):
        with pytest.raises(ValueError, match="limit_s"):
            bisection(plain, limit)
    large = random_instance(np.random.default_rng(0), MOST_CONTOURS + 1, layout="uniform")
    limits = f"{MOST_CONTOURS + 1} contours are too many, the most is {MOST_CONTOURS}"
    with pytest.raises(ValueError, match=limits):
        bisection(large, 1.0)
