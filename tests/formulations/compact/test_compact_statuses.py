"""What a solver says is never passed on: statuses, limits, missing solvers, and what is refused."""

from dataclasses import replace

import cvxpy as cp
import numpy as np
import pytest
from oracles.random_instances import random_instance

from cutgap.formulations.compact import TOUR_FORMULATIONS, compact_model, solving
from cutgap.formulations.compact.solvers import AGREEMENT, Outcome
from cutgap.formulations.compact.tours import MOST_CONTOURS
from cutgap.instances import Contour, Head, Instance, Machine, Plan, Rules, check, evaluate

EXACT = [name for name in TOUR_FORMULATIONS if name != "assignment"]


def instance_of(holes: int = 5, heads: int = 2, **options) -> Instance:
    return random_instance(np.random.default_rng(3), holes, layout="uniform", heads=heads, **options)


@pytest.mark.parametrize("formulation", EXACT)
def test_a_limit_without_a_plan_is_unknown(formulation):
    """cvxpy hands over zeros here; they are no plan."""
    result = compact_model(instance_of(), Rules(), formulation).solve(time_limit=0.0)
    assert (result.status, result.plan, result.value) == ("unknown", None, None)
    assert result.reason == "stopped by the time limit without a plan"


def test_a_relaxation_that_is_stopped_has_no_value():
    relaxation = compact_model(instance_of(), Rules(), "mtz").relax(time_limit=0.0)
    assert (relaxation.value, relaxation.lower_bound, relaxation.infeasible) == (None, None, False)
    assert (relaxation.point, relaxation.multipliers) == ({}, {})
    assert relaxation.reason.startswith("stopped by the time limit")


def stub_run(monkeypatch, change) -> None:
    """Let the solver tell something else than it found."""
    true_run = solving.run
    monkeypatch.setattr(solving, "run", lambda *a, **k: change(true_run(*a, **k)))


def test_stopped_rounds_keep_the_bound_of_the_relaxation(monkeypatch):
    instance = instance_of(8)
    relaxation = compact_model(instance, Rules("travel"), "dfj-rounds").relax()
    stub_run(monkeypatch, lambda outcome: replace(outcome, state="stopped", value=None, bound=None))
    result = compact_model(instance, Rules("travel"), "dfj-rounds").solve()
    assert (result.status, result.lower_bound) == ("unknown", relaxation.lower_bound)
    assert relaxation.lower_bound == pytest.approx(relaxation.value, rel=1e-6)


def test_an_optimum_that_is_not_the_plans_value_is_no_bound(monkeypatch):
    instance, rules = instance_of(), Rules()
    true = compact_model(instance, rules, "mtz").solve()
    assert true.lower_bound == true.value
    low = 0.9 * true.value
    stub_run(monkeypatch, lambda outcome: replace(outcome, value=low, bound=low))
    result = compact_model(instance, rules, "mtz").solve()
    assert (result.status, result.value) == ("feasible", true.value)
    assert result.lower_bound == pytest.approx(low, rel=1e-6)
    assert result.lower_bound < low


def test_a_bound_above_the_plan_is_not_reported(monkeypatch):
    instance = instance_of()
    stub_run(monkeypatch, lambda outcome: replace(outcome, state="stopped", bound=1e6))
    result = compact_model(instance, Rules(), "mtz").solve()
    assert result.lower_bound <= result.value


def test_without_a_bound_of_the_solver_there_is_none(monkeypatch):
    stub_run(monkeypatch, lambda outcome: replace(outcome, state="stopped", bound=None))
    result = compact_model(instance_of(), Rules(), "mtz").solve()
    assert (result.status, result.lower_bound, result.reason) == ("feasible", None, "stopped by the time limit")


def test_what_is_no_tour_is_no_plan(monkeypatch):
    """Halves, cycles, two beginnings: whatever state the solver claims."""
    instance = instance_of(4, heads=1)
    network = compact_model(instance, Rules()).programme().networks[0]
    tour = Plan.of_contours([[2, 0, 3, 1]]).tours[0]
    x = network.legs_of(tour)
    assert network.tour_of(x) == tour
    assert network.tour_of(np.zeros(len(x))) == ()
    home = instance.home_node(0)
    pairs = list(zip(network.tails.tolist(), network.heads.tolist(), strict=True))
    for extra in ((0, 2), (home, 1), (1, 3), (0, home)):
        worse = x.copy()
        worse[pairs.index(extra)] = 1.0
        assert network.tour_of(worse) is None
    for missing in ((home, 2), (0, 3), (1, home)):
        worse = x.copy()
        worse[pairs.index(missing)] = 0.0
        assert network.tour_of(worse) is None
    cycle = np.zeros(len(x))
    for pair in ((home, 0), (0, home), (1, 2), (2, 1)):
        cycle[pairs.index(pair)] = 1.0
    assert network.tour_of(cycle) is None
    monkeypatch.setattr(solving, "plan_of", lambda *_: None)
    result = compact_model(instance, Rules(), "mtz").solve()
    assert (result.status, result.plan) == ("unknown", None)
    assert result.reason == "what HIGHS calls optimal is no plan"
    assert result.lower_bound > 0.0


def test_a_solver_that_fails_is_unknown(monkeypatch):
    monkeypatch.setattr(solving, "run", lambda *a, **k: Outcome("failed", message="out of memory"))
    result = compact_model(instance_of(), Rules(), "mtz").solve()
    assert (result.status, result.lower_bound, result.reason) == (
        "unknown",
        None,
        "HIGHS failed: out of memory",
    )


def test_a_tie_between_heads_is_solved_again_with_a_margin():
    """One head would go from c to a across b at 1 s, as the other is done with b: the model lets it pass."""
    square = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])
    contours = tuple(
        Contour(name, [[x, 0, 0]], 0.0, geometry=square + np.array([x, 0.0]))
        for name, x in zip("abc", (0.0, 20.0, 40.0), strict=True)
    )
    far = np.array([[0.0, 500.0, 20.0], [500.0, 0.0, 500.0], [20.0, 500.0, 0.0]])
    machine = Machine(v_jump=10.0, t_aux=1.0, metric="matrix")
    sheet = Instance("row", contours, (Head("l"), Head("r")), machine, precedence=((2, 0),), matrix=far)
    rules = Rules("travel", non_overlap=None, clear_rapids=True)
    tied = Plan.of_contours([[2, 0], [1]])
    assert [violation.constraint for violation in check(sheet, rules, tied)] == ["clear rapids"]
    result = compact_model(sheet, rules, "mtz").solve()
    assert (result.status, result.violations) == ("feasible", ())
    assert result.lower_bound == pytest.approx(evaluate(sheet, tied).total_travel_mm, rel=2 * AGREEMENT)
    assert "tie" in result.reason


def test_a_missing_solver_is_named_with_those_that_are_there():
    model = compact_model(instance_of(), Rules())
    with pytest.raises(ValueError, match=r"'NONE' is not installed; .*mixed-integer.*: HIGHS"):
        model.solve("NONE")
    with pytest.raises(ValueError, match=r"'NONE' is not installed; installed solvers of linear .*CLARABEL"):
        model.relax("NONE")
    with pytest.raises(ValueError, match="'CLARABEL' takes none; installed solvers of mixed-integer"):
        model.solve("CLARABEL")
    with pytest.raises(ValueError, match="'CLARABEL': no time limit is known"):
        model.relax("CLARABEL", time_limit=1.0)
    empty = replace(instance_of(), contours=())
    with pytest.raises(ValueError, match="not installed"):
        compact_model(empty, Rules()).relax("NONE")


def test_what_is_refused():
    with pytest.raises(ValueError, match=r"expected one of assignment, mtz, .*got 'lp'"):
        compact_model(instance_of(), Rules(), "lp")
    with pytest.raises(ValueError, match="needs one or two heads, got 3"):
        compact_model(instance_of(heads=3), Rules())
    with pytest.raises(ValueError, match="'assignment' leaves cycles"):
        compact_model(instance_of(), Rules(), "assignment").solve()
    matrix = replace(instance_of(metric="matrix"), located=False)
    with pytest.raises(ValueError, match="no coordinates"):
        compact_model(matrix, Rules())


@pytest.mark.parametrize("formulation", TOUR_FORMULATIONS)
def test_too_large_a_model_is_refused_with_its_limit(formulation):
    most = MOST_CONTOURS[formulation]
    with pytest.raises(ValueError, match=rf"{most + 1} contours .*{formulation}, the limit is {most}"):
        compact_model(instance_of(most + 1), Rules(), formulation)
    compact_model(instance_of(most), Rules(), formulation)


def test_too_many_legs_are_refused():
    contours = tuple(Contour(f"c{i}", np.zeros((350, 3)), 1.0) for i in range(2))
    with pytest.raises(ValueError, match=r"490000 legs .*limit is 400000"):
        compact_model(Instance("dense", contours, (Head("h"),)), Rules())


def test_nothing_to_cut():
    for heads in (1, 2):
        model = compact_model(instance_of(0, heads=heads), Rules(), "mtz")
        result = model.solve()
        assert (result.status, result.value, result.plan) == ("optimal", 0.0, Plan(((),) * heads))
        assert (model.relax().value, model.size().variables) == (0.0, 0)


def test_sign_of_multipliers_against_a_programme_by_hand():
    """min 2 a + b, a + b = 1, a >= 1/4: multipliers 1 of the equation and 1 of the row."""
    from cutgap.formulations.compact.family import family

    a, b = cp.Variable(1, nonneg=True), cp.Variable(1, nonneg=True)
    families = [family("sum", (), [0], a + b == 1), family("least", (3,), [(1, 2)], a >= 0.25)]
    cp.Problem(cp.Minimize(cp.sum(2 * a + b)), [each.constraint for each in families]).solve("HIGHS")
    assert families[0].multipliers() == {("sum", 0): pytest.approx(1.0)}
    assert families[1].multipliers() == {("least", 3, 1, 2): pytest.approx(1.0)}
    with pytest.raises(ValueError, match="2 names for shape"):
        family("sum", (), [0, 1], a == 1)
