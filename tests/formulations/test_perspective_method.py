"""The method perspective against all orders, its certificate, limits and refusals."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from certificate.battery_perspective import random_contour, regions_of
from oracles.region_orders import shortest_of_orders

from cutgap.formulations import solve
from cutgap.formulations.certificate import verify
from cutgap.formulations.regions.perspective import MOST_WHOLE, solve_perspective
from cutgap.instances import Contour, Head, Instance, Machine, Rules, Status
from cutgap.instances.formats.json_format import format_instance
from cutgap.instances.region import Ellipsoid

RULES = Rules("travel", free_entries=True)


def instance_of(seed, count, home=False):
    rng = np.random.default_rng(seed)
    contours = tuple(random_contour(rng, f"c{i}") for i in range(count))
    return Instance("regions", contours, (Head("h", rng.uniform(0, 100, 3) if home else None),))


def discs(seed, count):
    rng = np.random.default_rng(seed)
    centres = np.column_stack((rng.uniform(0, 100, (count, 2)), np.zeros(count)))
    regions = [Ellipsoid(each, rng.uniform(5, 15) * np.eye(3)[:2]) for each in centres]
    holes = [Contour(f"d{i}", each.centre[None], 1.0, region=each) for i, each in enumerate(regions)]
    return Instance("discs", tuple(holes), (Head("h"),))


@pytest.mark.parametrize("seed", range(4))
def test_agrees_with_all_orders(seed):
    instance = instance_of(seed, 4 if seed % 2 else 5, home=bool(seed % 2))
    result = solve(instance, RULES, method="perspective")
    optimum = shortest_of_orders(regions_of(instance))
    assert result.violations == ()
    assert result.reason is None
    assert result.value == pytest.approx(optimum, abs=1e-5)
    assert optimum * (1 - 2e-6) <= result.lower_bound <= result.value


def test_scip_agrees():
    instance = discs(1, 4)
    result = solve_perspective(instance, RULES, solver="scip")
    optimum = shortest_of_orders(regions_of(instance))
    assert result.value == pytest.approx(optimum, abs=1e-5)
    assert result.lower_bound == pytest.approx(optimum, rel=1e-4)


def test_makespan_counts_the_work():
    instance = discs(2, 3)
    travel = solve(instance, RULES, method="perspective")
    timed = solve(instance, replace(RULES, objective="makespan"), method="perspective", certify=True)
    work = float(instance.service_times.sum())
    assert timed.value == pytest.approx(travel.value / instance.machine.v_jump + work, rel=1e-7)
    assert verify(timed.certificate, format_instance(instance)).bound >= timed.lower_bound
    assert timed.lower_bound == pytest.approx(timed.value, rel=1e-6)  # three regions have one tour


def test_a_certificate_proves_the_bound_of_the_result():
    instance = discs(3, 5)
    result = solve(instance, RULES, method="perspective", certify=True)
    proved = verify(result.certificate, format_instance(instance)).bound
    assert 0 < result.lower_bound <= proved <= result.value + 1e-6


def test_without_time_nothing_is_claimed_that_is_not_there():
    instance = discs(4, 5)
    result = solve(instance, RULES, method="perspective", time_limit=0.0)
    assert result.reason == "stopped early"
    # The relaxation and the first tour are always there.
    assert result.status is Status.FEASIBLE
    assert 0 < result.lower_bound < result.value
    exact = solve(instance, RULES, method="perspective", start=result.plan)
    assert result.lower_bound <= exact.lower_bound <= exact.value <= result.value


BENT = np.array([[0.0, 0], [10, 0], [10, 10], [5, 1], [0, 10]])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda i: replace(i, heads=(Head("l"), Head("r"))), "one head, got 2"),
        (lambda i: replace(i, machine=Machine(metric="chebyshev")), "euclidean, got chebyshev"),
        (lambda i: replace(i, precedence=((0, 1),)), "precedence"),
        (lambda i: replace(i, contours=i.contours[:2]), "got 2"),
        (
            lambda i: replace(i, contours=(*i.contours, Contour("b", np.zeros((1, 3)), 1, geometry=BENT))),
            "convex",
        ),
        (lambda i: discs(0, MOST_WHOLE + 1), f"up to {MOST_WHOLE} regions.*got {MOST_WHOLE + 1}"),
    ],
)
def test_what_does_not_apply_is_refused(change, message):
    with pytest.raises(ValueError, match=message):
        solve(change(discs(0, 3)), RULES, method="perspective")


def test_given_entries_are_refused():
    with pytest.raises(ValueError, match="free_entries"):
        solve(discs(0, 3), Rules("travel"), method="perspective")


def test_a_missing_scip_is_named_with_the_mend(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyscipopt", None)
    with pytest.raises(ValueError, match="pip install"):
        solve_perspective(discs(0, 3), RULES, solver="scip")
