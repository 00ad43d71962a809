r"""The shortest tour of one head, by branch and cut on edges.

    Nodes      0..n-1, n >= 4, node 0 is the home (any node for a closed tour)
    Data       c_e >= 0, symmetric rapid lengths                                    [mm]
               V   via nodes, or none
    Variables  x_e in {0, 1}   whether the tour uses edge e                         [-]

    min  sum_e c_e x_e
    (1)  x(delta(v)) = 2                 each node is entered and left
    (2)  x(delta(S)) >= 2                subtours, separated
    (3)  x(0 : V) >= 1                   one of the via nodes comes next to the home
    (4)  combs and blossoms, separated   (see ``separation``)

Edges enter the linear program when their reduced cost asks for it; after the root, those that reduced costs
rule out are gone and the rest have all entered.
"""

from collections.abc import Iterable, Sequence

import numpy as np
from numba import njit

from cutgap.formulations.branch_and_cut import wording
from cutgap.formulations.branch_and_cut.engine import BranchAndCut, Outcome
from cutgap.formulations.branch_and_cut.model import NO_COLUMNS, Fixing, Model, Row
from cutgap.formulations.branch_and_cut.separation import (
    Cut,
    Support,
    separate_combs,
    separate_subtours,
)
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.progress import Watch, nobody
from cutgap.instances.scene import Decision, Inequality, Leg
from cutgap.instances.tours import improve_tour, nearest_neighbour_tour, tour_length

TOLERANCE = 1e-10
"""Relative distance to the incumbent at which a node is closed."""

INTEGRALITY = 1e-6
"""A variable this near to an integer counts as one."""

NEIGHBOURS = 6
"""Edges to the nearest nodes with which the linear program starts."""

FORCED = 1e7
"""Length, in mm, beyond all others: local search keeps edges this negative, and avoids those this long."""

COMPLETE = 12
"""Once at most this many edges a node are left, all of them get a column and pricing ends."""


class TourModel(Model):
    """The model above, as the engine sees it; variable u * n + v with u < v is the edge u - v."""

    wording = wording.TOUR_ROWS

    def __init__(self, lengths: Floats, via: Ints, tour: Ints, cuts: Iterable[Cut] = ()) -> None:
        super().__init__()
        self.lengths = lengths
        self.nodes = len(lengths)
        self.via = via
        self.complete = False  # whether every edge that is left has a column
        self.removed = np.eye(self.nodes, dtype=bool)
        self.rng = np.random.default_rng(0)
        self.tails, self.heads = NO_COLUMNS, NO_COLUMNS
        for node in range(self.nodes):
            self.add_row(Row(("degree", node), 2.0, equal=True))
        if len(via):
            self.add_row(Row(("via",), 1.0))
        self.permanent = len(self.rows)
        self._add_edges(*self._initial_edges(tour))
        for cut in cuts:
            self._add_cut(cut)

    @property
    def cuts(self) -> list[Cut]:
        """The cuts among the rows, in their order."""
        return [row.name for row in self.rows[self.permanent :] if isinstance(row.name, Cut)]

    def _initial_edges(self, tour: Ints) -> tuple[Ints, Ints]:
        """Edges of the tour, to near neighbours, and between home and via nodes."""
        order = np.argsort(self.lengths + np.diag(np.full(self.nodes, np.inf)), axis=1)
        near = order[:, : min(NEIGHBOURS, self.nodes - 1)]
        tails = np.concatenate([np.repeat(np.arange(self.nodes), near.shape[1]), tour, 0 * self.via])
        heads = np.concatenate([near.ravel(), np.roll(tour, -1), self.via])
        keys = np.unique(np.minimum(tails, heads) * self.nodes + np.maximum(tails, heads))
        return keys // self.nodes, keys % self.nodes

    def _add_edges(self, tails: Ints, heads: Ints) -> None:
        """Give edges (tails < heads) a column each."""
        rows = [tails, heads]
        columns = [np.arange(len(tails))] * 2
        values = [np.ones(len(tails))] * 2
        if len(self.via):
            hits = np.flatnonzero((tails == 0) & np.isin(heads, self.via))
            rows.append(np.full(len(hits), self.nodes))
            columns.append(hits)
            values.append(np.ones(len(hits)))
        for index, cut in enumerate(self.cuts):
            coefficients = cut.coefficients(tails, heads, self.nodes)
            hits = np.flatnonzero(coefficients)
            rows.append(np.full(len(hits), self.permanent + index))
            columns.append(hits)
            values.append(coefficients[hits])
        row, column, value = np.concatenate(rows), np.concatenate(columns), np.concatenate(values)
        by_column = np.argsort(column, kind="stable")
        starts = np.searchsorted(column[by_column], np.arange(len(tails)))
        zeros, ones = np.zeros(len(tails)), np.ones(len(tails))
        self.lp.add_columns(self.lengths[tails, heads], zeros, ones, starts, row[by_column], value[by_column])
        self.tails = np.concatenate([self.tails, tails])
        self.heads = np.concatenate([self.heads, heads])

    def _add_cut(self, cut: Cut) -> None:
        coefficients = cut.coefficients(self.tails, self.heads, self.nodes)
        hits = np.flatnonzero(coefficients)
        self.add_row(Row(cut, float(cut.least)), hits, coefficients[hits])

    # Relaxation

    def apply(self, fixings: Sequence[Fixing]) -> None:
        columns = np.arange(len(self.tails))
        lower, upper = np.zeros(len(columns)), np.ones(len(columns))
        keys = self.tails * self.nodes + self.heads
        for fixing in fixings:
            column = np.flatnonzero(keys == fixing.variable)
            lower[column], upper[column] = fixing.lower, fixing.upper
        changed = (lower != self.lp.lower) | (upper != self.lp.upper)
        self.lp.change_bounds(columns[changed], lower[changed], upper[changed])

    def solve(self, iteration_limit: int | None = None) -> None:
        while True:
            self.solution = self.lp.solve(iteration_limit)
            if self.complete or iteration_limit is not None or not self._price():
                return

    def reduced_costs(self, multipliers: Floats) -> Floats:
        """Return c_e minus the priced rows for all edges, shape (n, n); removed edges get infinity.

        For a ray of an infeasible program the c_e are left out.
        """
        lengths = np.zeros_like(self.lengths) if self.solution.infeasible else self.lengths
        sets, prices = [], []
        for cut, price in zip(self.cuts, multipliers[self.permanent :], strict=True):
            if price > 0.0:
                sets += [list(members) for members in cut.sets]
                prices += [price] * len(cut.sets)
        starts = np.cumsum([0, *map(len, sets)])
        members = np.array([node for each in sets for node in each], dtype=np.int64)
        costs = _subtract_sets(lengths, multipliers[: self.nodes], starts, members, np.array(prices))
        if len(self.via):
            costs[0, self.via] -= multipliers[self.nodes]
            costs[self.via, 0] -= multipliers[self.nodes]
        costs[self.removed] = np.inf
        return costs

    def _price(self) -> bool:
        """Add the edges of most negative reduced cost; False when there are none."""
        costs = self.reduced_costs(self.multipliers())
        costs[self.tails, self.heads] = np.inf
        tails, heads = np.nonzero(np.triu(costs < -1e-7, 1))
        if len(tails) == 0:
            return False
        worst = np.argsort(costs[tails, heads])[: 5 * self.nodes]
        self._add_edges(tails[worst], heads[worst])
        return True

    def column_terms(self) -> float:
        if self.complete and not self.solution.infeasible:
            own, terms = self.solution.reduced_costs, 0.0
        else:
            costs = np.triu(self.reduced_costs(self.multipliers()), 1)
            own = costs[self.tails, self.heads]
            costs[self.tails, self.heads] = 0.0
            terms = float(np.minimum(costs, 0.0).sum())
        return terms + float(np.minimum(own * self.lp.lower, own * self.lp.upper).sum())

    def tighten(self, cutoff: float) -> bool:
        if not np.isfinite(cutoff):
            return False
        out = (self.reduced_costs(self.multipliers()) > cutoff - self.bound()) & ~self.removed
        self.removed |= out
        gone = np.flatnonzero(self.removed[self.tails, self.heads])
        self.lp.delete_columns(gone)
        self.solution = self.solution.without_columns(gone)
        self.tails, self.heads = np.delete(self.tails, gone), np.delete(self.heads, gone)
        missing = np.triu(~self.removed, 1)
        missing[self.tails, self.heads] = False
        tails, heads = np.nonzero(missing)
        if len(tails) + len(self.tails) <= COMPLETE * self.nodes:
            self._add_edges(tails, heads)
            self.solution = self.solution.with_columns(len(tails))
            self.complete = True
        return bool(out.any())

    # Cuts

    def support(self) -> Support:
        """Return the edges that carry weight in the current point."""
        used = self.solution.x > INTEGRALITY
        return Support(self.nodes, self.tails[used], self.heads[used], self.solution.x[used])

    def separate(self, *, thorough: bool) -> int:
        self.forget_slack_rows()
        support = self.support()
        found = separate_subtours(support)
        if not found and thorough:
            found = separate_combs(support, self._tight_sets(support), self.rng)
        new = set(found).difference(self.cuts)
        for cut in found:
            if cut in new:
                self._add_cut(cut)
        return len(new)

    def _tight_sets(self, support: Support) -> list[frozenset[int]]:
        sets = [cut.sets[0] for cut in self.cuts if len(cut.sets) == 1]
        return [members for members in sets if support.cut_value(members) < 2.0 + INTEGRALITY]

    # Search

    def round(self) -> tuple[float, Ints] | None:
        guide = self.lengths.copy()
        used = self.solution.x > INTEGRALITY
        discount = 1.0 - 0.9 * self.solution.x[used]
        guide[self.tails[used], self.heads[used]] *= discount
        guide[self.heads[used], self.tails[used]] *= discount
        return best_tour(self.lengths, self.via, guide)

    def candidates(self, most: int) -> list[int]:
        distance = np.abs(self.solution.x - 0.5)
        fractional = np.flatnonzero(distance < 0.5 - INTEGRALITY)
        order = fractional[np.argsort(distance[fractional])][:most]
        return (self.tails[order] * self.nodes + self.heads[order]).tolist()

    def children(self, variable: int) -> tuple[Fixing, Fixing]:
        return Fixing(variable, 0.0, 0.0), Fixing(variable, 1.0, 1.0)

    # For who watches

    def legs(self) -> tuple[Leg, ...]:
        support = self.support()
        return wording.legs_of(support.tails, support.heads, support.x)

    def inequality(self, row: Row) -> Inequality:
        assert isinstance(row.name, Cut)
        return wording.cut_in_words(row.name, self.support(), "(2)" if len(row.name.sets) == 1 else "(4)")

    def decision(self, fixing: Fixing) -> Decision:
        return Decision("x", divmod(fixing.variable, self.nodes), None, fixing.lower, fixing.upper)

    def tours(self, solution: Ints) -> tuple[tuple[int, ...], ...]:
        return (tuple(solution.tolist()),)


@njit(cache=True)
def _subtract_sets(lengths: Floats, degree: Floats, starts: Ints, members: Ints, prices: Floats) -> Floats:
    """Return lengths minus the prices of the degree equations and of the sets that each edge crosses."""
    potential = degree.copy()
    for s in range(len(prices)):
        for i in range(starts[s], starts[s + 1]):
            potential[members[i]] += prices[s]
    costs = lengths - potential.reshape(-1, 1) - potential
    # An edge with both ends in a set does not cross it: it gets back what its ends paid.
    for s in range(len(prices)):
        for i in range(starts[s], starts[s + 1]):
            for j in range(starts[s], starts[s + 1]):
                costs[members[i], members[j]] += 2.0 * prices[s]
    return costs


def best_tour(lengths: Floats, via: Ints, guide: Floats, kicks: int = 0) -> tuple[float, Ints]:
    """Return the length and order of a good tour: local search on ``guide``, then on the lengths.

    With via nodes, one of them comes second, after node 0.
    """
    guide, gated = _with_gate(guide, via), _with_gate(lengths, via)
    tour = improve_tour(guide, nearest_neighbour_tour(guide), 0, 0)
    tour = improve_tour(gated, tour, kicks, 0)
    tour = np.roll(tour, -int(np.flatnonzero(tour == 0)[0]))
    gate = len(lengths)
    if len(gated) > gate:
        if tour[1] != gate:
            tour = np.roll(tour[::-1], 1)
        tour = tour[tour != gate]
        if tour[1] not in via:
            raise AssertionError("local search lost the way from the home to a via node")
    return tour_length(lengths, tour), tour


def _with_gate(lengths: Floats, via: Ints) -> Floats:
    """Return lengths with a last node between node 0 and the via nodes, if there are any.

    The edge from node 0 to the gate is so short that local search keeps it, and the gate is far from all
    other nodes, so that a via node comes after it; which one is left to the search.
    """
    nodes = len(lengths)
    if len(via) == 0:
        return lengths
    gated = np.full((nodes + 1, nodes + 1), FORCED)
    gated[:nodes, :nodes] = lengths
    gated[nodes, via] = gated[via, nodes] = lengths[0, via]
    gated[0, nodes] = gated[nodes, 0] = -FORCED
    return gated


def shortest_tour(
    lengths: Floats,
    via: Ints = NO_COLUMNS,
    *,
    start: tuple[float, Ints] | None = None,
    cutoff: float = np.inf,
    deadline: float = np.inf,
    watch: Watch = nobody,
) -> Outcome:
    """Find the shortest closed tour through all nodes, or prove that none is below the cutoff.

    Parameters
    ----------
    lengths
        Shape (n, n), mm, symmetric, n >= 1; node 0 is the home.
    via
        Nodes of which one must come next to the home.
    start
        A known tour with its length.
    cutoff
        Tours of this length or more are of no interest.

    Returns
    -------
    Outcome
        ``solution`` is the order of nodes, node 0 first and a via node second.
    """
    nodes = len(lengths)
    if start is None:
        start = best_tour(lengths, via, lengths, kicks=20 * nodes)
    if nodes <= 3:  # the tour is the only one, but for its direction
        return Outcome(start[0], start[0], start[1], True, 0)
    tolerance = TOLERANCE * max(1.0, start[0])
    search = BranchAndCut(
        TourModel(lengths, via, start[1]),
        incumbent=start,
        cutoff=cutoff + 2.0 * tolerance,  # so that a complete search proves the cutoff, rounding included
        tolerance=TOLERANCE,
        deadline=deadline,
        watch=watch,
    )
    return search.run()
