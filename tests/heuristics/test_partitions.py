from dataclasses import replace

import numpy as np
import pytest
from heuristics_parts import RULES, random_part
from hypothesis import given, settings
from hypothesis import strategies as st

from cutgap.heuristics import HEURISTICS, task_balancing
from cutgap.heuristics.clustering import fuzzy_clusters, fuzzy_memberships, left_and_right
from cutgap.heuristics.genetic import GeneticParameters
from cutgap.heuristics.sides import allowed_splits, contour_xs
from cutgap.heuristics.task_balancing import TaskBalancingParameters, initial_offset
from cutgap.instances import Contour, Head, Instance, Machine, Rules, check, evaluate

SEEDS = st.integers(0, 2**32 - 1)
QUICK = GeneticParameters(population=6, generations=40)


def row_of_holes(perimeters, spacing=10.0, machine=None):
    """Holes along x, homes at both ends."""
    contours = tuple(
        Contour(f"{i}", np.array([[spacing * (i + 1), 0.0, 0.0]]), p) for i, p in enumerate(perimeters)
    )
    end = spacing * (len(perimeters) + 1)
    heads = (Head("left", np.zeros(3)), Head("right", np.array([end, 0.0, 0.0])))
    return Instance("row", contours, heads, machine or Machine(v_jump=100.0, v_cut=50.0, t_aux=1.0))


def test_initial_offset_by_hand():
    # Work per hole is 2 h + 100: 120, 140, 160, 220, 200 mm; sums 120, 260, 420, 640, 840; half is 420.
    # F_3 = 0 is not yet positive, so the first k is 4.
    part = row_of_holes([10.0, 20.0, 30.0, 60.0, 50.0])
    assert initial_offset(part, np.arange(5)) == 4
    # Mirrored: sums 200, 420, 580, ... F_2 = 0, so the first k is 3.
    assert initial_offset(part, np.arange(5)[::-1]) == 3


def test_initial_offset_without_any_work_counts_contours():
    part = row_of_holes([0.0] * 4, machine=Machine(t_aux=0.0))
    assert initial_offset(part, np.arange(4)) == 2
    assert initial_offset(row_of_holes([]), np.arange(0)) == 0


def test_task_balancing_shifts_to_the_least_imbalance():
    # By work alone half of the equal holes go left, but the left head comes from 300 mm further away. On a
    # line every side's shortest tour is there and back, so the times of all splits are known.
    row = row_of_holes([50.0] * 9, spacing=7.0)
    part = replace(row, heads=(Head("left", np.array([-300.0, 0.0, 0.0])), row.heads[1]))
    assert initial_offset(part, np.arange(9)) == 5
    imbalances = [
        abs((2 * (300 + 7 * k) / 100 + 2 * k) - (2 * 7 * (9 - k) / 100 + 2 * (9 - k))) for k in range(1, 9)
    ]
    assert np.argmin(imbalances) + 1 < 4
    plan = task_balancing(part, Rules(), rng=np.random.default_rng(0))
    assert evaluate(part, plan).imbalance_s == pytest.approx(min(imbalances))


@settings(deadline=None, max_examples=40)
@given(SEEDS, st.integers(0, 9), st.booleans(), st.sampled_from(RULES))
def test_task_balancing_keeps_to_the_rules_wherever_a_split_can(seed, holes, tied, rules):
    rng = np.random.default_rng(seed)
    part = random_part(rng, holes, tied=tied)
    plan = task_balancing(part, rules, rng=rng, parameters=TaskBalancingParameters(genetic=QUICK))
    broken = {violation.constraint for violation in check(part, rules, plan)}
    xs = np.sort(contour_xs(part))
    gaps = np.diff(xs)
    possible = rules.empty_heads or holes < 2 or (len(gaps) > 0 and gaps.max() >= (rules.non_overlap or 0.0))
    assert not broken or not possible
    assert "each contour once" not in broken


@settings(deadline=None, max_examples=20)
@given(SEEDS, st.integers(0, 9), st.booleans(), st.sampled_from(["k-means", "fuzzy-c-means"]))
def test_clustering_may_break_nothing_but_the_partition(seed, holes, tied, name):
    rng = np.random.default_rng(seed)
    part = random_part(rng, holes, tied=tied)
    rules = Rules(via_points=True)
    plan = HEURISTICS[name](part, rules, rng=rng)
    assert {violation.constraint for violation in check(part, rules, plan)} <= {"non-overlap", "no empty heads"}


@settings(deadline=None, max_examples=60)
@given(SEEDS, st.integers(2, 40), st.booleans())
def test_fuzzy_memberships_sum_to_one_and_the_objective_falls(seed, holes, tied):
    rng = np.random.default_rng(seed)
    points = random_part(rng, holes, tied=tied).points[:holes]
    clusters = fuzzy_clusters(points, 2, rng)
    assert clusters.memberships.sum(axis=1) == pytest.approx(1.0)
    assert (clusters.memberships >= 0).all()
    objectives = np.array(clusters.objectives)
    assert (np.diff(objectives) <= 1e-9 * max(1.0, objectives[0])).all()


def test_fuzzy_memberships_by_hand():
    squares = np.array([[1.0, 4.0], [0.0, 9.0], [0.0, 0.0]])
    assert fuzzy_memberships(squares) == pytest.approx(np.array([[0.8, 0.2], [1.0, 0.0], [0.5, 0.5]]))


@pytest.mark.parametrize("name", ["k-means", "fuzzy-c-means"])
def test_two_clear_clusters_are_found(name):
    rng = np.random.default_rng(6)
    xs = np.concatenate((rng.uniform(0, 100, 7), rng.uniform(2000, 2100, 5)))[rng.permutation(12)]
    contours = tuple(Contour(f"{i}", np.array([[x, 0.0, 0.0]]), 10.0) for i, x in enumerate(xs))
    part = Instance("two", contours, (Head("l", np.zeros(3)), Head("r", np.array([2100.0, 0, 0]))))
    plan = HEURISTICS[name](part, Rules(), rng=rng)
    assert {visit.contour for visit in plan.tours[0]} == set(np.flatnonzero(xs < 1000))


def test_points_that_coincide_are_halved():
    left, right = left_and_right(np.ones((5, 3)), lambda points, rng: np.zeros(5, dtype=int), None)
    assert (left, right) == ([0, 1, 2], [3, 4])


def test_allowed_splits_by_hand():
    part, order = row_of_holes([1.0] * 4), np.arange(4)
    for rules, splits in (
        (Rules(empty_heads=True), [0, 1, 2, 3, 4]),
        (Rules(empty_heads=False), [1, 2, 3]),
        (Rules(empty_heads=False, non_overlap=10.0), [1, 2, 3]),
        (Rules(empty_heads=True, non_overlap=10.5), [0, 4]),
        (Rules(empty_heads=False, non_overlap=10.5), [0, 1, 2, 3, 4]),
    ):
        assert allowed_splits(part, rules, order) == splits
