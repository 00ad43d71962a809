r"""The shortest tour of one head through one entry point of each contour (GTSP), by branch and cut.

    Nodes      0..n-1: entry points of contours in order, then the home as a contour of its own
    Sets       C_h   nodes of contour h, 0..m-1, m >= 2
    Data       l_e >= 0, symmetric rapid lengths between nodes of different contours           [mm]
    Variables  y_v in {0, 1}  whether the tour passes node v                                   [-]
               x_e in {0, 1}  whether it uses edge e ({0, 1, 2} for two contours)              [-]

    min  sum_e l_e x_e
    (1)  y(C_h) = 1                     each contour once
    (2)  x(delta(v)) = 2 y_v            a node that is passed is entered and left
    (3)  generalised subtours (G), separated
    (4)  generalised combs (K), separated     (see ``generalized_cuts``)

Edges enter the linear program when their reduced cost asks for it; after the root, those that reduced costs
rule out are gone and, when few are left, all of them have entered.

Source: Fischetti, Salazar, Toth (1995, 1997).
"""

from collections.abc import Sequence

import numpy as np
from numba import njit

from cutgap.formulations.branch_and_cut import wording
from cutgap.formulations.branch_and_cut.generalized_cuts import (
    GeneralizedCut,
    Point,
    combs,
    minimum_cuts,
    quick_cuts,
)
from cutgap.formulations.branch_and_cut.model import NO_COLUMNS, NO_VALUES, Fixing, Model, Row
from cutgap.formulations.branch_and_cut.separation import Mask, Members
from cutgap.formulations.branch_and_cut.tour import COMPLETE, INTEGRALITY
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.entry_tours import EntrySearch, plain_task, shortest_in_order
from cutgap.instances.scene import Decision, Inequality, Leg

NEIGHBOURS = 3
"""Contours to whose nearest node each node has an edge in the first linear program."""

ROUNDING = 10
"""Rounds of local search a contour, at a fractional point."""

SAMPLE = 3
"""Pairs of contours, a contour, whose minimum cuts are looked at in each round."""

FEW = 10
"""With fewer cuts than this found, the minimum cuts of all pairs follow."""


class GeneralizedTourModel(Model):
    """The model above, as the engine sees it.

    Variable v < n is y_v; n + u * n + v with u < v is the edge u - v. The first n columns are the y.
    """

    wording = wording.GENERALIZED_ROWS

    def __init__(self, lengths: Floats, first: Ints, tour: Ints) -> None:
        super().__init__()
        self.lengths, self.first = np.ascontiguousarray(lengths), first
        self.nodes, self.contours = len(lengths), len(first) - 1
        self.contour_of = np.repeat(np.arange(self.contours), np.diff(first))
        self.most = 2.0 if self.contours == 2 else 1.0
        self.complete = False  # whether every edge that is left has a column
        self.removed = self.contour_of[:, None] == self.contour_of
        self.y_upper = np.ones(self.nodes)
        self.task = plain_task(self.lengths, first)
        self.rng = np.random.default_rng(0)
        self.parts: dict[GeneralizedCut, tuple[Mask, Floats]] = {}  # masks and node coefficients of cuts
        self.tails, self.heads = NO_COLUMNS, NO_COLUMNS
        nothing, zeros = np.zeros(self.nodes, dtype=np.int64), np.zeros(self.nodes)
        self.lp.add_columns(zeros, zeros, self.y_upper, nothing, NO_COLUMNS, NO_VALUES)
        for h in range(self.contours):
            members = np.flatnonzero(self.contour_of == h)
            self.add_row(Row(("contour", h), 1.0, equal=True), members, np.ones(len(members)))
        for v in range(self.nodes):
            self.add_row(Row(("degree", v), 0.0, equal=True), np.array([v]), np.array([-2.0]))
        self.permanent = len(self.rows)
        self._add_edges(*self._initial_edges(tour))

    @property
    def cuts(self) -> list[GeneralizedCut]:
        """The cuts among the rows, in their order."""
        return [row.name for row in self.rows[self.permanent :] if isinstance(row.name, GeneralizedCut)]

    def _initial_edges(self, tour: Ints) -> tuple[Ints, Ints]:
        """Edges of the tour, and from each node to the nearest nodes of the nearest contours."""
        nearest = np.empty((self.nodes, self.contours), dtype=np.int64)
        for h in range(self.contours):
            members = slice(self.first[h], self.first[h + 1])
            nearest[:, h] = self.first[h] + np.argmin(self.lengths[:, members], axis=1)
        gaps = np.take_along_axis(self.lengths, nearest, axis=1)
        gaps[np.arange(self.nodes), self.contour_of] = np.inf
        order = np.argsort(gaps, axis=1)[:, : min(NEIGHBOURS, self.contours - 1)]
        near = np.take_along_axis(nearest, order, axis=1)
        tails = np.concatenate([np.repeat(np.arange(self.nodes), near.shape[1]), tour])
        heads = np.concatenate([near.ravel(), np.roll(tour, -1)])
        keys = np.unique(np.minimum(tails, heads) * self.nodes + np.maximum(tails, heads))
        return keys // self.nodes, keys % self.nodes

    def _add_edges(self, tails: Ints, heads: Ints) -> None:
        """Give edges (tails < heads) a column each."""
        rows = [self.contours + tails, self.contours + heads]
        columns = [np.arange(len(tails))] * 2
        values = [np.ones(len(tails))] * 2
        for index, cut in enumerate(self.cuts):
            masks = self.parts[cut][0]
            coefficients = -(masks[:, tails] & masks[:, heads]).sum(axis=0).astype(np.float64)
            hits = np.flatnonzero(coefficients)
            rows.append(np.full(len(hits), self.permanent + index))
            columns.append(hits)
            values.append(coefficients[hits])
        row, column, value = np.concatenate(rows), np.concatenate(columns), np.concatenate(values)
        by_column = np.argsort(column, kind="stable")
        starts = np.searchsorted(column[by_column], np.arange(len(tails)))
        zeros, most = np.zeros(len(tails)), np.full(len(tails), self.most)
        self.lp.add_columns(self.lengths[tails, heads], zeros, most, starts, row[by_column], value[by_column])
        self.tails = np.concatenate([self.tails, tails])
        self.heads = np.concatenate([self.heads, heads])

    def _add_cut(self, cut: GeneralizedCut) -> None:
        nodes = cut.node_coefficients(self.contour_of)
        self.parts[cut] = cut.masks(self.nodes), nodes
        edges = cut.edge_coefficients(self.tails, self.heads, self.nodes)
        coefficients = np.concatenate([nodes, edges])
        hits = np.flatnonzero(coefficients)
        self.add_row(Row(cut, cut.least), hits, coefficients[hits])

    # Relaxation

    def apply(self, fixings: Sequence[Fixing]) -> None:
        lower = np.zeros(self.nodes + len(self.tails))
        upper = np.concatenate([self.y_upper, np.full(len(self.tails), self.most)])
        for fixing in fixings:
            column = self._column(fixing.variable)
            if column is not None:
                lower[column], upper[column] = fixing.lower, min(fixing.upper, upper[column])
        changed = np.flatnonzero((lower != self.lp.lower) | (upper != self.lp.upper))
        self.lp.change_bounds(changed, lower[changed], upper[changed])

    def _column(self, variable: int) -> int | None:
        if variable < self.nodes:
            return variable
        u, v = divmod(variable - self.nodes, self.nodes)
        found = np.flatnonzero((self.tails == u) & (self.heads == v))
        return self.nodes + int(found[0]) if len(found) else None

    def solve(self, iteration_limit: int | None = None) -> None:
        while True:
            self.solution = self.lp.solve(iteration_limit)
            if self.complete or iteration_limit is not None or not self._price():
                return

    def multipliers(self) -> Floats:
        """Return the row duals; a node that was ruled out gets one that leaves none of its edges below zero."""
        duals = super().multipliers()
        dead = self.y_upper == 0.0
        if dead.any():
            degree = duals[self.contours : self.contours + self.nodes]
            degree[dead] = -max(0.0, float(degree[~dead].max()))
        return duals

    def reduced_costs(self, multipliers: Floats) -> tuple[Floats, Floats]:
        """Return reduced costs of all y, shape (n,), and edges, shape (n, n); removed edges get infinity.

        For a ray of an infeasible program the lengths are left out.
        """
        lengths = np.zeros_like(self.lengths) if self.solution.infeasible else self.lengths
        contour, degree = multipliers[: self.contours], multipliers[self.contours : self.permanent]
        nodes = 2.0 * degree - contour[self.contour_of]
        masks, prices = [], []
        for cut, price in zip(self.cuts, multipliers[self.permanent :].tolist(), strict=True):
            if price > 0.0:
                mine, coefficients = self.parts[cut]
                nodes -= price * coefficients
                masks.append(mine)
                prices += [price] * len(cut.sets)
        edges = lengths - degree[:, None] - degree
        if masks:
            _add_sets(edges, np.concatenate(masks), np.array(prices))
        edges[self.removed] = np.inf
        return nodes, edges

    def _price(self) -> bool:
        """Add the edges of most negative reduced cost; False when there are none."""
        _, costs = self.reduced_costs(self.multipliers())
        costs[self.tails, self.heads] = np.inf
        tails, heads = np.nonzero(np.triu(costs < -1e-7, 1))
        if len(tails) == 0:
            return False
        worst = np.argsort(costs[tails, heads])[: 2 * self.nodes]
        self._add_edges(tails[worst], heads[worst])
        return True

    def column_terms(self) -> float:
        if self.complete and not self.solution.infeasible:
            own = self.solution.reduced_costs
            return float(np.minimum(own * self.lp.lower, own * self.lp.upper).sum())
        nodes, costs = self.reduced_costs(self.multipliers())
        costs = np.triu(costs, 1)
        own = np.concatenate([nodes, costs[self.tails, self.heads]])
        costs[self.tails, self.heads] = 0.0
        terms = self.most * float(np.minimum(costs, 0.0).sum())
        return terms + float(np.minimum(own * self.lp.lower, own * self.lp.upper).sum())

    def tighten(self, cutoff: float) -> bool:
        if not np.isfinite(cutoff):
            return False
        gap = cutoff - self.bound()
        nodes, edges = self.reduced_costs(self.multipliers())
        dead = (nodes > gap) & (self.y_upper > 0.0)
        out = (edges > gap) & ~self.removed
        if not (dead.any() or out.any()):
            return False
        self.y_upper[dead] = 0.0
        self.removed |= out | dead[:, None] | dead
        gone = np.flatnonzero(self.removed[self.tails, self.heads])
        self.lp.delete_columns(gone + self.nodes)
        self.solution = self.solution.without_columns(gone + self.nodes)
        self.tails, self.heads = np.delete(self.tails, gone), np.delete(self.heads, gone)
        self.apply(())
        self._complete()
        return True

    def _complete(self) -> None:
        """Give every edge that is left a column, when they are few."""
        missing = np.triu(~self.removed, 1)
        missing[self.tails, self.heads] = False
        tails, heads = np.nonzero(missing)
        if len(tails) + len(self.tails) <= COMPLETE * self.nodes:
            self._add_edges(tails, heads)
            self.solution = self.solution.with_columns(len(tails))
            self.complete = True

    # Cuts

    def point(self) -> Point:
        """Return the current fractional solution."""
        x = self.solution.x[self.nodes :]
        used = x > INTEGRALITY
        y = np.where(self.solution.x[: self.nodes] > INTEGRALITY, self.solution.x[: self.nodes], 0.0)
        return Point(self.contour_of, y, self.tails[used], self.heads[used], x[used])

    def separate(self, *, thorough: bool) -> int:
        self.forget_slack_rows()
        point = self.point()
        found = quick_cuts(point)
        if thorough:
            pairs = np.column_stack(np.triu_indices(self.contours, 1))
            self.rng.shuffle(pairs)
            found += minimum_cuts(point, pairs[: SAMPLE * self.contours])
            if len(found) < self.contours:
                found += combs(point, *self._tight_sets(point), self.rng)
            if len(found) < FEW:
                found += minimum_cuts(point, pairs[SAMPLE * self.contours :])
        return self._add_new(found)

    def _add_new(self, found: list[GeneralizedCut]) -> int:
        known = set(self.cuts)
        new = [cut for cut in dict.fromkeys(found) if cut not in known]
        for cut in new:
            self._add_cut(cut)
        return len(new)

    def _tight_sets(self, point: Point) -> tuple[list[Members], list[Members]]:
        """Return the sets of nodes of cuts that the point crosses twice, and those of them made of contours."""
        tight, of_contours = [], []
        for cut in self.cuts:
            mask = self.parts[cut][0][0]
            if cut.pairs == ((None, None),) and point.crossing(mask) < 2.0 + INTEGRALITY:
                tight.append(cut.sets[0])
                inside = frozenset(self.contour_of[mask].tolist())
                if not (inside & frozenset(self.contour_of[~mask].tolist())):
                    of_contours.append(inside)
        return tight, of_contours

    # Search

    def round(self) -> tuple[float, Ints] | None:
        """Search near the point; the point itself comes first when it is a tour."""
        own = self._own_tour()
        if own is not None:
            return shortest_in_order(self.task, self.contour_of[own])
        guide = self.lengths.copy()
        columns = self.solution.x[self.nodes :]
        used = columns > INTEGRALITY
        discount = 1.0 - 0.9 * np.minimum(columns[used], 1.0)
        guide[self.tails[used], self.heads[used]] *= discount
        guide[self.heads[used], self.tails[used]] *= discount
        search = EntrySearch(plain_task(guide, self.first), ROUNDING * self.contours, rng=self.rng)
        search.run(search.rounds)
        return shortest_in_order(self.task, [visit.contour for visit in search.best.visits])

    def _own_tour(self) -> Ints | None:
        """Return the tour of an integral point, ``None`` when it is fractional or falls apart."""
        x = self.solution.x
        if (np.abs(x - np.round(x)) > INTEGRALITY).any():
            return None
        ends: dict[int, list[int]] = {}
        for edge in np.flatnonzero(x[self.nodes :] > 0.5).tolist():
            u, v = int(self.tails[edge]), int(self.heads[edge])
            ends.setdefault(u, []).append(v)
            ends.setdefault(v, []).append(u)
        tour = [next(iter(ends))]
        while len(tour) < self.contours:
            ahead = [node for node in ends[tour[-1]] if node not in tour[-2:]]
            if not ahead or ahead[0] == tour[0]:
                return None
            tour.append(ahead[0])
        return np.array(tour)

    def candidates(self, most: int) -> list[int]:
        """Take y and edges half and half, each the nearest to a half: either alone makes larger trees."""
        x = self.solution.x
        distance = np.abs(x - np.floor(x) - 0.5)
        fractional = np.flatnonzero(distance < 0.5 - INTEGRALITY)
        order = fractional[np.argsort(distance[fractional], kind="stable")]
        nodes, edges = order[order < self.nodes], order[order >= self.nodes]
        columns = [*nodes[: most // 2].tolist(), *edges[: most // 2].tolist()]
        return [self._variable(column) for column in columns]

    def _variable(self, column: int) -> int:
        if column < self.nodes:
            return column
        edge = column - self.nodes
        return int(self.nodes + self.tails[edge] * self.nodes + self.heads[edge])

    def children(self, variable: int) -> tuple[Fixing, Fixing]:
        column = self._column(variable)
        assert column is not None
        at = float(np.floor(self.solution.x[column]))
        upper = self.most if column >= self.nodes else 1.0
        return Fixing(variable, 0.0, at), Fixing(variable, at + 1.0, upper)

    # For who watches

    def legs(self) -> tuple[Leg, ...]:
        point = self.point()
        return wording.legs_of(point.tails, point.heads, point.x)

    def inequality(self, row: Row) -> Inequality:
        assert isinstance(row.name, GeneralizedCut)
        return wording.generalized_in_words(row.name, self.point())

    def decision(self, fixing: Fixing) -> Decision:
        if fixing.variable < self.nodes:
            return Decision("y", (fixing.variable,), None, fixing.lower, fixing.upper)
        ends = divmod(fixing.variable - self.nodes, self.nodes)
        return Decision("x", ends, None, fixing.lower, fixing.upper)

    def tours(self, solution: Ints) -> tuple[tuple[int, ...], ...]:
        return (tuple(solution.tolist()),)


@njit(cache=True)
def _add_sets(edges: Floats, masks: np.ndarray, prices: Floats) -> None:
    """Add the price of each set to the edges inside it, in place."""
    for s in range(len(masks)):
        members = np.flatnonzero(masks[s])
        for u in members:
            for v in members:
                edges[u, v] += prices[s]
