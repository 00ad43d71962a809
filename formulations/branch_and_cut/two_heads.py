r"""Two heads in one model: who cuts what and both tours at once, overlap allowed or not.

    Sets       i in 0..N-1 holes, a in {0, 1} heads, node N of head a its home
    Data       c_e   rapid length of edge e                                           [mm]
               w_i   v_jump times service time of hole i                              [mm]
    Variables  z_i in {0, 1}   hole i is cut by head 0; z^0_i = z_i, z^1_i = 1 - z_i  [-]
               x^a_e   how often head a runs along e: in {0, 1}, at home {0, 1, 2}    [-]
               e_a in {0, 1}   head a has work (fixed at 1 unless heads may rest)     [-]
               m, d >= 0   makespan and imbalance times v_jump                        [mm]
               T_a = sum_e c_e x^a_e + sum_i w_i z^a_i

    min  m   or   sum_{a, e} c_e x^a_e + (weight / v_jump) d
    (degree a i)     x^a(delta(i)) = 2 z^a_i
    (home a)         x^a(delta(N)) = 2 e_a
    (used a i)       e_a >= z^a_i
    (connect a i S)  x^a(delta(S)) >= 2 z^a_i       i in S, S without the home, separated
    (comb)           combs on x^0 + x^1 over sets of holes, separated
    (makespan a)     m >= T_a
    (imbalance s)    d >= s (T_0 - T_1)             s = +1, -1
    (balance s)      s (T_0 - T_1) <= v_jump * limit
    (order i j)      z_i >= z_j                     where hole i must not be right of hole j's head
    (via a i)        sum of x^a_{N j} over x_j <= x_i  >=  z^a_i

(order) is asked for x_i < x_j under non-overlap, and both ways for holes nearer in x than a positive gap.
(via) says it for the leftmost hole i of head a: an edge from the home to a hole as far left; for other i it
follows. (comb) holds because the two tours, joined by two links between doubled homes, are one Hamiltonian
cycle. Source: the 2TSP of Wang et al. (2025); subtours with optional nodes as for the generalised TSP
(Fischetti, Salazar, Toth, 1997).
"""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from cutgap.formulations.branch_and_cut import wording
from cutgap.formulations.branch_and_cut.model import Fixing, Model, Row
from cutgap.formulations.branch_and_cut.separation import (
    Cut,
    Support,
    connectivity_violations,
    separate_combs,
)
from cutgap.formulations.branch_and_cut.tour import INTEGRALITY
from cutgap.instances import Instance, Plan, Rules
from cutgap.instances.arrays import Floats, Ints, difference
from cutgap.instances.scene import Decision, Inequality, Leg, plan_nodes

Rounding = Callable[[Floats, Plan | None], tuple[float, Plan] | None]
"""Turns the values of z, and a plan if the point is one, into an allowed plan with its value in mm."""


class TwoHeadsModel(Model):
    """The model above, as the engine sees it.

    Variables are numbered z (0..N-1), e (N, N+1), m or d (N+2), then the edges of head 0 and of head 1.
    """

    wording = wording.TWO_HEADS_ROWS

    def __init__(self, instance: Instance, rules: Rules, rounding: Rounding) -> None:
        super().__init__()
        self.instance, self.rules, self.rounding = instance, rules, rounding
        self.holes = len(instance.contours)
        self.rng = np.random.default_rng(0)
        speed = instance.machine.v_jump
        self.work = instance.service_times * speed
        u, v = np.triu_indices(self.holes + 1, 1)
        self.edge_u, self.edge_v = np.tile(u, 2), np.tile(v, 2)
        self.edge_head = np.repeat([0, 1], len(u))
        self.lengths = np.concatenate([self._lengths(head)[u, v] for head in (0, 1)])
        self.first_edge = self.holes + 3
        self.variables = np.arange(self.first_edge + len(self.lengths))  # of each column
        self._add_columns()
        for row, columns, values in self._initial_rows():
            self.add_row(row, np.asarray(columns, dtype=np.int64), np.asarray(values, dtype=np.float64))
        self.permanent = len(self.rows)
        self.root_lower, self.root_upper = self.lp.lower.copy(), self.lp.upper.copy()

    def _lengths(self, head: int) -> Floats:
        nodes = [self.instance.node(hole) for hole in range(self.holes)]
        home = self.instance.home_node(head)
        assert home is not None
        return self.instance.rapids[np.ix_([*nodes, home], [*nodes, home])]

    def _add_columns(self) -> None:
        makespan = self.rules.objective == "makespan"
        price = 1.0 if makespan else self.rules.weight / self.instance.machine.v_jump
        costs = np.concatenate([np.zeros(self.holes + 2), [price], self.lengths * (0.0 if makespan else 1.0)])
        lower, upper = np.zeros(len(costs)), np.ones(len(costs))
        rests = self.rules.empty_heads or self.holes < 2
        lower[self.holes : self.holes + 2] = 0.0 if rests else 1.0
        upper[self.holes + 2] = np.inf
        upper[self.first_edge :] = np.where(self.edge_v == self.holes, 2.0, 1.0)
        nothing = np.empty(0, dtype=np.int64)
        self.lp.add_columns(costs, lower, upper, np.zeros(len(costs), dtype=np.int64), nothing, np.empty(0))

    # Rows

    def _z(self, head: int, hole: int, factor: float) -> tuple[int, float, float]:
        """Return column, coefficient and the move of the right side for ``factor * z^a_i`` on the left."""
        return (hole, factor, 0.0) if head == 0 else (hole, -factor, -factor)

    def _initial_rows(self) -> Iterator[tuple[Row, Sequence[int] | Ints, Sequence[float] | Floats]]:
        for head in (0, 1):
            mine = np.flatnonzero(self.edge_head == head)
            rest = self.holes + head
            for hole in range(self.holes):
                edges = mine[(self.edge_u[mine] == hole) | (self.edge_v[mine] == hole)] + self.first_edge
                column, factor, right = self._z(head, hole, -2.0)
                values = [*np.ones(len(edges)), factor]
                yield Row(("degree", head, hole), right, equal=True), [*edges, column], values
                column, factor, right = self._z(head, hole, -1.0)
                if self.lp.lower[rest] == 0.0:
                    yield Row(("used", head, hole), right), [rest, column], [1.0, factor]
            home_edges = mine[self.edge_v[mine] == self.holes]
            columns = [*(home_edges + self.first_edge), rest]
            yield Row(("home", head), 0.0, equal=True), columns, [*np.ones(len(home_edges)), -2.0]
        yield from self._order_rows()
        if self.rules.via_points:
            yield from self._via_rows()
        yield from self._time_rows()

    def _time_rows(self) -> Iterator[tuple[Row, Ints, Floats]]:
        """Makespan, imbalance and balance."""
        z, total = np.arange(self.holes), float(self.work.sum())
        extra = np.array([self.holes + 2])
        edges = np.arange(len(self.lengths)) + self.first_edge
        if self.rules.objective == "makespan":
            for head in (0, 1):
                mine = self.edge_head == head
                sign, right = (-1.0, 0.0) if head == 0 else (1.0, total)
                columns = np.concatenate([extra, edges[mine], z])
                values = np.concatenate([[1.0], -self.lengths[mine], sign * self.work])
                yield Row(("makespan", head), right), columns, values
        # T_0 - T_1 = sum of +-c x + 2 sum w z - sum w.
        signed = np.where(self.edge_head == 0, self.lengths, -self.lengths)
        difference = np.concatenate([signed, 2.0 * self.work])
        columns = np.concatenate([edges, z])
        for sign in (1, -1):
            if self.rules.objective == "weighted":
                values = np.concatenate([[1.0], -sign * difference])
                yield Row(("imbalance", sign), -sign * total), np.concatenate([extra, columns]), values
            if self.rules.balance is not None:
                limit = self.rules.balance * self.instance.machine.v_jump
                yield Row(("balance", sign), -limit - sign * total), columns, -sign * difference

    def _order_rows(self) -> Iterator[tuple[Row, list[int], list[float]]]:
        """Non-overlap between neighbours in x; the rest follows."""
        gap = self.rules.non_overlap
        if gap is None:
            return
        xs = self.instance.points[: self.holes, 0]
        values = np.unique(xs)
        groups = [np.flatnonzero(xs == x).tolist() for x in values]
        for index, group in enumerate(groups):
            if gap > 0.0:
                for hole in group[1:]:
                    yield Row(("order", group[0], hole), 0.0), [group[0], hole], [1.0, -1.0]
                    yield Row(("order", hole, group[0]), 0.0), [hole, group[0]], [1.0, -1.0]
            if index + 1 == len(groups):
                return
            for left in group:
                for right in groups[index + 1]:
                    yield Row(("order", left, right), 0.0), [left, right], [1.0, -1.0]
            if difference(values[index], values[index + 1]) < gap:
                left, right = group[0], groups[index + 1][0]
                yield Row(("order", right, left), 0.0), [right, left], [1.0, -1.0]

    def _via_rows(self) -> Iterator[tuple[Row, list[int], list[float]]]:
        xs = self.instance.points[: self.holes, 0]
        for head in (0, 1):
            home_edge = np.empty(self.holes, dtype=np.int64)
            mine = np.flatnonzero((self.edge_head == head) & (self.edge_v == self.holes))
            home_edge[self.edge_u[mine]] = mine + self.first_edge
            for hole in range(self.holes):
                column, factor, right = self._z(head, hole, -1.0)
                edges = home_edge[xs <= xs[hole]].tolist()
                yield Row(("via", head, hole), right), [*edges, column], [*np.ones(len(edges)), factor]

    def _add_set_row(self, row: Row, weights: Floats, extra: list[tuple[int, float]]) -> None:
        """Add a row with a weight for each edge variable and some further columns."""
        edges = np.flatnonzero(self.variables >= self.first_edge)
        values = weights[self.variables[edges] - self.first_edge]
        edges, values = edges[values != 0.0], values[values != 0.0]
        columns = np.append(edges, [column for column, _ in extra]).astype(np.int64)
        self.add_row(row, columns, np.append(values, [value for _, value in extra]))

    def _crossings(self, cut: Cut) -> Floats:
        return cut.coefficients(self.edge_u, self.edge_v, self.holes + 1)

    # Relaxation

    def apply(self, fixings: Sequence[Fixing]) -> None:
        lower, upper = self.root_lower.copy(), self.root_upper.copy()
        for fixing in fixings:
            column = np.searchsorted(self.variables, fixing.variable)
            lower[column], upper[column] = fixing.lower, fixing.upper
        changed = np.flatnonzero((lower != self.lp.lower) | (upper != self.lp.upper))
        self.lp.change_bounds(changed, lower[changed], upper[changed])

    def solve(self, iteration_limit: int | None = None) -> None:
        self.solution = self.lp.solve(iteration_limit)

    def multipliers(self) -> Floats:
        """Return the row duals; in a ray nothing balances the column of m or d, so its rows count for nothing.

        What rounding leaves there would be scaled up with the ray, and spoil its proof.
        """
        duals = super().multipliers()
        if self.solution.infeasible:
            kinds = [row.name[0] if isinstance(row.name, tuple) else "" for row in self.rows]
            duals[[kind in ("makespan", "imbalance") for kind in kinds]] = 0.0
        return duals

    def column_terms(self) -> float:
        costs = self.solution.reduced_costs
        if self.solution.infeasible:
            costs = -self.lp.row_combination(self.multipliers())
        # Only m and d have no upper bound; a cost below zero within rounding counts as none.
        at = np.where(costs > 0.0, self.lp.lower, np.where(np.isfinite(self.lp.upper), self.lp.upper, 0.0))
        return float(costs @ at)

    def tighten(self, cutoff: float) -> bool:
        if not np.isfinite(cutoff):
            return False
        gap = cutoff - self.bound()
        costs, integer = self.solution.reduced_costs, self.variables != self.holes + 2
        down = integer & (costs > gap) & (self.lp.upper > self.lp.lower)
        up = integer & (costs < -gap) & (self.lp.upper > self.lp.lower)
        self.root_upper[down] = self.root_lower[down]
        self.root_lower[up] = self.root_upper[up]
        gone = np.flatnonzero((self.root_upper == 0.0) & (self.variables >= self.first_edge))
        self.lp.delete_columns(gone)
        self.solution = self.solution.without_columns(gone)
        self.variables = np.delete(self.variables, gone)
        self.root_lower = np.delete(self.root_lower, gone)
        self.root_upper = np.delete(self.root_upper, gone)
        self.apply(())
        return bool(down.any() or up.any())

    # Cuts

    def separate(self, *, thorough: bool) -> int:
        self.forget_slack_rows()
        known = {row.name for row in self.rows}
        added = sum(self._separate_connect(head, self._support(head), known) for head in (0, 1))
        if added == 0 and thorough:
            added = self._separate_combs(*self._used(), known)
        return added

    def _used(self) -> tuple[Ints, Floats]:
        """Return the edges that carry weight in the current point, and their weights."""
        columns = np.flatnonzero((self.variables >= self.first_edge) & (self.solution.x > INTEGRALITY))
        return self.variables[columns] - self.first_edge, self.solution.x[columns]

    def _support(self, *heads: int) -> Support:
        """Return the graph of the edges of some heads that carry weight."""
        edges, weight = self._used()
        mine = np.isin(self.edge_head[edges], heads)
        return Support(self.holes + 1, self.edge_u[edges][mine], self.edge_v[edges][mine], weight[mine])

    def _separate_connect(self, head: int, support: Support, known: set[object]) -> int:
        z = self.solution.x[: self.holes]
        share = z if head == 0 else 1.0 - z
        added = 0
        for mask in connectivity_violations(support, self.holes, np.append(2.0 * share, 0.0)):
            members = np.flatnonzero(mask)
            hole = int(members[np.argmax(share[members])])
            column, factor, right = self._z(head, hole, -2.0)
            row = Row(("connect", head, hole, frozenset(members.tolist())), right)
            if row.name not in known:
                known.add(row.name)
                weights = self._crossings(Cut.subtour(members.tolist())) * (self.edge_head == head)
                self._add_set_row(row, weights, [(column, factor)])
                added += 1
        return added

    def _separate_combs(self, edges: Ints, weight: Floats, known: set[object]) -> int:
        """Separate combs on the joined tours, each home a node of its own."""
        tails = self.edge_u[edges]
        heads = np.where(
            self.edge_v[edges] == self.holes, self.holes + self.edge_head[edges], self.edge_v[edges]
        )
        keys, inverse = np.unique(tails * (self.holes + 2) + heads, return_inverse=True)
        joined = Support(
            self.holes + 2,
            keys // (self.holes + 2),
            keys % (self.holes + 2),
            np.bincount(inverse, weights=weight).astype(np.float64),
        )
        homes = {self.holes, self.holes + 1}
        added = 0
        for cut in separate_combs(joined, self._tight_sets(joined), self.rng):
            handle = cut.sets[0]
            if homes <= handle:
                handle = frozenset(range(self.holes)) - handle
            sets = (handle, *cut.sets[1:])
            if any(homes & members for members in sets):
                continue
            moved = Cut(sets, cut.least)
            row = Row(moved, float(cut.least))
            if row.name not in known:
                known.add(row.name)
                self._add_set_row(row, self._crossings(moved), [])
                added += 1
        return added

    def _tight_sets(self, joined: Support) -> list[frozenset[int]]:
        names = [row.name for row in self.rows[self.permanent :] if isinstance(row.name, tuple)]
        sets = {name[3] for name in names if name[0] == "connect"}
        return [members for members in sets if joined.cut_value(members) < 2.0 + INTEGRALITY]

    # Search

    def round(self) -> tuple[float, Plan] | None:
        """Round z; when the point is integral, its own tours, which need not be shortest, come first."""
        plan = self._own_plan() if not self.candidates(1) else None
        found = self.rounding(self.solution.x[: self.holes], plan)
        return found

    def _own_plan(self) -> Plan | None:
        """Return the plan of an integral point, or ``None`` when a tour falls apart."""
        tours = []
        for head in (0, 1):
            z = self.solution.x[: self.holes]
            mine = {int(hole) for hole in np.flatnonzero((z > 0.5) == (head == 0))}
            ends: dict[int, list[int]] = {node: [] for node in (*mine, self.holes)}
            columns = np.flatnonzero((self.variables >= self.first_edge) & (self.solution.x > 0.5))
            for column in columns:
                edge = self.variables[column] - self.first_edge
                if self.edge_head[edge] == head:
                    u, v = int(self.edge_u[edge]), int(self.edge_v[edge])
                    for _ in range(round(self.solution.x[column])):
                        ends[u].append(v)
                        ends[v].append(u)
            order, node = [], self.holes
            while ends[node]:
                following = ends[node].pop()
                ends[following].remove(node)
                if following == self.holes:
                    break
                order.append(following)
                node = following
            if set(order) != mine:
                return None
            tours.append(order)
        return Plan.of_contours(self._leftmost_first(tours))

    def _leftmost_first(self, tours: list[list[int]]) -> list[list[int]]:
        """Turn each tour so that of its two ends the one farther left comes first."""
        xs = self.instance.points[:, 0]
        return [tour[::-1] if tour and xs[tour[-1]] < xs[tour[0]] else tour for tour in tours]

    def candidates(self, most: int) -> list[int]:
        """Prefer z, then e, then edges; within each the nearest to a half."""
        x = self.solution.x
        distance = np.abs(x - np.floor(x) - 0.5)
        integer = self.variables != self.holes + 2
        for kind in (self.variables < self.holes, self.variables < self.first_edge, integer):
            fractional = np.flatnonzero(kind & integer & (distance < 0.5 - INTEGRALITY))
            if len(fractional):
                return self.variables[fractional[np.argsort(distance[fractional])][:most]].tolist()
        return []

    def children(self, variable: int) -> tuple[Fixing, Fixing]:
        column = int(np.searchsorted(self.variables, variable))
        at = float(np.floor(self.solution.x[column]))
        return (
            Fixing(variable, self.lp.lower[column], at),
            Fixing(variable, at + 1.0, self.lp.upper[column]),
        )

    # For who watches: nodes are those of the instance, where a hole's number is that of its only entry point

    def _nodes(self, head: int) -> Ints:
        return np.array([*range(self.holes), self.instance.home_node(head)])

    def legs(self) -> tuple[Leg, ...]:
        legs: tuple[Leg, ...] = ()
        for head in (0, 1):
            support, nodes = self._support(head), self._nodes(head)
            legs += wording.legs_of(nodes[support.tails], nodes[support.heads], support.x, head)
        return legs

    def inequality(self, row: Row) -> Inequality:
        if isinstance(row.name, Cut):
            return wording.cut_in_words(row.name, self._support(0, 1), "(comb)")
        assert isinstance(row.name, tuple)
        _, head, hole, members = row.name
        z = float(self.solution.x[hole])
        left = self._support(head).cut_value(members)
        return wording.connect_in_words(head, hole, members, left, z if head == 0 else 1.0 - z)

    def decision(self, fixing: Fixing) -> Decision:
        variable = fixing.variable
        if variable < self.holes:
            return Decision("z", (variable,), None, fixing.lower, fixing.upper)
        if variable < self.first_edge:
            return Decision("e", (), variable - self.holes, fixing.lower, fixing.upper)
        edge = variable - self.first_edge
        head = int(self.edge_head[edge])
        nodes = self._nodes(head)
        ends = int(nodes[self.edge_u[edge]]), int(nodes[self.edge_v[edge]])
        return Decision("x", ends, head, fixing.lower, fixing.upper)

    def tours(self, solution: Plan) -> tuple[tuple[int, ...], ...]:
        return plan_nodes(self.instance, solution)
