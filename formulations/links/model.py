r"""The cheapest even connected multigraph of links and rapids, as branch and cut sees it.

    Nodes      entry points of contours 0..m-1, then the home; places are the contours and the home
    Variables  s_e in {0, 1}    link or rapid e is passed once                                   [-]
               d_ij in {0, 1}   contours i, j are joined by a link that is passed twice, or
                                contour i and the home by a rapid                                [-]
               e_ij             half of the s between places i and j, rounded down               [-]
               w_ijk in {0, 1}  the numbers of single edges between i, j, k are all odd          [-]
    Data       c_e >= 0         what one pass costs (see ``graph``)                              [mm]

    min  sum_e c_e s_e + sum_ij 2 c_ij d_ij,   c_ij the least cost of a clear link between i and j

subject to the rows (1) to (9) of ``cuts``. Some best plan is such a point: of several doubled links between two
contours one is enough, and none is needed beside a single one, as even nodes and connection stay.

Columns enter when their reduced cost asks for it. Only then a link is tested for clearance; one that leads
through a part goes for good.

Source: Edmonds, Johnson (1973) for even sets of edges; Chopra (1989) for partitions; (2) joins both.
"""

from collections.abc import Hashable, Sequence

import numpy as np

from cutgap.formulations.branch_and_cut.model import Fixing, Model, Row
from cutgap.formulations.branch_and_cut.tour import INTEGRALITY
from cutgap.formulations.links import wording as words
from cutgap.formulations.links.cuts import (
    DOUBLE,
    EXCESS,
    HOME,
    LINK,
    PIERCES,
    RAPID,
    TRIPLE,
    Bundle,
    Columns,
    Cut,
    Edge,
    Rank,
    Triangle,
    coefficients,
)
from cutgap.formulations.links.graph import LinkGraph, Multigraph
from cutgap.formulations.links.prices import Prices
from cutgap.formulations.links.rounding import rounded
from cutgap.formulations.links.separation import Point, bundles, group_cuts, parities, partitions, ranks
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.scene import Decision, Inequality, Leg


class LinkModel(Model):
    """The model above; variable (kind * nodes + tail) * nodes + head is the edge of a kind and two ends."""

    wording = words.FAMILIES

    def __init__(self, graph: LinkGraph, known: Multigraph) -> None:
        super().__init__()
        self.graph, self.tree = graph, graph.tree()
        self.columns = Columns.of([], graph.place_of)
        self.priced = np.zeros((3, graph.nodes, graph.nodes), dtype=np.bool_)
        self.counted: set[Edge] = set()  # e and w that have a column
        self.add_row(Row(HOME, 2.0, equal=True))
        if graph.pierces is not None and graph.pierces > 1:
            self.add_row(Row(PIERCES, 1.0 - graph.pierces))
        self.permanent = len(self.rows)
        self._add_columns(self._first_edges(known))

    def _first_edges(self, known: Multigraph) -> list[Edge]:
        """Return the edges of a known multigraph, the cheapest tree, and the ways between home and contours."""
        graph, place_of = self.graph, self.graph.place_of.tolist()
        edges: list[Edge] = [(DOUBLE, contour, graph.home) for contour in range(graph.home)]
        edges += [(RAPID, *graph.nearest_rapid(contour)) for contour in range(graph.home)]
        edges += [(DOUBLE, place_of[p], place_of[q]) for p, q in self.tree]
        for (kind, tail, head), passes in known.items():
            if passes == 2:
                edges.append((DOUBLE, place_of[tail], place_of[head]))
                continue
            needed = head == graph.home_node or graph.rapids_needed(np.array([tail]), np.array([head]))[0]
            edges.append((kind if needed else LINK, tail, head))
        return list(dict.fromkeys(edges))

    def _cost(self, edge: Edge) -> float:
        kind, tail, head = edge
        if kind in (EXCESS, TRIPLE):
            return 0.0
        if kind == DOUBLE:
            rapid = head == self.graph.home
            pair = self.graph.nearest_rapid(tail) if rapid else self.graph.cheapest(tail, head)
            return 2.0 * float((self.graph.rapids if rapid else self.graph.links)[pair])
        return float((self.graph.links if kind == LINK else self.graph.rapids)[tail, head])

    def _add_columns(self, edges: list[Edge]) -> None:
        """Give edges a column each."""
        if not edges:
            return
        new = Columns.of(edges, self.graph.place_of)
        table = np.array([coefficients(row.name, new, self.graph.home) for row in self.rows]).T
        columns, rows = np.nonzero(table)
        starts = np.searchsorted(columns, np.arange(len(new)))
        costs = np.array([self._cost(edge) for edge in edges])
        self.lp.add_columns(costs, np.zeros(len(new)), self._upper(new), starts, rows, table[columns, rows])
        self.columns += new
        priced = new.kinds < EXCESS
        self.priced[new.kinds[priced], new.tails[priced], new.heads[priced]] = True

    def _upper(self, columns: Columns) -> Floats:
        """Return the upper bounds of columns: an e is not above the pairs of nodes."""
        sizes, excess = np.diff(self.graph.first), columns.kinds == EXCESS
        upper = np.ones(len(columns))
        upper[excess] = sizes[columns.places[excess]] * sizes[columns.others[excess]]
        return upper

    def add_cut(self, cut: Cut) -> None:
        """Append a row of ``cuts`` by its name."""
        places, needed = self.graph.places, list[Edge]()
        if isinstance(cut, Bundle):
            needed = [cut.excess]
        elif isinstance(cut, Triangle):
            i, j, k = cut.triple
            needed = [(EXCESS, *cut.pair), (TRIPLE, i, j * places + k)]
        elif isinstance(cut, Rank):
            needed = [(TRIPLE, i, j * places + k) for i, j, k in sorted(cut.triples)]
        self._add_columns([edge for edge in needed if edge not in self.counted])
        self.counted.update(needed)
        values = coefficients(cut, self.columns, self.graph.home)
        hits = np.flatnonzero(values)
        self.add_row(cut.row, hits, values[hits])

    # Relaxation

    def apply(self, fixings: Sequence[Fixing]) -> None:
        lower, upper = np.zeros(len(self.columns)), self._upper(self.columns)
        for fixing in fixings:
            column = self._column(fixing.variable)
            lower[column], upper[column] = fixing.lower, fixing.upper
        changed = np.flatnonzero((lower != self.lp.lower) | (upper != self.lp.upper))
        self.lp.change_bounds(changed, lower[changed], upper[changed])

    def _column(self, variable: int) -> int:
        """Return the column of a variable that was branched on; columns never leave."""
        rest, head = divmod(variable, self.graph.nodes)
        kind, tail = divmod(rest, self.graph.nodes)
        columns = self.columns
        return int(
            np.flatnonzero((columns.kinds == kind) & (columns.tails == tail) & (columns.heads == head))[0]
        )

    def variable(self, column: int) -> int:
        """Return the variable of a column."""
        kind, tail, head = (
            int(each[column]) for each in (self.columns.kinds, self.columns.tails, self.columns.heads)
        )
        return (kind * self.graph.nodes + tail) * self.graph.nodes + head

    def edge(self, variable: int) -> Edge:
        """Return kind and ends of a variable."""
        rest, head = divmod(variable, self.graph.nodes)
        return *divmod(rest, self.graph.nodes), head

    def solve(self, iteration_limit: int | None = None) -> None:
        while True:
            self.solution = self.lp.solve(iteration_limit)
            if iteration_limit is not None or not self._price():
                return

    def _price(self) -> bool:
        """Add the edges of most negative reduced cost; False when there are none."""
        prices = Prices(self.graph, [row.name for row in self.rows], self.multipliers())
        found: list[tuple[float, Edge]] = []
        scale = 0.0 if self.solution.infeasible else 1.0
        for kind in (LINK, RAPID, DOUBLE):
            while True:
                reduced, tails, heads = prices.negative(kind, self.priced[kind], scale)
                worst = np.argsort(reduced, kind="stable")[: 2 * self.graph.nodes]
                tails, heads, reduced = tails[worst], heads[worst], reduced[worst]
                good = self._are_clear(kind, tails, heads)
                found += zip(
                    reduced[good].tolist(),
                    ((kind, p, q) for p, q in zip(tails[good].tolist(), heads[good].tolist(), strict=True)),
                    strict=True,
                )
                if good.any() or len(good) == 0:
                    break
        edges = [edge for _, edge in sorted(found)[: 2 * self.graph.nodes]]
        self._add_columns(edges)
        return bool(edges)

    def _are_clear(self, kind: int, tails: Ints, heads: Ints) -> np.ndarray:
        """Return which edges there are: links that are clear, the cheapest ones of pairs of contours."""
        if len(tails) == 0:
            return np.ones(0, dtype=np.bool_)
        if kind == RAPID:
            return self.graph.rapids_needed(tails, heads)
        if kind == LINK:
            return self.graph.clear(tails, heads)
        pairs = [
            self.graph.nearest_rapid(i) if j == self.graph.home else self.graph.cheapest(i, j)
            for i, j in zip(tails.tolist(), heads.tolist(), strict=True)
        ]
        p, q = np.array(pairs, dtype=np.int64).T
        is_link = heads != self.graph.home
        is_link[is_link] = ~self.graph.clear(p[is_link], q[is_link])
        return ~is_link

    def column_terms(self) -> float:
        multipliers = self.multipliers()
        prices = Prices(self.graph, [row.name for row in self.rows], multipliers)
        scale = 0.0 if self.solution.infeasible else 1.0
        own = scale * self.lp.costs - self.lp.row_combination(multipliers)
        rest = sum(
            float(prices.negative(kind, self.priced[kind], scale, 0.0)[0].sum())
            for kind in (LINK, RAPID, DOUBLE)
        )
        return rest + float(np.minimum(own * self.lp.lower, own * self.lp.upper).sum())

    # Cuts

    def point(self) -> Point:
        """Return the current fractional solution."""
        used = np.flatnonzero(self.solution.x > INTEGRALITY)
        columns = self.columns
        part = Columns(*(getattr(columns, name)[used] for name in Columns.__slots__))
        return Point(part, self.solution.x[used], self.graph.places)

    def separate(self, *, thorough: bool) -> int:
        self.forget_slack_rows()
        point = self.point()
        found: list[Cut] = [*partitions(point, thorough=thorough)]
        found += parities(point, thorough=thorough)
        found += bundles(point, self.graph.first)
        if thorough:
            found += ranks(point, self.graph.first)
        if self.graph.pierces != 1:
            found += group_cuts(point)
        known: set[Hashable] = {row.name for row in self.rows}
        new = [cut for cut in found if cut not in known]
        for cut in new:
            self.add_cut(cut)
        return len(new)

    # Search

    def round(self) -> tuple[float, Multigraph] | None:
        point = self.point()
        part = point.columns.kinds < EXCESS
        if (np.abs(point.x - np.round(point.x))[part] <= INTEGRALITY).all() and self._is_plan(point):
            return self.value(point.columns.edges())
        edges = rounded(self.graph, self.tree, point)
        return None if edges is None else self.value(edges)

    def _is_plan(self, point: Point) -> bool:
        """Whether an integral point is connected and even, and its groups have two rapid ends each."""
        single = point.columns.kinds < DOUBLE
        ends = np.concatenate([point.columns.tails[single], point.columns.heads[single]])
        if point.support(1.0, 2.0).components().any() or (np.bincount(ends) % 2).any():
            return False
        return self.graph.pierces == 1 or not group_cuts(point)

    def value(self, edges: list[Edge]) -> tuple[float, Multigraph]:
        """Return the cost and the passes of a point by its edges."""
        passes: Multigraph = {}
        for edge in edges:
            kind, tail, head = edge
            if kind in (EXCESS, TRIPLE):
                continue
            if kind == DOUBLE:
                rapid = head == self.graph.home
                pair = self.graph.nearest_rapid(tail) if rapid else self.graph.cheapest(tail, head)
                passes[RAPID if rapid else LINK, *pair] = passes.get((RAPID if rapid else LINK, *pair), 0) + 2
            else:
                passes[edge] = passes.get(edge, 0) + 1
        passes = {edge: 2 - count % 2 for edge, count in passes.items()}
        return sum(self._cost(edge) * count for edge, count in passes.items()), passes

    def tighten(self, cutoff: float) -> bool:
        return False

    def candidates(self, most: int) -> list[int]:
        """Take doubles and single edges half and half, each the nearest to a half."""
        x = self.solution.x
        distance = np.abs(x - np.floor(x) - 0.5)
        fractional = np.flatnonzero((distance < 0.5 - INTEGRALITY) & (self.columns.kinds < EXCESS))
        order = fractional[np.argsort(distance[fractional], kind="stable")]
        double = self.columns.kinds[order] == DOUBLE
        columns = [*order[double][: most // 2].tolist(), *order[~double][: most // 2].tolist()]
        return [self.variable(column) for column in columns]

    def children(self, variable: int) -> tuple[Fixing, Fixing]:
        return Fixing(variable, 0.0, 0.0), Fixing(variable, 1.0, 1.0)

    # For who watches

    def legs(self) -> tuple[Leg, ...]:
        return words.legs(self)

    def inequality(self, row: Row) -> Inequality:
        return words.inequality(self, row)

    def decision(self, fixing: Fixing) -> Decision:
        return words.decision(self, fixing)

    def tours(self, solution: Multigraph) -> tuple[tuple[int, ...], ...]:
        return words.tours(self, solution)
