"""Each row of each model is the row of that name on the page, at random points of all variables."""

import cvxpy as cp
import numpy as np
import pytest
from oracles.exact_sheet import sheet_of
from oracles.random_instances import random_instance
from oracles.random_sheets import random_sheet
from page_rows import HOME, Page

from cutgap.formulations.compact.clock import latest_time
from cutgap.formulations.compact.programme import Programme, assemble
from cutgap.formulations.compact.tours import TOUR_FORMULATIONS
from cutgap.instances import Instance, Rules

VARIABLES = {
    "mtz": "p",
    "lifted-mtz": "p",
    "single-commodity": "f",
    "two-commodity": "fg",
    "multi-commodity": "f",
    "time-indexed": "w",
}


def drawn(rng: np.random.Generator, programme: Programme) -> dict[str, np.ndarray]:
    """Give every variable a random value between its bounds; y is what x makes it."""
    values = {}
    for variable in programme.problem().variables():
        low, high = variable.get_bounds()
        high = np.where(np.isfinite(high), high, 100.0)
        if variable.name()[0] != "y":
            variable.value = np.asarray(low + rng.random(variable.shape) * (high - low))
        values[variable.name()] = variable
    for head in programme.heads:
        if isinstance(head.way.y, cp.Variable):
            head.way.y.value = head.network.to_pairs @ head.x.value
    return {name: variable.value for name, variable in values.items()}


def residuals(programme: Programme) -> dict:
    """Left minus right of every row."""
    found = {}
    for family in programme.families:
        one, other = (np.broadcast_to(arg.value, (len(family.rows),)) for arg in family.constraint.args)
        left = one - other if family.is_equation else other - one
        found |= dict(zip(family.names, left.tolist(), strict=True))
    return found


def page_of(instance: Instance, rules: Rules, programme: Programme) -> Page:
    legs: dict[bool, dict] = {False: {}, True: {}}
    for head in programme.heads:
        net = head.network
        for tail, end, closes, value in zip(net.tails, net.heads, net.closing, head.x.value, strict=True):
            legs[bool(closes)][net.head, int(tail), int(end)] = float(value)
    return Page(instance, rules, legs[False], legs[True])


def tour_values(page: Page, formulation: str, values: dict) -> dict:
    """p, f, g and w of each head by their indices on the page."""
    n, begin = page.n, [(HOME, j) for j in page.contours]
    end = [(i, HOME) for i in page.contours]
    outward = page.pairs + begin
    keys = {
        "single-commodity": outward,
        "two-commodity": page.ends,
        "multi-commodity": [(k, *pair) for k in page.contours for pair in outward],
        "time-indexed": [(0, *pair) for pair in begin]
        + [(t, *pair) for t in range(1, n) for pair in page.pairs]
        + [(t, *pair) for t in ([n] if page.alone else range(1, n + 1)) for pair in end],
    }
    found: dict = {}
    for name in VARIABLES.get(formulation, ""):
        arrays = [values.get(f"{name}{h}", np.ones(n)).tolist() for h in page.heads]
        ordered = formulation in keys
        found[name] = [dict(zip(keys[formulation], a, strict=True)) if ordered else a for a in arrays]
    return found


def assert_rows_are_those_of_the_page(actual: dict, expected: dict) -> None:
    assert set(actual) == set(expected)
    names = sorted(actual, key=repr)
    np.testing.assert_allclose([actual[n] for n in names], [expected[n] for n in names], atol=1e-6)


@pytest.mark.parametrize("formulation", TOUR_FORMULATIONS)
@pytest.mark.parametrize("heads", [1, 2])
def test_tours_and_problem(heads, formulation):
    for seed in range(6):
        rng = np.random.default_rng((heads, seed))
        instance = random_instance(rng, 1 + seed % 5, heads=heads, homes=None, entries=1 + seed % 2)
        objective = ("makespan", "travel", "weighted")[seed % 3]
        rules = Rules(
            objective,
            non_overlap=[None, 0.0, 40.0][seed % 3],
            balance=7.0 if seed % 2 else None,
            via_points=seed % 2 == 0,
            empty_heads=seed % 4 == 0,
        )
        programme = assemble(instance, rules, formulation, integer=False)
        values = drawn(rng, programme)
        page = page_of(instance, rules, programme)
        expected = page.problem_rows(float(values.get("makespan", 0.0)), float(values.get("imbalance", 0.0)))
        if formulation not in ("assignment", "dfj-rounds"):
            expected |= page.tour_rows(formulation, tour_values(page, formulation, values))
        assert_rows_are_those_of_the_page(residuals(programme), expected)


@pytest.mark.parametrize("heads", [1, 2])
def test_rules_on_order(heads):
    for seed in range(8):
        rng = np.random.default_rng((3, heads, seed))
        instance = random_sheet(rng, 2 + seed % 4, heads=heads, homes=None, precedence=True, nested=0.8)
        rules = Rules("travel", non_overlap=None, clear_rapids=True, parts_in_one_go=True)
        programme = assemble(instance, rules, "mtz", integer=False)
        values = drawn(rng, programme)
        page = page_of(instance, rules, programme)
        crossed = crossed_between(page)
        p = [values[f"p{h}"].tolist() for h in page.heads]
        expected = page.problem_rows(0.0, 0.0) | page.tour_rows("mtz", {"p": p})
        expected |= page.order_rows(p, crossed)
        if heads == 2:
            most = latest_time(programme.heads)
            expected |= page.clock_rows(values["s"].tolist(), most, crossed)
        assert_rows_are_those_of_the_page(residuals(programme), expected)


def crossed_between(page: Page) -> dict:
    """What each rapid between contours crosses, but for its ends, from the oracle's exact geometry."""
    found = {}
    for (a, one, b, other), crossed in sheet_of(page.instance).crossed.items():
        u, v = page.problem.node(a, one), page.problem.node(b, other)
        found[u, v] = set(crossed) - {a, b}
    return found


@pytest.mark.parametrize("heads", [1, 2])
def test_the_legs_left_out_are_those_of_the_page(heads):
    """Neighbours only and clear rapids bar rapids; a single closed tour begins with contour 0."""
    for seed in range(10):
        rng = np.random.default_rng((4, heads, seed))
        instance = random_sheet(rng, 1 + seed % 5, heads=heads, homes=False, nested=0.5)
        rules = Rules(non_overlap=None, neighbours_only=seed % 3 == 1, clear_rapids=seed % 3 == 2)
        page = page_of(instance, rules, values_of(assemble(instance, rules, "assignment", integer=False)))
        sheet, of = sheet_of(instance), page.of
        entry = [u - of.index(of[u]) for u in page.nodes]
        for u in page.nodes:
            for v in page.nodes:
                i, j = of[u], of[v]
                names = sheet.parts[i], sheet.parts[j]
                near = i == j or names[0] == names[1] or names in sheet.neighbours
                crosses = i != j and i in sheet.crossed[i, entry[u], j, entry[v]]
                barred = (rules.neighbours_only and not near) or (rules.clear_rapids and crosses)
                ordered = bool(rules.process or instance.precedence)
                fixed = heads == 1 and len(instance.contours) > 1 and not ordered
                closes = (j == 0 and i != 0) if fixed else (u == v or i != j)
                for h in page.heads:
                    assert ((h, u, v) in page.x) == (i != j and not barred)
                    assert ((h, u, v) in page.c) == closes


def values_of(programme: Programme) -> Programme:
    for head in programme.heads:
        head.x.value = np.zeros(head.x.shape)
    return programme
