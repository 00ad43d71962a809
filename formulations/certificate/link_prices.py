"""Sums of multipliers of rows about plans with links (see ``links``), by what they mean for edges."""

from dataclasses import dataclass, field
from itertools import combinations

from cutgap.formulations.certificate.link_costs import Edge, Triple


@dataclass
class Prices:
    """Sums of rows by what they mean for edges.

    ``odd`` and ``tree`` are about single edges, ``toward`` about those from a node to a place.
    """

    node: list[int]
    single: list[list[int]]
    double: list[list[int]]
    end: list[int]
    rapid: int = 0
    sets: list[tuple[frozenset[int], int]] = field(default_factory=list)
    odd: dict[Edge, int] = field(default_factory=dict)
    tree: dict[Edge, int] = field(default_factory=dict)
    toward: dict[tuple[int, int], int] = field(default_factory=dict)
    excess: dict[tuple[int, int], int] = field(default_factory=dict)
    partitions: list[tuple[int, list[int]]] = field(default_factory=list)
    triples: dict[Triple, int] = field(default_factory=dict)
    value: int = 0

    def add_home(self, price: int) -> None:
        home = len(self.end) - 1
        self.value += 2 * price
        for contour in range(home):
            self.single[contour][home] += price
            self.double[contour][home] += 2 * price

    def add_pierces(self, price: int, most: int) -> None:
        self.value += price * (1 - most)
        self.rapid -= price

    def add_partition(self, price: int, label: list[int], count: int) -> None:
        self.value += price * count * (count - 1)
        self.partitions.append((price * (count - 2), label))
        self._add_across(label, price * (count - 1), price * count)

    def add_rank(self, price: int, label: list[int], count: int, family: list[Triple]) -> None:
        self.value += price * (count - 1)
        self.partitions.append((price, label))
        self._add_across(label, price, price)
        for triple in family:
            if len({label[place] for place in triple}) > 1:
                self.triples[triple] = self.triples.get(triple, 0) + price

    def _add_across(self, label: list[int], by_single: int, by_double: int) -> None:
        """Add prices to what joins different parts."""
        for i, mine in enumerate(label):
            single, double = self.single[i], self.double[i]
            for j in range(i + 1, len(label)):
                if label[j] != mine:
                    single[j] += by_single
                    double[j] += by_double

    def add_triangle(self, price: int, places: Triple, triple: Triple, *sets: frozenset[int]) -> None:
        i, j, k = places
        self.triples[triple] = self.triples.get(triple, 0) - price
        pair = min(i, j), max(i, j)
        self.excess[pair] = self.excess.get(pair, 0) - 2 * price
        # All edges among the three count 1, but 2 - 1 of the pair and with a node of a set they are 2 less.
        for one, other in combinations(triple, 2):
            self.single[one][other] += price
        for inside, near in zip(sets, ((j, k), (i, k)), strict=True):
            for node in inside:
                self.node[node] += price
                for place in near:
                    self.toward[node, place] = self.toward.get((node, place), 0) + 2 * price

    def add_parity(self, price: int, inside: frozenset[int], odd: list[Edge]) -> None:
        self.value += price * (1 - len(odd))
        for node in inside:
            self.node[node] += price
        if len(inside) > 1:
            self.sets.append((inside, price))
        for edge in odd:
            self.odd[edge] = self.odd.get(edge, 0) + 2 * price

    def add_once(self, price: int, i: int, j: int) -> None:
        self.value -= price
        self.single[i][j] -= price
        self.excess[i, j] = self.excess.get((i, j), 0) - 2 * price

    def add_bundle(self, price: int, i: int, j: int, inside: frozenset[int]) -> None:
        pair = min(i, j), max(i, j)
        self.excess[pair] = self.excess.get(pair, 0) - 2 * price
        for node in inside:
            self.node[node] += price
            self.toward[node, j] = self.toward.get((node, j), 0) + 2 * price

    def add_group(self, price: int, members: list[int], edges: list[Edge]) -> None:
        self.value -= 2 * price * len(members)
        for contour in members:
            self.end[contour] -= price
            self.double[contour][-1] -= 2 * price
        for edge in edges:
            self.tree[edge] = self.tree.get(edge, 0) + 2 * price
