"""Relaxations: their multipliers prove their value, and they are as strong as theory says."""

from itertools import pairwise

import numpy as np
import pytest
from oracles.random_instances import random_instance
from oracles.random_sheets import random_sheet

from cutgap.formulations.compact import TOUR_FORMULATIONS, Size, compact_model
from cutgap.formulations.compact.programme import MatrixForm, assemble, matrix_form
from cutgap.instances import Contour, Head, Instance, Rules


def proved(form: MatrixForm, multipliers: dict) -> float:
    """The bound of weak duality; y is free, so rows that define it take what makes its reduced cost 0."""
    given = np.array([multipliers.get(name, 0.0) for name in form.names])
    assert (given[~form.is_equation] >= 0.0).all()
    reduced = form.costs - form.matrix.T @ given
    free = np.flatnonzero(~np.isfinite(form.lower) & ~np.isfinite(form.upper))
    ties = form.matrix.toarray()[[name == ("definition",) for name in form.names]]
    if len(free):
        reduced = reduced - ties.T @ np.linalg.solve(ties[:, free].T, reduced[free])
    assert reduced[~np.isfinite(form.upper)] == pytest.approx(
        np.maximum(reduced[~np.isfinite(form.upper)], 0.0), abs=1e-6
    )
    ends = np.where(reduced > 0.0, form.lower, np.where(np.isfinite(form.upper), form.upper, 0.0))
    ends[free] = 0.0
    return float(given @ form.right + reduced @ ends)


def small_problem(seed: int, heads: int) -> tuple[Instance, Rules]:
    rng = np.random.default_rng((heads, seed))
    if seed % 2:
        instance = random_sheet(rng, 4, heads=heads, homes=None, entries=2, precedence=True)
        rules = Rules("travel", clear_rapids=True, parts_in_one_go=True, non_overlap=None)
        return instance, rules
    instance = random_instance(rng, 5, heads=heads, layout="uniform", entries=1 + seed // 2 % 2)
    weighted = seed % 4 == 0
    return instance, Rules(
        "weighted" if weighted else "makespan", 50.0 if weighted else 0.0, balance=9.0, via_points=True
    )


@pytest.mark.parametrize("formulation", TOUR_FORMULATIONS)
@pytest.mark.parametrize("heads", [1, 2])
def test_multipliers_prove_the_value(heads, formulation):
    for seed in range(4):
        instance, rules = small_problem(seed, heads)
        model = compact_model(instance, rules, formulation)
        relaxation = model.relax()
        if relaxation.infeasible:
            assert (relaxation.value, relaxation.lower_bound, relaxation.multipliers) == (None, None, {})
            continue
        form = matrix_form(assemble(instance, rules, formulation, integer=False, sets=relaxation.sets))
        assert {name for name in form.names if name != ("definition",)} == set(relaxation.multipliers)
        assert relaxation.size == Size(form.matrix.shape[1], form.matrix.shape[0], form.matrix.nnz)
        assert proved(form, relaxation.multipliers) == pytest.approx(relaxation.value, rel=1e-6, abs=1e-6)


def test_the_point_of_a_relaxation_is_feasible_and_costs_its_value():
    instance = random_instance(np.random.default_rng(2), 6, layout="uniform", heads=1, entries=2)
    relaxation = compact_model(instance, Rules("travel"), "multi-commodity").relax()
    lengths = {name: instance.rapid_length(*name[2:]) for name in relaxation.point}
    total = sum(lengths[name] * value for name, value in relaxation.point.items())
    assert total == pytest.approx(relaxation.value)
    assert {name[:2] for name in relaxation.point} == {("x", 0)}
    entered = [
        sum(v for name, v in relaxation.point.items() if name[3] in nodes) for nodes in clusters(instance)
    ]
    assert entered == pytest.approx([1.0] * 6)


def clusters(instance: Instance) -> list[range]:
    first = instance.first_node.tolist()
    return [range(a, b) for a, b in pairwise(first)]


ORDERED = [
    ("dfj", "single-commodity"),
    ("single-commodity", "two-commodity"),
    ("two-commodity", "mtz"),
    ("time-indexed", "single-commodity"),
    ("lifted-mtz", "mtz"),
    ("mtz", "assignment"),
]
EQUAL = [("dfj", "multi-commodity"), ("dfj", "dfj-rounds")]


@pytest.mark.parametrize("heads", [1, 2])
def test_strength(heads):
    """Each order holds on every instance, and is strict on some."""
    strict = set()
    for seed in range(6):
        rng = np.random.default_rng((heads, seed))
        metric = ("euclidean", "matrix")[seed % 2]
        instance = random_instance(
            rng, 7 - heads, layout="uniform", heads=heads, metric=metric, homes=None, entries=1 + seed % 3 // 2
        )
        rules = Rules("travel", non_overlap=None, empty_heads=seed == 5)
        value = {name: compact_model(instance, rules, name).relax().value for name in TOUR_FORMULATIONS}
        slack = 1e-5 * value["dfj"]
        for strong, weak in ORDERED:
            assert value[strong] >= value[weak] - slack, (strong, weak, value)
            strict |= {(strong, weak)} if value[strong] > value[weak] + slack else set()
        for one, other in EQUAL:
            assert value[one] == pytest.approx(value[other], abs=slack)
    # What lifting adds for two heads is almost nothing, as is what MTZ adds to the assignment.
    assert strict >= set(ORDERED[:4] if heads == 2 else ORDERED)


def test_rounds_name_the_rows_of_dfj():
    instance = random_instance(np.random.default_rng(4), 8, layout="uniform", heads=2)
    rounds = compact_model(instance, Rules("travel"), "dfj-rounds").relax()
    listed = compact_model(instance, Rules("travel"), "dfj").relax()
    entered = {name for name in rounds.multipliers if name[0] == "enter"}
    assert rounds.rounds > 1
    assert entered
    assert entered < {name for name in listed.multipliers if name[0] == "enter"}
    assert rounds.size.constraints < listed.size.constraints


def test_sizes_count_variables_rows_and_entries():
    """One head with a home, n contours of one entry point: n (n + 1) legs, 2 n + 1 rows of the problem."""
    instance = random_instance(np.random.default_rng(0), 5, layout="uniform", heads=1)
    assert compact_model(instance, Rules("travel"), "assignment").size() == Size(30, 11, 25 + 50 + 5)
    sizes = {name: compact_model(instance, Rules("travel"), name).size() for name in TOUR_FORMULATIONS}
    assert sizes["mtz"] == Size(35, 11 + 20, 80 + 20 * 3)
    assert sizes["single-commodity"].variables == 30 + 25
    assert sizes["multi-commodity"].constraints == 11 + 5 * 5 + 5 * 25
    assert sizes["dfj"].constraints == 11 + 2**5 - 1 - 5
    assert sizes["dfj-rounds"] == sizes["assignment"]


def test_an_interior_point_solver_gives_the_same_value():
    instance = random_instance(np.random.default_rng(6), 5, layout="uniform", entries=2)
    model = compact_model(instance, Rules(), "multi-commodity")
    other = model.relax("CLARABEL")
    assert other.value == pytest.approx(model.relax().value, rel=1e-6)
    form = model.matrix_form()
    assert proved_loosely(form, other.multipliers) == pytest.approx(other.value, rel=1e-4)


def proved_loosely(form: MatrixForm, multipliers: dict) -> float:
    """Weak duality with reduced costs that are 0 up to the solver's tolerance."""
    tidy = {name: value if abs(value) > 1e-7 else 0.0 for name, value in multipliers.items()}
    return proved(form, tidy)


def test_a_relaxation_without_a_point():
    """A head whose home is a thousand kilometres away cannot be done within a second of the other."""
    contours = tuple(Contour(f"c{i}", [[10.0 * i, 0.0, 0.0]], 40.0) for i in range(3))
    heads = (Head("near", [0.0, 0.0, 0.0]), Head("far", [1e9, 0.0, 0.0]))
    model = compact_model(Instance("far", contours, heads), Rules("travel", balance=1.0), "mtz")
    relaxation = model.relax()
    assert (relaxation.infeasible, relaxation.value, relaxation.lower_bound) == (True, None, None)
    assert (relaxation.point, relaxation.multipliers) == ({}, {})
    assert relaxation.reason == "HIGHS claims that there is no plan"
    assert model.solve().status == "infeasible"
