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
from dataclasses import dataclass, replace

import numpy as np

from cutgap.formulations.branch_and_cut.engine import BranchAndCut, Outcome
from cutgap.formulations.branch_and_cut.linear_program import INFINITY, LinearProgram, Solution
from cutgap.formulations.branch_and_cut.model import Fixing, Model
from cutgap.formulations.branch_and_cut.separation import (
    Cut,
    Support,
    separate_combs,
    separate_subtours,
)
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.progress import Watch, nobody
from cutgap.instances.tours import improve_tour, nearest_neighbour_tour, tour_length

TOLERANCE = 1e-9
"""Relative distance to the incumbent at which a node is closed."""

INTEGRALITY = 1e-6
"""A variable this near to an integer counts as one."""

NEIGHBOURS = 6
"""Edges to the nearest nodes with which the linear program starts."""

FORCED = 1e7
"""Bonus, in mm, that makes local search keep the edge from the home to a via node."""

COMPLETE = 12
"""Once at most this many edges a node are left, all of them get a column and pricing ends."""

NO_COLUMNS: Ints = np.empty(0, dtype=np.int64)
NO_VALUES: Floats = np.empty(0)

AGE = 4
"""Rows slack in this many root rounds are deleted."""


@dataclass(frozen=True, slots=True)
class Prices:
    """Row duals: of the degree equations, of the via row, and of each cut (all but the first clipped at 0)."""

    degree: Floats
    via: float
    cuts: Floats


class TourModel(Model):
    """The model above, as the engine sees it; variable u * n + v with u < v is the edge u - v."""

    def __init__(self, lengths: Floats, via: Sequence[int], tour: Ints, cuts: Iterable[Cut] = ()) -> None:
        self.lengths = lengths
        self.nodes = len(lengths)
        self.via = np.array(sorted(via), dtype=np.int64)
        self.cuts: list[Cut] = []
        self.slack_rounds: list[int] = []
        self.complete = False  # whether every edge that is left has a column
        self.removed = np.zeros((self.nodes, self.nodes), dtype=bool)
        self.rng = np.random.default_rng(0)
        self.lp = LinearProgram()
        self.tails = np.empty(0, dtype=np.int64)
        self.heads = np.empty(0, dtype=np.int64)
        self.solution: Solution
        for _ in range(self.nodes):
            self.lp.add_row(2.0, 2.0, NO_COLUMNS, NO_VALUES)
        if len(self.via):
            self.lp.add_row(1.0, INFINITY, NO_COLUMNS, NO_VALUES)
        self._add_edges(*self._initial_edges(tour))
        for cut in cuts:
            self._add_cut(cut)

    @property
    def first_cut(self) -> int:
        """Row of the first cut."""
        return self.nodes + (1 if len(self.via) else 0)

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
            rows.append(np.full(len(hits), self.first_cut + index))
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
        self.lp.add_row(cut.least, INFINITY, hits, coefficients[hits])
        self.cuts.append(cut)
        self.slack_rounds.append(0)

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

    def solve(self, iteration_limit: int | None = None) -> bool:
        while True:
            solution = self.lp.solve(iteration_limit)
            if solution is None:
                return False
            self.solution = solution
            if self.complete or iteration_limit is not None or not self._price():
                return True

    def prices(self) -> Prices:
        """Return the row duals with the signs that weak duality needs."""
        duals = self.solution.duals
        via = max(0.0, duals[self.nodes]) if len(self.via) else 0.0
        return Prices(duals[: self.nodes], via, np.maximum(0.0, duals[self.first_cut :]))

    def reduced_costs(self, prices: Prices) -> Floats:
        """Return c_e minus the priced rows for all edges, shape (n, n); removed edges get infinity."""
        potential = prices.degree.copy()
        inside: list[tuple[Ints, float]] = []
        for cut, price in zip(self.cuts, prices.cuts, strict=True):
            if price > 0.0:
                for members in cut.sets:
                    nodes = np.fromiter(members, dtype=np.int64, count=len(members))
                    potential[nodes] += price
                    inside.append((nodes, 2.0 * price))
        # An edge crosses S once if one end is inside; both ends inside pay twice too much above.
        costs = self.lengths - potential[:, None] - potential[None, :]
        for nodes, excess in inside:
            costs[np.ix_(nodes, nodes)] += excess
        costs[0, self.via] -= prices.via
        costs[self.via, 0] -= prices.via
        costs[self.removed] = np.inf
        np.fill_diagonal(costs, np.inf)
        return costs

    def _price(self) -> bool:
        """Add the edges of most negative reduced cost; False when there are none."""
        costs = self.reduced_costs(self.prices())
        costs[self.tails, self.heads] = np.inf
        tails, heads = np.nonzero(np.triu(costs < -1e-7, 1))
        if len(tails) == 0:
            return False
        worst = np.argsort(costs[tails, heads])[: 5 * self.nodes]
        self._add_edges(tails[worst], heads[worst])
        return True

    def bound(self) -> float:
        prices = self.prices()
        costs = np.triu(self.reduced_costs(prices), 1)
        right = 2.0 * prices.degree.sum() + prices.via
        right += sum(p * cut.least for p, cut in zip(prices.cuts, self.cuts, strict=True) if p > 0.0)
        own = costs[self.tails, self.heads]
        fixed = np.minimum(own * self.lp.lower, own * self.lp.upper).sum()
        costs[self.tails, self.heads] = 0.0
        return float(right + fixed + np.minimum(costs, 0.0).sum())

    def tighten(self, cutoff: float) -> None:
        if not np.isfinite(cutoff):
            return
        self.removed |= self.reduced_costs(self.prices()) > cutoff - self.bound()
        np.fill_diagonal(self.removed, True)
        gone = np.flatnonzero(self.removed[self.tails, self.heads])
        self.lp.delete_columns(gone)
        self.solution = replace(self.solution, x=np.delete(self.solution.x, gone))
        self.tails, self.heads = np.delete(self.tails, gone), np.delete(self.heads, gone)
        missing = np.triu(~self.removed, 1)
        missing[self.tails, self.heads] = False
        tails, heads = np.nonzero(missing)
        if len(tails) + len(self.tails) <= COMPLETE * self.nodes:
            self._add_edges(tails, heads)
            self.solution = replace(self.solution, x=np.append(self.solution.x, np.zeros(len(tails))))
            self.complete = True

    # Cuts

    def support(self) -> Support:
        """Return the edges that carry weight in the current point."""
        used = self.solution.x > INTEGRALITY
        return Support(self.nodes, self.tails[used], self.heads[used], self.solution.x[used])

    def separate(self, *, thorough: bool) -> int:
        self._delete_slack_rows()
        support = self.support()
        found = separate_subtours(support)
        if not found and thorough:
            found = separate_combs(support, self._tight_sets(support), self.rng)
        known = set(self.cuts)
        new = [cut for cut in found if cut not in known]
        for cut in new:
            self._add_cut(cut)
        return len(new)

    def _tight_sets(self, support: Support) -> list[frozenset[int]]:
        sets = [cut.sets[0] for cut in self.cuts if len(cut.sets) == 1]
        return [members for members in sets if support.cut_value(members) < 2.0 + INTEGRALITY]

    def _delete_slack_rows(self) -> None:
        duals = self.solution.duals[self.first_cut :]
        self.slack_rounds = [
            0 if dual > 1e-9 else age + 1 for age, dual in zip(self.slack_rounds, duals, strict=True)
        ]
        old = [index for index, age in enumerate(self.slack_rounds) if age > AGE]
        self.lp.delete_rows(np.array(old, dtype=np.int64) + self.first_cut)
        gone = set(old)
        self.cuts = [cut for index, cut in enumerate(self.cuts) if index not in gone]
        self.slack_rounds = [age for index, age in enumerate(self.slack_rounds) if index not in gone]

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

    def save_basis(self) -> object:
        return self.lp.save_basis()

    def restore_basis(self, basis: object) -> None:
        self.lp.restore_basis(basis)


def best_tour(lengths: Floats, via: Ints, guide: Floats, kicks: int = 0) -> tuple[float, Ints]:
    """Return the length and order of a good tour: local search on ``guide``, then on the lengths.

    With via nodes, one of them comes second, after node 0.
    """
    best: tuple[float, Ints] | None = None
    for node in via if len(via) else [None]:
        bonus = np.zeros_like(lengths)
        if node is not None:
            bonus[0, node] = bonus[node, 0] = -FORCED
        tour = improve_tour(guide + bonus, nearest_neighbour_tour(guide + bonus), 0, 0)
        tour = home_first(improve_tour(lengths + bonus, tour, kicks, 0), node)
        value = tour_length(lengths, tour)
        if best is None or value < best[0]:
            best = value, tour
    assert best is not None
    return best


def home_first(tour: Ints, via: int | None) -> Ints:
    """Turn a closed tour so that node 0 comes first and, if given, the via node second."""
    tour = np.roll(tour, -int(np.flatnonzero(tour == 0)[0]))
    if via is not None and tour[1] != via:
        tour = np.roll(tour[::-1], 1)
    if via is not None and tour[1] != via:
        raise AssertionError("local search lost the edge from the home to the via node")
    return tour


def shortest_tour(
    lengths: Floats,
    via: Sequence[int] = (),
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
    via_nodes = np.array(sorted(via), dtype=np.int64)
    if start is None:
        start = best_tour(lengths, via_nodes, lengths, kicks=20 * nodes)
    if nodes <= 3:  # the tour is the only one, but for its direction
        return Outcome(start[0], start[0], start[1], True, 0)
    search = BranchAndCut(
        TourModel(lengths, via_nodes.tolist(), start[1]),
        incumbent=start,
        cutoff=cutoff,
        tolerance=TOLERANCE * max(1.0, start[0]),
        deadline=deadline,
        watch=watch,
    )
    return search.run()
