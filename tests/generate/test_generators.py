"""What the generators promise: ranges, equal parts, ties; and that a seed names a part for good."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cutgap.instances import Machine
from cutgap.instances.formats.json_format import format_instance
from cutgap.instances.generate import (
    KINDS,
    b_pillars,
    bolt_circles_part,
    clusters_part,
    coincident_part,
    collinear_part,
    columns_part,
    door_panel,
    generate,
    grid_part,
    one_column_part,
    random_part,
    staggered_grid_part,
    tied_part,
)

SEEDS = st.integers(0, 2**32 - 1)
HOLES = st.integers(0, 60)
PARTS_OF_ANY_SIZE = [random_part, tied_part, coincident_part, collinear_part, one_column_part]


def xyz(instance):
    return instance.points[: len(instance.contours)]


@pytest.mark.parametrize("make", PARTS_OF_ANY_SIZE)
@given(holes=HOLES, seed=SEEDS)
def test_parts_keep_to_the_ranges_of_the_reference(make, holes, seed):
    instance = make(holes, np.random.default_rng(seed))
    assert len(instance.contours) == holes
    for column, (low, high) in enumerate([(300, 2400), (500, 1500), (100, 300)]):
        assert ((xyz(instance)[:, column] >= low) & (xyz(instance)[:, column] <= high)).all()
    assert ((instance.perimeters >= 20) & (instance.perimeters <= 100)).all()
    assert [head.home.tolist() for head in instance.heads] == [[200, 200, 400], [2400, 1400, 400]]
    assert [head.id for head in instance.heads] == ["left", "right"]
    assert instance.machine == Machine()


def test_random_parts_fill_the_ranges():
    """The extremes of 2000 even draws lie within 1 % of the ends, but for a chance below 1e-8."""
    instance = random_part(2000, np.random.default_rng(7))
    figures = np.column_stack([xyz(instance), instance.perimeters])
    low, high = np.array([(300, 2400), (500, 1500), (100, 300), (20, 100)]).T
    assert (figures.min(axis=0) < low + 0.01 * (high - low)).all()
    assert (figures.max(axis=0) > high - 0.01 * (high - low)).all()


@given(holes=st.integers(2, 60), seed=SEEDS)
def test_special_parts_are_special(holes, seed):
    rng = np.random.default_rng(seed)
    assert max(Counter(xyz(tied_part(holes, rng))[:, 0]).values()) > 1
    places = Counter(map(tuple, xyz(coincident_part(holes, rng)).tolist()))
    assert len(places) <= (holes + 1) // 2
    assert len(set(xyz(one_column_part(holes, rng))[:, 0])) == 1
    on_line = xyz(collinear_part(holes, rng))
    assert (np.cross(on_line[1:] - on_line[0], on_line[1] - on_line[0]) == 0).all()
    assert len(set(on_line[:, 0])) == holes


STRUCTURED = (grid_part, staggered_grid_part, bolt_circles_part, clusters_part, columns_part)


@pytest.mark.parametrize("make", STRUCTURED)
@given(holes=st.integers(0, 300), seed=SEEDS)
def test_structured_parts_stay_in_the_ranges(make, holes, seed):
    points = xyz(make(holes, np.random.default_rng(seed)))
    low, high = np.array([(300, 2400), (500, 1500), (100, 300)]).T
    assert points.shape == (holes, 3)
    assert ((low <= points) & (points <= high)).all()


def nearest(points: np.ndarray) -> np.ndarray:
    """Distances to the nearest other point, mm."""
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    return np.min(apart + np.diag(np.full(len(points), np.inf)), axis=1)


@given(seed=SEEDS)
def test_structured_parts_have_their_structure(seed):
    rng = np.random.default_rng(seed)
    for make in (grid_part, staggered_grid_part, bolt_circles_part):
        part = make(72, rng)
        # Within the rounding of coordinates each hole has a neighbour at the same distance.
        assert np.ptp(nearest(xyz(part))) < 0.01
        assert len(set(part.perimeters)) == 1
    square, staggered = xyz(grid_part(64, rng)), xyz(staggered_grid_part(64, rng))
    assert [len(set(square[:, axis])) for axis in (0, 1)] == [8, 8]
    assert len(set(staggered[:, 0])) > 8
    assert len(set(staggered[:, 1])) == 8
    circles = xyz(bolt_circles_part(72, rng)).reshape(6, 12, 3)
    centres = circles.mean(axis=1, keepdims=True)
    assert np.ptp(np.linalg.norm(circles - centres, axis=2)) < 0.01
    assert nearest(centres[:, 0]) == pytest.approx(400.0, abs=0.01)
    assert set(Counter(xyz(columns_part(64, rng))[:, 0]).values()) == {8}
    groups = xyz(clusters_part(60, rng)).reshape(15, 4, 3)
    assert np.linalg.norm(np.ptp(groups.mean(axis=0), axis=0)[:2]) > 500.0


@given(seed=SEEDS)
def test_the_pillars_are_equal_and_apart(seed):
    instance = b_pillars(np.random.default_rng(seed))
    assert len(instance.contours) == 76
    pillars = xyz(instance).reshape(4, 19, 3)
    steps = np.diff(pillars, axis=0)
    assert np.allclose(steps, [420, 0, 0], rtol=0, atol=1e-9)
    assert (np.diff(instance.perimeters.reshape(4, 19), axis=0) == 0).all()
    # A partition between two pillars exists, and both homes lie outside.
    assert (pillars[:-1, :, 0].max(axis=1) < pillars[1:, :, 0].min(axis=1)).all()
    homes = [head.home[0] for head in instance.heads]
    assert homes[0] < xyz(instance)[:, 0].min() < xyz(instance)[:, 0].max() < homes[1]


@given(seed=SEEDS)
def test_the_door_has_columns_around_window_and_pockets(seed):
    instance = door_panel(np.random.default_rng(seed))
    assert len(instance.contours) == 91
    columns = Counter(xyz(instance)[:, 0].tolist())
    # Lock edge with the upright above it, hinge edge, both sides of the service opening; a hole drawn
    # elsewhere may happen to lie in line with them.
    most = [count for _, count in columns.most_common(4)]
    assert all(count >= least for count, least in zip(most, [17, 10, 4, 4], strict=True))
    assert len(set(map(tuple, xyz(instance).tolist()))) == 91
    # The window: no hole between belt and roof, behind the A-pillar.
    x, y = xyz(instance)[:, 0] - 720, xyz(instance)[:, 1] - 330
    assert not ((x > 440) & (x < 1100) & (y > 660) & (y < 1000)).any()


@pytest.mark.parametrize("kind", ["b-pillars", "door-panel"])
def test_time_per_hole_is_near_that_of_the_published_parts(kind):
    """(T_1 + T_2 - L / v_jump) / N of Table 2, Wang et al. (2025): 1.6 s and 1.9 s."""
    published = {
        "b-pillars": (93.8 + 93.5 - 9916.2 / 150) / 76,
        "door-panel": (120.9 + 121.4 - 10830.1 / 150) / 91,
    }
    times = [generate(kind, seed=seed).service_times.mean() for seed in range(20)]
    assert np.mean(times) == pytest.approx(published[kind], rel=0.05)


@pytest.mark.parametrize("kind", KINDS)
def test_kind_holes_and_seed_name_a_part(kind):
    first, again, other = (format_instance(generate(kind, seed=seed)) for seed in (3, 3, 4))
    assert first == again
    assert first.replace("-s3", "-s4") != other
    assert generate(kind, seed=3).name == f"{kind}-{KINDS[kind].holes}-s3"


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "flame"])
def test_coordinates_are_whole_micrometres(kind):
    instance = generate(kind, seed=5)
    for figures in (instance.points, instance.perimeters):
        assert (figures == np.round(figures, 3)).all()


@pytest.mark.parametrize(
    ("kind", "holes", "seed", "message"),
    [
        ("wheel", None, 1, "kind: expected one of random, b-pillars, .* got 'wheel'"),
        ("random", -1, 1, "holes: expected 0 to 100000, got -1"),
        ("random", 10**9, 1, "holes: expected 0 to 100000, got 1000000000"),
        ("random", 5, -1, "seed: expected at least 0, got -1"),
        ("b-pillars", 75, 1, "holes: b-pillars has 76, got 75"),
        ("door-panel", 90, 1, "holes: door-panel has 91, got 90"),
        ("nest28", 28, 1, "holes: nest28 has 47, got 28"),
        ("collinear", 142, 1, "holes: a collinear part has at most 141, got 142"),
    ],
)
def test_bad_arguments_are_named(kind, holes, seed, message):
    with pytest.raises(ValueError, match=message):
        generate(kind, holes=holes, seed=seed)
