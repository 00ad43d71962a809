r"""The relaxation of tours through one entry point of each contour (one head); its rows and why each holds.

Contours C_h are those of the problem, then the home, if there is one, as a contour of its own: m >= 2 in all.

    y_v    the tour passes node v                                          {0, 1}
    x_uv   how often it goes between u and v, of different contours        {0, 1}, for m = 2 {0, 1, 2}
    x(delta(S)) = 2 y(S) - 2 x(E(S)) by (2), where x(E(S)) counts edges within S

    min  sum l_uv x_uv
    contour (1) y(C_h) = 1
    degree  (2) x(delta(v)) = 2 y_v
    border  (3) x(delta(S)) >= 2 (a + b - 1),   a = y(S & C_h),  b = y(C_k \ S)
    comb    (4) x(delta(H)) + sum_i x(delta(T_i)) >= 3 t + 1 - 2 sum_i (2 - a_i - b_i),   t >= 3 odd, teeth T_i
                disjoint,  a_i = y(T_i & H & C_hi),  b_i = y((T_i \ H) & C_ki)

h or k may be null where the part holds a whole contour: then a or b is 1. Rows (3) and (4) stand divided by 2.

(3): if a + b > 1 the tour has a node in S and one outside, so it crosses the border twice. (4): call a tooth
good if the tour passes T_i & H and T_i \ H, half if it passes one of them, else bad; let g + p + q = t count
them. As a_i + b_i is at most 2, 1, 0 for these, it is enough that the left side is at least 3 g + p - q + 1.

- g = 0. With p >= 2 the tour leaves each half tooth: the left side is at least 2 p = p + t - q >= p - q + 1.
  With p <= 1 the right side, p - q + 1 = 2 p - t + 1, is at most 0.
- g = 1, p = 0. The tour passes H and its outside: the left side is at least 2 >= 5 - t.
- Else the tour leaves each good and each half tooth. A good tooth that it crosses twice only holds one path of
  it, with an edge from H to outside H in the tooth. With s of these the left side is at least
  s + 2 s + 4 (g - s) + 2 p = 4 g - s + 2 p. For s < g that is at least 3 g + 1 + 2 p. For s = g it is
  3 g + 2 p, and one more if g is odd, as the tour crosses H an even number of times. If g is even, p + q is
  odd, so at least 1.
"""

from array import array
from collections.abc import Sequence
from itertools import chain, combinations
from math import gcd
from typing import Any

from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.reading import Refused, entries, integer, require, show
from cutgap.formulations.certificate.relaxation import MAX_VARIABLES, Relaxation, Row, cut_sets

Terms = list[tuple[int, Sequence[int]]]


class GeneralizedRelaxation(Relaxation):
    """The relaxation above; variables are all y, then x of all pairs of nodes (0 within a contour).

    Attributes
    ----------
    step
        A whole number that divides every length, at least 1.
    """

    def __init__(self, problem: Problem, scale: int, multiplier_scale: int) -> None:
        homes = [range(home, home + 1) for home in problem.homes if home is not None]
        self.contours = [*problem.entries, *homes]
        self.count = sum(map(len, self.contours))
        require(len(problem.homes) == 1, "gtsp: needs one head")
        require(len(self.contours) >= 2, "gtsp: a single place needs no rows: leave the proof out")
        require(self.count**2 <= MAX_VARIABLES, f"gtsp: {self.count} nodes are too many")
        super().__init__(self.count + 1, multiplier_scale)
        self.contour_of = [h for h, nodes in enumerate(self.contours) for _ in nodes]
        most, self.step = 1 if len(self.contours) > 2 else 2, 0
        for _ in range(self.count):
            self.add(0, 1)
        for tail in range(self.count):
            heads = list(range(tail + 1, self.count))
            for head, cost in zip(heads, problem.lengths(tail, heads, scale), strict=True):
                within = self.contour_of[tail] == self.contour_of[head]
                self.add(0 if within else cost, 0 if within else most, tail, head)
                self.step = self.step if within else gcd(self.step, cost)
        self.step = self.step or 1

    def edge(self, u: int, v: int) -> int:
        """Return the variable of the edge between two nodes."""
        u, v = min(u, v), max(u, v)
        return self.count + u * self.count - u * (u + 1) // 2 + v - u - 1

    def variable(self, name: Any) -> int:
        match name:
            case ["y", int(v)] if 0 <= v < self.count:
                return v
            case ["x", int(u), int(v)] if 0 <= u < v < self.count:
                return self.edge(u, v)
        raise Refused(f"no variable {show(name)}")

    def row(self, name: Any) -> Row:
        match name:
            case ["contour", int(h)] if 0 <= h < len(self.contours):
                return Row(True, 1, (), ((1, self.contours[h]),))
            case ["degree", int(v)] if 0 <= v < self.count:
                return Row(True, 0, ((v, 1),), ((-2, [v]),))
            case ["border", list(members), h, k]:
                sets, _ = cut_sets([members], self.count)
                inside = set(sets[0])
                outside = set(range(self.count)) - inside
                return self._row(sets, -1, [(inside, h), (outside, k)])
            case ["comb", [_, _, *_] as given, list(pairs)]:
                sets, _ = cut_sets(given, self.count)
                teeth = len(sets) - 1
                handle, parts = set(sets[0]), []
                for tooth, pair in zip(sets[1:], entries(pairs, "pairs", count=teeth), strict=True):
                    h, k = entries(pair, "pair", count=2)
                    parts += [(set(tooth) & handle, h), (set(tooth) - handle, k)]
                return self._row(sets, (1 - teeth) // 2, parts)
        raise Refused(f"no row {show(name)}")

    def _row(self, sets: list[list[int]], rhs: int, parts: list[tuple[set[int], Any]]) -> Row:
        """Return sum over sets of y(S) - x(E(S)) - sum of the parts' terms >= rhs."""
        terms: Terms = [(1, members) for members in sets]
        for part, contour in parts:
            if contour is None:
                whole = any(part.issuperset(nodes) for nodes in self.contours)
                require(whole, "null: no whole contour lies in this part")
                rhs += 1
            else:
                known = integer(contour, "contour", least=0) < len(self.contours)
                require(known, f"there is no contour {show(contour)}")
                terms.append((-1, sorted(part.intersection(self.contours[contour]))))
        inner = chain.from_iterable(combinations(members, 2) for members in sets)
        terms.append((-1, array("i", (self.edge(u, v) for u, v in inner))))
        return Row(False, rhs, (), tuple(terms))
