"""Certificates from the multipliers of compact models: what a relaxation says is proved, whoever solved it."""

import json
from dataclasses import replace

import numpy as np
import pytest
from certificate.compact_samples import compact_samples, programme
from oracles.compact_programmes import FORMULATIONS
from oracles.entry_tours import best_plan
from oracles.random_instances import random_instance

from cutgap.formulations.certificate import Refused, verify
from cutgap.formulations.compact import compact_model
from cutgap.formulations.compact.proof import CLOCK, certified_bound
from cutgap.instances import Head, Instance, Plan, Rules
from cutgap.instances.formats.json_format import format_instance


def needs_clock(made):
    return len(made.instance.heads) == 2 and bool(made.instance.precedence or made.rules.clear_rapids)


def proved(instance, certificate):
    """What a certificate proves when it has been written to a file, in s or mm."""
    return verify(json.dumps(certificate), format_instance(instance))


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_relaxations_of_models_are_certified(formulation):
    for number, made in enumerate(compact_samples()):
        if needs_clock(made):
            continue
        relaxation = compact_model(made.instance, made.rules, formulation).relax()
        expected = programme(number, formulation).solved.value
        assert relaxation.value == pytest.approx(expected, rel=1e-7, abs=1e-6)
        bound, certificate = certified_bound(made.instance, made.rules, formulation, relaxation.multipliers)
        assert bound == pytest.approx(relaxation.value, rel=1e-6, abs=1e-6)
        assert bound <= made.optimum * (1 + 1e-12)
        assert 0 <= proved(made.instance, certificate).bound - bound <= 1e-15 * bound


def test_rounds_are_certified_as_well():
    made = compact_samples()[0]
    relaxation = compact_model(made.instance, made.rules, "dfj-rounds").relax()
    bound, certificate = certified_bound(made.instance, made.rules, "dfj-rounds", relaxation.multipliers)
    assert bound == pytest.approx(programme(0, "dfj").solved.value, rel=1e-6)
    assert proved(made.instance, certificate).bound >= bound


def test_without_the_clock_bounds_are_weaker_and_valid():
    seen = 0
    for number, made in enumerate(compact_samples()):
        if not needs_clock(made):
            continue
        relaxation = compact_model(made.instance, made.rules, "dfj").relax()
        assert {name[0] for name in relaxation.multipliers} & set(CLOCK)
        bound, _ = certified_bound(made.instance, made.rules, "dfj", relaxation.multipliers)
        # The relaxation without these families, whose multipliers are the best that there are.
        best = programme(number, "dfj").solved
        alone, _ = certified_bound(made.instance, made.rules, "dfj", best.multipliers)
        assert bound <= alone + 1e-6
        assert alone == pytest.approx(best.value, rel=1e-6, abs=1e-6)
        assert alone <= made.optimum
        seen += 1
    assert seen > 1


def test_any_multipliers_are_safe():
    rng = np.random.default_rng(3)
    for number, made in enumerate(compact_samples()):
        solved = programme(number, "dfj").solved
        for spread in (1e-3, 1.0, 100.0):
            drawn = {name: value + spread * rng.normal() for name, value in solved.multipliers.items()}
            bound, certificate = certified_bound(made.instance, made.rules, "dfj", drawn)
            assert 0 <= bound <= made.optimum * (1 + 1e-12)
            assert proved(made.instance, certificate).bound >= bound


def test_too_dear_times_are_scaled():
    found = 0
    for number, made in enumerate(compact_samples()):
        if made.rules.objective != "makespan" or needs_clock(made):
            continue
        solved = programme(number, "dfj").solved
        doubled = {name: 2 * m if name[0] == "makespan" else m for name, m in solved.multipliers.items()}
        bound, _ = certified_bound(made.instance, made.rules, "dfj", doubled)
        assert bound == pytest.approx(solved.value, rel=1e-6)
        found += 1
    assert found > 2


def test_plans_are_shown_where_they_can_be_valued():
    made = compact_samples()[0]
    best = best_plan(made.instance, made.rules)
    multipliers = programme(0, "dfj").solved.multipliers
    _, certificate = certified_bound(made.instance, made.rules, "dfj", multipliers, best.plan)
    verdict = proved(made.instance, certificate)
    assert float(verdict.value) == pytest.approx(made.optimum)
    two = next(m for m in compact_samples() if m.rules.clear_rapids and len(m.instance.heads) == 2)
    best = best_plan(two.instance, two.rules)
    _, certificate = certified_bound(two.instance, two.rules, "assignment", {}, best.plan)
    assert certificate["plan"] is None


def test_nothing_to_cut():
    instance = Instance("nothing", (), (Head("h", np.zeros(3)),))
    for rules in (Rules(), Rules("travel")):
        bound, certificate = certified_bound(instance, rules, "mtz", {}, Plan(((),)))
        assert bound == 0.0
        assert proved(instance, certificate).value == 0


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
def test_multipliers_that_are_no_numbers_are_refused(value):
    made = compact_samples()[0]
    with pytest.raises(ValueError, match=r"cut-once.*finite"):
        certified_bound(made.instance, made.rules, "mtz", {("cut-once", 0): value})


def test_rows_of_other_models_are_refused():
    made = compact_samples()[0]
    for formulation, name in (
        ("mtz", ("flow-keep", 0, 0)),
        ("dfj", ("enter", 0, (1,))),
        ("dfj", ("makespan", 0)),
    ):
        with pytest.raises(Refused, match=r"row|set"):
            certified_bound(made.instance, made.rules, formulation, {name: 1.0})
    three = replace(made.instance, heads=tuple(Head(name) for name in "abc"))
    with pytest.raises(ValueError, match="heads"):
        certified_bound(three, Rules("travel", non_overlap=None), "mtz", {})


@pytest.mark.parametrize("objective", ["makespan", "travel"])
def test_twelve_contours(objective):
    instance = random_instance(np.random.default_rng(5), 12, layout="uniform", entries=3)
    rules = Rules(objective, non_overlap=None)
    for formulation in ("single-commodity", "multi-commodity"):
        relaxation = compact_model(instance, rules, formulation).relax()
        bound, _ = certified_bound(instance, rules, formulation, relaxation.multipliers)
        assert bound == pytest.approx(relaxation.value, rel=1e-6)
