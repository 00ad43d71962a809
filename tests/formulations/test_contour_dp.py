"""Dynamic programming over contours agrees with brute force under every rule; a stopped run keeps its bound."""

from dataclasses import replace

import numpy as np
import pytest
from oracles.entry_tours import best_plan
from oracles.random_instances import random_instance
from oracles.random_sheets import random_sheet

from cutgap.formulations import solve
from cutgap.formulations.certificate import verify
from cutgap.formulations.contour_dp import ascent, closing
from cutgap.formulations.contour_dp.ascent import Ascent, forgotten_by
from cutgap.formulations.contour_dp.memory import build_memory, start_members
from cutgap.formulations.contour_dp.passes import backward_pass, best_walk, forward_pass
from cutgap.formulations.contour_dp.search import search
from cutgap.formulations.contour_dp.solve import ContourSearch, length_step
from cutgap.formulations.contour_dp.walks import walk_problems
from cutgap.instances import Contour, Head, Instance, Machine, Plan, Rules, evaluate
from cutgap.instances.formats.json_format import format_instance

SWITCHES = ("parts_in_one_go", "neighbours_only", "clear_rapids")


def require_optimum(instance, rules):
    best = best_plan(instance, rules)
    result = solve(instance, rules, method="contour-dp", certify=True)
    if best is None:
        assert result.status == "infeasible"
        assert result.plan is None
        return None
    assert result.status == "optimal"
    assert not result.violations
    assert result.value == pytest.approx(best.value, abs=1e-6)
    proved = float(verify(result.certificate, format_instance(instance)).bound)
    assert best.value - 1e-4 <= proved <= best.value + 1e-9
    return best.value


@pytest.fixture(params=["usual", "no first plan", "weak relaxation"])
def way(request, monkeypatch):
    """On tiny parts the first plan is mostly optimal and the relaxation exact: then nothing else is tried.

    Without a first plan the programme has to find the optimum; with memories of nothing and two steps of the
    ascent the sparse search has to.
    """
    if request.param != "usual":
        monkeypatch.setattr(ContourSearch, "_start", lambda search, start: (None, np.inf))
    if request.param == "weak relaxation":
        monkeypatch.setattr(ascent, "START_MEMBERS", 0)
        monkeypatch.setattr(ascent, "STEPS", 2)


@pytest.mark.usefixtures("way")
@pytest.mark.parametrize("metric", ["euclidean", "chebyshev", "matrix"])
@pytest.mark.parametrize("seed", range(12))
def test_agrees_with_brute_force_on_any_points(metric, seed):
    rng = np.random.default_rng((seed, len(metric)))
    share = float(rng.choice([0.0, 0.3]))
    part = random_instance(
        rng, int(rng.integers(1, 6)), heads=1, homes=None, metric=metric, entries=3, precedence=share
    )
    price = 0.0 if metric == "matrix" else float(rng.choice([0.0, 0.7]))
    require_optimum(part, Rules("travel", backward_price=price))
    require_optimum(part, Rules("makespan"))


@pytest.mark.usefixtures("way")
@pytest.mark.parametrize("asked", [(), *[(each,) for each in SWITCHES], SWITCHES])
@pytest.mark.parametrize("seed", range(8))
def test_agrees_with_brute_force_on_sheets(asked, seed, monkeypatch):
    rng = np.random.default_rng((seed, len(asked), 1))
    # A search of one row a layer has to grow many times before it is complete.
    monkeypatch.setattr(closing, "FIRST_WIDTH", int(rng.choice([1, 1000])))
    sheet = random_sheet(rng, int(rng.integers(2, 6)), homes=None)
    value = require_optimum(sheet, Rules("travel", **dict.fromkeys(asked, True)))
    free = require_optimum(sheet, Rules("travel"))
    assert value is None or value >= free - 1e-9


@pytest.mark.usefixtures("way")
def test_what_positions_and_neighbouring_steps_alone_do_not_tell():
    home = (Head("h", np.array([-100.0, 0.0, 0.0])),)
    line = tuple(Contour(f"c{x}", np.array([[100.0 * x, 0.0, 0.0]]), 1.0) for x in range(6))
    require_optimum(Instance("to and fro", line, home, precedence=((5, 0), (0, 4))), Rules("travel"))
    # Parts of opposite corners of a square and of its middle: a step to the nearest leaves a part unfinished.
    corners = ((0, 0, "1"), (100, 0, "2"), (100, 100, "1"), (0, 100, "2"), (50, 60, "1"), (50, 40, "2"))
    tiles = tuple(Contour(f"t{i}", np.array([[x, y, 0.0]]), 1.0, part=p) for i, (x, y, p) in enumerate(corners))
    one_go, free = (
        require_optimum(Instance("square", tiles, home), Rules("travel", parts_in_one_go=each))
        for each in (True, False)
    )
    assert one_go > free + 1.0


def test_rules_change_the_optimum_of_some_sheets():
    """Both rules bind somewhere among such sheets as the tests above draw, so that they test something."""
    for switch in ("parts_in_one_go", "clear_rapids"):
        changed = 0
        for seed in range(12):
            sheet = random_sheet(np.random.default_rng(seed), 5, homes=True, entries=2)
            best = best_plan(sheet, Rules("travel", **{switch: True}))
            changed += best is None or best.value > best_plan(sheet, Rules("travel")).value + 1e-6
        assert changed > 0, switch


@pytest.mark.parametrize("pairs", [(), ((0, 2), (2, 1))])
def test_squares_in_a_row_have_neighbours_side_by_side(pairs):
    corners = np.array([[0.0, 0.0, 0.0], [30.0, 0.0, 0.0], [30.0, 30.0, 0.0], [0.0, 30.0, 0.0]])
    right = np.array([50.0, 0.0, 0.0])
    contours = tuple(
        Contour(name, corners + i * right, 120.0, geometry=(corners + i * right)[:, :2])
        for i, name in enumerate("abc")
    )
    row = Instance("row", contours, (Head("h", np.array([-50.0, 0.0, 0.0])),), precedence=pairs)
    assert (require_optimum(row, Rules("travel", neighbours_only=True)) is None) == bool(pairs)
    assert require_optimum(row, Rules("travel")) is not None


def large_part(seed, contours=16, entries=5):
    """Contours of several points on circles, far too many for brute force."""
    rng = np.random.default_rng(seed)
    angles = np.linspace(0, 2 * np.pi, entries, endpoint=False)
    ring = np.column_stack((np.cos(angles), np.sin(angles), np.zeros(entries)))
    centres = np.column_stack((rng.uniform(0, 1000, (contours, 2)), np.zeros(contours)))
    sizes = rng.uniform(10, 200, contours)
    parts = tuple(
        Contour(str(i), centre + size * ring, 100.0)
        for i, (centre, size) in enumerate(zip(centres, sizes, strict=True))
    )
    return Instance("circles", parts, (Head("h", np.zeros(3)),))


def plain_optimum(instance):
    """Held and Karp's programme over (set, last point), in plain Python."""
    first, d, home = instance.first_node, instance.rapids, instance.home_node(0)
    count = len(instance.contours)
    layer = {(1 << c, v): d[home, v] for c in range(count) for v in range(first[c], first[c + 1])}
    for _ in range(count - 1):
        following = {}
        for (done, v), cost in layer.items():
            for c in range(count):
                if not done >> c & 1:
                    for w in range(first[c], first[c + 1]):
                        key = (done | 1 << c, w)
                        following[key] = min(following.get(key, np.inf), cost + d[v, w])
        layer = following
    return min(cost + d[v, home] for (_, v), cost in layer.items())


@pytest.mark.usefixtures("way")
@pytest.mark.parametrize("seed", range(3))
def test_agrees_with_a_plain_programme(seed):
    part = large_part(seed, contours=9, entries=3)
    assert solve(part, Rules("travel"), method="contour-dp").value == pytest.approx(plain_optimum(part))


@pytest.mark.parametrize("seed", range(4))
def test_relaxation_bounds_every_walk_and_is_tight_with_full_memories(seed):
    rng = np.random.default_rng(seed)
    sheet = random_sheet(rng, 5, homes=True)
    rules = Rules("travel", parts_in_one_go=True, clear_rapids=bool(rng.integers(2)))
    best = best_plan(sheet, rules)
    (walks,) = walk_problems(sheet, rules)
    prices = rng.uniform(-50, 50, walks.count)
    for size in (0, 2, walks.count - 1):
        memory = build_memory(walks, start_members(walks, size))
        allowed = np.ones((walks.count, len(walks.end)), dtype=bool)
        onward = backward_pass(walks.costs, walks.end, prices, walks.first, walks.closed, allowed)
        tables = (memory.following, memory.offset, memory.crossed)
        value = forward_pass(walks.costs, walks.start, prices, walks.first, *tables, onward, np.inf)
        total, walk = best_walk(walks.costs, walks.end, prices, walks.first, *tables, value)
        bound = total - prices.sum()
        if best is None:
            continue
        assert bound <= best.value + 1e-9
        if size == walks.count - 1:
            assert bound == pytest.approx(best.value)
            assert not forgotten_by(walks, walk)


@pytest.mark.parametrize("width", [1, 3, 30])
def test_a_narrow_search_still_bounds(width):
    part = large_part(5, contours=9, entries=3)
    optimum = plain_optimum(part)
    (walks,) = walk_problems(part, Rules("travel"))
    rounds = Ascent(walks, np.inf, np.inf, lambda bound: None)
    rounds.round()
    result = search(walks, rounds.found, width)
    assert not result.complete  # every layer but the first and the last has more rows
    assert min(result.bound, result.cost) <= optimum + 1e-9
    assert result.cost >= optimum - 1e-9
    assert rounds.found.bound <= optimum + 1e-9


def test_translation_mirror_and_order_change_nothing():
    part = large_part(3)
    value = solve(part, Rules("travel"), method="contour-dp").value
    shifted = [
        replace(c, entry_points=c.entry_points * (-1.0, 1.0, 1.0) + (5000.0, 7.0, 0.0)) for c in part.contours
    ]
    homes = (Head("h", np.array([5000.0, 7.0, 0.0])),)
    image = replace(part, contours=tuple(shifted[::-1]), heads=homes)
    assert solve(image, Rules("travel"), method="contour-dp").value == pytest.approx(value)


def test_whole_lengths_are_proved_to_the_unit():
    part = random_instance(np.random.default_rng(1), 5, heads=1, homes=True, metric="matrix", entries=3)
    assert length_step(walk_problems(part, Rules("travel"))) == 1.0
    assert length_step(walk_problems(large_part(0), Rules("travel"))) == 0.0
    result = solve(part, Rules("travel"), method="contour-dp")
    assert result.lower_bound == result.value


def test_a_stopped_run_keeps_plan_and_bound():
    part = large_part(4, contours=40, entries=6)
    start = Plan.of_contours([range(40)])
    result = solve(part, Rules("travel"), method="contour-dp", time_limit=1e-6, start=start)
    assert result.status == "feasible"
    assert result.value <= evaluate(part, start).total_travel_mm
    assert result.reason == "stopped early"
    again = solve(part, Rules("travel"), method="contour-dp", time_limit=1e-6, start=result.plan)
    assert again.value <= result.value
    longer = solve(part, Rules("travel"), method="contour-dp", time_limit=3.0, start=start)
    assert 0 < longer.lower_bound <= longer.value


def test_what_it_does_not_take_is_refused():
    rng = np.random.default_rng(0)
    with pytest.raises(ValueError, match="needs one head"):
        solve(random_instance(rng, 4), Rules(), method="contour-dp")
    with pytest.raises(ValueError, match="via points"):
        solve(random_instance(rng, 4, heads=1), Rules(via_points=True), method="contour-dp")
    bare = Instance("bare", large_part(0).contours, (Head("h", np.zeros(3)),), Machine())
    with pytest.raises(ValueError, match="no geometry"):
        solve(bare, Rules("travel", clear_rapids=True), method="contour-dp")


@pytest.mark.parametrize("homes", [True, False])
def test_nothing_and_one_contour(homes):
    for count in (0, 1):
        part = random_instance(np.random.default_rng(count), count, heads=1, homes=homes, entries=3)
        result = solve(part, Rules("travel"), method="contour-dp")
        assert result.status == "optimal"
