"""The readable model of links: agreement with brute force, statuses, the rows."""

import numpy as np
import pytest
from oracles.linked_strokes import least_value
from oracles.random_outlines import random_outlines

from cutgap.formulations import links_model
from cutgap.instances import Rules, Status


def random_rules(rng):
    objective = str(rng.choice(["travel", "makespan"]))
    return Rules(objective, links=True, pierces=[None, None, 1, 2][int(rng.integers(4))])


@pytest.mark.parametrize("seed", range(24))
def test_agrees_with_brute_force(seed):
    rng = np.random.default_rng(seed)
    instance = random_outlines(rng, int(rng.integers(1, 5)), entries=3)
    rules = random_rules(rng)
    result = links_model(instance, rules).solve()
    least = least_value(instance, rules)
    if least is None:
        assert result.status is Status.INFEASIBLE
        return
    assert result.status is Status.OPTIMAL
    assert result.value == pytest.approx(least, rel=1e-9)
    assert links_model(instance, rules).relax().safe_bound <= least
