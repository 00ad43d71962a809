"""The rows of ``cuts`` in words and symbols, with both sides at the current point, for who watches a search."""

from typing import TYPE_CHECKING

import numpy as np

from cutgap.formulations.branch_and_cut.model import Fixing, Row
from cutgap.formulations.links.cuts import (
    DOUBLE,
    Bundle,
    Group,
    Parity,
    Partition,
    Rank,
    Triangle,
    coefficients,
)
from cutgap.formulations.links.graph import Multigraph
from cutgap.instances.scene import Decision, Inequality, Leg

if TYPE_CHECKING:
    from cutgap.formulations.links.model import LinkModel

Named = tuple[tuple[str, tuple[int, ...]], ...]

WORDS: dict[type, tuple[str, str, str]] = {
    Partition: (
        "(2) partition",
        "s(δ(P)) + k/(k-1) d(δ(P)) - (k-2)/(k-1) e(δ(P)) ≥ k",
        "What joins the parts of P to one piece: k - 1 joints that are passed twice, or a circle of k.",
    ),
    Rank: (
        "(9) rank",
        "(s + d - e)(δ(P)) - Σ w ≥ k - 1",
        "The parts of P are joined by k - 1 joints at least.",
    ),
    Parity: (
        "(3) parity",
        "s(δ(T) \\ F) - s(F) ≥ 1 - |F|",
        "An even number of single passes comes to the nodes T, so not just the odd number F.",
    ),
    Group: (
        "(5) group",
        "ends(W) + 2 Σ (s + d) ≤ 2 |W|",
        "One stroke goes through linked contours W: it has two ends.",
    ),
    Bundle: (
        "(7) bundle",
        "s_ij - 2 e_ij ≤ s(T : not j) + s(i \\ T : j)",
        "Single passes between two places are even in number where their nodes have no other edges.",
    ),
    Triangle: (
        "(8) triangle",
        "t_ij ≤ w_ijk + R_i + R_j",
        "Where nodes of i and j have no other edges, a single pass between them belongs to a triangle with k.",
    ),
}

FAMILIES: dict[str, tuple[str, str, str]] = {
    "home": ("(1) home", "s(δ(home)) + 2 d(δ(home)) = 2", "The head leaves its home once and comes back."),
    "pierces": ("(4) pierces", "s(rapids) ≤ most - 1", "Each rapid between contours is a pierce more."),
}


def nodes_of(model: "LinkModel", places: frozenset[int] | tuple[int, ...]) -> tuple[int, ...]:
    """Return the nodes of some places."""
    return tuple(np.flatnonzero(np.isin(model.graph.place_of, list(places))).tolist())


def legs(model: "LinkModel") -> tuple[Leg, ...]:
    """Return the edges of the current point by nodes; what is passed twice has the value 2."""
    found = []
    point = model.point()
    for edge, value in zip(point.columns.edges(), point.x.tolist(), strict=True):
        for (_, tail, head), passes in model.value([edge])[1].items():
            found.append(Leg(tail, head, value * passes))
    return tuple(found)


def inequality(model: "LinkModel", row: Row) -> Inequality:
    """Return a cut in words, with its sides at the current point."""
    tag, symbols, words = WORDS[type(row.name)]
    left = float(coefficients(row.name, model.columns, model.graph.home) @ model.solution.x)
    return Inequality(tag, symbols, words, _sets(model, row), left, row.least)


def _sets(model: "LinkModel", row: Row) -> Named:
    """Return the sets of nodes that the symbols of a cut stand for."""
    cut = row.name
    if isinstance(cut, Partition | Rank):
        parts = (cut if isinstance(cut, Partition) else cut.partition).parts
        return tuple((f"P_{k}", nodes_of(model, part)) for k, part in enumerate(parts, start=1))
    if isinstance(cut, Parity):
        return (("T", tuple(sorted(cut.nodes))),)
    if isinstance(cut, Group):
        return (("W", nodes_of(model, cut.contours)),)
    if isinstance(cut, Bundle):
        return (("i", nodes_of(model, (cut.place,))), ("j", nodes_of(model, (cut.other,))))
    assert isinstance(cut, Triangle)
    named = zip("ijk", (*cut.pair, cut.third), strict=True)
    return tuple((name, nodes_of(model, (place,))) for name, place in named)


def decision(model: "LinkModel", fixing: Fixing) -> Decision:
    """Return a branching decision with its variable named; d joins two places, s two nodes."""
    kind, tail, head = model.edge(fixing.variable)
    ends = (tail, head)
    if kind == DOUBLE:
        (ends,) = ((p, q) for _, p, q in model.value([(kind, tail, head)])[1])
    return Decision("d" if kind == DOUBLE else "s", ends, None, fixing.lower, fixing.upper)


def tours(model: "LinkModel", solution: Multigraph) -> tuple[tuple[int, ...], ...]:
    """Return the ends of rapids, the home first: links do not make a tour by themselves."""
    home = model.graph.home_node
    ends = {node for kind, tail, head in solution if kind != 0 for node in (tail, head)} - {home}
    return ((home, *sorted(ends)),)
