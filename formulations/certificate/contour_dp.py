r"""A lower bound for one head by dynamic programming over sets of contours, computed again from scratch.

    F(S, v)     least cost of a walk that has cut the set S, the last contour at node v
    R_k(v, M)   least cost of going on from v, at position k of 0..n-1, over n - 1 - k visits to the base, among
                walks that may cut a contour again once they have forgotten it: at a contour a they remember, of
                what they cut later, the set M, a subset of N_a
    p_a         an integer for each contour, added to the cost of each visit

    f_k(v)      least cost of a walk of k + 1 visits to v, without p of the last one, that forgets everything

    (1) R_(n-1)(v, {}) = t_v
    (2) R_k(v, M') <= c_vw + p_b + R_(k+1)(w, M),   M' = (M + {b}) restricted to N_a,  v in a, w in b, where
        a is not b and not in M; nothing in M + {b} must precede a; at least |before a| visits come before
        position k, at least as many after it as must follow a; and if parts are cut in one go and a, b are in
        different parts, M holds all mates of b, and no mate of a must follow it; if only neighbours may follow
        each other, the parts of a and b are neighbours
        A state with R_k(v, M) + p_a + f_k(v) >= limit is dropped
    (3) the state (S, v) at position k is dropped when F(S, v) + R_k(v, M) >= limit for all M that do not meet S
    (4) no state is left at the end with F + t < limit:  no walk costs less than limit - sum p

Why (2) holds: a walk that cuts each contour once, read from its end, passes such steps, and M holds what it cut
later as far as it is remembered. Mates are always remembered: N_a contains those of a, so along a part, which
is cut without a break, none is forgotten. Why (4): a walk below limit - sum p passes a state at each position
whose F is at most, and R at most, what it costs before and after; so none of its states is dropped, whatever
p and N are: these are hints, and bad ones only make the work longer. Clear rapids count for F alone.

When all lengths are multiples of a unit, a bound that is a multiple of it holds as soon as no walk costs less
than the next lower multiple plus 1.
"""

from operator import add
from typing import Any

from cutgap.formulations.certificate.barred import INFINITE, Barred
from cutgap.formulations.certificate.curves import Curves
from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.proof import Budget
from cutgap.formulations.certificate.reading import Refused, entries, fields, integer, require, show
from cutgap.formulations.certificate.rules import Rules
from cutgap.formulations.certificate.walks import Visit, Walks, beginnings, length_unit, walks_from

Row = list[int]
Layer = list[dict[int, Row]]
"""For each contour, a row of values (one a node) for each set of bits."""


def check_contours(problem: Problem, rules: Rules, proof: Any, target: int, scale: int, budget: Budget) -> None:
    """Refuse unless the proof shows that every walk costs at least ``target``, in 1 / scale mm."""
    table = fields(proof, "proof", "kind walks")
    given: dict[Visit | None, Any] = {}
    for index, entry in enumerate(entries(table["walks"], "walks")):
        try:
            item = fields(entry, "walk", "first prices memories")
            first = _beginning(problem, item["first"])
            require(first not in given, "first: this beginning is there already")
            given[first] = item
        except Refused as error:
            raise Refused(f"walks {index}: {error}") from None
    covered = any(all(first in given for first in each) for each in beginnings(problem, rules))
    require(covered, "walks: some beginnings of tours are left out")
    curves = Curves(problem, budget) if rules.neighbours_only or rules.clear_rapids else None
    unit = length_unit(problem, rules, scale)
    limit = (target - 1) // unit * unit + 1
    for first, item in given.items():
        require(first is not None or problem.homes[0] is not None, "walks: the head has no home to begin at")
        walks = walks_from(problem, rules, first, scale)
        prices, memories = _hints(walks, problem, item)
        barred = Barred(problem, rules, walks, first, curves)
        Programme(walks, prices, memories, limit, barred, budget).check()


def _beginning(problem: Problem, value: Any) -> Visit | None:
    if value is None:
        return None
    name, entry = entries(value, "first", count=2)
    require(isinstance(name, str) and name in problem.ids, f"first: no contour {show(name)}")
    contour = problem.ids.index(name)
    nodes = problem.entries[contour]
    require(integer(entry, "first, entry", least=0) < len(nodes), f"first: no entry point {show(entry)}")
    return contour, nodes[entry]


def _hints(walks: Walks, problem: Problem, item: Any) -> tuple[list[int], list[int]]:
    """Return p, and N as sets of bits; both lists are over all contours of the instance."""
    count = len(problem.ids)
    prices = [integer(each, "prices") for each in entries(item["prices"], "prices", count=count)]
    lists = [entries(each, "memories") for each in entries(item["memories"], "memories", count=count)]
    for each in lists:
        known = all(type(contour) is int and 0 <= contour < count for contour in each)
        require(known, "memories: expected numbers of contours")
    numbers = {contour: number for number, contour in enumerate(walks.contours)}
    kept = [sum(1 << b for b in {numbers[c] for c in lists[a] if c in numbers}) for a in walks.contours]
    memories = [kept[a] & ~(1 << a) | walks.mates[a] for a in range(len(walks.contours))]
    return [prices[contour] for contour in walks.contours], memories


class Programme:
    """One run of the programme; ``limit`` is on the cost without prices."""

    def __init__(
        self,
        walks: Walks,
        prices: list[int],
        memories: list[int],
        limit: int,
        barred: Barred,
        budget: Budget,
    ) -> None:
        self.walks, self.prices, self.memories, self.budget = walks, prices, memories, budget
        self.barred = barred
        self.count = len(walks.contours)
        self.limit = limit + sum(prices)
        self.after = [
            sum(1 << b for b in range(self.count) if walks.before[b] >> a & 1) for a in range(self.count)
        ]
        self.front: list[list[Row]] = []
        self.onward: list[Layer] = []
        self.known: dict[tuple[int, int, int], Row] = {}

    def check(self) -> None:
        """Refuse unless (4)."""
        if self.count == 0:
            require(self.limit <= 0, "the head only stays where it is, which costs nothing")
            return
        self._fill_front()
        self._fill_onward()
        layer: Layer = [{} for _ in range(self.count)]
        for a in range(self.count):
            if self.walks.before[a] == 0 and self.walks.openers >> a & 1:
                reached = [cost + self.prices[a] for cost in self.walks.start[a]]
                self._keep(layer, 0, a, 1 << a, self.barred.first(a, reached))
        for k in range(1, self.count):
            layer = self._next(layer, k)
        for a, rows in enumerate(layer):
            for row in rows.values():
                least = min(map(add, row, self.walks.end[a])) - sum(self.prices)
                require(
                    least >= self.limit - sum(self.prices), f"a walk of cost {show(least)} is below the bound"
                )

    def _fill_front(self) -> None:
        """Fill f, by position and contour."""
        first = self.walks.start
        self.front = [[row if self._allowed(a, 0) else self._nothing(a) for a, row in enumerate(first)]]
        for k in range(1, self.count):
            paid = [[value + self.prices[a] for value in row] for a, row in enumerate(self.front[-1])]
            self.front.append([self._reached(paid, b, k) for b in range(self.count)])

    def _reached(self, paid: list[Row], b: int, k: int) -> Row:
        least = self._nothing(b)
        for a, row in enumerate(paid):
            # Coming from another part, all mates of b are still to be cut.
            ahead = 0 if self.walks.mates[b] >> a & 1 else self.walks.mates[b]
            if self._allowed(b, k) and self._may_precede(a, k - 1, b, ahead):
                self.budget.spend(len(row) * len(least) + 10)
                least = list(map(min, least, [min(map(add, leg, row)) for leg in self.walks.steps[a][b]]))
        return least

    def _allowed(self, a: int, k: int) -> bool:
        """Whether contour a may be at position k."""
        later = self.after[a].bit_count()
        return self.walks.before[a].bit_count() <= k <= self.count - 1 - later

    def _fill_onward(self) -> None:
        """(1) and (2)."""
        last = [{0: end} if self._allowed(a, self.count - 1) else {} for a, end in enumerate(self.walks.end)]
        self.onward = [last]
        for k in range(self.count - 2, -1, -1):
            layer: list[dict[int, Row]] = [{} for _ in range(self.count)]
            for b, rows in enumerate(self.onward[0]):
                for memory, row in rows.items():
                    for a in range(self.count):
                        if self._may_precede(a, k, b, memory):
                            self._lower(layer[a], a, b, (memory | 1 << b) & self.memories[a], row)
            self.onward.insert(0, [self._promising(k, a, rows) for a, rows in enumerate(layer)])

    def _promising(self, k: int, a: int, rows: dict[int, Row]) -> dict[int, Row]:
        """Drop states of R that are too dear together with f."""
        bounds = [self.limit - self.prices[a] - value for value in self.front[k][a]]
        kept = {}
        for memory, row in rows.items():
            below = [value if value < most else INFINITE for value, most in zip(row, bounds, strict=True)]
            if min(below) < INFINITE:
                kept[memory] = below
        return kept

    def _may_precede(self, a: int, k: int, b: int, memory: int) -> bool:
        later = memory | 1 << b
        if later >> a & 1 or self.walks.before[a] & later or not self._allowed(a, k):
            return False
        mates = self.walks.mates
        if not self.barred.may_follow(a, b):
            return False
        if mates[a] >> b & 1:
            return True
        return mates[b] & ~memory == 0 and mates[a] & self.after[a] == 0

    def _lower(self, rows: dict[int, Row], a: int, b: int, memory: int, row: Row) -> None:
        """Take the steps from the nodes of a to those of b into R."""
        self.budget.spend(len(self.walks.nodes[a]) * len(row) + 10)
        steps, price = self.walks.steps[a][b], self.prices[b]
        onward = [price + value for value in row]
        costs = zip(*steps, strict=True)
        candidate = [min(map(add, leg, onward)) for leg in costs]
        rows[memory] = list(map(min, rows[memory], candidate)) if memory in rows else candidate

    def _next(self, layer: Layer, k: int) -> Layer:
        """Return the states at position k."""
        grown: Layer = [{} for _ in range(self.count)]
        for a, rows in enumerate(layer):
            for cut, row in rows.items():
                for b in range(self.count):
                    if cut >> b & 1 or self.walks.before[b] & ~cut:
                        continue
                    mates = self.walks.mates[a]
                    if not mates >> b & 1 and mates & ~cut:
                        continue
                    self.budget.spend(len(row) * len(self.walks.nodes[b]) + 10)
                    price = self.prices[b]
                    steps = self.barred.steps(a, b, cut)
                    reached = [price + min(map(add, leg, row)) for leg in steps]
                    self._keep(grown, k, b, cut | 1 << b, reached)
        return grown

    def _keep(self, layer: Layer, k: int, a: int, cut: int, row: Row) -> None:
        """Keep the states of a row that (3) does not drop."""
        total = map(add, row, self._least_onward(k, a, cut))
        kept = [value if whole < self.limit else INFINITE for value, whole in zip(row, total, strict=True)]
        if min(kept) < INFINITE:
            rows = layer[a]
            rows[cut] = list(map(min, rows[cut], kept)) if cut in rows else kept

    def _least_onward(self, k: int, a: int, cut: int) -> Row:
        """Return the least R_k over all M that do not meet ``cut``."""
        seen = cut & self.memories[a]
        key = k, a, seen
        if key not in self.known:
            rows = [row for memory, row in self.onward[k][a].items() if memory & seen == 0]
            self.budget.spend(10 + len(self.onward[k][a]) + len(rows) * len(self.walks.nodes[a]))
            self.known[key] = list(map(min, *rows)) if len(rows) > 1 else (rows or [self._nothing(a)])[0]
        return self.known[key]

    def _nothing(self, a: int) -> Row:
        return [INFINITE] * len(self.walks.nodes[a])
