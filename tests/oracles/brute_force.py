"""The best plan among all plans: every assignment, every order, every entry point. Up to 7 contours.

Every prefix of an order is itself an order of fewer contours, so one depth-first walk lists the tours of all
subsets. A balance limit, or a weight above v_jump, can be served by a longer tour: all lengths are kept, and
for each time of the left head the best time of the right head is found by bisection.
"""

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from dataclasses import dataclass

from cutgap.instances import Instance, Plan, Rules, Visit
from oracles.problem import Figures, Problem, Tour, figures, plain_problem

SLACK = 1e-9
"""Relative slack of the balance limit: equal times differ by rounding."""

Kind = tuple[float, float, bool]
"""Smallest and largest x of a tour's entry points, and whether it starts at the smallest.

A tour without work is nowhere: infinitely far from any other.
"""
Lengths = dict[float, Tour]
EMPTY: Kind = (float("inf"), float("-inf"), True)


@dataclass(frozen=True)
class Best:
    """An optimal plan and its value."""

    value: float
    tours: tuple[Tour, ...]
    figures: Figures

    @property
    def plan(self) -> Plan:
        return Plan(tuple(tuple(Visit(*visit) for visit in tour) for tour in self.tours))


class AllPlans:
    """All tours of an instance, listed once and asked for the best plan under any rules.

    Raises
    ------
    ValueError
        With three heads or more, more than 7 contours, or precedence among two heads (it needs times).
    """

    def __init__(self, instance: Instance) -> None:
        self.problem = plain_problem(instance)
        if len(self.problem.homes) > 2 or len(self.problem.entries) > 7:
            raise ValueError("brute force takes at most 2 heads and 7 contours")
        if self.problem.precedence and len(self.problem.homes) > 1:
            raise ValueError("brute force takes precedence for one head only")
        self.tours = [list_tours(self.problem, head) for head in range(len(self.problem.homes))]

    def best(self, rules: Rules) -> Best | None:
        """Return an optimal plan, ``None`` when no plan is allowed."""
        everything = (1 << len(self.problem.entries)) - 1
        plans: Iterator[tuple[Tour, ...]]
        if len(self.tours) == 1:
            # One head: the value grows with the length.
            plans = ((tours[min(tours)],) for _, tours in self.allowed(0, everything, rules))
        else:
            plans = (
                plan for left in range(everything + 1) for plan in self.pairs(left, everything - left, rules)
            )
        best: Best | None = None
        for plan in plans:
            measured = figures(self.problem, plan)
            value = measured.objective(rules)
            if best is None or value < best.value:
                best = Best(value, plan, measured)
        return best

    def allowed(self, head: int, subset: int, rules: Rules) -> list[tuple[Kind, Lengths]]:
        """Tours of one subset that keep the rules of a single head."""
        enough = len(self.problem.entries) >= len(self.problem.homes)
        if subset == 0 and enough and not rules.empty_heads:
            return []
        found = self.tours[head].get(subset, {})
        return [(kind, tours) for kind, tours in found.items() if kind[2] or not rules.via_points]

    def pairs(self, left: int, right: int, rules: Rules) -> Iterator[tuple[Tour, ...]]:
        """For each pair of ranges that may stand side by side, the best pair of tours."""
        seconds = [
            self.problem.work([c for c in range(len(self.problem.entries)) if subset >> c & 1])
            for subset in (left, right)
        ]
        for left_kind, left_tours in self.allowed(0, left, rules):
            for right_kind, right_tours in self.allowed(1, right, rules):
                apart = right_kind[0] - left_kind[1]
                if rules.non_overlap is not None and apart < rules.non_overlap:
                    continue
                pair = best_pair(left_tours, right_tours, seconds, self.problem.v_jump, rules)
                if pair is not None:
                    yield left_tours[pair[0]], right_tours[pair[1]]


def brute_force(instance: Instance, rules: Rules) -> Best | None:
    """Return an optimal plan of a tiny instance, ``None`` when no plan is allowed."""
    return AllPlans(instance).best(rules)


def list_tours(problem: Problem, head: int) -> dict[int, dict[Kind, Lengths]]:
    """Return every tour of every subset (bit mask) that precedence allows, by kind and length in mm."""
    lengths, home = problem.lengths, problem.home_node(head)
    nodes = [[problem.node(c, e) for e in range(len(points))] for c, points in enumerate(problem.entries)]
    before = [sum(1 << a for a, b in set(problem.precedence) if b == c) for c in range(len(nodes))]
    found: dict[int, dict[Kind, Lengths]] = {0: {EMPTY: {0.0: ()}}}

    def extend(subset: int, tour: Tour, length: float, last: int, first: int, kind: Kind) -> None:
        for contour, entries in enumerate(nodes):
            if subset >> contour & 1 or before[contour] & ~subset:
                continue
            for entry, node in enumerate(entries):
                x = problem.entries[contour][entry][0]
                start = node if first < 0 else first
                walked = length + (lengths[last][node] if last >= 0 else 0.0)
                # A tour that starts at x has kind[2] as long as nothing to the left of x joins it.
                leftmost = not tour or (kind[2] and x >= kind[0])
                longer = (min(kind[0], x), max(kind[1], x), leftmost)
                closed = walked + lengths[node][start if home is None else home]
                now, visits = subset | 1 << contour, (*tour, (contour, entry))
                found.setdefault(now, {}).setdefault(longer, {}).setdefault(closed, visits)
                extend(now, visits, walked, node, start, longer)

    extend(0, (), 0.0, -1 if home is None else home, -1, EMPTY)
    return found


def best_pair(
    left: Lengths, right: Lengths, work: list[float], v_jump: float, rules: Rules
) -> tuple[float, float] | None:
    """Return the two lengths of the best pair under balance and objective, ``None`` when none is balanced.

    Without a limit, and with a weight of at most v_jump, the value grows with both lengths: the shortest
    do. Else, for a given left time, the objective as a function of the right time is convex with its only
    kinks at the left time and at the ends, so the nearest times on both sides and the smallest decide.
    """
    if rules.balance is None and rules.weight <= v_jump:
        return min(left), min(right)
    lengths = sorted(right)
    times = [length / v_jump + work[1] for length in lengths]
    best, best_value = None, float("inf")
    for mine in left:
        time = mine / v_jump + work[0]
        low, high = 0, len(times) - 1
        if rules.balance is not None:
            limit = rules.balance + SLACK * max(1.0, time)
            low, high = bisect_left(times, time - limit), bisect_right(times, time + limit) - 1
        meeting = bisect_left(times, time)
        for other in {low, meeting - 1, meeting}:
            if not low <= other <= high:
                continue
            value = _value(mine, lengths[other], time, times[other], rules)
            if value < best_value:
                best, best_value = (mine, lengths[other]), value
    return best


def _value(left: float, right: float, left_time: float, right_time: float, rules: Rules) -> float:
    if rules.objective == "makespan":
        return max(left_time, right_time)
    return left + right + (rules.weight * abs(left_time - right_time) if rules.objective == "weighted" else 0)
