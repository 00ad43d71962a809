"""Bounds on two heads without overlap from bounds on their tours: valid, tight with exact tours, certified."""

from dataclasses import replace

import numpy as np
import pytest
from oracles.brute_force import brute_force
from oracles.random_instances import LAYOUTS, random_instance

from cutgap.formulations.certificate import Refused, verify
from cutgap.formulations.relaxations.bound import Size
from cutgap.formulations.relaxations.connectivity import connectivity
from cutgap.formulations.relaxations.cycle_distances import cycle_distances
from cutgap.formulations.relaxations.held_karp import held_karp, held_karp_of_tour
from cutgap.formulations.relaxations.thresholds import bound_of_tours
from cutgap.formulations.relaxations.tour_proof import TourProof
from cutgap.instances import Head, Rules
from cutgap.instances.formats.json_format import format_instance

SEEDS = 4


def some_rules(rng):
    objective = str(rng.choice(["makespan", "travel", "weighted"]))
    return Rules(
        objective,
        weight=float(rng.choice([50.0, 600.0])) if objective == "weighted" else 0.0,
        non_overlap=float(rng.choice([0.0, 0.0, 30.0])),
        balance=float(rng.uniform(1, 8)) if rng.random() < 0.3 else None,
        via_points=bool(rng.random() < 0.4),
        empty_heads=bool(rng.random() < 0.4),
    )


def some_part(seed, layout, holes):
    """Heads with and without home; a third has random lengths, which are no metric."""
    rng = np.random.default_rng((seed, LAYOUTS.index(layout)))
    if seed % 3 < 2:
        return random_instance(rng, holes, layout=layout, homes=None)
    part = random_instance(rng, holes, layout=layout, homes=True, metric="matrix")
    return replace(part, matrix=np.minimum(part.matrix, part.matrix.T))


def checked(bound, part, rules):
    """The bound, verified and compared, and the optimum; ``None`` for what does not exist."""
    proved = verify(bound.certificate, format_instance(part)).bound
    best = brute_force(part, rules)
    if bound.bound is None:
        assert proved is None
        assert best is None
        return None, None
    assert 0 <= bound.bound <= proved
    # With a balance limit there may be no plan though each division has tours.
    assert best is None or bound.bound <= best.value * (1 + 1e-12)
    return bound.bound, None if best is None else best.value


@pytest.mark.parametrize("relaxation", [held_karp, connectivity, cycle_distances])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_two_heads_stay_below_the_optimum(relaxation, layout):
    for seed in range(SEEDS):
        rng = np.random.default_rng((seed, LAYOUTS.index(layout)))
        part, rules = some_part(seed, layout, int(rng.integers(1, 7))), some_rules(rng)
        checked(relaxation(part, rules), part, rules)


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("via", [False, True])
def test_exact_tours_give_the_optimum(layout, via):
    """Up to five nodes the subtour program finds shortest tours, so the least division is the best plan."""
    for seed, objective in enumerate(("makespan", "travel", "weighted")):
        rules = Rules(objective, weight=40.0 * (objective == "weighted"), via_points=via)
        part = some_part(seed, layout, 4)
        bound, best = checked(held_karp(part, rules), part, rules)
        assert bound == pytest.approx(best, rel=1e-9, abs=1e-6)


def test_no_division_at_all():
    part = random_instance(np.random.default_rng(0), 4, layout="uniform")
    bound = held_karp(part, Rules(non_overlap=1e6))
    assert bound.bound is None
    assert verify(bound.certificate, format_instance(part)).bound is None


def test_only_what_holds_the_bound_down_is_solved():
    part = random_instance(np.random.default_rng(1), 25, layout="uniform")
    calls = []

    def counted(lengths, via):
        calls.append(len(lengths))
        return held_karp_of_tour(lengths, via)

    bound = bound_of_tours(part, Rules(), "counted", counted)
    assert 0 < len(calls) < 12 < 2 * 24
    assert bound.nonzeros > 0
    assert bound.bound == held_karp(part, Rules()).bound


def test_no_time_leaves_a_bound_from_the_work():
    part = random_instance(np.random.default_rng(2), 6, layout="uniform")
    none, all_of_it = (held_karp(part, Rules(), time_limit=limit) for limit in (0.0, None))
    left = np.cumsum(part.service_times[np.argsort(part.points[:6, 0])])[:-1]
    assert none.bound == pytest.approx(np.maximum(left, part.service_times.sum() - left).min(), rel=1e-6)
    assert none.bound < all_of_it.bound
    assert none.variables == 0
    verify(none.certificate, format_instance(part))


def test_a_wrong_solver_cannot_raise_the_bound():
    """Its word counts for nothing: multipliers decide, and wild ones prove little."""
    part = random_instance(np.random.default_rng(3), 6, layout="uniform", heads=1)
    rng = np.random.default_rng(4)
    for _ in range(10):
        rows = tuple((["degree", v], float(rng.normal(0, 1e4))) for v in range(7))
        wild = TourProof(1e9, Size(1, 1, 1), (*rows, (["connectivity", rng.integers(-9, 9, 7).tolist()], 1e3)))
        bound = bound_of_tours(part, Rules("travel"), "wild", lambda lengths, via, wild=wild: wild)
        checked(bound, part, Rules("travel"))


def test_a_higher_claim_is_refused():
    part = random_instance(np.random.default_rng(5), 8, layout="grid")
    bound = cycle_distances(part, Rules())
    more = bound.certificate | {"bound": bound.certificate["bound"] + 10**6}
    with pytest.raises(Refused, match="below the claimed"):
        verify(more, format_instance(part))


def test_three_heads_are_refused():
    part = random_instance(np.random.default_rng(0), 4)
    three = replace(part, heads=(*part.heads, Head("third")))
    with pytest.raises(ValueError, match="one head or two, got 3"):
        held_karp(three, Rules())


def test_too_many_nodes_name_the_head():
    part = random_instance(np.random.default_rng(0), 70, layout="uniform")
    with pytest.raises(ValueError, match=r"cycle-distances, head \d: a tour of \d+ nodes is too large"):
        cycle_distances(part, Rules())
