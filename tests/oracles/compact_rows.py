"""Legs, shorthands and rows of compact models, whatever the tour formulation, from docs/formulations.md alone.

Variables and rows have the names that the page gives them; the depot is -1. Units are mm and s, numbers are
floats. Every row is spelled out in legs x and c. Up to about 5 contours.
"""

from collections import Counter
from fractions import Fraction
from functools import cached_property
from itertools import permutations
from typing import Any

import numpy as np

from cutgap.instances import Instance, Rules
from oracles.exact_sheet import sheet_of
from oracles.problem import plain_problem

EQUATIONS = {
    "cut-once",
    "continuity",
    "flow-keep",
    "load-keep",
    "space-keep",
    "load-and-space",
    "to-sink",
    "through",
    "step",
    "timed",
}

Name = tuple[Any, ...]
Sum = Counter[Name]


def times(factor: float, terms: Sum) -> Sum:
    return Counter({name: factor * number for name, number in terms.items()})


def total(*sums: Sum) -> Sum:
    found: Sum = Counter()
    for each in sums:
        for name, number in each.items():
            found[name] += number
    return found


class CompactRows:
    """``rows[name] = (left, is_equation, right)``; all variables within ``ranges``, at ``cost``."""

    def __init__(self, instance: Instance, rules: Rules) -> None:
        self.instance, self.rules, self.problem = instance, rules, plain_problem(instance)
        self.n, self.heads = len(instance.contours), range(len(instance.heads))
        self.alone = len(instance.heads) == 1
        self.of = [c for c, points in enumerate(self.problem.entries) for _ in points]
        self.xs = [Fraction(repr(point[0])) for points in self.problem.entries for point in points]
        self.entry = [(c, e) for c, points in enumerate(self.problem.entries) for e in range(len(points))]
        self.sheet = sheet_of(instance) if rules.neighbours_only or rules.clear_rapids else None
        parts = [
            contour.part if contour.part is not None else f"alone {i}"
            for i, contour in enumerate(instance.contours)
        ]
        self.parts = [list(dict.fromkeys(parts)).index(part) for part in parts]
        self.ranges: dict[Name, tuple[float, float]] = {}
        self.lengths: dict[Name, float] = {}
        self.cost: Sum = Counter()
        self.rows: dict[Name, tuple[Sum, bool, float]] = {}
        for h in self.heads:
            self.add_legs(h)
        self.add_problem()
        self.add_order()

    # Variables

    def add_legs(self, h: int) -> None:
        home, points = self.problem.home_node(h), range(len(self.of))
        for u, v in permutations(points, 2):
            if self.of[u] != self.of[v] and self.may_go(u, v):
                backward = max(0.0, float(self.xs[u] - self.xs[v]))
                self.add_leg(("x", h, u, v), self.rules.backward_price * backward)
        for u in points:
            if home is not None:
                self.add_leg(("x", h, home, u))
                self.add_leg(("x", h, u, home))
                continue
            for v in points:
                turned = self.anywhere and not self.of[v] == 0 != self.of[u]
                if (u == v or self.of[u] != self.of[v]) and not turned:
                    self.add_leg(("c", h, u, v))

    def add_leg(self, name: Name, price: float = 0.0) -> None:
        _, _, u, v = name
        self.ranges[name] = (0.0, 1.0)
        self.lengths[name] = self.problem.lengths[u][v] if u != v else 0.0
        if self.rules.objective != "makespan":
            self.cost[name] = self.lengths[name] + price

    def may_go(self, u: int, v: int) -> bool:
        if self.sheet is None:
            return True
        i, j = self.of[u], self.of[v]
        names = self.sheet.parts[i], self.sheet.parts[j]
        if self.rules.neighbours_only and names[0] != names[1] and names not in self.sheet.neighbours:
            return False
        return not (self.rules.clear_rapids and i in self.sheet.crossed[(*self.entry[u], *self.entry[v])])

    @property
    def anywhere(self) -> bool:
        asked = self.rules.via_points or self.rules.process or self.instance.precedence
        return self.alone and self.n >= 2 and not asked

    def variable(self, *name: Any, most: float, least: float = 0.0) -> Sum:
        self.ranges[name] = (least, most)
        return Counter({name: 1.0})

    def p(self, h: int, i: int) -> Sum:
        return self.variable("p", h, i, least=1.0, most=self.n)

    # Shorthands

    @cached_property
    def ends(self) -> dict[Name, tuple[int, int]]:
        """Contours that each leg goes from and to, the depot for a home."""
        of = [*self.of, *[-1] * len(self.heads)]
        return {name: (of[name[2]], of[name[3]]) for name in self.lengths}

    def y(self, h: int, i: int, j: int) -> Sum:
        found: Sum = Counter()
        for name, (tail, head) in self.ends.items():
            if name[1] == h and name[0] == "x" and (tail, head) == (i, j):
                found[name] += 1
            if name[1] == h and name[0] == "c" and (i, j) in ((-1, head), (tail, -1)):
                found[name] += 1
        return found

    def z(self, h: int, i: int) -> Sum:
        return total(*(self.y(h, j, i) for j in self.places(i)))

    def q(self, h: int, u: int) -> Sum:
        return Counter({name: 1 for name in self.lengths if name[1] == h and name[3] == u})

    def first(self, h: int, u: int) -> Sum:
        return Counter({name: 1 for name in self.q(h, u) if name[0] == "c" or self.ends[name][0] == -1})

    def time(self, h: int) -> Sum:
        legs = Counter({name: mm / self.problem.v_jump for name, mm in self.lengths.items() if name[1] == h})
        return total(legs, *(times(self.problem.work([i]), self.z(h, i)) for i in range(self.n)))

    def places(self, j: int) -> list[int]:
        return [i for i in range(-1, self.n) if i != j]

    def others(self, j: int) -> list[int]:
        return [i for i in range(self.n) if i != j]

    # Rows

    def row(self, name: Name, left: Sum, right: float = 0.0, equation: bool | None = None) -> None:
        self.rows[name] = left, name[0] in EQUATIONS if equation is None else equation, right

    def add_problem(self) -> None:
        for i in range(self.n):
            self.row(("cut-once", i), total(*(self.z(h, i) for h in self.heads)), 1)
        rests = self.rules.empty_heads or self.n < len(self.heads)
        for h in self.heads:
            for u in range(len(self.of)):
                out = Counter({name: -1 for name in self.lengths if name[1] == h and name[2] == u})
                self.row(("continuity", h, u), total(self.q(h, u), out))
            begun = total(*(self.y(h, -1, j) for j in range(self.n)))
            self.row(("leave-once", h), times(-1, begun) if rests else begun, -1 if rests else 1, not rests)
            if self.rules.via_points:
                self.add_via(h)
            if self.rules.parts_in_one_go:
                self.add_one_go(h)
        if self.rules.objective == "makespan":
            makespan = self.variable("makespan", most=np.inf)
            self.cost["makespan",] = 1.0
            for h in self.heads:
                self.row(("makespan", h), total(makespan, times(-1, self.time(h))))
        if not self.alone:
            self.add_two_heads()

    def add_two_heads(self) -> None:
        for h, other in ((0, 1), (1, 0)):
            apart = total(self.time(other), times(-1, self.time(h)))
            if self.rules.objective == "weighted":
                self.cost["imbalance",] = self.rules.weight
                self.row(("imbalance", h, other), total(self.variable("imbalance", most=np.inf), apart))
            if self.rules.balance is not None:
                self.row(("balance", h, other), apart, -self.rules.balance)
        if self.rules.non_overlap is not None:
            gap = Fraction(repr(self.rules.non_overlap))
            for u, v in permutations(range(len(self.of)), 2):
                if self.of[u] != self.of[v] and self.xs[v] - self.xs[u] < gap:
                    self.row(("apart", u, v), times(-1, total(self.q(0, u), self.q(1, v))), -1)

    def add_via(self, h: int) -> None:
        for u, v in permutations(range(len(self.of)), 2):
            if self.of[u] != self.of[v] and self.xs[v] < self.xs[u]:
                self.row(("via", h, u, v), times(-1, total(self.first(h, u), self.q(h, v))), -1)

    def add_one_go(self, h: int) -> None:
        for part in set(self.parts):
            mates = [i for i in range(self.n) if self.parts[i] == part]
            rest = [j for j in range(-1, self.n) if j not in mates]
            if len(mates) >= 2:
                left = total(*(self.y(h, i, j) for i in mates for j in rest))
                self.row(("one-go", h, part), times(-1, left), -1)

    def add_order(self) -> None:
        n = self.n
        for h in self.heads:
            if self.instance.precedence or self.rules.clear_rapids:
                self.add_mtz(h)
            for i, j in self.instance.precedence:
                later = total(self.p(h, j), times(-1, self.p(h, i)))
                if self.alone:
                    self.row(("precedence", h, i, j), later, 1)
                else:
                    both = total(self.z(h, i), self.z(h, j))
                    self.row(("precedence", h, i, j), total(later, times(-n, both)), 1 - 2 * n)
            if self.rules.clear_rapids:
                self.add_clear(h)

    def add_clear(self, h: int) -> None:
        n = self.n
        for name, (i, j) in self.ends.items():
            if name[:2] != ("x", h) or -1 in (i, j):
                continue
            for k in self.sheet.crossed[(*self.entry[name[2]], *self.entry[name[3]])] - {i, j}:
                later = total(self.p(h, k), times(-1, self.p(h, i)), Counter({name: -n}))
                if not self.alone:
                    later = total(later, times(-n, self.z(h, k)))
                self.row(("clear", *name[1:], k), later, 1 - n if self.alone else 1 - 2 * n)

    def add_mtz(self, h: int) -> None:
        for i, j in permutations(range(self.n), 2):
            left = total(self.p(h, j), times(-1, self.p(h, i)), times(-self.n, self.y(h, i, j)))
            self.row(("position", h, i, j), left, 1 - self.n)
