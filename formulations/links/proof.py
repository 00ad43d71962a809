"""Certificates of the method ``links``: what the search remembers, in the names and numbers of the checker."""

from fractions import Fraction
from itertools import combinations, product
from typing import Any

import numpy as np

from cutgap.formulations.branch_and_cut.engine import Outcome
from cutgap.formulations.branch_and_cut.model import Fixing, Proof
from cutgap.formulations.certify import (
    SCALE,
    TOUR_MULTIPLIER_SCALE,
    Certificate,
    Family,
    Rows,
    certificate_of,
    flat_tree,
    leaf_proof,
)
from cutgap.formulations.links.cuts import DOUBLE, LINK, RAPID, Bundle, Group, Parity, Partition, Rank, Triangle
from cutgap.formulations.links.graph import LinkGraph
from cutgap.formulations.links.prices import Prices
from cutgap.instances import Instance, Plan, Rules
from cutgap.instances.links.clearance import deepest_shares

SHARES = 10**6
"""Places on blocked links are shares of them with this denominator."""

MARGINS_MM = (1e-6, 1e-4, 1e-2, 0.2, 2.0)
"""The checker prices links that only graze a part, which the search leaves out: proofs may fall short of it."""

KINDS = {LINK: "s", RAPID: "r", DOUBLE: "d"}


def bound_certificate(
    instance: Instance, rules: Rules, graph: LinkGraph, outcome: Outcome, plan: Plan | None
) -> Certificate | None:
    """Return a verified certificate of what a search proved."""
    work = 0
    if rules.objective == "makespan":
        machine, perimeters = instance.machine, [contour.perimeter for contour in instance.contours]
        exact = sum((Fraction(repr(each)) for each in perimeters), Fraction(0))
        work = int(SCALE * Fraction(repr(machine.v_jump)) * exact / Fraction(repr(machine.v_cut)))

    def claim(margin: float) -> tuple[int | None, dict[str, Any]]:
        length = max(0.0, outcome.lower_bound - margin)
        return work + int(length * SCALE), _tree(graph, outcome, length)

    return certificate_of(instance, rules, plan, TOUR_MULTIPLIER_SCALE, claim, margins=MARGINS_MM)


def empty_certificate(instance: Instance, rules: Rules, plan: Plan) -> Certificate | None:
    """Return the certificate of an instance without contours."""
    proof = {"kind": "links", "rows": [], "nodes": [], "blocked": []}
    return certificate_of(instance, rules, plan, TOUR_MULTIPLIER_SCALE, lambda _: (0, proof))


def infeasibility_certificate(
    instance: Instance, rules: Rules, graph: LinkGraph, parts: list[list[int]]
) -> Certificate | None:
    """Return the certificate that more pierces are needed, one for each of the parts that no link joins.

    The rows partition, k - 1 times less home, and k - 1 times pierces leave no edge a positive coefficient.
    """
    count = len(parts)
    rows: list[Any] = [["partition", parts], ["home"], ["pierces"]]
    leaf = [[0, 1], [1, -count], [2, count]] if (rules.pierces or 0) > 1 else [[0, 1], [1, -count]]
    pairs = [
        (min(pair), max(pair))
        for one, other in combinations(parts, 2)
        for i, j in product(one, other)
        for pair in product(
            range(*graph.members(i).indices(graph.nodes)), range(*graph.members(j).indices(graph.nodes))
        )
    ]
    proof = {"kind": "links", "rows": rows, "nodes": [{"leaf": leaf}], "blocked": _blocked(instance, pairs)}
    return certificate_of(instance, rules, None, 1, lambda _: (None, proof))


def _tree(graph: LinkGraph, outcome: Outcome, target: float) -> dict[str, Any]:
    assert outcome.root is not None
    rows = Rows(lambda name: _family(name, graph))
    nodes = flat_tree(outcome.root, (), rows, lambda fixing: _variable(fixing, graph), target)
    pairs: set[tuple[int, int]] = set()
    waiting = [outcome.root]
    while waiting:
        node = waiting.pop()
        waiting += node.children
        if not node.children:
            pairs |= _tempting(graph, leaf_proof(node, target))
    blocked = _blocked(graph.instance, sorted(pairs))
    return {"kind": "links", "rows": rows.names, "nodes": nodes, "blocked": blocked}


def _tempting(graph: LinkGraph, proof: Proof) -> set[tuple[int, int]]:
    """Return the blocked links of negative reduced cost, single or double."""
    prices = Prices(graph, [name for name, _ in proof], np.array([value for _, value in proof]))
    tails, heads = prices.blocked_links(graph)
    return set(zip(tails.tolist(), heads.tolist(), strict=True))


def _blocked(instance: Instance, pairs: list[tuple[int, int]]) -> list[list[int]]:
    """Return links, each with a share of it that is deep in a part, but for those that only graze one."""
    if not pairs:
        return []
    tails, heads = np.array(pairs, dtype=np.int64).T
    shares = deepest_shares(instance, tails, heads)
    return [
        [p, q, round(share * SHARES)]
        for (p, q), share in zip(pairs, shares.tolist(), strict=True)
        if np.isfinite(share)
    ]


def _variable(fixing: Fixing, graph: LinkGraph) -> list[Any]:
    rest, head = divmod(fixing.variable, graph.nodes)
    kind, tail = divmod(rest, graph.nodes)
    return [KINDS[kind], tail, head]


def _family(name: Any, graph: LinkGraph) -> Family:
    """Name the rows of the model, and say how often the checker's row is the model's."""
    factor = float(SCALE * TOUR_MULTIPLIER_SCALE)
    if isinstance(name, Partition):
        return ["partition", sorted(sorted(part) for part in name.parts)], factor / (name.count - 1)
    if isinstance(name, Parity):
        return ["parity", sorted(name.nodes), [[KINDS[kind], p, q] for kind, p, q in sorted(name.odd)]], factor
    if isinstance(name, Group):
        links = {(int(graph.place_of[p]), int(graph.place_of[q])): [p, q] for p, q in name.tree}
        joints = [[*joint, *links.get(joint, [])] for joint in sorted(name.joints)]
        return ["group", sorted(name.contours), joints], factor
    if isinstance(name, Rank):
        parts = sorted(sorted(part) for part in name.partition.parts)
        return ["rank", parts, [list(triple) for triple in sorted(name.triples)]], factor
    if isinstance(name, Triangle):
        return ["triangle", *name.pair, name.third, *(sorted(nodes) for nodes in name.nodes)], factor
    if isinstance(name, Bundle):
        if name.nodes is None:
            return ["once", name.place, name.other], factor
        return ["bundle", name.place, name.other, sorted(name.nodes)], factor
    return [name[0]], factor
