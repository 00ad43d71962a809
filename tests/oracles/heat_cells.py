"""Peaks with each lag known only up to a cell: what the compact models under heat make of a plan.

Positions b < t, counted from 1. Of two in a row the lag is known. Else it is somewhere between the g - 1
least works and g least rapids and the g - 1 largest works and g largest rapids, g = t - b, and all that is
known of it is its cell, of so many that are equal in the root of time. Shares no code with the package.
"""

import math
from itertools import pairwise

from cutgap.instances import Instance
from oracles.heat import distances, kernel
from oracles.problem import Problem, Tour, plain_problem

NEAR = 1e-7
"""A lag so near to an edge may be in either cell."""

INFINITE = 1e6


class CellPeaks:
    """Lowest or highest peaks of plans, deg C, for lags in cells."""

    def __init__(self, instance: Instance, cells: int) -> None:
        assert instance.material is not None
        self.instance, self.cells, self.ambient = instance, cells, instance.material.ambient_c
        self.problem: Problem = plain_problem(instance)
        self.table = distances(instance)
        self.work = sorted(self.problem.work([i]) for i in range(len(self.problem.entries)))
        of = [i for i, points in enumerate(self.problem.entries) for _ in points]
        lengths = self.problem.lengths
        self.rapids = sorted(
            lengths[u][v] / self.problem.v_jump
            for u in range(len(of))
            for v in range(len(of))
            if of[u] != of[v]
        )

    def edges(self, gap: int) -> list[float]:
        least = sum(self.work[: gap - 1]) + gap * self.rapids[0]
        most = sum(self.work[::-1][: gap - 1]) + gap * self.rapids[-1]
        low, high = math.sqrt(least), math.sqrt(most)
        return [(low + (high - low) * c / self.cells) ** 2 for c in range(self.cells + 1)]

    def term(self, distance: float, lag: float, gap: int, above: bool) -> float:
        if gap == 1:
            return min(INFINITE, kernel(self.instance, distance, lag))
        found = []
        for low, high in pairwise(self.edges(gap)):
            if low - NEAR <= lag <= high + NEAR:
                times = [low, high, self.hottest(distance, low, high)] if above else [low, high]
                heats = [min(INFINITE, kernel(self.instance, distance, time)) for time in times]
                found.append(max(heats) if above else min(heats))
        # The solver takes the better of two cells.
        return min(found)

    def hottest(self, distance: float, low: float, high: float) -> float:
        """Return when the kernel, which rises and then falls, is highest, by thirds."""
        for _ in range(100):
            one, other = low + (high - low) / 3, high - (high - low) / 3
            if kernel(self.instance, distance, one) < kernel(self.instance, distance, other):
                low = one
            else:
                high = other
        return low

    def peak(self, tour: Tour, *, above: bool = False) -> float:
        nodes = [self.problem.node(*visit) for visit in tour]
        rapids = [self.problem.lengths[a][b] / self.problem.v_jump for a, b in pairwise(nodes)]
        warmest = 0.0
        for t in range(1, len(tour)):
            lag, rise = 0.0, 0.0
            for b in range(t - 1, -1, -1):
                lag += rapids[b]
                rise += self.term(self.table[(*tour[t], tour[b][0])], lag, t - b, above)
                lag += self.problem.work([tour[b][0]])
            warmest = max(warmest, rise)
        return self.ambient + warmest
