r"""One head under heat: all orders and start points are tried, on small plates. Nothing is believed.

    walk       start points v_1 .. v_k of different contours; S what they cut, v = v_k in contour a
    (1) warm(v, w, S) <= rise at w after v, in whatever order S was cut:  T(L_wa, d_vw) + g(S - a),
        g(0) = 0,  g(X) = min over j in X of  g(X - j) + least T(L_wj, t) over t in I(j, X - j),
        I(j, Y) = d_vw + work on Y and a + [lo, hi],  lo, hi = sums over Y and a of the shortest and of the
        longest way into each of them: j was cut just before the set Y, and Y just before a
    (2) R(S, v) = min of c_vw + R(S + w, w) over allowed steps v -> w with warm(v, w, S) < hot;  R(all, v) = b_v
    (3) a walk ends where its travel + R is at least ``dear``, or the rise at its last point at least ``hot``;
        that of all contours, which does not end, refutes the claim

The claim is that no plan has travel below ``dear`` and all rises below ``hot``; either may be ``None``, which
nothing reaches. Proof: T is never negative, and rounded down (``warmth``). (1) by induction over X: the contour
of X that the plan cut first is one of the j, and its time lies in I(j, X - j). (2) by induction from the end: a
plan below ``hot`` only makes such steps. So a plan below both does not end at (3).

Times are integers of 1 / SECOND s, rounded down, each by less than 1 + 1 / FINER. The time from the end of one
contour to the start of another is a sum of at most n - 2 works and n - 1 ways, so less than 2 n above that of
the integers; the uncertainty of ``warmth`` goes to both sides. What the library calls a time counts from the
home, so the way from there is part of the longest time; and so is the way to the largest coordinate, as the
floats of two places that are far off make a short way between them uncertain.
"""

from fractions import Fraction
from math import ceil, floor
from typing import Any

from cutgap.formulations.certificate.curves import Curves
from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.proof import Budget
from cutgap.formulations.certificate.reading import fields, require
from cutgap.formulations.certificate.rules import Rules
from cutgap.formulations.certificate.walks import mates_of, preceding, step_costs
from cutgap.formulations.certificate.warmth import FLOATS, KELVIN, SECOND, Warmth

MOST_CELLS = 50_000_000
"""Most entries of the table of (1)."""
MOST_CONTOURS = 16
MOST_POINTS = 1000
"""A pair of points takes some 200 bytes, however few contours there are."""
KERNEL_STEPS, STATE_STEPS, DISTANCE_STEPS = 25, 5, 400
"""Elementary steps of one T, of one entry of a table, and of a point and an edge."""
FINER = 2**20
"""Ways are rounded down to this part of a unit of time, before they are to whole ones."""
SLACK = Fraction(2, 10**9)
"""What a proof has to show a cap broken by, relative to its own rise: the library grants half of it."""
NEVER = 10**100
"""Above all travel."""

Ends = list[tuple[int, int]]
"""Contours of a walk and when they were done."""


def hot_rise(problem: Problem, rules: Rules) -> int | None:
    """Return a rise that breaks the cap for certain, as the library compares it, in 1 / KELVIN K."""
    cap, material = rules.temperature_cap, problem.material
    if cap is None or material is None:
        return None
    rise = cap - material.ambient
    slack = SLACK * max(Fraction(1), abs(rise)) + FLOATS * abs(material.ambient)
    return floor((rise + slack) * KELVIN) + 1


def check_heat(
    problem: Problem, rules: Rules, proof: Any, scales: tuple[int, int], bound: int | None, budget: Budget
) -> None:
    """Refuse unless no plan within the cap is worth less than the claim."""
    fields(proof, "proof", "kind")
    require(problem.material is not None, "heat: the instance has no material")
    assert problem.material is not None
    scale, dear, hot = scales[0], None, hot_rise(problem, rules)
    if bound is not None and rules.objective == "peak":
        claimed = ceil((Fraction(bound, scale) - problem.material.ambient) * KELVIN)
        hot = claimed if hot is None else min(hot, claimed)
    elif bound is not None:
        work = sum((problem.work(contour, scale) for contour in range(len(problem.ids))), Fraction(0))
        dear = ceil(bound - (work if rules.objective == "makespan" else 0))
    search_heat(problem, rules, scale, dear, hot, budget)


def search_heat(
    problem: Problem, rules: Rules, scale: int, dear: int | None, hot: int | None, budget: Budget
) -> None:
    """Refuse unless no plan has travel below ``dear`` / scale mm and all rises below ``hot`` / KELVIN K."""
    require(len(problem.homes) == 1, "heat: needs one head")
    require(len(problem.ids) <= MOST_CONTOURS, f"heat: more than {MOST_CONTOURS} contours")
    if hot is not None and hot <= 0:
        return
    if not problem.ids:
        require(dear is not None and dear <= 0, "heat: the head only stays where it is")
        return
    search = Search(problem, rules, scale, dear, hot, budget)
    home, nodes = problem.homes[0], list(range(len(search.contour_of)))
    nothing = [0 for _ in nodes]
    if dear is None:
        search.check(nothing, nothing, None)
    elif home is not None:
        end = [problem.lengths(v, [home], scale)[0] for v in nodes]
        search.check(problem.lengths(home, nodes, scale), end, None)
    else:
        # Times count from the first contour, so it matters where a closed tour begins.
        for first in nodes:
            search.check(nothing, [problem.lengths(v, [first], scale)[0] for v in nodes], first)


def _farthest(problem: Problem) -> int:
    """Return the time to the largest coordinate."""
    if problem.metric == "matrix":
        return 0
    largest = max(abs(value) for place in problem.places for value in place)
    return ceil(Fraction(largest, problem.denominator) / problem.v_jump * SECOND)


class Search:
    """The walks of a problem."""

    def __init__(
        self, problem: Problem, rules: Rules, scale: int, dear: int | None, hot: int | None, budget: Budget
    ) -> None:
        self.budget, self.dear, self.hot = budget, NEVER if dear is None else dear, hot
        self.count = len(problem.ids)
        self.full = (1 << self.count) - 1
        self.entries = problem.entries
        self.contour_of = [contour for contour, nodes in enumerate(problem.entries) for _ in nodes]
        points = len(self.contour_of)
        fits = points <= MOST_POINTS and points * points << self.count <= MOST_CELLS
        require(fits, "heat: more points and contours than are searched")
        pairs, sets = points * points, 1 << max(0, self.count - 2)
        budget.spend(pairs * sets * (self.count + STATE_STEPS))
        budget.spend(DISTANCE_STEPS * points * sum(len(curve) for curve in problem.curves))
        nodes, contours = list(range(points)), list(range(self.count))
        # Where travel has no limit it is 0, so none is above NEVER.
        self.cost = [
            [0] * points if dear is None else step_costs(problem, rules, v, nodes, scale) for v in nodes
        ]
        self.before, self.mates = preceding(problem, contours), mates_of(problem, rules, contours)
        curves = Curves(problem, budget) if rules.neighbours_only or rules.clear_rapids else None
        self.barring = [[self._barring(problem, rules, curves, v, w) for w in nodes] for v in nodes]
        self.warmth = Warmth(problem)
        self._fill_times(problem)
        self.members = [[j for j in contours if cut >> j & 1] for cut in range(1 << self.count)]
        self.barred = [[self._bars(v, w) for w in nodes] for v in nodes]
        self.onward: list[list[int]] = []

    def _barring(self, problem: Problem, rules: Rules, curves: Curves | None, v: int, w: int) -> int:
        """Return the contours that bar the step from v to w once one of them is cut; v's is always cut."""
        a, b = self.contour_of[v], self.contour_of[w]
        if curves is None or a == b:
            return 0
        parts = problem.parts[a], problem.parts[b]
        if rules.neighbours_only and parts[0] != parts[1] and not curves.neighbours(*parts):
            return 1 << a
        return curves.crossed(v, w) if rules.clear_rapids else 0

    def _fill_times(self, problem: Problem) -> None:
        """Fill d, the works, the sums of ways, and how far off a time may be."""
        nodes = list(range(len(self.contour_of)))
        scale = ceil(SECOND / problem.v_jump) * FINER
        unit = SECOND / (scale * problem.v_jump)
        self.way = [[floor(each * unit) for each in problem.lengths(v, nodes, scale)] for v in nodes]
        home = problem.homes[0]
        out = 0 if home is None else floor(max(problem.lengths(home, nodes, scale)) * unit)
        self.work = [floor(each * SECOND) for each in problem.seconds]
        least, most = [0] * self.count, [0] * self.count
        for b, inside in enumerate(self.entries):
            ways = [self.way[v][w] for v in nodes if self.contour_of[v] != b for w in inside]
            least[b], most[b] = min(ways, default=0), max(ways, default=0)
        longest = out + _farthest(problem) + sum(self.work) + sum(most) + 2 * self.count + 2
        self.early = ceil(longest * FLOATS) + 1
        self.late = self.early + 2 * self.count
        self.soonest, self.latest = [0], [0]
        for cut in range(1, 1 << self.count):
            j, rest = cut.bit_length() - 1, cut ^ 1 << cut.bit_length() - 1
            self.soonest.append(self.soonest[rest] + self.work[j] + least[j])
            self.latest.append(self.latest[rest] + self.work[j] + most[j])

    def _bars(self, v: int, w: int) -> bytearray:
        """Return for each set S with v's contour, without w's, whether (1) is at least ``hot``."""
        a, b = self.contour_of[v], self.contour_of[w]
        barred = bytearray(1 << self.count)
        if a == b or self.hot is None:
            return barred
        way, hot = self.way[v][w], self.hot
        rise = [hot] * (1 << self.count)
        rise[0] = self.warmth.least(w, a, way - self.early, way + self.late)
        barred[1 << a] = rise[0] >= hot
        own, terms = 1 << a | 1 << b, 1
        for done in range(1, 1 << self.count):
            if done & own:
                continue
            best = hot
            for j in self.members[done]:
                known = rise[done ^ 1 << j]
                if known < best:
                    behind = done ^ 1 << j | 1 << a
                    soon = way + self.soonest[behind] - self.early
                    late = way + self.latest[behind] + self.late
                    best = min(best, known + self.warmth.least(w, j, soon, late))
                    terms += 1
            rise[done] = best
            barred[done | 1 << a] = best >= hot
        self.budget.spend(terms * KERNEL_STEPS)
        return barred

    def _may_come(self, cut: int, v: int, w: int) -> bool:
        """Whether the step from v to w is allowed and below ``hot`` by (1), once ``cut`` is."""
        a, b = self.contour_of[v], self.contour_of[w]
        if cut >> b & 1 or self.before[b] & ~cut or self.barring[v][w] & cut or self.barred[v][w][cut]:
            return False
        return bool(self.mates[a] >> b & 1) or not self.mates[a] & ~cut

    def check(self, start: list[int], end: list[int], first: int | None) -> None:
        """Refuse unless (3), for the walks that begin at ``first``, or at any point."""
        self._fill_onward(end)
        for w in range(len(start)) if first is None else [first]:
            b = self.contour_of[w]
            if not self.before[b] and start[w] + self.onward[1 << b][w] < self.dear:
                self._go_on(w, 1 << b, start[w], [(b, self.work[b])])

    def _fill_onward(self, end: list[int]) -> None:
        """(2)."""
        points = len(end)
        self.budget.spend(STATE_STEPS * (points * points << max(0, self.count - 2)))
        self.onward = [[NEVER] * points for _ in range(1 << self.count)]
        self.onward[self.full] = end
        for cut in range(self.full - 1, 0, -1):
            for a in self.members[cut]:
                for v in self.entries[a]:
                    self.onward[cut][v] = min(
                        (
                            self.cost[v][w] + self.onward[cut | 1 << b][w]
                            for b in self.members[self.full ^ cut]
                            for w in self.entries[b]
                            if self._may_come(cut, v, w)
                        ),
                        default=NEVER,
                    )

    def _go_on(self, v: int, cut: int, travel: int, ends: Ends) -> None:
        """Try all steps from the end of a walk that (3) does not end."""
        require(cut != self.full, "heat: a plan below the bound, within the cap, is not excluded")
        now = ends[-1][1]
        self.budget.spend(STATE_STEPS * len(self.contour_of))
        for b in self.members[self.full ^ cut]:
            for w in self.entries[b]:
                further, after = travel + self.cost[v][w], cut | 1 << b
                if further + self.onward[after][w] < self.dear and self._may_come(cut, v, w):
                    begun = now + self.way[v][w]
                    if self.hot is None or self._rise(w, begun, ends) < self.hot:
                        self._go_on(w, after, further, [*ends, (b, begun + self.work[b])])

    def _rise(self, w: int, begun: int, ends: Ends) -> int:
        """Return the rise at w from a walk, rounded down; it is enough when it reaches ``hot``."""
        total = 0
        self.budget.spend(KERNEL_STEPS * len(ends))
        for j, done in reversed(ends):
            total += self.warmth.least(w, j, begun - done - self.early, begun - done + self.late)
        return total
