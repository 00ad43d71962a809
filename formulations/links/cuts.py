r"""Rows of the model of links, by what names them; proofs are in ``docs/certificates.md``.

    s_e    link or rapid e is passed once          d_ij   contours i, j (or i and the home) are joined twice
    s_ij   sum of s_e between places i and j       e_ij   half of s_ij, rounded down
    t_ij   s_ij - 2 e_ij, 0 or 1                   w_ijk  t_ij t_jk t_ik
    W      a set of contours; T a tree of links that joins them; ends(W) rapid ends at contours of W

    (1) home       s(delta(home)) + 2 d(delta(home)) = 2
    (2) partition  s(delta(P)) + k / (k - 1) d(delta(P)) - (k - 2) / (k - 1) e(delta(P)) >= k
                                                                    P parts the places into k >= 2 sets
    (3) parity     s(delta(T) \ F) - s(F) >= 1 - |F|                T a set of nodes, F odd, within delta(T)
    (4) pierces    sum of s over rapids between contours <= most pierces - 1
    (5) group      ends(W) + 2 sum of (s_e + d_e) over e in T <= 2 |W|
    (6) once       s_ij - 2 e_ij <= 1
    (7) bundle     s_ij - 2 e_ij <= s(T : not j) + s(i \ T : j)     T a set of nodes of place i
    (8) triangle   t_ij <= w_ijk + R_i + R_j,  R_i = s(T : not j, k) + s(i \ T : j, k)    T a set of nodes of i
    (9) rank       (s + d - e)(delta(P)) - sum of w over triples of F that P parts >= k - 1
                                                                    no two triples of F share two places

(2) with k = 2 says that each set of contours is left twice; for all k it says that a tree of d alone needs
k - 1 of them and a circle of s alone k. It is stronger than either (d counts double, a tree has k - 1 edges).
(3) says that each node set is passed an even number of times. (5) says that a group has two rapid ends: the
used links of a tree make |W| - (their number) groups. By (7) the single edges between two places are even
in number where their nodes at place i have no other edges; in (2) two of them count as one joint. By (8) three
places that are joined in a triangle of nodes without other edges make w = 1; in (9) such a triangle counts as
two joints.
"""

from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np

from cutgap.formulations.branch_and_cut.model import Row
from cutgap.instances.arrays import Floats, Ints

LINK, RAPID, DOUBLE, EXCESS, TRIPLE = 0, 1, 2, 3, 4
"""Kinds of variables: s of links, s of rapids, d, e, w."""

Pair = tuple[int, int]
Edge = tuple[int, int, int]
"""Kind, and its ends: nodes, or places for ``DOUBLE`` and ``EXCESS``, in ascending order.

w_ijk has the ends i and j * places + k, so that no end of it is a place of another kind."""

HOME = ("home",)
PIERCES = ("pierces",)


@dataclass(frozen=True, slots=True)
class Columns:
    """Variables by kind and ends; ``places`` and ``others`` are the places of the ends."""

    kinds: Ints
    tails: Ints
    heads: Ints
    places: Ints
    others: Ints

    @classmethod
    def of(cls, edges: list[Edge], place_of: Ints) -> "Columns":
        """Build the columns of some edges."""
        kinds, tails, heads = np.array(edges, dtype=np.int64).reshape(-1, 3).T
        double = kinds >= DOUBLE
        sides = (np.where(double, end, place_of[np.where(double, 0, end)]) for end in (tails, heads))
        return cls(kinds, tails, heads, *sides)

    def edges(self) -> list[Edge]:
        """Return kind and ends of each."""
        return list(zip(self.kinds.tolist(), self.tails.tolist(), self.heads.tolist(), strict=True))

    def __add__(self, other: "Columns") -> "Columns":
        pairs = ((getattr(self, name), getattr(other, name)) for name in self.__slots__)
        return Columns(*(np.concatenate(pair) for pair in pairs))

    def __len__(self) -> int:
        return len(self.kinds)


@dataclass(frozen=True, slots=True)
class Partition:
    """(2) for parts of contours; all other places, the home among them, are the last part."""

    parts: tuple[frozenset[int], ...]

    @property
    def count(self) -> int:
        """The number k of parts."""
        return len(self.parts) + 1

    @property
    def row(self) -> Row:
        """The row without its coefficients."""
        return Row(self, float(self.count))

    def labels(self, places: int) -> Ints:
        """Return the part of each place."""
        label = np.full(places, len(self.parts), dtype=np.int64)
        for number, part in enumerate(self.parts):
            label[list(part)] = number
        return label

    def coefficients(self, columns: Columns, places: int) -> Floats:
        """Return the coefficients of columns, among so many places."""
        rest = self.count - 1
        shares = np.array([1.0, 1.0, self.count / rest, (1 - rest) / rest, 0.0])
        return np.where(_across(self.labels(places), columns), shares[columns.kinds], 0.0)


def _across(label: Ints, columns: Columns) -> Ints:
    """Return which columns join different parts, but for w."""
    pairs = columns.kinds != TRIPLE
    return pairs & (label[columns.places] != label[np.where(pairs, columns.others, 0)])


Triple = tuple[int, int, int]


@dataclass(frozen=True, slots=True)
class Rank:
    """(9) for a partition and triples of places."""

    partition: Partition
    triples: frozenset[Triple]

    @property
    def row(self) -> Row:
        """The row without its coefficients."""
        return Row(self, self.partition.count - 1.0)

    def coefficients(self, columns: Columns, places: int) -> Floats:
        """Return the coefficients of columns, among so many places."""
        shares = np.array([1.0, 1.0, 1.0, -1.0, 0.0])
        label = self.partition.labels(places)
        values = np.where(_across(label, columns), shares[columns.kinds], 0.0)
        for i, j, k in self.triples:
            if len({label[i], label[j], label[k]}) > 1:
                same = (columns.kinds == TRIPLE) & (columns.tails == i) & (columns.heads == j * places + k)
                values[same] = -1.0
        return values


@dataclass(frozen=True, slots=True)
class Triangle:
    """(8) for two places and a third one, with sets of nodes of the two."""

    pair: Pair
    third: int
    nodes: tuple[frozenset[int], frozenset[int]]

    @property
    def triple(self) -> Triple:
        """The three places, ascending."""
        i, j, k = sorted((*self.pair, self.third))
        return i, j, k

    @property
    def row(self) -> Row:
        """The row without its coefficients."""
        return Row(self, 0.0)

    def coefficients(self, columns: Columns, places: int) -> Floats:
        """Return the coefficients of columns, among so many places."""
        i, j, k = self.triple
        values = np.where(
            (columns.kinds == TRIPLE) & (columns.tails == i) & (columns.heads == j * places + k), 1.0, 0.0
        )
        own = (columns.places == self.pair[0]) & (columns.others == self.pair[1])
        values[own & (columns.kinds == EXCESS)] = 2.0
        single = columns.kinds < DOUBLE
        both = np.isin(columns.places, self.triple) & np.isin(columns.others, self.triple)
        values[single & both] = 1.0
        for nodes in self.nodes:
            for ends in (columns.tails, columns.heads):
                inside = single & np.isin(ends, list(nodes))
                values[inside] += np.where(both[inside], -1.0, 1.0)
        return values


@dataclass(frozen=True, slots=True)
class Parity:
    """(3) for a set of nodes and an odd set of edges between it and the rest."""

    nodes: frozenset[int]
    odd: frozenset[Edge]

    @property
    def row(self) -> Row:
        """The row without its coefficients."""
        return Row(self, 1.0 - len(self.odd))

    def coefficients(self, columns: Columns) -> Floats:
        """Return the coefficients of columns."""
        inside = np.isin(columns.tails, list(self.nodes)) != np.isin(columns.heads, list(self.nodes))
        values = np.where(inside & (columns.kinds < DOUBLE), 1.0, 0.0)
        for kind, tail, head in self.odd:
            values[(columns.kinds == kind) & (columns.tails == tail) & (columns.heads == head)] = -1.0
        return values


@dataclass(frozen=True, slots=True)
class Group:
    """(5) for contours and a tree of links that joins them; ``joints`` are the contours that these join."""

    contours: frozenset[int]
    tree: frozenset[Pair] = frozenset()
    joints: frozenset[Pair] = frozenset()

    @property
    def row(self) -> Row:
        """The row without its coefficients."""
        return Row(self, -2.0 * len(self.contours))

    def coefficients(self, columns: Columns, home: int) -> Floats:
        """Return the coefficients of columns; ``home`` is the home's place."""
        members = list(self.contours)
        ends = np.isin(columns.places, members).astype(np.float64) + np.isin(columns.others, members)
        values = np.where(columns.kinds == RAPID, -ends, 0.0)
        values[(columns.kinds == DOUBLE) & (columns.others == home)] = (
            -2.0 * ends[(columns.kinds == DOUBLE) & (columns.others == home)]
        )
        for kind, pairs in ((LINK, self.tree), (DOUBLE, self.joints)):
            for tail, head in pairs:
                values[(columns.kinds == kind) & (columns.tails == tail) & (columns.heads == head)] = -2.0
        return values


@dataclass(frozen=True, slots=True)
class Bundle:
    """(7) for two places and nodes of the first, or (6) without nodes."""

    place: int
    other: int
    nodes: frozenset[int] | None

    @property
    def excess(self) -> Edge:
        """The variable e of the two places."""
        return EXCESS, min(self.place, self.other), max(self.place, self.other)

    @property
    def row(self) -> Row:
        """The row without its coefficients."""
        return Row(self, -1.0 if self.nodes is None else 0.0)

    def coefficients(self, columns: Columns) -> Floats:
        """Return the coefficients of columns."""
        _, low, high = self.excess
        same = (columns.places == low) & (columns.others == high)
        values = np.where(same & (columns.kinds == EXCESS), 2.0, 0.0)
        single = columns.kinds < DOUBLE
        if self.nodes is None:
            return np.where(single & same, -1.0, values)
        members = list(self.nodes)
        inside = single & (np.isin(columns.tails, members) | np.isin(columns.heads, members))
        return np.where(inside, np.where(same, -1.0, 1.0), values)


Cut = Partition | Rank | Triangle | Parity | Group | Bundle


def coefficients(name: Hashable, columns: Columns, home: int) -> Floats:
    """Return the coefficients of columns in a row; ``home`` is the home's place."""
    if isinstance(name, Partition | Rank | Triangle):
        return name.coefficients(columns, home + 1)
    if isinstance(name, Parity | Bundle):
        return name.coefficients(columns)
    if isinstance(name, Group):
        return name.coefficients(columns, home)
    at_home = columns.others == home
    if name == HOME:
        return np.where(at_home, np.array([1.0, 1.0, 2.0, 0.0, 0.0])[columns.kinds], 0.0)
    return np.where((columns.kinds == RAPID) & ~at_home, -1.0, 0.0)
