"""The front of travel against imbalance agrees with brute force, point by point."""

import numpy as np
import pytest
from oracles.brute_force import AllPlans
from oracles.random_instances import random_instance

from cutgap.formulations.certificate import verify
from cutgap.formulations.pareto import pareto_front
from cutgap.instances import Rules
from cutgap.instances.formats.json_format import format_instance


@pytest.mark.parametrize("seed", range(4))
def test_each_point_is_the_least_travel_under_its_limit(seed):
    rng = np.random.default_rng(seed)
    part = random_instance(rng, 6, layout="uniform")
    plans = AllPlans(part)
    results = list(pareto_front(part, Rules(), points=4))
    assert len(results) == 4
    assert results[0].rules.balance is None
    for result in results:
        best = plans.best(result.rules)
        if best is None:
            assert result.status == "infeasible"
            continue
        assert result.status == "optimal"
        assert result.value == pytest.approx(best.value, rel=1e-6)
        assert result.certificate is not None
        assert verify(result.certificate, format_instance(part)).bound <= best.value * (1 + 1e-9)


def test_negative_limits_are_refused():
    part = random_instance(np.random.default_rng(0), 4, layout="uniform")
    with pytest.raises(ValueError, match="balance"):
        list(pareto_front(part, Rules(), limits=[-1.0]))
