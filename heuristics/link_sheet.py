"""What the search over links reads of an instance: the nodes it uses, clear links between near ones, rapids."""

import numpy as np
from scipy.spatial.distance import cdist

from cutgap.heuristics.euler_bridging import rooms
from cutgap.heuristics.link_rings import Rings, Sheet, edge, insert, new_rings, rapid
from cutgap.instances import Instance, Link, Plan, Rules, Visit
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.links.clearance import blocked

MOST_NODES = 1500
"""Most nodes that the search uses; of more it takes those that are nearest to other contours."""

NEAR_CONTOURS = 10
"""To how many of the nearest contours a node may be linked."""

LINKS_EACH = 3
"""Over how many of the nearest nodes of each of them."""


def chosen_nodes(instance: Instance, wanted: set[int]) -> Ints:
    """Return the nodes that the search uses, ascending, the home last.

    All of them up to ``MOST_NODES``; else ``wanted`` ones and, by turns for each near contour, the nearest.
    """
    count = int(instance.first_node[-1])
    if count <= MOST_NODES:
        return np.arange(count + 1)
    each = max(1, MOST_NODES // len(instance.contours))
    chosen = set(wanted)
    for contour in range(len(instance.contours)):
        own = np.arange(*instance.first_node[contour : contour + 2])
        to_contours = node_distances(instance, own)
        to_contours[:, contour] = np.inf
        near = np.argsort(to_contours.min(axis=0), kind="stable")[:NEAR_CONTOURS]
        ranks = np.argsort(np.argsort(to_contours[:, near], axis=0, kind="stable"), axis=0)
        chosen.update(own[np.argsort(ranks.min(axis=1), kind="stable")[:each]].tolist())
    return np.array(sorted(chosen | {count}), dtype=np.int64)


def node_distances(instance: Instance, nodes: Ints) -> Floats:
    """Return the distance of nodes to the nearest node of each contour, shape (nodes, contours), mm."""
    points = instance.points
    lengths = cdist(points[nodes], points[: int(instance.first_node[-1])])
    return np.minimum.reduceat(lengths, instance.first_node[:-1], axis=1)


def sheet_of(instance: Instance, rules: Rules, nodes: Ints, reference: Plan) -> Sheet:
    """Return what the kernels read, for some nodes (the home last).

    The reference's links are clear, and its pierces the fewest that clear links allow.
    """
    contours, home = len(instance.contours), len(nodes) - 1
    owner = np.searchsorted(instance.first_node, nodes, side="right") - 1
    first = np.searchsorted(owner, np.arange(contours + 2)).astype(np.int64)
    lengths = cdist(instance.points[nodes], instance.points[nodes])
    ones, others = near_pairs(instance, lengths, first, owner)
    clear = ~blocked(instance, nodes[ones], nodes[others])
    place = {int(node): at for at, node in enumerate(nodes)}
    known = [[place[instance.node(*link[:2])], place[instance.node(*link[2:4])]] for link in reference.links]
    pairs = np.concatenate(
        (np.column_stack((ones, others))[clear], np.reshape(known, (-1, 2)).astype(np.int64))
    )
    linked = np.zeros((home + 1, home + 1), dtype=np.bool_)
    linked[pairs[:, 0], pairs[:, 1]] = linked[pairs[:, 1], pairs[:, 0]] = True
    machine = instance.machine
    rapids = instance.rapid_lengths(nodes, nodes)
    if rules.objective == "makespan":
        lengths = lengths / machine.v_cut
        rapids = rapids / machine.v_jump + machine.t_aux
        rapids[:, home] -= machine.t_aux / 2
        rapids[home] -= machine.t_aux / 2
    rapids[home, home] = 0.0
    order = np.argsort(lengths, axis=1, kind="stable")
    near = [row[linked[node, row]] for node, row in enumerate(order)]
    apart = np.minimum.reduceat(np.minimum.reduceat(lengths[:home, :home], first[:-2], 0), first[:-2], 1)
    np.fill_diagonal(apart, -1.0)
    return Sheet(
        np.where(linked, lengths, np.inf),
        np.ascontiguousarray(rapids),
        first,
        owner.astype(np.int64),
        np.concatenate(([0], np.cumsum([len(row) for row in near]))).astype(np.int64),
        np.concatenate(near).astype(np.int64),
        np.ascontiguousarray(np.argsort(apart, axis=1, kind="stable")[:, 1:]),
        np.array(instance.precedence, dtype=np.int64).reshape(-1, 2),
        contours if rules.pierces is None else max(rules.pierces, len(reference.tours[0])),
        float(rapids.max()),
    )


def near_pairs(instance: Instance, lengths: Floats, first: Ints, owner: Ints) -> tuple[Ints, Ints]:
    """Return pairs of nodes of different contours that are near to one another, in rising order."""
    home = len(lengths) - 1
    room = rooms(instance)
    chosen = np.zeros((home, home), dtype=np.bool_)
    away = np.where(room[owner[:home, None]] == room[owner[None, :home]], lengths[:home, :home], np.inf)
    away[owner[:home, None] == owner[None, :home]] = np.inf
    to_contour = np.minimum.reduceat(away, first[:-2], axis=1)
    allowed = np.argsort(np.argsort(to_contour, axis=1, kind="stable"), axis=1) < NEAR_CONTOURS
    for contour in range(len(first) - 2):
        own = slice(*first[contour : contour + 2])
        block = np.where(allowed[:, contour, None], away[:, own], np.inf)
        order = np.argsort(block, axis=1, kind="stable")[:, :LINKS_EACH]
        rows = np.repeat(np.arange(home), order.shape[1])
        columns = first[contour] + order.ravel()
        near = np.isfinite(block[rows, order.ravel()])
        chosen[rows[near], columns[near]] = True
    ones, others = np.nonzero(np.triu(chosen | chosen.T))
    return ones, others


def rings_of(sheet: Sheet, nodes: Ints, instance: Instance, plan: Plan) -> Rings:
    """Return the cycles of a plan whose links are all passed twice and make a forest."""
    place = {int(node): at for at, node in enumerate(nodes)}
    rings, last = new_rings(sheet), 0
    for visit in plan.tours[0]:
        last = insert(sheet, rings, place[instance.node(*visit[:2])], last)
    for link in plan.links:
        ends = place[instance.node(*link[:2])], place[instance.node(*link[2:4])]
        insert(sheet, rings, ends[1], insert(sheet, rings, ends[0], -1))
    return rings


def plan_of_rings(sheet: Sheet, nodes: Ints, instance: Instance, rings: Rings, price: float) -> Plan:
    """Return the plan that the cycles make where a rapid has taken a link's place as it is cheaper."""

    def entry(v: int) -> tuple[int, int]:
        contour = int(sheet.owner[v])
        return contour, int(nodes[v] - instance.first_node[contour])

    visits, passes = [], dict[tuple[int, int], int]()
    slot = int(rings.after[0])
    while slot != 0:
        u, v = int(rings.node[rings.before[slot]]), int(rings.node[slot])
        if rapid(sheet, u, v, price) < sheet.link[u, v]:
            visits.append(Visit(*entry(v)))
        slot = int(rings.after[slot])
    for slot in np.flatnonzero(rings.node >= 0).tolist():
        u, v = int(rings.node[slot]), int(rings.node[rings.after[slot]])
        main = bool(rings.main[slot])
        if u != v and edge(sheet, u, v, main, price) == sheet.link[u, v]:
            ends = min(u, v), max(u, v)
            passes[ends] = passes.get(ends, 0) + 1
    links = [Link(*entry(u), *entry(v), count) for (u, v), count in sorted(passes.items())]
    return Plan((tuple(visits),), tuple(links))
