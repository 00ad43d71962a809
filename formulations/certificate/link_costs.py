"""What links and rapids cost at least, in whole units, for proofs about plans with links."""

from fractions import Fraction
from math import floor, isqrt, lcm

from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.rules import Rules

LINK, RAPID, DOUBLE = "s", "r", "d"
"""Kinds of variables: s of links, s of rapids, d."""

Edge = tuple[str, int, int]
Triple = tuple[int, int, int]


class Costs:
    """What links and rapids cost at least, in whole units, and what is known of links."""

    def __init__(self, problem: Problem, rules: Rules, scale: int, costless: bool) -> None:
        self.problem, self.scale, self.costless = problem, scale, costless
        self.home_node = len(problem.xs)
        self.members = [*problem.entries, range(self.home_node, self.home_node + 1)]
        self.home = len(self.members) - 1
        self.place_of = [place for place, nodes in enumerate(self.members) for _ in nodes]
        timed = rules.objective == "makespan"
        self.ratio = problem.v_jump / problem.v_cut if timed else Fraction(1)
        self.pierce = problem.t_aux * problem.v_jump if timed else Fraction(0)
        self.no_rapids = rules.pierces == 1
        points = [point for contour in problem.contours for point in contour[1]]
        self.unit = lcm(1, *(value.denominator for point in points for value in point))
        self.points = [tuple(int(value * self.unit) for value in point) for point in points]
        self.blocked: set[tuple[int, int]] = set()
        self._links: dict[tuple[int, int], int] = {}
        self._cheapest: dict[tuple[int, int], int | None] = {}

    def _square(self, p: int, q: int) -> int:
        return sum((a - b) ** 2 for a, b in zip(self.points[p], self.points[q], strict=True))

    def _link(self, square: int) -> int:
        """Return the cost of a link by the square of its length."""
        factor = (self.scale * self.ratio / self.unit) ** 2
        return 0 if self.costless else isqrt(square * factor.numerator // factor.denominator)

    def link(self, p: int, q: int) -> int:
        """Return the cost of a link."""
        if (p, q) not in self._links:
            self._links[p, q] = self._link(self._square(p, q))
        return self._links[p, q]

    def rapid(self, p: int, q: int) -> int:
        """Return the cost of a rapid, with half a pierce for each end at a contour."""
        if self.costless:
            return 0
        ends = 1 if q == self.home_node else 2
        return self.problem.lengths(p, [q], self.scale)[0] + floor(self.scale * self.pierce * ends / 2)

    def replaces(self, p: int, q: int) -> bool:
        """Whether a link costs no more than the rapid, exactly; known for Euclidean rapids alone."""
        if self.problem.metric != "euclidean":
            return False
        more = max(self.ratio - 1, Fraction(0))
        return self._square(p, q) * more * more <= (self.pierce * self.unit) ** 2

    def joined(self, p: int, q: int) -> bool:
        """Whether only one of link and rapid is there."""
        return q < self.home_node and not self.no_rapids and self.replaces(p, q)

    def least(self, i: int, j: int) -> tuple[int, int]:
        """Return what any link, and any rapid, between two contours costs at least."""
        square = sum(
            max(low - other_high, other_low - high, 0) ** 2
            for (low, high), (other_low, other_high) in zip(self._box(i), self._box(j), strict=True)
        )
        rapid = 0 if self.costless else floor(self.scale * self.pierce)
        if self.problem.metric == "euclidean" and not self.costless:
            rapid += isqrt(square * self.scale**2 // self.unit**2)
        return self._link(square), rapid

    def _box(self, contour: int) -> list[tuple[int, int]]:
        sides = zip(*(self.points[p] for p in self.members[contour]), strict=True)
        return [(min(side), max(side)) for side in map(list, sides)]

    def double(self, i: int, j: int) -> int | None:
        """Return the cost of joining two places by two passes; ``None`` when all links are blocked."""
        if (i, j) not in self._cheapest:
            home = j == self.home
            costs = [
                self.rapid(p, q) if home else self.link(p, q)
                for p in self.members[i]
                for q in self.members[j]
                if (p, q) not in self.blocked
            ]
            self._cheapest[i, j] = 2 * min(costs) if costs else None
        return self._cheapest[i, j]
