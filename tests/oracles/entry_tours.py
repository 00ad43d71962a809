"""The best plan with entry points under the process rules, by listing every tour of one or two heads.

Precedence, parts in one go, neighbours only, clear rapids, a price of going back, via points; on two heads also
non-overlap, balance and empty heads. Ways from and to a home, and the leg that closes a tour without a home,
are exempt from neighbours only, clear rapids and the price; each start of such a tour counts.

One head: up to 6 contours of 3 entry points. Two heads: up to 5 contours of 2.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from cutgap.instances import Instance, Plan, Rules, Visit
from oracles.exact_sheet import Sheet, sheet_of
from oracles.problem import Figures, Problem, Tour, figures, plain_problem

SLACK = 1e-9
"""Relative slack of limits on times, which differ by rounding."""


@dataclass(frozen=True)
class BestPlan:
    """An optimal plan and its value, mm or s as the rules say."""

    value: float
    tours: tuple[Tour, ...]

    @property
    def plan(self) -> Plan:
        return Plan(tuple(tuple(Visit(*visit) for visit in tour) for tour in self.tours))


def best_plan(instance: Instance, rules: Rules) -> BestPlan | None:
    """Return an optimal plan, ``None`` when there is none."""
    if len(instance.heads) > 2:
        raise ValueError("lists plans of one or two heads")
    return _Search(instance, rules).best()


def value_of(problem: Problem, rules: Rules, tours: tuple[Tour, ...]) -> float:
    """The objective of any plan, with the price of going back."""
    value = figures(problem, tours).objective(rules)
    return value + rules.backward_price * sum(
        max(0.0, _x(problem, one) - _x(problem, other)) for tour in tours for one, other in pairwise(tour)
    )


def broken_rules(instance: Instance, rules: Rules, tours: tuple[Tour, ...]) -> set[str]:
    """Names of the rules that a plan breaks that cuts each contour once, as ``check`` calls them."""
    search = _Search(instance, rules)
    broken = {name for tour in tours for name in search.broken_on_a_head(tour)}
    return broken | search.broken_between(tours)


def ends_of(problem: Problem, head: int, tour: Tour) -> dict[int, float]:
    """When the head is done with each contour, s; it starts from its home, or at its first contour."""
    time, place, ends = 0.0, problem.home_node(head), {}
    for contour, entry, *_ in tour:
        node = problem.node(contour, entry)
        if place is not None:
            time += problem.lengths[place][node] / problem.v_jump
        time += problem.work([contour])
        place = node
        ends[contour] = time
    return ends


def _x(problem: Problem, visit: tuple[int, int]) -> float:
    return problem.entries[visit[0]][visit[1]][0]


class _Search:
    def __init__(self, instance: Instance, rules: Rules) -> None:
        self.instance, self.rules, self.problem = instance, rules, plain_problem(instance)
        self.count = len(self.problem.entries)
        process = rules.neighbours_only or rules.clear_rapids
        self.sheet: Sheet | None = sheet_of(instance) if process else None
        self.parts = [c.part if c.part is not None else ("alone", i) for i, c in enumerate(instance.contours)]

    def best(self) -> BestPlan | None:
        best: BestPlan | None = None
        for tours in self._plans():
            value = value_of(self.problem, self.rules, tours)
            if best is None or value < best.value:
                best = BestPlan(value, tours)
        return best

    def _plans(self) -> Iterator[tuple[Tour, ...]]:
        everything = frozenset(range(self.count))
        if len(self.problem.homes) == 1:
            yield from ((tour,) for tour in self._shorter_tours(everything))
            return
        for left in range(1 << self.count):
            mine = frozenset(c for c in range(self.count) if left >> c & 1)
            others = list(self._tours(everything - mine))
            for tour in self._tours(mine):
                for other in others:
                    if not self.broken_between((tour, other)):
                        yield tour, other

    def _shorter_tours(self, contours: frozenset[int]) -> Iterator[Tour]:
        """Tours of one head; a beginning that costs as much as the best tour so far is left."""
        least = [float("inf")]

        def hopeless(tour: Tour) -> bool:
            return self._walked(tour) >= least[0]

        for tour in self._tours(contours, hopeless):
            least[0] = min(least[0], self._walked(tour, closed=True))
            yield tour

    def _walked(self, tour: Tour, closed: bool = False) -> float:
        """Cost of a beginning of a tour, mm, up to the order in which its legs are added."""
        problem, home = self.problem, self.problem.home_node(0)
        nodes = [problem.node(*visit[:2]) for visit in tour]
        if home is not None:
            nodes = [home, *nodes]
        if closed and nodes:
            nodes.append(nodes[0])
        price = self.rules.backward_price
        return sum(problem.lengths[a][b] for a, b in pairwise(nodes)) + price * sum(
            max(0.0, _x(problem, one) - _x(problem, other)) for one, other in pairwise(tour)
        )

    def _tours(self, contours: frozenset[int], hopeless=lambda tour: False) -> Iterator[Tour]:
        """Every tour of the contours that keeps the rules of one head."""

        def extend(tour: Tour) -> Iterator[Tour]:
            done = {contour for contour, *_ in tour}
            if len(done) == len(contours):
                yield tour
            for contour in sorted(contours - done):
                for entry in range(len(self.problem.entries[contour])):
                    longer = (*tour, (contour, entry))
                    if self._may_extend(contours, longer) and not hopeless(longer):
                        yield from extend(longer)

        yield from extend(())

    def _may_extend(self, contours: frozenset[int], tour: Tour) -> bool:
        """Whether the last visit may follow the others, with the rest of the contours still to come."""
        new, done = tour[-1], [contour for contour, *_ in tour[:-1]]
        to_come = contours - set(done)
        if any(after == new[0] and before in to_come for before, after in self.problem.precedence):
            return False
        if self.rules.via_points and _x(self.problem, new) < _x(self.problem, tour[0]):
            return False
        if not done:
            return True
        last = done[-1]
        left = any(self.parts[contour] == self.parts[last] for contour in to_come)
        if self.rules.parts_in_one_go and self.parts[new[0]] != self.parts[last] and left:
            return False
        return self._may_go(tour[-2], new, done)

    def _may_go(self, one: tuple[int, int], other: tuple[int, int], done: list[int]) -> bool:
        if self.rules.neighbours_only:
            names = self.sheet.parts[one[0]], self.sheet.parts[other[0]]
            if names[0] != names[1] and names not in self.sheet.neighbours:
                return False
        return not (self.rules.clear_rapids and self.sheet.crossed[(*one[:2], *other[:2])] & set(done))

    def broken_on_a_head(self, tour: Tour) -> set[str]:
        """Names of the broken rules that concern one head, from the whole tour."""
        broken, order = set(), [contour for contour, *_ in tour]
        pairs = [(a, b) for a, b in self.problem.precedence if a in order and b in order]
        if any(order.index(a) > order.index(b) for a, b in pairs):
            broken.add("precedence")
        xs = [_x(self.problem, visit) for visit in tour]
        if self.rules.via_points and xs and xs[0] > min(xs):
            broken.add("via points")
        if self.rules.parts_in_one_go:
            for part in set(self.parts):
                turns = [turn for turn, contour in enumerate(order) if self.parts[contour] == part]
                if turns and turns[-1] - turns[0] >= len(turns):
                    broken.add("parts in one go")
        for turn, (one, other) in enumerate(pairwise(tour)):
            if self.rules.neighbours_only:
                names = self.sheet.parts[one[0]], self.sheet.parts[other[0]]
                if names[0] != names[1] and names not in self.sheet.neighbours:
                    broken.add("neighbours only")
            if self.rules.clear_rapids and self.sheet.crossed[(*one[:2], *other[:2])] & set(order[: turn + 1]):
                broken.add("clear rapids")
        return broken

    def broken_between(self, tours: tuple[Tour, ...]) -> set[str]:
        """Names of the broken rules that concern two heads."""
        measured = figures(self.problem, tours)
        ends = [ends_of(self.problem, head, tour) for head, tour in enumerate(tours)]
        broken = self._broken_limits(measured, tours)
        for mine, others in ((ends[0], ends[-1]), (ends[-1], ends[0])) if len(tours) == 2 else ():
            for a, b in self.problem.precedence:
                if a in mine and b in others:
                    start = others[b] - self.problem.work([b])
                    if mine[a] - start > SLACK * max(1.0, mine[a]):
                        broken.add("precedence")
        if self.rules.clear_rapids and len(tours) == 2:
            for head, tour in enumerate(tours):
                for one, other in pairwise(tour):
                    leaves, others = ends[head][one[0]], ends[1 - head]
                    crossed = self.sheet.crossed[(*one[:2], *other[:2])]
                    if any(k in others and others[k] <= leaves for k in crossed):
                        broken.add("clear rapids")
        return broken

    def _broken_limits(self, measured: Figures, tours: tuple[Tour, ...]) -> set[str]:
        rules, broken = self.rules, set()
        if self.count >= len(tours) and not rules.empty_heads and not all(tours):
            broken.add("no empty heads")
        if rules.balance is not None and measured.imbalance > rules.balance + SLACK * max(
            1.0, measured.makespan
        ):
            broken.add("balance")
        gap = measured.partition_gap
        if rules.non_overlap is not None and gap is not None and gap < rules.non_overlap:
            broken.add("non-overlap")
        return broken
