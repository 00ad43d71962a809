"""Finding violated rows of the model of links (see ``cuts``) at a fractional point.

Partitions: those of least weight less their number of parts, exactly, by the greedy algorithm for the Dilworth
truncation of half a cut function, one minimum cut a place (Cunningham, 1985; Barahona, 1992). The weights, as
s (k - 1) / k + d, depend on k, so it runs for some k again. Parities: cuts of a cut tree with the weights
min(s, 1 - s), each with its best odd set (Padberg, Rao, 1982; Letchford, Reinelt, Theis, 2004).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numba import njit

from cutgap.formulations.branch_and_cut.flows import Graph, build_graph, cut_tree, maximum_flow
from cutgap.formulations.branch_and_cut.separation import Mask, Support, connectivity_violations
from cutgap.formulations.links.cuts import (
    DOUBLE,
    EXCESS,
    LINK,
    RAPID,
    TRIPLE,
    Bundle,
    Columns,
    Cut,
    Edge,
    Group,
    Parity,
    Partition,
    Rank,
    Triangle,
    Triple,
    coefficients,
)
from cutgap.instances.arrays import Floats, Ints

VIOLATION = 1e-5
"""Least violation that is worth a row."""

SMALL = 0.02
"""Triangles of less weight than this are not looked at."""

ENOUGH = 1e6
"""Capacity that no cut takes."""


@dataclass(frozen=True, slots=True)
class Point:
    """A fractional solution: the columns of some weight ``x``, and the number of places."""

    columns: Columns
    x: Floats
    places: int

    def support(self, single: float, double: float, excess: float = 0.0) -> Support:
        """Return the graph of places where s, d and e count so much each."""
        pairs = self.columns.kinds != TRIPLE
        weights = self.x * np.array([single, single, double, excess, 0.0])[self.columns.kinds]
        ends = (self.columns.places[pairs], self.columns.others[pairs])
        graph = Support(self.places, *ends, weights[pairs])
        return graph.shrink(np.arange(self.places), self.places)

    def missing(self, cut: Cut) -> float:
        """Return by how much the point misses a row."""
        values = coefficients(cut, self.columns, self.places - 1)
        return cut.row.least - float(values @ self.x)


def partitions(point: Point, *, thorough: bool) -> list[Partition]:
    """Return violated (2): minimum cuts, and with ``thorough`` partitions of more parts."""
    home = point.places - 1
    both = point.support(1.0, 2.0)
    label = both.components()
    found = [_partition(label == each, home) for each in range(label.max() + 1) if each != label[home]]
    if found:
        return [_of_labels(label, home), *found] if len(found) > 1 else found
    found = [_partition(mask, home) for mask in connectivity_violations(both, home, np.full(point.places, 2.0))]
    if thorough or not found:
        found += list(_many_parts(point, home))
    return [cut for cut in dict.fromkeys(found) if point.missing(cut) > VIOLATION]


def _partition(mask: Mask, home: int) -> Partition:
    inside = mask if not mask[home] else ~mask
    return Partition((frozenset(np.flatnonzero(inside).tolist()),))


def _of_labels(label: Ints, home: int) -> Partition:
    parts = (np.flatnonzero(label == each).tolist() for each in np.unique(label) if each != label[home])
    return Partition(tuple(map(frozenset, parts)))


def _many_parts(point: Point, home: int) -> Iterator[Partition]:
    """Yield the worst partitions for the weights of some numbers of parts, which lead to the next numbers."""
    order = np.roll(np.arange(point.places), 1)  # the home first
    for start in (point.places, 8, 4, 3):
        count, seen = start, set[int]()
        while count >= 3 and count not in seen:
            seen.add(count)
            support = point.support((count - 1) / count, 1.0, (2 - count) / count)
            label = _truncation(support.tails, support.heads, support.x, order)
            count = len(np.unique(label))
            if count >= 2:
                yield _of_labels(label, home)


def _truncation(tails: Ints, heads: Ints, weights: Floats, order: Ints) -> Ints:
    """Return the partition of least weight between parts less the number of parts."""
    places = len(order)
    small = np.arange(places)
    source, sink = np.full(places, places), np.full(places, places + 1)
    graph = build_graph(
        places + 2, np.concatenate([tails, source, small]), np.concatenate([heads, small, sink])
    )
    return _greedy(graph, weights, order)


@njit(cache=True)
def _greedy(graph: Graph, weights: Floats, order: Ints) -> Ints:
    r"""Give each place v, in order, the least of  cut(S) / 2 - 1 - y(S \ v)  over S with v within what came."""
    places, edges = len(order), len(weights)
    label = np.arange(places)
    y = np.zeros(places)
    came = np.zeros(places, dtype=np.bool_)
    capacity = np.zeros(edges + 2 * places)
    capacity[:edges] = np.maximum(weights, 0.0) / 2.0
    is_source = np.zeros(places + 2, dtype=np.bool_)
    for v in order:
        constant = 0.0
        for u in range(places):
            gain = y[u] if came[u] else 0.0
            constant += max(gain, 0.0)
            capacity[edges + u] = max(gain, 0.0)
            capacity[edges + places + u] = max(-gain, 0.0) if came[u] else ENOUGH
        capacity[edges + places + v] = 0.0
        is_source[:] = False
        is_source[places] = is_source[v] = True
        flow, reached = maximum_flow(graph, capacity[graph.edge], is_source, places + 1, ENOUGH)
        y[v] = flow - constant - 1.0
        came[v] = True
        for u in range(places):
            if reached[u] and label[u] != label[v]:
                old = label[u]
                for w in range(places):
                    if label[w] == old:
                        label[w] = label[v]
    return label


def parities(point: Point, *, thorough: bool) -> list[Parity]:
    """Return violated (3): of single nodes, and with ``thorough`` or without such ones of node sets."""
    single = np.flatnonzero(point.columns.kinds < DOUBLE)
    if len(single) == 0:
        return []
    tails, heads, s = point.columns.tails[single], point.columns.heads[single], point.x[single]
    edges = [point.columns.edges()[each] for each in single.tolist()]
    used, ends = np.unique(np.concatenate([tails, heads]), return_inverse=True)
    tails, heads = ends[: len(single)], ends[len(single) :]
    found = list(_odd_cuts(np.eye(len(used), dtype=bool), tails, heads, s, used, edges))
    if thorough or not found:
        graph = build_graph(len(used), tails, heads)
        sides = cut_tree(graph, np.minimum(s, 1.0 - s).clip(min=0.0))[2][1:]
        found += _odd_cuts(sides, tails, heads, s, used, edges)
    return list(dict.fromkeys(found))


def _odd_cuts(
    masks: Mask, tails: Ints, heads: Ints, s: Floats, used: Ints, edges: list[tuple[int, int, int]]
) -> Iterator[Parity]:
    """Yield the violated rows of node sets, each with its best odd set of edges."""
    crossing = masks[:, tails] != masks[:, heads]
    for mask, across in zip(masks, crossing, strict=True):
        border = np.flatnonzero(across)
        if len(border) == 0:
            continue
        odd = s[border] > 0.5
        if odd.sum() % 2 == 0:
            turn = int(np.abs(s[border] - 0.5).argmin())
            odd[turn] = ~odd[turn]
        if np.where(odd, 1.0 - s[border], s[border]).sum() < 1.0 - VIOLATION:
            inside = mask if 2 * mask.sum() <= len(mask) else ~mask
            yield Parity(
                frozenset(used[inside].tolist()), frozenset(edges[each] for each in border[odd].tolist())
            )


def _toward(point: Point, first: Ints) -> tuple[Floats, Floats]:
    """Return the single edges from each node to each place, and t of each two places."""
    columns = point.columns
    single = columns.kinds < DOUBLE
    toward = np.zeros((int(first[-1]), point.places))
    np.add.at(toward, (columns.tails[single], columns.others[single]), point.x[single])
    np.add.at(toward, (columns.heads[single], columns.places[single]), point.x[single])
    odds = np.add.reduceat(toward, first[:-1], axis=0)
    excess = columns.kinds == EXCESS
    pairs = columns.places[excess], columns.others[excess]
    odds[pairs] -= 2.0 * point.x[excess]
    odds[pairs[::-1]] -= 2.0 * point.x[excess]
    return toward, odds


def ranks(point: Point, first: Ints) -> list[Cut]:
    """Return violated (9) for the triples that must be triangles, and the (8) that say so."""
    forced = {
        each.triple: (amount, each) for amount, each in sorted(_triangles(point, first), key=lambda a: a[0])
    }
    used: set[tuple[int, int]] = set()
    family: dict[Triple, float] = {}
    for triple, (amount, _) in sorted(forced.items(), key=lambda item: (-item[1][0], item[0])):
        pairs = set(combinations(triple, 2))
        if amount > SMALL and not pairs & used:
            used |= pairs
            family[triple] = amount
    if not family:
        return []
    values = np.array(list(family.values()))
    edges: list[Edge] = [(EXCESS, *pair) for triple in family for pair in combinations(triple, 2)]
    shares = Columns.of(edges, np.zeros(1, dtype=np.int64))
    found: list[Cut] = []
    for share in (1.0 / 2.0, 2.0 / 3.0):
        support = Point(point.columns + shares, np.append(point.x, np.repeat(share * values, 3)), point.places)
        graph = support.support(1.0, 1.0, -1.0)
        label = _truncation(graph.tails, graph.heads, graph.x, np.roll(np.arange(point.places), 1))
        if len(np.unique(label)) < 3:
            continue
        cut = Rank(_of_labels(label, point.places - 1), frozenset(family))
        crossed = sum(amount for triple, amount in family.items() if len(set(label[list(triple)].tolist())) > 1)
        plain = Rank(cut.partition, frozenset())
        if point.missing(plain) + crossed > VIOLATION:
            found += [cut, *(forced[triple][1] for triple in family)]
    return list(dict.fromkeys(found))


def _triangles(point: Point, first: Ints) -> Iterator[tuple[float, Triangle]]:
    """Yield the least that w must be by (8), for every triple of places that are joined by single edges."""
    toward, odds = _toward(point, first)
    near = [set(np.flatnonzero(row > SMALL).tolist()) for row in odds]
    total = toward.sum(axis=1)
    for i in range(point.places):
        for j in (each for each in near[i] if each > i):
            for k in near[i] & near[j]:
                sets, loose = [], 0.0
                for mine, other in ((i, j), (j, i)):
                    members = slice(first[mine], first[mine + 1])
                    inside = toward[members, other] + toward[members, k]
                    outside = total[members] - inside
                    loose += float(np.minimum(inside, outside).sum())
                    nodes = first[mine] + np.flatnonzero(inside > outside)
                    sets.append(frozenset(nodes.tolist()))
                if odds[i, j] - loose > SMALL:
                    yield float(odds[i, j]) - loose, Triangle((i, j), k, (sets[0], sets[1]))


def bundles(point: Point, first: Ints) -> list[Bundle]:
    """Return violated (6) and (7), these each with its best nodes; ``first`` holds the places' first nodes."""
    toward, odds = _toward(point, first)
    away = toward.sum(axis=1)[:, None] - toward
    found = []
    for i, j in np.argwhere(np.abs(odds) > VIOLATION).tolist():
        members = slice(first[i], first[i + 1])
        odd = odds[i, j]
        if i < j and odd > 1.0 + VIOLATION:
            found.append(Bundle(i, j, None))
        if odd > np.minimum(toward[members, j], away[members, j]).sum() + VIOLATION:
            nodes = first[i] + np.flatnonzero(toward[members, j] > away[members, j])
            found.append(Bundle(i, j, frozenset(nodes.tolist())))
    return found


def group_cuts(point: Point) -> list[Group]:
    """Return violated (5): of single contours, and of trees of the heaviest links."""
    columns, home = point.columns, point.places - 1
    at_home = columns.others == home
    weights = point.x * np.where(
        columns.kinds == RAPID, 1.0, np.where(at_home & (columns.kinds == DOUBLE), 2.0, 0.0)
    )
    ends = np.zeros(point.places)
    ending = np.flatnonzero(weights)
    np.add.at(ends, columns.places[ending], weights[ending])
    np.add.at(ends, columns.others[ending], weights[ending])
    found = [Group(frozenset([place])) for place in np.flatnonzero(ends[:home] > 2.0 + VIOLATION).tolist()]
    members = {place: [place] for place in range(home)}
    trees: dict[int, list[tuple[int, int, int, int]]] = {place: [] for place in range(home)}
    for pair, link, weight in _joints(point):
        one, other = (members[each] for each in pair)
        if one is other or weight < 0.5:
            continue
        tree = trees[one[0]] + trees[other[0]] + [(*link, *pair)]
        one += other
        for place in one:
            members[place], trees[place] = one, tree
        if ends[one].sum() > 2.0:
            joints = frozenset((i, j) for _, _, i, j in tree)
            links = frozenset((p, q) for p, q, _, _ in tree if p >= 0)
            found.append(Group(frozenset(one), links, joints))
    return [cut for cut in dict.fromkeys(found) if point.missing(cut) > VIOLATION]


def _joints(point: Point) -> list[tuple[tuple[int, int], tuple[int, int], float]]:
    """Return pairs of contours, their heaviest link, and what it and the double weigh; heaviest first."""
    best: dict[tuple[int, int], tuple[float, tuple[int, int]]] = {}
    doubles: dict[tuple[int, int], float] = {}
    home = point.places - 1
    places = zip(point.columns.places.tolist(), point.columns.others.tolist(), strict=True)
    for (kind, tail, head), pair, x in zip(point.columns.edges(), places, point.x.tolist(), strict=True):
        if kind == LINK:
            best[pair] = max(best.get(pair, (0.0, (tail, head))), (x, (tail, head)))
        elif kind == DOUBLE and head != home:
            doubles[pair] = x
    joints = [
        (pair, best.get(pair, (0.0, (-1, -1)))[1], best.get(pair, (0.0, (-1, -1)))[0] + doubles.get(pair, 0.0))
        for pair in best.keys() | doubles.keys()
    ]
    return sorted(joints, key=lambda joint: (-joint[2], joint[0]))
