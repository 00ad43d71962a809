"""One head: the shortest tour agrees with brute force and dynamic programming, and is certified."""

import numpy as np
import pytest
from oracles.brute_force import brute_force
from oracles.held_karp import shortest_tour
from oracles.random_instances import LAYOUTS, random_instance

from cutgap.formulations import solve
from cutgap.formulations.certificate import verify
from cutgap.instances import Rules
from cutgap.instances.formats.json_format import format_instance


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("layout", LAYOUTS)
def test_agrees_with_brute_force(layout, seed):
    rng = np.random.default_rng((seed, LAYOUTS.index(layout)))
    part = random_instance(rng, int(rng.integers(0, 7)), layout=layout, heads=1, homes=None)
    rules = Rules(str(rng.choice(["makespan", "travel"])), via_points=bool(rng.integers(2)))
    best = brute_force(part, rules)
    result = solve(part, rules, certify=True)
    assert (result.status, result.method) == ("optimal", "tour")
    assert result.value == pytest.approx(best.value, abs=1e-6)
    assert result.certificate is not None
    bound = verify(result.certificate, format_instance(part)).bound
    assert best.value - 1e-4 <= float(bound) <= best.value * (1 + 1e-12)


def test_agrees_with_dynamic_programming():
    part = random_instance(np.random.default_rng(1), 11, layout="uniform", heads=1, homes=True)
    length, _ = shortest_tour(part.rapids.tolist())
    assert solve(part, Rules("travel")).value == pytest.approx(length)


def test_a_stopped_run_keeps_plan_and_bound():
    part = random_instance(np.random.default_rng(2), 150, layout="uniform", heads=1, homes=True)
    result = solve(part, Rules("travel"), time_limit=1e-3, certify=True)
    assert result.plan is not None
    assert 0 < result.lower_bound <= result.value
    assert result.certificate is not None


def test_two_heads_are_refused():
    part = random_instance(np.random.default_rng(0), 4)
    with pytest.raises(ValueError, match="one head"):
        solve(part, Rules(), method="tour")
