r"""Two heads without overlap: every partition that is allowed lies in a cell, and each cell has a bound.

Let the contours be sorted by x. Non-overlap F asks that x jumps by at least F from the largest on the left to
the smallest on the right. So the left set is a prefix that ends at such a jump, is empty or is everything; only
for F = 0 contours of equal x may be divided: then a prefix, then any part of the next group of equal x. A tie
tree divides a group step by step; contours that a leaf leaves undecided *float*: either head does their work.

    U_a = l_a + w(decided contours of head a),  l_a a proved length,   f = w(floating contours)    [mm / scale]
    D   = max(0, |U_0 - U_1| - f),   p = min(weight / v_jump, 1),   b = balance * v_jump * scale

    (1) scale * v_jump * makespan          >= max(U_0, U_1, (U_0 + U_1 + f) / 2)
    (2) scale * (travel + weight * imbalance) >= l_0 + l_1 + p min(D, b) + max(0, D - b)

(1): T_0 and T_1 are at least U_0 and U_1, and the two add up to U_0 + U_1 + f at least. (2): in these units let
the plan's tours have lengths l_0 + a_0 and l_1 + a_1, a >= 0, and I = |t_0 - t_1| <= b. As f goes to a head,
I >= D - a_0 - a_1. So the objective is at least l_0 + l_1 + max(0, D - I) + p I, and its least value over
0 <= I <= b is at I = min(D, b), since p <= 1. Weights above v_jump count as v_jump, which lowers the bound;
without a balance limit b is infinite.
"""

from fractions import Fraction
from itertools import groupby
from math import floor
from typing import Any

from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.proof import Budget
from cutgap.formulations.certificate.reading import Refused, entries, fields, integer, require, show
from cutgap.formulations.certificate.rules import Rules, may_rest
from cutgap.formulations.certificate.tours import TourBounds


class Cells:
    """All cells of a problem, each to be bounded from below by the claim."""

    def __init__(
        self, problem: Problem, rules: Rules, tours: TourBounds, claim: int | None, scale: int, budget: Budget
    ) -> None:
        require(len(problem.homes) == 2, "split: needs two heads")
        require(rules.non_overlap is not None, "split: the rules allow overlap")
        self.problem, self.rules, self.tours = problem, rules, tours
        self.claim, self.budget = claim, budget
        self.gap = rules.non_overlap or Fraction(0)
        self.work = [problem.work(contour, scale) for contour in range(len(problem.ids))]
        self.price = min(rules.weight / problem.v_jump, Fraction(1))
        self.limit = None if rules.balance is None else rules.balance * problem.v_jump * scale
        self.order = sorted(range(len(problem.ids)), key=lambda contour: problem.xs[contour])

    def check(self, ties: Any) -> None:
        """Refuse unless every cell has its bound; ``ties`` holds a tree for each group that may be divided."""
        count, xs = len(self.order), self.problem.xs
        for k in range(count + 1):
            inner = 0 < k < count
            jump = xs[self.order[k]] - xs[self.order[k - 1]] if inner else Fraction(0)
            if not inner or (jump > 0 and jump >= self.gap):
                self._check_cell(self.order[:k], self.order[k:], [])
        places = [list(group) for _, group in groupby(range(count), key=lambda k: xs[self.order[k]])]
        groups = [group for group in places if len(group) > 1] if self.gap == 0 else []
        for number, (group, tree) in enumerate(zip(groups, entries(ties, "ties", len(groups)), strict=True)):
            try:
                self._check_ties(group[0], group[-1] + 1, tree)
            except Refused as error:
                raise Refused(f"ties {number}: {error}") from None

    def _check_ties(self, start: int, end: int, tree: Any) -> None:
        """Check the divisions of the contours at ``start`` up to ``end`` in the order of x."""
        nodes = entries(tree, "tree")
        numbers = {self.problem.ids[contour]: contour for contour in self.order[start:end]}
        reached = [False] * len(nodes)
        stack: list[tuple[int, list[int], list[int]]] = [(0, [], [])]
        while stack:
            index, left, right = stack.pop()
            require(index < len(nodes), f"there is no node {show(index)}")
            require(not reached[index], f"node {index} is reached twice")
            reached[index] = True
            floating = [contour for contour in numbers.values() if contour not in left + right]
            if "leaf" in entries_of(nodes[index]):
                require(
                    fields(nodes[index], "leaf", "leaf")["leaf"] is True, f"node {index}: leaf must be true"
                )
                self._check_cell(self.order[:start] + left, right + self.order[end:], floating)
                continue
            table = fields(nodes[index], f"node {index}", "branch left right")
            contour = numbers.get(table["branch"]) if isinstance(table["branch"], str) else None
            if contour is None or contour not in floating:
                raise Refused(f"node {index}: {show(table['branch'])} is no undecided contour of the group")
            for side, more in (("left", ([*left, contour], right)), ("right", (left, [*right, contour]))):
                child = integer(table[side], side)
                require(child > index, f"node {index}: its child {show(child)} must come later in the list")
                stack.append((child, *more))
        require(all(reached), "a node is never reached")

    def _check_cell(self, left: list[int], right: list[int], floating: list[int]) -> None:
        """Refuse unless the cell's plans are worth the claim, or there are none."""
        self.budget.spend(100 + 20 * len(self.order) + 10 * sum(map(len, self.tours.of_head)))
        if not floating and not (left and right) and not may_rest(self.problem, self.rules):
            return
        name = f"cell of {len(left)} left, {len(right)} right, {len(floating)} floating"
        require(self.claim is not None, f"{name}: it is allowed, so the problem is not infeasible")
        bound = self._bound(left, right, floating)
        require(
            bound >= (self.claim or 0),
            f"{name}: bound {show(floor(bound))}, below the claimed {show(self.claim)}",
        )

    def _bound(self, left: list[int], right: list[int], floating: list[int]) -> Fraction:
        """Return (1) or (2)."""
        lengths = [self.tours.length(head, cut, floating) for head, cut in enumerate((left, right))]
        works = [sum((self.work[each] for each in cut), Fraction(0)) for cut in (left, right, floating)]
        times = [length + work for length, work in zip(lengths, works[:2], strict=True)]
        if self.rules.objective == "makespan":
            return max(*times, (sum(times) + works[2]) / 2)
        apart = max(Fraction(0), abs(times[0] - times[1]) - works[2])
        kept = apart if self.limit is None else min(apart, self.limit)
        return sum(lengths) + self.price * kept + (apart - kept)


def entries_of(value: Any) -> Any:
    """Return an object's fields, none for what is no object."""
    return value if isinstance(value, dict) else {}
