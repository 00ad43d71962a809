"""Via points and equal x together: what bounds the right head while holes are still free."""

import numpy as np
import pytest
from oracles.brute_force import brute_force

from cutgap.formulations import solve
from cutgap.formulations.certificate import verify
from cutgap.instances import Contour, Head, Instance, Machine, Rules
from cutgap.instances.formats.json_format import format_instance


def square(side: float) -> Instance:
    """Without the hole at its home the right head would have to cross the square to its leftmost hole."""
    points = [(0, -10, 0), (0, 0, 0), (1, side, side), (2, 0, side), (3, side, 0)]
    contours = tuple(Contour(f"c{i}", np.array([point], dtype=float), 0.0) for i, point in enumerate(points))
    heads = (Head("left", np.array([0.0, -10.0, 0.0])), Head("right", np.zeros(3)))
    return Instance("square", contours, heads, Machine())


@pytest.mark.parametrize("objective", ["travel", "makespan"])
def test_a_free_hole_may_become_the_via_point(objective):
    instance, rules = square(100.0), Rules(objective, via_points=True)
    best = brute_force(instance, rules)
    result = solve(instance, rules, method="split", certify=True)
    assert result.value == pytest.approx(best.value)
    assert result.lower_bound == pytest.approx(best.value)
    assert result.certificate is not None
    assert verify(result.certificate, format_instance(instance)).bound <= best.value
