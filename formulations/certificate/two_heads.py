"""The relaxation of the general problem of two heads; its rows and why each holds."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import floor
from typing import Any

from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.reading import Refused, entries, require, show
from cutgap.formulations.certificate.relaxation import (
    MAX_VARIABLES,
    Corrections,
    Numbers,
    Relaxation,
    Row,
    cut_sets,
    cuts,
)
from cutgap.formulations.certificate.rules import Rules, may_rest


class TwoHeadsRelaxation(Relaxation):
    r"""Two heads with homes: which cuts what, and both tours; N contours, whose ranges may overlap.

        z_i    contour i is on head 0; z^0_i = z_i, z^1_i = 1 - z_i           {0, 1}
        x^a_uv how often head a goes between u and v; the home is node -1     {0, 1}, with the home {0, 1, 2}
        e_a    head a has work; 1 where no head may rest                      {0, 1}
        m      makespan * v_jump * scale,  d  imbalance * v_jump * scale      >= 0
        W_a    = sum of floor(w_i) z^a_i,  L_a = sum of l_uv x^a_uv

        min    m,  or  L_0 + L_1,  or  q (L_0 + L_1) + p d  where weight / v_jump = p / q

        degree    (6) x^a(delta(i)) = 2 z^a_i
        home      (7) x^a(delta(home)) = 2 e_a
        used      (8) e_a >= z^a_i
        connect   (9) x^a(delta(S)) >= 2 z^a_i              i in S, S contours: the tour comes from outside S
        visit    (10) x^a_uv <= z^a_i                       i in {u, v}, contours
        comb     (2), (3) for x^0 + x^1 and sets of contours
        makespan (11) m >= L_a + W_a
        imbalance(12) d >= s (L_0 + W_0 - L_1 - W_1) - E    s = 1 or -1, E = 2 N + 1
        balance  (13) s (L_0 + W_0 - L_1 - W_1) <= balance * v_jump * scale + E
        order    (14) z_i >= z_j for x_i < x_j;  z_i = z_j for |x_i - x_j| < F
        via      (15) sum over x_j <= x_i of x^a_(home, j) >= z^a_i

    Combs: cut each head's cycle open at its home and join the two paths, end to start, into one Hamiltonian
    cycle of the contours and four copies of homes (a head at rest is left out). The joints run between copies
    of homes and cross no set of contours, so x^0 + x^1 has the cycle's cuts. E: a head's time has at most N + 1
    legs and N works, each less than 1 above its floor. (14): F is at most the smallest x on the right minus the
    largest x on the left. (15): the first contour of head a is not to the right of contour i, if i is its.
    """

    def __init__(
        self, problem: Problem, rules: Rules, scale: int, multiplier_scale: int, costless: bool
    ) -> None:
        """Build the variables; ``costless`` for a proof that no plan exists."""
        self.problem, self.rules, self.scale = problem, rules, scale
        self.count = len(problem.ids)
        require(len(problem.homes) == 2 and None not in problem.homes, "two-heads: needs two heads with homes")
        require(self.count**2 <= MAX_VARIABLES, f"two-heads: {self.count} contours are too many")
        super().__init__(2 * (self.count + 1) + 1, multiplier_scale)
        self.work = [floor(problem.work(i, scale)) for i in range(self.count)]
        self.slack = 2 * self.count + 1
        price, makespan = rules.weight / problem.v_jump, rules.objective == "makespan"
        self.factor = price.denominator
        for _ in range(self.count):
            self.add(0, 1)
        self.legs = [self._add_edges(head, 0 if costless or makespan else self.factor) for head in (0, 1)]
        self.m = self.add(0 if costless else 1, None) if makespan else None
        self.d = self.add(0 if costless else price.numerator, None) if rules.objective == "weighted" else None
        self.e = [self.add(0, 1), self.add(0, 1)] if may_rest(problem, rules) else None
        self.families: dict[str, tuple[list[str], Callable[..., Row]]] = {
            "degree": (["head", "contour"], self._degree),
            "home": (["head"], self._home),
            "used": (["head", "contour"], self._used),
            "connect": (["head", "contour", "sets"], self._connect),
            "visit": (["head", "contour", "contour", "contour"], self._visit),
            "comb": (["sets"], self._comb),
            "makespan": (["head"], self._makespan),
            "imbalance": (["sign"], self._imbalance),
            "balance": (["sign"], self._balance),
            "order": (["contour", "contour"], self._order),
            "via": (["head", "contour"], self._via),
        }

    def _add_edges(self, head: int, times: int) -> list[int]:
        """Add the edges of one head; return their lengths."""
        home = self.problem.homes[head]
        legs: list[int] = []
        for u in range(-1, self.count):
            start = home if u == -1 and home is not None else u
            lengths = self.problem.lengths(start, list(range(u + 1, self.count)), self.scale)
            for v, length in enumerate(lengths, u + 1):
                self.add(times * length, 2 if u == -1 else 1, self.node(head, u), self.node(head, v))
            legs += lengths
        return legs

    def node(self, head: int, place: int) -> int:
        """Return the node of a contour, or of the home (-1), in the graph of a head."""
        return head * (self.count + 1) + place + 1

    def edge(self, head: int, u: int, v: int) -> int:
        """Return the variable of an edge."""
        u, v, count = min(u, v) + 1, max(u, v) + 1, self.count + 1
        return self.count + head * (count * self.count // 2) + u * count - u * (u + 1) // 2 + v - u - 1

    def variable(self, name: Any) -> int:
        match name:
            case ["z", int(i)] if 0 <= i < self.count:
                return i
            case ["x", int(a), int(u), int(v)] if a in (0, 1) and -1 <= u < v < self.count:
                return self.edge(a, u, v)
            case ["e", int(a)] if a in (0, 1) and self.e is not None:
                return self.e[a]
        raise Refused(f"no whole variable {show(name)}")

    def row(self, name: Any) -> Row:
        family, *arguments = entries(name, "row") or [None]
        require(
            isinstance(family, str) and family in self.families, f"no row {show(family)} in this relaxation"
        )
        kinds, build = self.families[family]
        require(len(arguments) == len(kinds), f"{family}: expected {', '.join(kinds)}")
        for kind, argument in zip(kinds, arguments, strict=True):
            if kind != "sets":
                allowed = {"head": (0, 1), "sign": (1, -1), "contour": range(self.count)}[kind]
                require(
                    type(argument) is int and argument in allowed, f"{family}: {show(argument)} is no {kind}"
                )
        return build(*arguments)

    def _degree(self, head: int, i: int) -> Row:
        return self._with_z(Row(True, 0, ((self.node(head, i), 1),)), head, -2, i)

    def _home(self, head: int) -> Row:
        legs = ((self.node(head, -1), 1),)
        return Row(True, 2, legs) if self.e is None else Row(True, 0, legs, ((-2, [self.e[head]]),))

    def _used(self, head: int, i: int) -> Row:
        require(self.e is not None, "used: no head may rest")
        return self._with_z(Row(False, 0, (), ((1, [self.variable(["e", head])]),)), head, -1, i)

    def _connect(self, head: int, i: int, sets: Any) -> Row:
        members, _ = cut_sets(sets, self.count)
        require(len(members) == 1 and i in members[0], "connect: expected one set, with the contour in it")
        crossing = cuts(members, partial(self.node, head), partial(self.edge, head))
        return self._with_z(Row(False, 0, *crossing), head, -2, i)

    def _visit(self, head: int, i: int, u: int, v: int) -> Row:
        require(u < v and i in (u, v), "visit: expected an edge u < v at contour i")
        return self._with_z(Row(False, 0, (), ((-1, [self.edge(head, u, v)]),)), head, 1, i)

    def _comb(self, sets: Any) -> Row:
        members, rhs = cut_sets(sets, self.count)
        numbers: Numbers = ()
        corrections: Corrections = ()
        for head in (0, 1):
            more = cuts(members, partial(self.node, head), partial(self.edge, head))
            numbers, corrections = numbers + more[0], corrections + more[1]
        return Row(False, rhs, numbers, corrections)

    def _makespan(self, head: int) -> Row:
        require(self.m is not None, "makespan: the objective is another")
        return self._times(-1 if head == 0 else 0, -1 if head == 1 else 0, 0, self.m)

    def _imbalance(self, sign: int) -> Row:
        require(self.d is not None, "imbalance: the objective does not price it")
        return self._times(-sign, sign, -self.slack, self.d)

    def _balance(self, sign: int) -> Row:
        require(self.rules.balance is not None, "balance: the rules set no limit")
        limit = (self.rules.balance or 0) * self.problem.v_jump * self.scale
        return self._times(-sign, sign, -floor(limit + self.slack), None)

    def _order(self, i: int, j: int) -> Row:
        require(self.rules.non_overlap is not None, "order: the rules allow overlap")
        apart = self.problem.xs[j] - self.problem.xs[i]
        together = abs(apart) < (self.rules.non_overlap or 0)
        require(i != j and (together or apart > 0), "order: the first contour is not left of the second")
        return Row(together, 0, (), ((1, [i]), (-1, [j])))

    def _via(self, head: int, i: int) -> Row:
        require(self.rules.via_points, "via: the rules ask for no via points")
        firsts = [self.edge(head, -1, j) for j in range(self.count) if self.problem.xs[j] <= self.problem.xs[i]]
        return self._with_z(Row(False, 0, (), ((1, firsts),)), head, -1, i)

    def _with_z(self, row: Row, head: int, coefficient: int, i: int) -> Row:
        """Add coefficient * z^a_i to the left side; for head 1 that is coefficient - coefficient * z_i."""
        if head == 1:
            row, coefficient = replace(row, rhs=row.rhs - coefficient), -coefficient
        return replace(row, corrections=(*row.corrections, (coefficient, [i])))

    def _times(self, first: int, second: int, rhs: int, variable: int | None) -> Row:
        """Return variable + first * (L_0 + W_0) + second * (L_1 + W_1) >= rhs."""
        terms = [] if variable is None else [(1, [variable])]
        for head, factor in enumerate((first, second)):
            offset = self.edge(head, -1, 0)
            if factor != 0:
                terms += [(factor * length, [offset + k]) for k, length in enumerate(self.legs[head])]
        terms += [((first - second) * work, [i]) for i, work in enumerate(self.work)]
        return Row(False, rhs - second * sum(self.work), (), tuple(terms))
