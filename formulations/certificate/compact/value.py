r"""What multipliers of a compact model's rows prove, by weak duality.

    (1) K q * value of a plan >= sum_i m_i b_i + sum_j min(r_j l_j, r_j u_j),    r = K q cost - sum_i m_i row_i

for integers m, those of inequalities at least 0, and any rows that the plan keeps at a point whose variables
lie in their ranges l .. u and which costs no more than it. Variables are all legs of all heads, makespan and
imbalance without upper bound, and p, f, g, unit, w (``terms``). In units of 1 / (scale * v_jump) s for the
makespan, 1 / scale mm else,

    cost = makespan,   or  sum of floor(l) + floor(price * backward), + p / q * imbalance for weighted

with weight / v_jump = p / q. Rows speak of sums of legs, so r of a leg is found from those it counts in: all
rows are added up first, then one pass goes over the legs. Legs that rules bar are looked at only where r < 0.
"""

from collections import defaultdict
from collections.abc import Sequence
from typing import Any

from cutgap.formulations.certificate.compact.rows import CompactRows
from cutgap.formulations.certificate.compact.terms import DEPOT, Name, Setting
from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.proof import Budget
from cutgap.formulations.certificate.reading import Refused, entries, fields, integer, require, show
from cutgap.formulations.certificate.rules import Rules
from cutgap.formulations.certificate.walks import step_costs

Sums = defaultdict[Name, int]
"""The numbers in front of terms, after all rows are added up."""


def check_compact(
    problem: Problem, rules: Rules, proof: Any, scales: tuple[int, int], bound: int | None, budget: Budget
) -> None:
    """Refuse unless the multipliers prove the bound; ``scales`` are those of lengths and multipliers."""
    table = fields(proof, "proof", "kind formulation multipliers")
    require(bound is not None, "compact: proves bounds, not that there is no plan")
    worth = compact_value(problem, rules, table["formulation"], table["multipliers"], *scales, budget)
    require(worth >= (bound or 0), f"the multipliers are worth {show(worth)}, less than the claimed bound")


def compact_value(
    problem: Problem,
    rules: Rules,
    formulation: Any,
    multipliers: Any,
    scale: int,
    multiplier_scale: int,
    budget: Budget | None = None,
) -> int:
    """Return the largest bound that multipliers prove, by (1).

    Parameters
    ----------
    multipliers
        Pairs [row, m], a row as [family, index, ...].
    scale
        Lengths are integers in 1 / scale mm.
    multiplier_scale
        K: multipliers are in 1 / K.

    Returns
    -------
    int
        In units of 1 / (scale * v_jump) s for the makespan, 1 / scale mm else; may be below 0.

    Raises
    ------
    Refused
        For a row that the model has not, or a multiplier of the wrong sign or size.
    """
    rows = CompactRows(problem, rules, formulation, scale, budget or Budget())
    value, sums = _added_up(rows, multipliers)
    factor, most = rows.imbalance_price.denominator, multiplier_scale * rows.imbalance_price.numerator
    require(sums["imbalance",] <= most, "the multipliers of imbalance rows add up to more than the weight")
    require(sums["makespan",] <= multiplier_scale, "the multipliers of makespan rows add up to more than 1")
    value += _auxiliary_value(sums, len(problem.ids))
    price_of_legs = 0 if rules.objective == "makespan" else multiplier_scale * factor
    return (value + _legs_value(rows.setting, sums, price_of_legs)) // (multiplier_scale * factor)


def _added_up(rows: CompactRows, multipliers: Any) -> tuple[int, Sums]:
    """Return the sum of m b, and the sum of m row."""
    value, sums = 0, Sums(int)
    for index, pair in enumerate(entries(multipliers, "multipliers")):
        try:
            name, multiplier = entries(pair, "pair", count=2)
            row = rows.row(name)
            allowed = integer(multiplier, "multiplier") >= 0 or row.equality
            require(allowed, f"multiplier {show(multiplier)} of a row that is no equation")
        except Refused as error:
            raise Refused(f"multipliers {index}: {error}") from None
        value += multiplier * row.rhs
        for coefficient, term in row.terms:
            sums[term] += multiplier * coefficient
    return value, sums


def _auxiliary_value(sums: Sums, count: int) -> int:
    """Return the share of positions and flows in (1); they cost nothing."""
    ranges = {"p": (1, count), "f": (0, count), "g": (0, count), "unit": (0, 1), "w": (0, 1)}
    value = 0
    for (kind, *_), number in sums.items():
        low, high = ranges.get(kind, (0, 0))
        value -= max(number * low, number * high)
    return value


def _legs_value(setting: Setting, sums: Sums, price: int) -> int:
    """Return the share of all legs in (1), their cost being ``price`` times their cost in mm / scale."""
    problem, nodes = setting.problem, list(range(len(setting.problem.xs)))
    ways = [Way(setting, sums, head) for head in setting.heads]
    setting.budget.spend(10 * len(ways) * len(nodes) ** 2)
    value = 0
    for way in ways:
        if way.home is not None:
            value += way.out_of_home(problem.lengths(way.home, nodes, setting.scale), price)
    for u in nodes:
        lengths = problem.lengths(u, nodes, setting.scale)
        costs = step_costs(problem, setting.rules, u, nodes, setting.scale) if price else lengths
        for way in ways:
            value += way.to_others(u, lengths, costs, price)
            if way.home is None:
                value += way.closing(u, lengths, price)
            else:
                value += way.to_home(u, problem.lengths(u, [way.home], setting.scale)[0], price)
    return value


class Way:
    """The legs of one head, with what the rows add up to for them.

    Attributes
    ----------
    time
        The number in front of the head's time.
    enters, begins, leaves, ends
        For each node, what counts for legs to it, in addition for first legs to it, for legs out of it, and in
        addition for last legs out of it.
    single
        For each node the legs out of it that rows name one by one.
    """

    def __init__(self, setting: Setting, sums: Sums, head: int) -> None:
        problem, of = setting.problem, setting.contour_of
        self.setting, self.sums, self.head = setting, sums, head
        self.home = problem.homes[head]
        self.time = sums["T", head]
        cut = [
            sums["z", head, i] + self.time * (problem.work(i, setting.scale).__floor__())
            for i in range(setting.count)
        ]
        self.enters = [sums["q", head, u] + cut[i] for u, i in enumerate(of)]
        self.begins = [sums["first", head, u] + sums["y", head, DEPOT, i] for u, i in enumerate(of)]
        self.leaves = [sums["out", head, u] for u in range(len(of))]
        self.ends = [sums["y", head, i, DEPOT] for i in of]
        self.single: dict[int, list[tuple[int, int]]] = defaultdict(list)
        for name, number in sums.items():
            if name[:2] == ("x", head):
                self.single[name[2]].append((name[3], number))

    def out_of_home(self, lengths: Sequence[int], price: int) -> int:
        """Return the share of the legs out of the home."""
        each = price - self.time
        counts = zip(lengths, self.enters, self.begins, strict=True)
        return sum(min(0, each * length - enters - begins) for length, enters, begins in counts)

    def to_home(self, u: int, length: int, price: int) -> int:
        """Return the share of the leg from u to the home."""
        return min(0, (price - self.time) * length - self.leaves[u] - self.ends[u])

    def to_others(self, u: int, lengths: Sequence[int], costs: Sequence[int], price: int) -> int:
        """Return the share of the legs from u to other contours."""
        of, time, leaves = self.setting.contour_of, self.time, self.leaves[u]
        i = of[u]
        goes = [self.sums.get(("y", self.head, i, j), 0) + leaves for j in range(self.setting.count)]
        reduced = [
            price * cost - time * length - enters - goes[j]
            for cost, length, enters, j in zip(costs, lengths, self.enters, of, strict=True)
        ]
        for v, number in self.single.get(u, ()):
            reduced[v] -= number
        return sum(
            r for v, r in enumerate(reduced) if r < 0 and of[v] != i and not self.setting.is_barred(u, v)
        )

    def closing(self, u: int, lengths: Sequence[int], price: int) -> int:
        """Return the share of the legs that close a tour which ends at u."""
        of, each, ends = self.setting.contour_of, price - self.time, self.leaves[u] + self.ends[u]
        return sum(
            min(0, each * length - enters - begins - ends)
            for v, (length, enters, begins) in enumerate(zip(lengths, self.enters, self.begins, strict=True))
            if self._may_close(u, v, of)
        )

    def _may_close(self, u: int, v: int, of: list[int]) -> bool:
        if self.setting.turns:
            return of[v] == 0 != of[u]
        return u == v or of[u] != of[v]
