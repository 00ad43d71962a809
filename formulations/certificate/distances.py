r"""A relaxation of one closed tour that tells how far apart its nodes are, counted in steps along the tour.

    n >= 4 nodes, d = floor(n / 2); x^k_uv in {0, 1}: u and v are k steps apart, k = 1..d, u < v

        min  sum l_uv x^1_uv
    (1) pair    sum_k x^k_uv = 1                        each u < v
    (2) degree  sum_u x^k_uv = 2, or 1 for k = n / 2     each k, v
    (3) via     sum over leftmost v of x^1_0v >= 1       the first contour is a leftmost one; needs a home
    (4) cosine  sum_{u < v} 2 f_u f_v sum_k cos(2 pi i k / n) x^k_uv >= -sum_v f_v^2     each i and integers f

(4): let node v be the p_v-th of the tour, and t_v = 2 pi i p_v / n. The cosine that x chooses for u and v is
cos(t_u - t_v), so the left side less the right one is (sum_v f_v cos t_v)^2 + (sum_v f_v sin t_v)^2 >= 0. The
coefficients are rounded up to integers, which is right for x >= 0.

Source: de Klerk, Pasechnik, Sotirov (2008): (4) for all f is their matrix inequality.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any

from cutgap.formulations.certificate.cosines import UNIT, Coefficients, cosine, vector
from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.reading import Refused, require, show
from cutgap.formulations.certificate.relaxation import Relaxation, Row

MAX_NODES = 64


class DistancesRelaxation(Relaxation):
    """The relaxation above; see ``relaxation``."""

    def __init__(
        self, problem: Problem, nodes: list[int], leftmost: list[int], scale: int, multiplier_scale: int
    ) -> None:
        super().__init__(1, multiplier_scale)
        self.count, self.leftmost, self.most = len(nodes), leftmost, len(nodes) // 2
        require(self.count >= 4, "up to 3 nodes need no rows: leave the proof out")
        require(self.count <= MAX_NODES, f"distances: {self.count} nodes, the most is {MAX_NODES}")
        self.pairs = list(combinations(range(self.count), 2))
        self.place = {pair: number for number, pair in enumerate(self.pairs)}
        for steps in range(1, self.most + 1):
            for tail in range(self.count):
                lengths = problem.lengths(nodes[tail], nodes[tail + 1 :], scale)
                for length in lengths:
                    self.add(length if steps == 1 else 0, 1)

    def at(self, steps: int, u: int, v: int) -> int:
        """Return the number of x^steps_uv."""
        return (steps - 1) * len(self.pairs) + self.place[min(u, v), max(u, v)]

    def variable(self, name: Any) -> int:
        match name:
            case ["x", int(steps), int(u), int(v)] if 1 <= steps <= self.most and 0 <= u < v < self.count:
                return self.at(steps, u, v)
        raise Refused(f"no variable {show(name)}")

    def row(self, name: Any) -> Row:
        steps = range(1, self.most + 1)
        match name:
            case ["pair", int(u), int(v)] if 0 <= u < v < self.count:
                return Row(True, 1, (), ((1, [self.at(k, u, v) for k in steps]),))
            case ["degree", int(k), int(v)] if 1 <= k <= self.most and 0 <= v < self.count:
                others = [self.at(k, u, v) for u in range(self.count) if u != v]
                return Row(True, 1 if 2 * k == self.count else 2, (), ((1, others),))
            case ["via"] if self.leftmost:
                return Row(False, 1, (), ((1, [self.at(1, 0, v) for v in self.leftmost]),))
            case ["cosine", int(i), list(numbers)] if 1 <= i <= self.most:
                f = vector(numbers, self.count)
                return Row(
                    False, -sum(each * each for each in f), (), Coefficients(lambda: self._cosines(i, f))
                )
        raise Refused(f"no row {show(name)}")

    def _cosines(self, i: int, f: list[int]) -> Iterator[tuple[int, Sequence[int]]]:
        """Yield the coefficients of (4), rounded up."""
        number = 0
        for k in range(1, self.most + 1):
            low, high = cosine(i * k, self.count)
            for u, v in self.pairs:
                product = 2 * f[u] * f[v]
                yield -(-product * (high if product > 0 else low) // UNIT), (number,)
                number += 1
