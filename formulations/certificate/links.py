r"""The relaxation of plans with links (one head); its rows and why each holds are in docs/certificates.md.

Nodes are the entry points and the home, places the contours and the home (the last ones). With c_e the cost of
a link or rapid in units of 1 / scale mm (for the makespan times and pierces count times v_jump), rounded down:

    s_e    link or rapid e is passed an odd number of times             {0, 1}
    d_ij   contours i, j are joined by a link that is passed twice,
           or contour i and the home by a rapid                         {0, 1}
    e_ij   half of s_ij, the sum of the s between places i and j, rounded down; t_ij = s_ij - 2 e_ij
    w_ijk  t_ij t_jk t_ik                                               {0, 1}

    min  sum c_e s_e + sum 2 c_ij d_ij,   c_ij the least c_e between i and j
    home       s(delta(home)) + 2 d(delta(home)) = 2
    partition  (k - 1) s(delta(P)) + k d(delta(P)) - (k - 2) e(delta(P)) >= k (k - 1)
                                                                    P parts the places into k >= 2 sets
    parity     s(delta(T) \ F) - s(F) >= 1 - |F|                    T a set of nodes, F odd, within delta(T)
    pierces    - s(rapids between contours) >= 1 - most pierces
    group      - ends(W) - 2 sum of (s_e + d_e) over e in T >= - 2 |W|    T a forest of links among contours W
    once       2 e_ij - s_ij >= -1
    bundle     2 e_ij - s_ij + s(T : not j) + s(i \ T : j) >= 0     T a set of nodes of place i
    triangle   w_ijk - t_ij + R_i + R_j >= 0, R_i = s(T : not j, k) + s(i \ T : j, k), T a set of nodes of i
    rank       (s + d - e)(delta(P)) - sum of w over triples of F that P parts >= k - 1
                                                                    no two triples of F share two places

Links that are shown to be blocked are left out. Where a link costs no more than the rapid only one of the two
is there: the link if it is clear, else the rapid; it is named as the link. Every pair of nodes is priced, but
for pairs of contours that a bound on their distance excludes: what that bound leaves out only adds to reduced
costs.
"""

from collections.abc import Iterator
from fractions import Fraction
from itertools import combinations
from math import floor
from typing import Any

from cutgap.formulations.certificate.link_costs import DOUBLE, LINK, RAPID, Costs, Edge, Triple
from cutgap.formulations.certificate.link_prices import Prices
from cutgap.formulations.certificate.material import Material
from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.proof import Budget
from cutgap.formulations.certificate.reading import Refused, entries, fields, integer, require, show
from cutgap.formulations.certificate.rules import Rules

SHARES = 10**6
"""The place on a blocked link is a share of it with this denominator."""


def check_links(
    problem: Problem, rules: Rules, proof: Any, scales: tuple[int, int], bound: int | None, budget: Budget
) -> None:
    """Refuse unless the tree proves the bound; ``None``: that there is no plan."""
    table = fields(proof, "proof", "kind rows nodes blocked")
    require(len(problem.homes) == 1 and problem.homes[0] is not None, "links: needs one head with a home")
    require(problem.is_symmetric(), "links: takes symmetric lengths")
    require(problem.located, "links: the points carry no coordinates")
    require(rules.links, "links: the rules allow none")
    costs = Costs(problem, rules, scales[0], bound is None)
    _block(costs, table["blocked"], budget)
    work = 0
    if rules.objective == "makespan":
        perimeter = sum((contour[2] for contour in problem.contours), Fraction(0))
        work = floor(scales[0] * problem.v_jump * perimeter / problem.v_cut)
    if not problem.ids:
        require(bound is not None and bound <= 0, "links: without contours the empty plan is worth 0")
        return
    target = 1 if bound is None else scales[1] * (bound - work)
    Tree(costs, rules, scales[1], table["rows"], budget).check(table["nodes"], target)


def _block(costs: Costs, value: Any, budget: Budget) -> None:
    """Take in the links that are shown to lead through material."""
    material = Material(costs.problem) if entries(value, "blocked") else None
    for index, entry in enumerate(value):
        p, q, share = (
            integer(each, f"blocked {index}", least=0) for each in entries(entry, "blocked", count=3)
        )
        require(p < q < costs.home_node and share <= SHARES, f"blocked {index}: no link")
        budget.spend(30 * sum(map(len, costs.problem.curves)) + 100)
        assert material is not None
        shown = material.is_blocked(p, q, Fraction(share, SHARES))
        require(shown, f"blocked {index}: the link from node {p} to {q} is not deep in a part there")
        costs.blocked.add((p, q))


class Tree:
    """Rows, and the branching tree whose leaves add them up."""

    def __init__(self, costs: Costs, rules: Rules, multiplier_scale: int, names: Any, budget: Budget) -> None:
        self.costs, self.rules, self.scale, self.budget = costs, rules, multiplier_scale, budget
        self.least = {(i, j): costs.least(i, j) for i, j in combinations(range(costs.home), 2)}
        self.rows = []
        for index, name in enumerate(entries(names, "rows")):
            try:
                self.rows.append(self._row(name))
            except Refused as error:
                raise Refused(f"row {index}: {error}") from None

    def _row(self, name: Any) -> tuple[Any, ...]:
        """Return a row's kind and content."""
        match name:
            case ["home"]:
                return ("home",)
            case ["pierces"] if self.rules.pierces is not None:
                return ("pierces", self.rules.pierces)
            case ["partition", list(given)] if given:
                return ("partition", self._labels(given), len(given) + 1)
            case ["rank", list(given), list(triples)] if given:
                family = [self._triple(each) for each in triples]
                pairs = [pair for triple in family for pair in combinations(triple, 2)]
                require(len(set(pairs)) == len(pairs), "rank: two triples share two places")
                return ("rank", self._labels(given), len(given) + 1, family)
            case ["triangle", int(i), int(j), int(k), nodes, others]:
                triple = self._triple(sorted((i, j, k)))
                return ("triangle", (i, j, k), triple, self._members(i, nodes), self._members(j, others))
            case ["parity", nodes, list(given)]:
                inside = frozenset(self._numbers(nodes, self.costs.home_node + 1))
                odd = [self._single(edge) for edge in given]
                require(
                    len(set(odd)) == len(odd) and len(odd) % 2 == 1, "parity: expected an odd number of edges"
                )
                across = all((p in inside) != (q in inside) for _, p, q in odd)
                require(across, "parity: an edge does not lead out of the set")
                return ("parity", inside, odd)
            case ["once", int(i), int(j)] if 0 <= i < j <= self.costs.home:
                return ("once", i, j)
            case ["bundle", int(i), int(j), nodes] if i != j and 0 <= min(i, j) <= max(i, j) <= self.costs.home:
                inside = self._members(i, nodes)
                return ("bundle", i, j, inside)
            case ["group", contours, list(given)]:
                members = self._numbers(contours, self.costs.home)
                return ("group", members, self._forest(members, given))
        raise Refused(f"no row {show(name)}")

    def _numbers(self, value: Any, count: int, least: int = 1) -> list[int]:
        numbers = [integer(each, "set", least=0) for each in entries(value, "set")]
        require(
            len(numbers) >= least and len(set(numbers)) == len(numbers) and max(numbers, default=0) < count,
            f"set: expected different numbers below {count}",
        )
        return numbers

    def _labels(self, given: list[Any]) -> list[int]:
        """Return the part of each place; the home is in the last one, with all that is named in none."""
        parts = [self._numbers(part, self.costs.home) for part in given]
        members = [contour for part in parts for contour in part]
        require(len(set(members)) == len(members), "partition: the parts overlap")
        label = [len(parts)] * (self.costs.home + 1)
        for number, part in enumerate(parts):
            for contour in part:
                label[contour] = number
        return label

    def _triple(self, value: Any) -> Triple:
        """Return three places in ascending order."""
        i, j, k = (integer(each, "triple", least=0) for each in entries(value, "triple", count=3))
        require(i < j < k <= self.costs.home, "triple: expected three places in ascending order")
        return i, j, k

    def _members(self, place: int, nodes: Any) -> frozenset[int]:
        """Return a set of nodes of a place."""
        inside = frozenset(self._numbers(nodes, self.costs.home_node + 1, least=0))
        require(inside.issubset(self.costs.members[place]), "a node of another place")
        return inside

    def _single(self, value: Any) -> Edge:
        """Return a link or rapid; where only one of both is there, the link stands for it."""
        costs = self.costs
        match value:
            case ["s" | "r" as kind, int(p), int(q)] if 0 <= p < q < costs.home_node + (kind == RAPID):
                require(costs.place_of[p] != costs.place_of[q], "an edge within a contour")
                return (LINK if costs.joined(p, q) else kind), p, q
        raise Refused(f"no link or rapid {show(value)}")

    def _forest(self, members: list[int], given: list[Any]) -> list[Edge]:
        """Return the edges of a forest: joints [i, j], each with a link [i, j, p, q] or without."""
        leader, edges = {contour: contour for contour in members}, list[Edge]()
        for joint in given:
            numbers = [integer(each, "joint", least=0) for each in entries(joint, "joint")]
            require(len(numbers) in (2, 4), "group: expected joints of two contours, or with two nodes")
            i, j, *nodes = numbers
            require(i < j and i in leader and j in leader, "group: a joint of other contours")
            require(leader[i] != leader[j], "group: the joints close a circle")
            old, new = leader[i], leader[j]
            leader = {contour: new if each == old else each for contour, each in leader.items()}
            edges.append((DOUBLE, i, j))
            if nodes:
                _, p, q = self._single(["s", *nodes])
                require(
                    (self.costs.place_of[p], self.costs.place_of[q]) == (i, j),
                    "group: a link of other contours",
                )
                edges.append((LINK, p, q))
        return edges

    def check(self, nodes: Any, target: int) -> None:
        """Refuse unless every leaf is worth the target."""
        tree = entries(nodes, "nodes")
        require(tree != [], "nodes: expected at least one")
        reached = [False] * len(tree)
        stack: list[tuple[int, dict[Edge, int]]] = [(0, {})]
        while stack:
            index, fixed = stack.pop()
            require(not reached[index], f"node {index} is reached twice")
            reached[index] = True
            node = tree[index]
            require(isinstance(node, dict), f"node {index}: expected an object")
            try:
                if "leaf" in node:
                    value = self._value(fields(node, "node", "leaf")["leaf"], fixed)
                    require(value >= target, f"the leaf is worth {show(value)}, less than {show(target)}")
                    continue
                table = fields(node, "branch", "branch at down up")
                require(table["at"] == 0, "at: expected 0")
                edge = self._variable(table["branch"])
                require(edge not in fixed, "branch: the variable is fixed already")
            except Refused as error:
                raise Refused(f"node {index}: {error}") from None
            for side, at in (("down", 0), ("up", 1)):
                child = integer(table[side], side)
                require(index < child < len(tree), f"node {index}: its child must come later in the list")
                stack.append((child, {**fixed, edge: at}))
        require(all(reached), "a node is never reached")

    def _variable(self, value: Any) -> Edge:
        match value:
            case ["d", int(i), int(j)] if 0 <= i < j <= self.costs.home:
                return DOUBLE, i, j
        return self._single(value)

    def _value(self, multipliers: Any, fixed: dict[Edge, int]) -> int:
        """Return what a leaf proves: sum of multiplier times right side, and of negative reduced costs."""
        prices, costs = self._prices(multipliers), self.costs
        self.budget.spend(20 * len(self.least) + 50 * costs.home_node)
        value = prices.value
        for edge, at in fixed.items():
            value += at * self._reduced(edge, prices)
        for i in range(costs.home):
            value += self._pay((DOUBLE, i, costs.home), prices, fixed)
            value += sum(self._pay((RAPID, p, costs.home_node), prices, fixed) for p in costs.members[i])
        value += sum(min(0, reduced) for reduced in prices.triples.values())
        value += sum(self._excess(i, j, reduced, prices) for (i, j), reduced in prices.excess.items())
        most = [max(prices.node[p] for p in nodes) for nodes in costs.members]
        for i, j in self.least:
            value += sum(self._pay(edge, prices, fixed) for edge in self._tempting(i, j, most, prices))
        return value

    def _excess(self, i: int, j: int, reduced: int, prices: Prices) -> int:
        """Return the least that an e adds to the value: it is at most the number of pairs of nodes."""
        self.budget.spend(len(prices.partitions))
        reduced += sum(price for price, label in prices.partitions if label[i] != label[j])
        return min(0, reduced) * len(self.costs.members[i]) * len(self.costs.members[j])

    def _tempting(self, i: int, j: int, most: list[int], prices: Prices) -> Iterator[Edge]:
        """Yield the edges between two contours that may have negative reduced costs."""
        link, rapid = self.least[i, j]
        if 2 * self.scale * link < prices.double[i][j]:
            yield DOUBLE, i, j
        by_rapid = prices.end[i] + prices.end[j] + prices.rapid
        least = min(self.scale * link, self.scale * rapid - by_rapid) - prices.single[i][j]
        if least >= most[i] + most[j]:
            return
        self.budget.spend(20 * len(self.costs.members[i]) * len(self.costs.members[j]))
        for p in self.costs.members[i]:
            rest = least - prices.node[p]
            for q in self.costs.members[j]:
                if rest < prices.node[q]:
                    yield from self._between(p, q)

    def _between(self, p: int, q: int) -> Iterator[Edge]:
        """Yield the single edges between two nodes of contours."""
        if self.costs.joined(p, q):
            yield LINK, p, q
            return
        if (p, q) not in self.costs.blocked:
            yield LINK, p, q
        if not self.costs.no_rapids:
            yield RAPID, p, q

    def _pay(self, edge: Edge, prices: Prices, fixed: dict[Edge, int]) -> int:
        """Return the least that an edge which is not fixed adds to the value."""
        return 0 if edge in fixed else min(0, self._reduced(edge, prices))

    def _reduced(self, edge: Edge, prices: Prices) -> int:
        kind, p, q = edge
        costs = self.costs
        if kind == DOUBLE:
            cost = costs.double(p, q)
            tree = prices.tree.get(edge, 0)
            return 0 if cost is None else self.scale * cost - prices.double[p][q] + tree
        i, j = costs.place_of[p], costs.place_of[q]
        common = prices.odd.get(edge, 0) - prices.node[p] - prices.node[q] - prices.single[i][j]
        common += sum(2 * price for inside, price in prices.sets if p in inside and q in inside)
        common += prices.toward.get((p, j), 0) + prices.toward.get((q, i), 0)
        link = rapid = None
        if kind == LINK:
            link = self.scale * costs.link(p, q) + prices.tree.get(edge, 0)
        if kind == RAPID or costs.joined(p, q):
            between = prices.rapid if j < costs.home else 0
            rapid = self.scale * costs.rapid(p, q) - prices.end[i] - prices.end[j] - between
        if link is not None and rapid is not None and (p, q) in costs.blocked:
            link = None
        return common + min(each for each in (link, rapid) if each is not None)

    def _prices(self, multipliers: Any) -> Prices:
        """Add up rows."""
        costs = self.costs
        places = costs.home + 1
        single, double = ([[0] * places for _ in range(places)] for _ in range(2))
        prices = Prices(
            [0] * (costs.home_node + 1), single, double, [0] * places, 0, [], {}, {}, {}, {}, [], {}, 0
        )
        for entry in entries(multipliers, "multipliers"):
            index, price = (integer(each, "multiplier") for each in entries(entry, "multipliers", count=2))
            require(0 <= index < len(self.rows), f"there is no row {show(index)}")
            kind, *content = self.rows[index]
            require(price >= 0 or kind == "home", "a negative multiplier of a row that is no equation")
            self.budget.spend(places * places if kind in ("partition", "rank") else 100)
            getattr(prices, f"add_{kind}")(price, *content)
        return prices
