"""Exact methods that start from a heuristic's plan leave themselves time."""

import numpy as np
import pytest

from cutgap.benchmark.methods import STARTER_SHARE, STARTERS, run
from cutgap.heuristics import HEURISTICS, Heuristic
from cutgap.instances import Contour, Head, Instance, Rules


@pytest.mark.parametrize(
    ("method", "rules", "heads"),
    [("links", Rules("travel", links=True), 1), ("free", Rules(non_overlap=None), 2)],
)
def test_a_starter_gets_a_share_of_the_limit(monkeypatch, method, rules, heads):
    limits = []
    name = STARTERS[method]
    make = HEURISTICS[name].make

    def noted(instance, rules, *, time_limit=None, **options):
        limits.append(time_limit)
        return make(instance, rules, time_limit=time_limit, **options)

    monkeypatch.setitem(HEURISTICS, name, Heuristic(noted, HEURISTICS[name].applies))
    contours = tuple(
        Contour(str(x), np.array([[x, 0, 0]]), 3.0, geometry=np.array([[x, 0], [x + 1, 0], [x, 1]]))
        for x in (0.0, 5.0, 11.0, 18.0)
    )
    homes = [Head(str(x), np.array([x, -5.0, 0.0])) for x in range(heads)]
    result = run(method, Instance("row", contours, tuple(homes)), rules, time_limit=240.0)
    assert limits == [STARTER_SHARE * 240.0]
    assert result.status == "optimal"
