"""From even connected multigraphs to plans and back, and first ones: trees of links that are passed twice.

Links that are passed twice join groups of contours; a tour of rapids visits one node of each group.
"""

from collections.abc import Iterator

import networkx
import numpy as np

from cutgap.formulations.links.cuts import LINK, RAPID
from cutgap.formulations.links.graph import LinkGraph, Multigraph, Pair
from cutgap.instances import Instance, Plan, Visit
from cutgap.instances.entry_tours import EntrySearch, plain_task
from cutgap.instances.links.strokes import groups, link_ends, strokes
from cutgap.instances.plan import Link

TRIES = 6
"""Numbers of groups that are tried for a first plan, where several are allowed."""

ROUNDS = 20
"""Rounds of local search a group."""


def plan_of(instance: Instance, passes: Multigraph) -> Plan:
    """Return the plan of an even connected multigraph whose groups have two rapid ends each."""
    links = tuple(
        Link(*_spot(instance, tail), *_spot(instance, head), count)
        for (kind, tail, head), count in sorted(passes.items())
        if kind == LINK
    )
    leaders, home = groups(instance, links), instance.node_count - 1

    def stand(node: int) -> int:
        """Return where a rapid can start that ends at a node: the home, or a group."""
        return -1 if node == home else leaders[_spot(instance, node)[0]]

    rapids = [edge[1:] for edge, count in sorted(passes.items()) if edge[0] == RAPID for _ in range(count)]
    visits: list[Visit] = []
    at = home
    while rapids:
        tail, head = next(ends for ends in rapids if stand(at) in map(stand, ends))
        rapids.remove((tail, head))
        at = head if stand(tail) == stand(at) else tail
        if at != home:
            visits.append(Visit(*_spot(instance, at)))
    return Plan((tuple(visits),), links)


def _spot(instance: Instance, node: int) -> tuple[int, int]:
    """Return contour and entry point of a node."""
    contour = int(np.searchsorted(instance.first_node, node, side="right")) - 1
    return contour, node - int(instance.first_node[contour])


def passes_of(instance: Instance, plan: Plan) -> Multigraph:
    """Return how often a plan passes its links and rapids."""
    home = instance.node_count - 1
    passes: Multigraph = {}
    at = home
    for stroke in strokes(instance, plan)[0]:
        _count(passes, RAPID, at, stroke.start, 1)
        for link in stroke.links:
            _count(passes, LINK, *link_ends(instance, link), link.passes)
        at = stroke.end
    _count(passes, RAPID, at, home, 1)
    return passes


def _count(passes: Multigraph, kind: int, tail: int, head: int, times: int) -> None:
    key = kind, min(tail, head), max(tail, head)
    passes[key] = passes.get(key, 0) + times


def cost(graph: LinkGraph, passes: Multigraph) -> float:
    """Return the cost of a multigraph, mm."""
    return float(
        sum(
            (graph.links if kind == LINK else graph.rapids)[p, q] * count
            for (kind, p, q), count in passes.items()
        )
    )


def first_plans(graph: LinkGraph, tree: list[Pair]) -> Iterator[Multigraph]:
    """Yield multigraphs of doubled trees, for some numbers of groups, made by the cheapest links of a tree."""
    lengths = [float(graph.links[link]) for link in tree]
    links = [tree[each] for each in np.argsort(lengths, kind="stable")]
    fewest = graph.home - len(links)
    most = graph.home if graph.pierces is None else min(graph.pierces, graph.home)
    for count in np.unique(np.linspace(fewest, most, TRIES).round().astype(int)).tolist():
        yield _grouped(graph, links[: graph.home - count])


def _grouped(graph: LinkGraph, links: list[Pair]) -> Multigraph:
    """Return links passed twice, and the shortest tour that is found through the groups that they make."""
    forest = networkx.Graph()
    forest.add_nodes_from(range(graph.places))
    forest.add_edges_from((int(graph.place_of[p]), int(graph.place_of[q])) for p, q in links)
    parts = sorted(sorted(part) for part in networkx.connected_components(forest))
    nodes = [[v for place in part for v in range(*graph.members(place).indices(graph.nodes))] for part in parts]
    passes: Multigraph = {(LINK, *link): 2 for link in links}
    if len(parts) == 2:
        contours = [place for part in parts for place in part if place != graph.home]
        near = min((graph.nearest_rapid(each) for each in contours), key=lambda pair: float(graph.rapids[pair]))
        return {**passes, (RAPID, *near): 2}
    order = np.concatenate([np.array(each, dtype=np.int64) for each in nodes])
    lengths = graph.rapids[np.ix_(order, order)]
    first = np.cumsum([0, *map(len, nodes)])
    search = EntrySearch(
        plain_task(np.where(np.isfinite(lengths), lengths, 0.0), first),
        ROUNDS * len(parts),
        rng=np.random.default_rng(0),
    )
    search.run(search.rounds)
    stops = [int(order[first[visit.contour] + visit.entry]) for visit in search.best.visits]
    for tail, head in zip(stops, np.roll(stops, -1).tolist(), strict=True):
        _count(passes, RAPID, tail, head, 1)
    return passes
