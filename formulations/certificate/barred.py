"""Steps of walks that process rules on curves forbid: to parts that are no neighbours, across what is cut."""

from cutgap.formulations.certificate.curves import Curves
from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.rules import Rules
from cutgap.formulations.certificate.walks import Visit, Walks

INFINITE = 10**100
"""Cost of what is forbidden."""


class Barred:
    """What is forbidden among the walks from a beginning; without ``curves`` nothing is."""

    def __init__(
        self, problem: Problem, rules: Rules, walks: Walks, beginning: Visit | None, curves: Curves | None
    ) -> None:
        self.problem, self.rules, self.walks = problem, rules, walks
        self.beginning, self.curves = beginning, curves

    def may_follow(self, a: int, b: int) -> bool:
        """Whether contour b of the walk may come right after contour a, as to their parts."""
        return self._are_neighbours(self.walks.contours[a], self.walks.contours[b])

    def _are_neighbours(self, one: int, other: int) -> bool:
        parts = self.problem.parts
        if self.curves is None or not self.rules.neighbours_only or parts[one] == parts[other]:
            return True
        return self.curves.neighbours(parts[one], parts[other])

    def first(self, a: int, row: list[int]) -> list[int]:
        """Return the costs of beginning at the nodes of contour a; the way from a home crosses nothing cut."""
        if self.curves is None or self.beginning is None:
            return row
        contour, node = self.beginning
        if not self._are_neighbours(contour, self.walks.contours[a]):
            return [INFINITE] * len(row)
        return [
            INFINITE if self._crosses(node, w, 1 << contour) else cost
            for cost, w in zip(row, self.walks.nodes[a], strict=True)
        ]

    def steps(self, a: int, b: int, cut: int) -> list[list[int]]:
        """Return the costs of the steps from a to b, as ``Walks.steps``, when ``cut`` of the walk is cut."""
        costs = self.walks.steps[a][b]
        if self.curves is None:
            return costs
        if not self.may_follow(a, b):
            return [[INFINITE] * len(leg) for leg in costs]
        if not self.rules.clear_rapids:
            return costs
        done = self._in_instance(cut)
        return [
            [
                INFINITE if self._crosses(v, w, done) else cost
                for cost, v in zip(leg, self.walks.nodes[a], strict=True)
            ]
            for leg, w in zip(costs, self.walks.nodes[b], strict=True)
        ]

    def _crosses(self, v: int, w: int, cut: int) -> bool:
        assert self.curves is not None
        return self.rules.clear_rapids and self.curves.crossed(v, w) & cut != 0

    def _in_instance(self, cut: int) -> int:
        """Return a set of the walk's contours, and what a closed tour began with, in the instance's numbers."""
        done = sum(1 << c for number, c in enumerate(self.walks.contours) if cut >> number & 1)
        return done if self.beginning is None else done | 1 << self.beginning[0]
