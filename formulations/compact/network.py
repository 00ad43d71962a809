"""Where a head may go: its legs, as plain numbers, and how they make up what the models speak of.

Sets      V        entry points, as nodes; C(u) the contour of u; home, where there is one
          X        rapids (u, v): C(u) != C(v), or one of them the home
          K        without a home, closing legs (u, v) from the last entry point u of a tour to the first, v:
                   u = v, or C(u) != C(v)
Left out  (1)      rapids between parts that are no neighbours, where neighbours only are asked for
          (2)      where clear rapids are asked for, rapids that cross the contour which they leave
          (3)      a single head without home, where no rule asks what comes first and there are two contours
                   or more: closing legs (u, v) other than C(v) = 0 and C(u) != 0, as the tour may begin there

A head's legs are one vector x, rapids before closing legs. Shorthands are matrices times it:

    y[i,j]   = sum of x over rapids from V(i) to V(j)
    y[-1,j]  = sum over rapids from the home to V(j), or over closing legs that end in V(j)
    y[i,-1]  = the same out of V(i)
    q[u]     = what enters u,   first[u] = what enters u from the depot
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array

from cutgap.instances import Instance, Plan, Rules, Visit
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.process import WORD, adjacent_parts, contours_in, crossings, part_of, rapid_costs

DEPOT = -1
"""The home in lists of contours, or what is before the first and after the last."""

Bools = npt.NDArray[np.bool_]


class Pairs:
    """The ordered pairs of different contours, then (depot, contour), then (contour, depot).

    Attributes
    ----------
    tails, heads
        Shape (pairs,): contours, or ``DEPOT``.
    """

    def __init__(self, contours: int) -> None:
        each = np.arange(contours)
        i, j = np.nonzero(each[:, None] != each)
        depot = np.full(contours, DEPOT)
        self.contours = contours
        self.tails = np.concatenate((i, depot, each)).astype(np.int64)
        self.heads = np.concatenate((j, each, depot)).astype(np.int64)
        self.inner = slice(0, len(i))
        self.begin = slice(len(i), len(i) + contours)
        self.end = slice(len(i) + contours, len(self.tails))
        self.index = {pair: at for at, pair in enumerate(self.names)}

    @property
    def names(self) -> list[tuple[int, int]]:
        """The pairs."""
        return list(zip(self.tails.tolist(), self.heads.tolist(), strict=True))

    @cached_property
    def into(self) -> csr_array:
        """Which pairs lead to each contour, shape (contours, pairs)."""
        return selection(self.heads, self.contours)

    @cached_property
    def out_of(self) -> csr_array:
        """Which pairs leave each contour, shape (contours, pairs)."""
        return selection(self.tails, self.contours)

    @cached_property
    def reversed(self) -> Ints:
        """The place of (j, i) for each pair (i, j)."""
        return np.array([self.index[j, i] for i, j in self.names], dtype=np.int64)


def selection(rows: Ints, count: int) -> csr_array:
    """Return the matrix with a one in column c of row ``rows[c]``, if that is one of 0 .. count - 1."""
    columns = np.flatnonzero((rows >= 0) & (rows < count))
    return csr_array((np.ones(len(columns)), (rows[columns], columns)), shape=(count, len(rows)))


@dataclass(frozen=True, eq=False)
class Network:
    """The legs of one head.

    Attributes
    ----------
    head
        Index of the head.
    tails, heads
        Shape (legs,): nodes.
    closing
        Shape (legs,): which legs close a tour without home.
    lengths, costs
        Shape (legs,), mm: l and d.
    """

    instance: Instance
    head: int
    pairs: Pairs
    tails: Ints
    heads: Ints
    closing: Bools
    lengths: Floats
    costs: Floats

    @cached_property
    def contour_of(self) -> Ints:
        """Contour of each node, ``DEPOT`` for homes."""
        return contours_of_nodes(self.instance)

    @cached_property
    def to_pairs(self) -> csr_array:
        """The matrix of y, shape (pairs, legs); a closing leg begins the tour and ends it."""
        tails, heads = self.contour_of[self.tails], self.contour_of[self.heads]
        index = self.pairs.index
        rows, columns = [], []
        for leg, (i, j, closes) in enumerate(zip(tails.tolist(), heads.tolist(), self.closing, strict=True)):
            at = [index[DEPOT, j], index[i, DEPOT]] if closes else [index[i, j]]
            rows += at
            columns += [leg] * len(at)
        return csr_array((np.ones(len(rows)), (rows, columns)), shape=(len(self.pairs.tails), len(self.tails)))

    @cached_property
    def into(self) -> csr_array:
        """The matrix of q, shape (entry points, legs)."""
        return selection(self.heads, int(self.instance.first_node[-1]))

    @cached_property
    def out_of(self) -> csr_array:
        """What leaves each entry point, shape (entry points, legs)."""
        return selection(self.tails, int(self.instance.first_node[-1]))

    @cached_property
    def from_depot(self) -> csr_array:
        """The matrix of first, shape (entry points, legs)."""
        begins = self.closing | (self.contour_of[self.tails] == DEPOT)
        return selection(np.where(begins, self.heads, -1), int(self.instance.first_node[-1]))

    def legs_of(self, tour: tuple[Visit, ...]) -> Floats | None:
        """Return x of a tour, ``None`` when it takes a leg that there is none of."""
        legs = zip(self.tails.tolist(), self.heads.tolist(), self.closing.tolist(), strict=True)
        place = {key: leg for leg, key in enumerate(legs)}
        nodes = [self.instance.node(*visit[:2]) for visit in tour]
        home = self.instance.home_node(self.head)
        keys = [(*pair, False) for pair in pairwise(nodes)]
        if nodes:
            closed = [(nodes[-1], nodes[0], True)]
            keys += closed if home is None else [(home, nodes[0], False), (nodes[-1], home, False)]
        x = np.zeros(len(self.tails))
        for key in keys:
            if key not in place:
                return None
            x[place[key]] = 1.0
        return x

    def tour_of(self, x: Floats) -> tuple[Visit, ...] | None:
        """Return the tour that the legs with x above 1/2 make, ``None`` when they make anything else."""
        chosen = np.flatnonzero(x > 0.5)
        home = self.instance.home_node(self.head)
        following: dict[int, int] = {}
        starts: list[int] = []
        for leg in chosen.tolist():
            tail, head = int(self.tails[leg]), int(self.heads[leg])
            if self.closing[leg] or tail == home:
                starts.append(head)
            if not self.closing[leg] and tail != home:
                if tail in following:
                    return None
                following[tail] = head
        tour: list[int] = starts[:1]
        while tour and following.get(tour[-1], home) != home and len(tour) <= len(following):
            tour.append(following[tour[-1]])
        visits = tuple(self._visit(node) for node in tour)
        again = self.legs_of(visits)
        return visits if again is not None and np.array_equal(np.flatnonzero(again), chosen) else None

    def _visit(self, node: int) -> Visit:
        contour = int(self.contour_of[node])
        return Visit(contour, node - int(self.instance.first_node[contour]))


def contours_of_nodes(instance: Instance) -> Ints:
    """Return the contour of each node, ``DEPOT`` for homes, shape (nodes,)."""
    of = np.full(instance.node_count, DEPOT, dtype=np.int64)
    of[: int(instance.first_node[-1])] = np.repeat(
        np.arange(len(instance.contours)), np.diff(instance.first_node)
    )
    return of


def plan_of(networks: tuple[Network, ...], points: list[Floats]) -> Plan | None:
    """Return the plan that the heads' vectors x make, ``None`` when a head's is no tour."""
    tours = [network.tour_of(x) for network, x in zip(networks, points, strict=True)]
    found = tuple(tour for tour in tours if tour is not None)
    return Plan(found) if len(found) == len(tours) else None


def networks_of(instance: Instance, rules: Rules) -> tuple[Network, ...]:
    """Return the legs of all heads."""
    pairs = Pairs(len(instance.contours))
    rapids = _rapids(instance, rules)
    return tuple(_network(instance, rules, head, pairs, rapids) for head in range(len(instance.heads)))


def _network(instance: Instance, rules: Rules, head: int, pairs: Pairs, rapids: tuple[Ints, Ints]) -> Network:
    tails, heads = rapids
    home = instance.home_node(head)
    points = np.arange(int(instance.first_node[-1]))
    if home is None:
        ends, starts = _closing_legs(instance, rules)
    else:
        homes = np.full(len(points), home)
        ends, starts = np.concatenate((homes, points)), np.concatenate((points, homes))
    closing = np.zeros(len(tails) + len(ends), dtype=np.bool_)
    closing[len(tails) :] = home is None
    tails, heads = np.concatenate((tails, ends)), np.concatenate((heads, starts))
    lengths = instance.rapids[tails, heads]
    costs = np.where(closing, lengths, rapid_costs(instance, rules)[tails, heads])
    return Network(instance, head, pairs, tails, heads, closing, lengths, costs)


def _rapids(instance: Instance, rules: Rules) -> tuple[Ints, Ints]:
    """Return the rapids between entry points, but for (1) and (2)."""
    of = contours_of_nodes(instance)[: int(instance.first_node[-1])]
    allowed = of[:, None] != of
    if rules.neighbours_only:
        part, adjacent = part_of(instance)[of], adjacent_parts(instance)
        allowed &= (part[:, None] == part) | adjacent[np.ix_(part, part)]
    if rules.clear_rapids:
        words = crossings(instance)[np.arange(len(of)), :, of // WORD]
        allowed &= words >> (of % WORD).astype(np.uint64)[:, None] & np.uint64(1) == 0
    tails, heads = np.nonzero(allowed)
    return tails.astype(np.int64), heads.astype(np.int64)


def _closing_legs(instance: Instance, rules: Rules) -> tuple[Ints, Ints]:
    """Return K, but for (3)."""
    of = contours_of_nodes(instance)[: int(instance.first_node[-1])]
    allowed = (of[:, None] != of) | np.eye(len(of), dtype=np.bool_)
    single = len(instance.heads) == 1 and len(instance.contours) >= 2
    ordered = rules.via_points or rules.process or instance.precedence or rules.speaks_of_heat
    if single and not ordered:
        allowed &= (of[:, None] != 0) & (of == 0)
    ends, starts = np.nonzero(allowed)
    return ends.astype(np.int64), starts.astype(np.int64)


class Crossed(NamedTuple):
    """Rapids between contours and what they cross: one entry for each rapid (u, v) and each such contour k.

    Attributes
    ----------
    names
        (u, v, k).
    legs, contours, tails
        Shape (names,): the leg, k and C(u).
    """

    names: list[tuple[int, int, int]]
    legs: Ints
    contours: Ints
    tails: Ints


def crossed(network: Network) -> Crossed:
    """Return what rapids cross, but for the contours at their ends: that of u by (2), and v's is cut later."""
    table, of = crossings(network.instance), network.contour_of
    names, legs = [], []
    for leg, (u, v) in enumerate(zip(network.tails.tolist(), network.heads.tolist(), strict=True)):
        if network.closing[leg] or DEPOT in (of[u], of[v]):
            continue
        met = [k for k in contours_in(table[u, v]) if k not in (of[u], of[v])]
        names += [(u, v, k) for k in met]
        legs += [leg] * len(met)
    u, _, k = np.transpose(np.array(names, dtype=np.int64).reshape(-1, 3))
    return Crossed(names, np.array(legs, dtype=np.int64), k, of[u])
