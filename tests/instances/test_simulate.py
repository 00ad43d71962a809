"""The heads in time: starts and separation by hand, and against a simulation that samples time finely."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.problem import figures, plain_problem
from oracles.random_instances import LAYOUTS, random_instance, random_plan
from oracles.sampled_simulation import sampled_separation

from cutgap.instances import Contour, Head, Instance, Machine, Plan, evaluate
from cutgap.instances.simulate import start_times

SEEDS = st.integers(0, 2**32 - 1)
SAMPLES = 300


def line(xs, homes, *, perimeters=None, ys=None, **machine) -> Instance:
    """Holes at ``xs``; 100 mm/s for rapids, 10 mm/s for cutting, no auxiliary time."""
    perimeters, ys = perimeters or [0.0] * len(xs), ys or [0.0] * len(xs)
    contours = tuple(
        Contour(f"c{i}", [[x, y, 0]], h) for i, (x, y, h) in enumerate(zip(xs, ys, perimeters, strict=True))
    )
    heads = tuple(Head(f"h{i}", None if x is None else [x, 0, 0]) for i, x in enumerate(homes))
    settings_of_machine = {"v_jump": 100.0, "v_cut": 10.0, "t_aux": 0.0} | machine
    return Instance("line", contours, heads, Machine(**settings_of_machine))


def separation(part: Instance, orders) -> float | None:
    return evaluate(part, Plan.of_contours(orders)).separation_mm


def test_start_times_by_hand():
    part = line([100, 300, 1000], [0, 800], perimeters=[10.0, 20.0, 0.0], t_aux=0.5)
    # Left: 1 s rapid, 1.5 s work, 2 s rapid. Right: 2 s rapid.
    assert start_times(part, Plan.of_contours([[0, 1], [2]])) == {0: 1.0, 1: 4.5, 2: 2.0}


def test_head_without_home_starts_at_once():
    part = line([100, 300], [None], perimeters=[10.0, 20.0])
    assert start_times(part, Plan.of_contours([[0, 1]])) == {0: 0.0, 1: 3.0}
    assert start_times(part, Plan.of_contours([[1, 0]])) == {1: 0.0, 0: 4.0}


def test_separation_of_heads_at_rest():
    assert separation(line([], [0, 400]), [[], []]) == 400.0
    assert separation(line([300], [0, 400]), [[0], []]) == 100.0
    assert separation(line([500], [0, 400]), [[0], []]) == -100.0


def test_heads_that_meet_in_time():
    """Both reach the middle after 4 s, though their ranges are 50 mm apart."""
    part = line([400, 450], [0, 850])
    assert separation(part, [[0], [1]]) == 50.0
    # Starting 1000 mm away the right head is still 600 mm off when the left one turns back.
    late = line([400, 450], [0, 1450])
    assert separation(late, [[0], [1]]) == pytest.approx(450.0)


def test_ranges_apart_can_still_collide_with_a_passing_head():
    """The right head's home is on the left: on its way it passes the left head."""
    part = line([100, 300], [0, -200], perimeters=[50.0, 0.0])
    assert evaluate(part, Plan.of_contours([[0], [1]])).partition_gap_mm == 200.0
    assert separation(part, [[0], [1]]) == -200.0


def test_ranges_that_overlap_can_be_apart_in_time():
    """The left head goes far right only when the right head is away."""
    part = line([100, 500, 450, 900], [0, 600], perimeters=[100.0, 0.0, 0.0, 100.0])
    plan = Plan.of_contours([[0, 1], [2, 3]])
    result = evaluate(part, plan)
    assert result.partition_gap_mm == -50.0
    # After 1 s: left at 100, right at 500. At 1.5 s right at 450; it cuts at 900 from 6 to 16 s.
    # Left leaves 100 at 11 s, is at 500 at 15 s, and goes home while right follows 1 s later.
    assert result.separation_mm == 350.0


def test_cutting_time_holds_the_head():
    waiting = line([400, 450], [0, 850], perimeters=[100.0, 0.0])
    # Left stands at 400 from 4 to 14 s; right comes to 450 at 4 s.
    assert separation(waiting, [[0], [1]]) == 50.0
    passing = line([400, 300], [0, 850], perimeters=[100.0, 0.0])
    # Right passes over 400 on its way to 300, where it is at 5.5 s.
    assert separation(passing, [[0], [1]]) == -100.0


def test_chebyshev_moves_x_at_full_speed():
    """A rapid of 400 mm in y brings x to 100 within 1 s of its 4 s."""
    steep = {"xs": [100, 200], "ys": [400, 0], "homes": [0, 450], "perimeters": [0.0, 0.0]}
    # Right reaches 200 at 2.5 s. By then left is at 100 (chebyshev), or at 62.5 of its way.
    assert separation(line(**steep, metric="chebyshev"), [[0], [1]]) == 100.0
    even = separation(line(**steep), [[0], [1]])
    length = np.hypot(100, 400)
    assert even == pytest.approx(200 - 100 * 250 / length)


def test_separation_of_one_head_or_of_none_is_not_known():
    assert separation(line([100], [0]), [[0]]) is None
    assert separation(line([100], [0, None]), [[0], []]) is None
    assert separation(line([100], [0, None]), [[], [0]]) == 100.0


def test_three_heads_are_compared_with_their_neighbours():
    part = line([100, 300, 650], [0, 400, 1000])
    # Middle and right: 400 and 1000 at the start; at 3.5 s right at 650, middle long back at 400.
    assert separation(part, [[0], [1], [2]]) == 200.0
    assert separation(part, [[0], [], [2]]) == 250.0


def test_jump_of_a_matrix_counts_on_both_sides():
    """Left cuts at 500 until 1 s and is home in no time; right has come to 700 by then."""
    contours = (Contour("a", [[500, 0, 0]], 10.0), Contour("b", [[600, 0, 0]], 0.0))
    matrix = np.zeros((4, 4))
    matrix[3, 1] = matrix[1, 3] = 400.0 / 3
    part = Instance(
        "jump",
        contours,
        (Head("l", [0, 0, 0]), Head("r", [1000, 0, 0])),
        Machine(v_jump=100.0, v_cut=10.0, t_aux=0.0, metric="matrix"),
        matrix=matrix,
    )
    assert separation(part, [[0], [1]]) == pytest.approx(1000 - 300 - 500)


@settings(max_examples=80, deadline=None)
@given(
    SEEDS,
    st.integers(0, 6),
    st.integers(2, 3),
    st.sampled_from(["euclidean", "chebyshev"]),
    st.sampled_from(LAYOUTS),
)
def test_separation_agrees_with_fine_sampling(seed, holes, heads, metric, layout):
    rng = np.random.default_rng(seed)
    part = random_instance(rng, holes, layout=layout, heads=heads, homes=None, metric=metric, entries=2)
    plan = random_plan(rng, part)
    exact = evaluate(part, plan).separation_mm
    if any(head.home is None and not tour for head, tour in zip(part.heads, plan.tours, strict=True)):
        assert exact is None
        return
    problem = plain_problem(part)
    times = np.linspace(0.0, 1.05 * figures(problem, plan.tours).makespan, SAMPLES)
    sampled = sampled_separation(problem, plan.tours, times.tolist(), metric == "chebyshev")
    # Two heads close in at no more than twice the speed, so a sample misses at most this much.
    slack = float(times[1]) * part.machine.v_jump
    assert exact - 1e-6 <= sampled <= exact + slack + 1e-6


@settings(max_examples=60, deadline=None)
@given(SEEDS, st.integers(1, 6), st.booleans())
def test_starts_fill_the_time_of_each_head(seed, holes, homes):
    """A head is done when its last contour is cut and the way back is behind it."""
    rng = np.random.default_rng(seed)
    part = random_instance(rng, holes, homes=homes, metric="matrix")
    plan = random_plan(rng, part)
    problem, starts = plain_problem(part), start_times(part, plan)
    assert sorted(starts) == list(range(holes))
    for head, tour in enumerate(plan.tours):
        if not tour:
            continue
        last = tour[-1].contour
        back = problem.home_node(head) if homes else tour[0].contour
        end = starts[last] + problem.work([last]) + problem.lengths[last][back] / problem.v_jump
        assert end == pytest.approx(figures(problem, plan.tours).time[head], abs=1e-9)
        for earlier, later in pairwise(tour):
            rapid = problem.lengths[earlier.contour][later.contour] / problem.v_jump
            assert starts[later.contour] == pytest.approx(
                starts[earlier.contour] + problem.work([earlier.contour]) + rapid, abs=1e-9
            )
