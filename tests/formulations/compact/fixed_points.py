"""Models with x held at a point: which points they keep, and at which value."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import permutations, product

import cvxpy as cp
import numpy as np

from cutgap.formulations.compact.programme import Programme
from cutgap.formulations.compact.solvers import Outcome, run
from cutgap.instances import Instance, Plan, Visit


class Held:
    """A programme whose x is held; compiled once."""

    def __init__(self, programme: Programme, without: Iterable[str] = ()) -> None:
        self.programme = programme
        self.points = [cp.Parameter(len(head.network.tails)) for head in programme.heads]
        rows = [each.constraint for each in programme.families if each.name not in set(without)]
        ties = [row for head in programme.heads for row in head.definitions]
        held = [head.x == point for head, point in zip(programme.heads, self.points, strict=True)]
        self.problem = cp.Problem(cp.Minimize(programme.objective), rows + ties + held)

    def at(self, points: Sequence[np.ndarray]) -> Outcome:
        for parameter, point in zip(self.points, points, strict=True):
            parameter.value = point
        return run(self.problem, "HIGHS", None, integer=False)

    def at_plan(self, plan: Plan) -> Outcome | None:
        """``None`` when the plan takes a leg that there is none of."""
        legs = [
            network.legs_of(tour) for network, tour in zip(self.programme.networks, plan.tours, strict=True)
        ]
        return None if any(each is None for each in legs) else self.at(legs)

    def keeps(self, plan: Plan) -> bool:
        outcome = self.at_plan(plan)
        assert outcome is None or outcome.state in ("optimal", "infeasible")
        return outcome is not None and outcome.state == "optimal"


def point_of(programme: Programme, head: int, legs: Iterable[tuple[int, int]]) -> np.ndarray:
    """x of a head that takes some rapids, each (node, node)."""
    network = programme.heads[head].network
    wanted = set(legs)
    taken = [
        pair in wanted and not closes
        for *pair_, closes in zip(
            network.tails.tolist(), network.heads.tolist(), network.closing.tolist(), strict=True
        )
        for pair in [tuple(pair_)]
    ]
    assert sum(taken) == len(wanted)
    return np.array(taken, dtype=float)


def all_plans(instance: Instance) -> Iterator[Plan]:
    """Every plan that cuts each contour once: orders, entry points, heads."""
    count, heads = len(instance.contours), len(instance.heads)
    choices = [range(len(contour.entry_points)) for contour in instance.contours]
    for order in permutations(range(count)):
        for cut in range(count + 1) if heads == 2 else [count]:
            for entries in product(*choices):
                visits = [Visit(contour, entries[contour]) for contour in order]
                yield Plan((tuple(visits[:cut]), tuple(visits[cut:]))[:heads])
