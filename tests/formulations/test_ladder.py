"""The ladder: bounds in the order that theory gives them, each with a proof that verifies."""

from dataclasses import replace

import numpy as np
import pytest

import cutgap.formulations as public
from cutgap.formulations import LADDER, ladder, solve, verify
from cutgap.formulations.rungs import Rung, optimum
from cutgap.instances import Contour, Head, Instance, Rules
from cutgap.instances.formats.json_format import format_instance
from cutgap.instances.region import Ellipsoid

SLACK = 1e-6
"""Relative; bounds are proved from multipliers that are optimal but for a solver's tolerance."""


def part(seed, holes=7, heads=1, entries=1):
    rng = np.random.default_rng(seed)
    contours = [Contour(f"c{i}", rng.uniform(0, 100, (entries, 3)).round(2), 30.0) for i in range(holes)]
    return Instance("part", contours, [Head(f"h{k}", np.array([k * 100.0, -5.0, 0.0])) for k in range(heads)])


def bounds(instance, rules, names=None):
    found = {}
    for rung in ladder(instance, rules, names=names):
        found[rung.formulation] = rung.bound
        if rung.bound is not None:
            verdict = verify(rung.certificate, format_instance(instance))
            assert float(verdict.bound) == pytest.approx(rung.bound, rel=1e-12, abs=1e-12)
            assert None not in (rung.variables, rung.constraints, rung.nonzeros)
    return found


def at_least(larger, smaller):
    return larger >= smaller * (1 - SLACK)


@pytest.mark.parametrize("seed", range(4))
def test_one_head_stands_in_the_order_of_theory(seed):
    instance, rules = part(seed), Rules("travel")
    found = bounds(instance, rules)
    best = solve(instance, rules).value
    assert all(best * (1 + SLACK) >= bound for bound in found.values() if bound is not None)
    for same in ("multi-commodity", "dfj-rounds", "held-karp"):
        assert found[same] == pytest.approx(found["dfj"], rel=SLACK)
    assert at_least(found["multi-commodity"], found["single-commodity"])
    assert at_least(found["single-commodity"], found["two-commodity"])
    assert at_least(found["two-commodity"], found["mtz"])
    assert at_least(found["lifted-mtz"], found["mtz"])
    assert at_least(found["time-indexed"], found["single-commodity"])
    assert at_least(found["mtz"], found["assignment"])
    assert at_least(found["cycle-distances"], found["connectivity"])
    assert at_least(found["held-karp"], found["connectivity"])
    assert at_least(found["held-karp"], found["two-matching"])


def test_formulations_differ_where_a_tour_would_fall_apart():
    """Three far pairs: the weaker models take each pair for a tour of its own."""
    places = [(0, 0), (0, 1), (100, 0), (100, 1), (50, 80), (50, 81)]
    contours = [Contour(f"c{i}", [[x, y, 0]], 1.0) for i, (x, y) in enumerate(places)]
    found = bounds(Instance("pairs", contours, [Head("h", [0, 0.5, 0])]), Rules("travel"))
    assert found["assignment"] < 0.5 * found["mtz"] or found["assignment"] < 0.5 * found["dfj"]
    assert found["mtz"] < found["single-commodity"] < found["dfj"]


@pytest.mark.parametrize("rules", [Rules(), Rules("travel", balance=2.0), Rules("weighted", weight=20.0)])
def test_two_heads(rules):
    instance = part(11, heads=2)
    best, exact = optimum(instance, rules)
    found = bounds(instance, rules)
    assert exact.bound == best.lower_bound
    assert all(best.value * (1 + SLACK) >= bound for bound in found.values() if bound is not None)
    assert at_least(found["dfj"], found["mtz"])
    assert found["dfj"] > 0


def test_two_heads_under_precedence_are_certified_without_their_clock():
    instance = replace(part(5, holes=4, heads=2), precedence=((0, 1), (2, 3)))
    rules = Rules("travel", non_overlap=None)
    found = bounds(instance, rules, ["mtz", "multi-commodity"])
    best = solve(instance, rules)
    assert 0 < found["mtz"] <= best.value * (1 + SLACK)
    assert at_least(found["multi-commodity"], found["mtz"])


def test_entry_points_and_precedence():
    instance = replace(part(2, holes=6, entries=3), precedence=((0, 3), (1, 2)))
    found = bounds(instance, Rules("travel"))
    best = solve(instance, Rules("travel")).value
    linear = {name for name, relaxation in LADDER.items() if relaxation.kind == "linear"}
    assert {name for name, bound in found.items() if bound is not None} == linear
    assert all(found[name] <= best * (1 + SLACK) for name in linear)


def test_free_entries_take_the_cone_alone():
    rng = np.random.default_rng(3)
    centres = np.column_stack((rng.uniform(0, 100, (5, 2)), np.zeros(5)))
    discs = [
        Contour(f"d{i}", [centre], 60.0, region=Ellipsoid(centre, 8.0 * np.eye(3)[:2]))
        for i, centre in enumerate(centres)
    ]
    instance, rules = Instance("discs", discs, [Head("h")]), Rules("travel", free_entries=True)
    found = bounds(instance, rules)
    assert [name for name, bound in found.items() if bound is not None] == ["perspective"]
    assert found["perspective"] <= solve(instance, rules).value


def test_what_does_not_apply_says_why():
    (rung,) = ladder(part(1, holes=13), Rules("travel"), names=["dfj"])
    assert rung.bound is None
    assert "13" in rung.note
    assert "12" in rung.note
    assert rung.gap(10.0) is None


def test_gap_is_to_the_value():
    assert Rung("x", "linear", 0.0, 75.0).gap(100.0) == 0.25
    assert Rung("x", "linear", 0.0, 0.0).gap(0.0) == 0.0


def test_unknown_names_are_refused():
    with pytest.raises(ValueError, match="'simplex'"):
        list(ladder(part(1), Rules(), names=["simplex"]))


def test_every_public_name_is_there():
    assert all(callable(getattr(public, name)) or getattr(public, name) for name in public.__all__)
    with pytest.raises(AttributeError):
        _ = public.nothing
