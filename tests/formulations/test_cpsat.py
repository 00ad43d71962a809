"""The CP-SAT model agrees with brute force and with the other methods, and claims no more than it may."""

import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from oracles.brute_force import brute_force
from oracles.random_instances import LAYOUTS, random_instance

from cutgap.formulations import METHODS, solve
from cutgap.formulations.cpsat.integers import integers_of
from cutgap.formulations.cpsat.solving import solve_cpsat
from cutgap.instances import Contour, Head, Instance, Machine, Plan, Result, Rules, check, evaluate
from cutgap.instances.generate import random_part

GAPS = (None, None, 0.0, 1.0, 40.0, 150.0)
SLACK = 1e-7
"""Relative slack of values; the scale lets single roundings be far smaller."""


def cpsat(instance: Instance, rules: Rules, **options) -> Result:
    return solve_cpsat(instance, rules, workers=1, isolated=False, **options)


def draw_rules(rng: np.random.Generator, instance: Instance, *, balance: bool = True) -> Rules:
    objective = str(rng.choice(["makespan", "travel", "weighted"]))
    v_jump = instance.machine.v_jump
    weight = float(rng.choice([0.0, 0.3, 1.0, 2.5])) * v_jump if objective == "weighted" else 0.0
    gap = GAPS[int(rng.integers(len(GAPS)))]
    limit = [None, None, 0.4, 3.0][int(rng.integers(4))] if balance else None
    via_points, empty_heads = (bool(each) for each in rng.random(2) < 0.5)
    return Rules(objective, weight, gap, limit, via_points, empty_heads)


def assert_agrees(instance: Instance, rules: Rules) -> None:
    best, result = brute_force(instance, rules), cpsat(instance, rules)
    assert result.certificate is None
    if best is None:
        assert result.status == "infeasible" or (rules.balance is not None and result.value is None)
        return
    assert result.status in ("feasible", "optimal")
    assert check(instance, rules, result.plan) == []
    slack = SLACK * max(1.0, best.value)
    assert result.value == pytest.approx(best.value, abs=slack)
    assert result.lower_bound == pytest.approx(best.value, abs=slack)
    assert result.lower_bound <= best.value + 1e-9 * max(1.0, best.value)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("layout", LAYOUTS)
def test_agrees_with_brute_force(layout, seed):
    rng = np.random.default_rng((LAYOUTS.index(layout), seed))
    instance = random_instance(rng, int(rng.integers(0, 7)), layout=layout)
    for _ in range(2):
        assert_agrees(instance, draw_rules(rng, instance))


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("metric", ["euclidean", "chebyshev", "matrix"])
def test_agrees_without_homes_and_with_asymmetric_lengths(metric, seed):
    rng = np.random.default_rng((3, seed))
    instance = random_instance(rng, int(rng.integers(1, 6)), metric=metric, homes=None)
    assert_agrees(instance, draw_rules(rng, instance))


@pytest.mark.parametrize("seed", range(3))
def test_agrees_with_the_other_methods_on_larger_parts(seed):
    instance = random_part(10, np.random.default_rng(seed))
    for rules in (Rules(), Rules("travel", via_points=True), Rules("weighted", weight=80.0, non_overlap=30.0)):
        expected = solve(instance, rules, method="split")
        assert cpsat(instance, rules).value == pytest.approx(expected.value, rel=SLACK)
    for rules in (Rules(non_overlap=None), Rules("travel", non_overlap=None, balance=0.5)):
        expected = solve(instance, rules, method="free")
        assert cpsat(instance, rules).value == pytest.approx(expected.value, rel=SLACK)


def test_data_are_rounded_down_and_the_slack_covers_all_roundings():
    instance = random_part(9, np.random.default_rng(5))
    data = integers_of(instance, Rules("weighted", weight=70.0, balance=0.5))
    rng = np.random.default_rng(6)
    for _ in range(20):
        order = rng.permutation(9).tolist()
        cut = int(rng.integers(0, 10))
        plan = Plan.of_contours([order[:cut], order[cut:]])
        exact = np.array(evaluate(instance, plan).time_s) * instance.machine.v_jump * data.scale
        whole = []
        for head, tour in enumerate((order[:cut], order[cut:])):
            rapids = sum(data.rapids[a][b] for a, b in pairwise(tour))
            if tour:
                rapids += data.out[head][tour[0]] + data.back[head][tour[-1]]
            whole.append(rapids + sum(data.work[hole] for hole in tour))
        noise = 1e-12 * exact.max()
        assert (whole <= exact + noise).all()
        assert (exact - whole).sum() <= data.slack + noise
    numerator, denominator = data.price
    assert numerator / denominator <= 70.0 / instance.machine.v_jump


def balanced(limit: float) -> tuple[Instance, Rules]:
    """Two holes, one for each head, with times that differ by exactly 1 s but for irrational rapids."""
    contours = (Contour("a", [[1, 1, 0]], 0.0), Contour("b", [[3, 1, 0]], 40.0))
    heads = (Head("left", [0, 0, 0]), Head("right", [4, 0, 0]))
    return Instance("two", contours, heads, Machine(t_aux=0.0)), Rules("travel", balance=limit)


def test_balance_alone_feasible_and_infeasible():
    assert cpsat(*balanced(1.01)).status in ("feasible", "optimal")
    result = cpsat(*balanced(0.99))
    assert (result.status, result.plan, result.lower_bound, result.certificate) == (
        "infeasible",
        None,
        None,
        None,
    )
    assert "claims" in result.reason


def test_a_plan_that_breaks_the_balance_by_rounding_is_said_to():
    """The limit is missed by less than the roundings, but by more than ``check`` forgives."""
    instance, rules = balanced(0.0)
    plan = Plan.of_contours([[0], [1]])
    unit_s = 1.0 / integers_of(instance, rules).scale / instance.machine.v_jump
    times = evaluate(instance, plan)
    # Just out of reach of the tolerance.
    rules = replace(rules, balance=times.imbalance_s - 1.001e-9 * max(1.0, times.makespan_s))
    assert check(instance, rules, plan)
    assert unit_s < 1e-9
    result = cpsat(instance, rules)
    assert result.status == "unknown"
    assert [violation.constraint for violation in result.violations] == ["balance"]
    assert "rounding" in result.reason


def test_order_via_points_and_work_alone_feasible_and_infeasible():
    column = random_instance(np.random.default_rng(0), 4, layout="column")
    assert cpsat(column, Rules(non_overlap=1.0)).status == "infeasible"
    assert cpsat(column, Rules(non_overlap=1.0, empty_heads=True)).status == "optimal"
    assert cpsat(column, Rules(non_overlap=0.0, via_points=True)).status == "optimal"
    assert check(column, Rules(), cpsat(column, Rules(empty_heads=False)).plan) == []


def test_a_stopped_run_keeps_plan_and_bound():
    instance = random_part(30, np.random.default_rng(1))
    rules = Rules(non_overlap=None)
    start = Plan.of_contours([range(15), range(15, 30)])
    result = cpsat(instance, rules, time_limit=0.0, start=start)
    assert (result.status, result.plan) == ("feasible", start)
    assert "stopped early" in result.reason
    result = cpsat(instance, rules, time_limit=2.0, start=start)
    assert result.value <= evaluate(instance, start).makespan_s
    assert result.lower_bound is not None


def test_a_start_that_breaks_rules_is_ignored():
    instance = random_part(5, np.random.default_rng(1))
    result = cpsat(instance, Rules(), start=Plan.of_contours([range(5), []]))
    assert result.value == pytest.approx(solve(instance, Rules()).value, rel=SLACK)


def test_the_front_door_searches_in_a_child_process():
    instance = random_part(6, np.random.default_rng(2))
    seen = []
    result = solve(instance, Rules(), method="cpsat", certify=True, watch=seen.append)
    assert (result.status, result.method, result.certificate) == ("optimal", "cpsat", None)
    assert seen[-1].value == pytest.approx(result.value)
    assert "cpsat" in METHODS


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="memory limits are enforced on Linux")
def test_a_search_that_dies_of_memory_is_survived():
    instance = random_part(6, np.random.default_rng(2))
    result = solve_cpsat(instance, Rules(), workers=1, memory_mib=300)
    assert (result.status, result.plan, result.lower_bound) == ("unknown", None, None)
    assert "300 MiB" in result.reason


@pytest.mark.skipif(os.name != "posix", reason="sends a signal")
def test_ctrl_c_keeps_the_best_plan():
    instance = random_part(40, np.random.default_rng(2))

    def interrupt() -> None:
        if not pressed.is_set():
            pressed.set()
            os.kill(os.getpid(), signal.SIGINT)

    pressed = threading.Event()
    started = time.perf_counter()
    result = solve_cpsat(
        instance,
        Rules(non_overlap=None),
        workers=1,
        time_limit=60.0,
        watch=lambda state: interrupt() if state.value is not None else None,
    )
    assert time.perf_counter() - started < 30.0
    assert "interrupted" in result.reason
    assert result.status == "feasible"


def test_the_search_ends_when_its_input_does():
    worker = subprocess.Popen([sys.executable, "-m", "cutgap.formulations.cpsat.worker"], stdin=subprocess.PIPE)
    worker.stdin.close()
    assert worker.wait(timeout=30) != 0  # no job


def test_three_heads_are_refused():
    instance = random_instance(np.random.default_rng(0), 3, heads=3)
    with pytest.raises(ValueError, match="cpsat: needs one or two heads, got 3"):
        cpsat(instance, Rules())
