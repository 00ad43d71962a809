r"""Linear relaxations that proofs speak of: integer variables with costs and bounds, and rows built on demand.

    (1) value(y) = sum_i y_i b_i + sum_j min(r_j l_j, r_j u_j),   r_j = K c_j - sum_i y_i a_ij

Weak duality: for every x with l <= x <= u that keeps rows a_i x >= b_i (y_i >= 0) and a_i x = b_i (any y_i), K
c x >= (1). So any integers y are safe; they only have to be good to prove much.

Most variables are edges x_uv of complete graphs, and most rows cuts x(delta(S)). The coefficient of an edge in
x(delta(S)) is [u in S] + [v in S] - 2 [both in S], so a row stores a number for each node, which counts for
every edge at it, and corrections of single variables. That keeps the rows of small sets short.

Sums of cuts that both relaxations use, for node sets of a Hamiltonian cycle C with edge set x:

    (2) cut   x(delta(S)) >= 2                       S neither empty nor everything
    (3) comb  x(delta(H)) + sum_i x(delta(T_i)) >= 3 k + 1,   k >= 3 odd, teeth T_1 .. T_k disjoint,
              each with a node in H and one outside H

(3) holds because |C in delta(T)| is 2 or at least 4. If it is 2, C within T is a path, which goes from H to
outside H somewhere: an edge of delta(H) inside T. With t teeth of the first kind the left side is at least
t + 2 t + 4 (k - t) = 4 k - t. For t < k this is at least 3 k + 1. For t = k, |C in delta(H)| >= k is even and k
is odd, so it is at least k + 1. Blossoms are combs whose teeth are single edges.
"""

from array import array
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

from cutgap.formulations.certificate.cosines import UNIT, Coefficients, cosine, vector
from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.reading import Refused, entries, require, show

MAX_VARIABLES = 2_500_000


@dataclass(frozen=True, slots=True)
class Row:
    """sum_j a_j x_j >= rhs, or = rhs; a_j = the numbers of the two ends of edge j + the corrections of j."""

    equality: bool
    rhs: int
    nodes: tuple[tuple[int, int], ...] = ()
    corrections: Iterable[tuple[int, Sequence[int]]] = ()

    @property
    def size(self) -> int:
        """Numbers that the row holds."""
        return len(self.nodes) + sum(len(variables) for _, variables in self.corrections)


@dataclass(slots=True)
class Bounds:
    """Bounds of all variables; 0 stands for the upper bound that a variable in ``endless`` has not."""

    lower: list[int]
    upper: list[int]


class Relaxation:
    """Variables with costs, times the multiplier scale K; subclasses build the rows.

    Attributes
    ----------
    ends
        The two nodes of each edge, for variables that are none twice the node ``nodes - 1``.
    endless
        The variables without upper bound; they are the ones that need not be whole, and are at least 0.
    """

    def __init__(self, nodes: int, multiplier_scale: int) -> None:
        self.nodes = nodes
        self.multiplier_scale = multiplier_scale
        self.costs: list[int] = []
        self.tails, self.heads = array("i"), array("i")
        self.start = Bounds([], [])
        self.endless: list[int] = []

    def add(self, cost: int, upper: int | None, tail: int | None = None, head: int | None = None) -> int:
        """Add a variable with lower bound 0 and return its number; tail and head for an edge."""
        number = len(self.costs)
        require(number < MAX_VARIABLES, f"a relaxation of more than {MAX_VARIABLES} variables")
        self.costs.append(self.multiplier_scale * cost)
        self.tails.append(self.nodes - 1 if tail is None else tail)
        self.heads.append(self.nodes - 1 if head is None else head)
        self.start.lower.append(0)
        self.start.upper.append(0 if upper is None else upper)
        if upper is None:
            self.endless.append(number)
        return number

    def variable(self, name: Any) -> int:
        """Return the number of a variable named as in a certificate, one that must be whole."""
        raise NotImplementedError

    def row(self, name: Any) -> Row:
        """Return the row named as in a certificate; refuses names of rows that need not hold."""
        raise NotImplementedError


def leaf_value(
    relaxation: Relaxation, bounds: Bounds, multipliers: Sequence[tuple[Row, int]]
) -> tuple[int, list[int]]:
    """Return (1), in units of cost / multiplier scale, and the reduced costs r.

    Raises
    ------
    Refused
        When the sign of a multiplier, or of a reduced cost with an infinite bound, makes (1) no bound.
    """
    potentials = [0] * relaxation.nodes
    value = 0
    for row, multiplier in multipliers:
        require(row.equality or multiplier >= 0, f"multiplier {show(multiplier)} of a row that is no equation")
        value += multiplier * row.rhs
        for node, coefficient in row.nodes:
            potentials[node] += multiplier * coefficient
    reduced = [
        cost - potentials[tail] - potentials[head]
        for cost, tail, head in zip(relaxation.costs, relaxation.tails, relaxation.heads, strict=True)
    ]
    for row, multiplier in multipliers:
        for coefficient, variables in row.corrections:
            change = multiplier * coefficient
            for variable in variables:
                reduced[variable] -= change
    for variable in relaxation.endless:
        require(reduced[variable] >= 0, "reduced cost below 0 of a variable without upper bound")
    for r, low, high in zip(reduced, bounds.lower, bounds.upper, strict=True):
        value += r * low if r >= 0 else r * high
    return value, reduced


class TourRelaxation(Relaxation):
    r"""One closed tour over nodes 0 .. n-1, n >= 4 (the head's home, if it has one, is node 0).

        min  sum l_uv x_uv   over x in {0, 1}
        degree  (4) x(delta(v)) = 2                 each v
        cut     (2), (3)
        connectivity  (6) sum (f_u - f_v)^2 x_uv >= beta (|f|^2 - (sum f)^2 / n)     each integers f
        via     (5) sum over leftmost v of x_0v >= 1     the first contour is a leftmost one; needs a home

    (6), beta = 2 - 2 cos(2 pi / n): the left side is f' L f for the cycle's Laplacian matrix L, whose least
    eigenvalue is 0, with the constant vectors, and whose next one is beta; so f may be replaced by what it
    differs from its mean, the square of which is the bracket. It is whole, so the right side is rounded up.

    Source: Dantzig, Fulkerson, Johnson (1954); Edmonds (1965) and Chvatal (1973) for (3); Cvetkovic,
    Cangalovic, Kovacevic-Vujcic (1999) for (6).
    """

    def __init__(
        self, problem: Problem, nodes: list[int], leftmost: list[int], scale: int, multiplier_scale: int
    ) -> None:
        super().__init__(len(nodes) + 1, multiplier_scale)
        self.count, self.leftmost = len(nodes), leftmost
        require(self.count >= 4, "up to 3 nodes need no rows: leave the proof out")
        require(self.count**2 <= 2 * MAX_VARIABLES, f"{self.count} nodes are too many for rows: use one_tree")
        for tail in range(self.count):
            for head, cost in enumerate(problem.lengths(nodes[tail], nodes[tail + 1 :], scale), tail + 1):
                self.add(cost, 1, tail, head)

    def edge(self, u: int, v: int) -> int:
        """Return the variable of the edge between two nodes."""
        u, v = min(u, v), max(u, v)
        return u * self.count - u * (u + 1) // 2 + v - u - 1

    def variable(self, name: Any) -> int:
        match name:
            case ["x", int(u), int(v)] if 0 <= u < v < self.count:
                return self.edge(u, v)
        raise Refused(f"no variable {show(name)}")

    def row(self, name: Any) -> Row:
        match name:
            case ["degree", int(v)] if 0 <= v < self.count:
                return Row(True, 2, ((v, 1),))
            case ["cut", list(sets)]:
                members, rhs = cut_sets(sets, self.count)
                require(len(members) > 1 or len(members[0]) < self.count, "cut: the set is everything")
                # A set and its complement have one cut.
                short = [s if 2 * len(s) <= self.count else self._complement(s) for s in members]
                return Row(False, rhs, *cuts(short, lambda v: v, self.edge))
            case ["connectivity", list(numbers)]:
                return self._connectivity(vector(numbers, self.count))
            case ["via"] if self.leftmost:
                return Row(False, 1, (), ((1, [self.edge(0, v) for v in self.leftmost]),))
        raise Refused(f"no row {show(name)}")

    def _connectivity(self, f: list[int]) -> Row:
        squares = [each * each for each in f]
        # n |f|^2 - (sum f)^2 is at least 0, so a beta from below makes the right side smaller.
        spread = self.count * sum(squares) - sum(f) ** 2
        beta = 2 * (UNIT - cosine(1, self.count)[1])

        def products() -> Iterator[tuple[int, Sequence[int]]]:
            for edge, (u, v) in enumerate(zip(self.tails, self.heads, strict=True)):
                yield -2 * f[u] * f[v], (edge,)

        least = -(-beta * spread // (self.count * UNIT))
        return Row(False, least, tuple(enumerate(squares)), Coefficients(products))

    def _complement(self, members: list[int]) -> list[int]:
        inside = set(members)
        return [v for v in range(self.count) if v not in inside]


def cut_sets(sets: Any, count: int) -> tuple[list[list[int]], int]:
    """Return the sets of (2) or (3), over nodes 0 .. count-1, and the right side."""
    members = [entries(each, "set") for each in entries(sets, "sets")]
    for each in members:
        known = all(type(v) is int and 0 <= v < count for v in each)
        require(
            known and each != [] and len(set(each)) == len(each), f"set: expected different nodes below {count}"
        )
    teeth = len(members) - 1
    if teeth == 0:
        return members, 2
    require(teeth >= 3 and teeth % 2 == 1, f"comb with {teeth} teeth: expected an odd number from 3 on")
    handle, seen = set(members[0]), set[int]()
    for tooth in map(set, members[1:]):
        require(
            bool(tooth & handle) and bool(tooth - handle), "comb: a tooth must meet the handle and leave it"
        )
        require(not tooth & seen, "comb: the teeth overlap")
        seen |= tooth
    return members, 3 * teeth + 1


Numbers = tuple[tuple[int, int], ...]
Corrections = tuple[tuple[int, Sequence[int]], ...]


def cuts(
    sets: list[list[int]], node: Callable[[int], int], edge: Callable[[int, int], int]
) -> tuple[Numbers, Corrections]:
    """Return the coefficients of the sum of x(delta(S)) over the sets."""
    numbers = tuple((node(v), 1) for members in sets for v in members)
    inside = (array("i", (edge(u, v) for u, v in combinations(members, 2))) for members in sets)
    return numbers, tuple((-2, variables) for variables in inside)
