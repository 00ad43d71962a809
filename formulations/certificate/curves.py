r"""The curves of contours, exactly: what a rapid crosses, and which parts are neighbours.

    (1) The rapid from v to w crosses a contour when the segment from v + t (w - v) to w - t (w - v), t = 1e-6,
        meets the contour's closed polyline.
    (2) Which contours lie in which is for ``nests`` to say; curves for which it is in doubt are refused.
    (3) Parts A and B are neighbours when some rapid between their entry points crosses no contour of another
        part; parts with a contour in which a contour of A or B lies do not count as other parts.

Coordinates are integers, multiplied so that t (w - v) is one too. They are those of the nearest doubles, for
which the library decides (1) without rounding: a rapid that touches a corner in decimals may miss it there.
"""

from itertools import combinations, pairwise

from cutgap.formulations.certificate.nests import lies_in
from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.proof import Budget
from cutgap.formulations.certificate.reading import require
from cutgap.formulations.certificate.segments import Edge, box, meet

SHARE = 10**6
"""1 / t of (1)."""


class Curves:
    """The curves of a problem whose every contour has one."""

    def __init__(self, problem: Problem, budget: Budget) -> None:
        require(problem.located, "curves: the points carry no coordinates")
        self.problem, self.budget = problem, budget
        self.edges: list[list[Edge]] = []
        for name, curve in zip(problem.ids, problem.curves, strict=True):
            require(bool(curve), f"curves: contour {name} has no geometry")
            points = [(x * SHARE, y * SHARE) for x, y in curve]
            self.edges.append(list(pairwise([*points, points[0]])))
        self.boxes = [box([point for point, _ in edges]) for edges in self.edges]
        self.known: dict[tuple[int, int], int] = {}
        self.near: dict[tuple[int, int], bool] = {}
        self._own: list[int] = []

    def crossed(self, v: int, w: int) -> int:
        """Return the contours that the rapid crosses, as bits, by (1)."""
        key = min(v, w), max(v, w)
        if key not in self.known:
            self.known[key] = self._crossed(*key)
        return self.known[key]

    def _crossed(self, v: int, w: int) -> int:
        (a, b), (c, d) = self.problem.plane[v], self.problem.plane[w]
        step = c - a, d - b
        if step == (0, 0):
            return 0
        p, q = (SHARE * a + step[0], SHARE * b + step[1]), (SHARE * c - step[0], SHARE * d - step[1])
        low_x, low_y, high_x, high_y = box([p, q])
        found = 0
        self.budget.spend(10 + len(self.boxes))
        for contour, (left, below, right, above) in enumerate(self.boxes):
            if left <= high_x and low_x <= right and below <= high_y and low_y <= above:
                self.budget.spend(10 * len(self.edges[contour]))
                if any(meet(p, q, *edge) for edge in self.edges[contour]):
                    found |= 1 << contour
        return found

    def neighbours(self, a: int, b: int) -> bool:
        """Whether two parts are neighbours, by (3)."""
        key = min(a, b), max(a, b)
        if key not in self.near:
            others = ~(self.own(a) | self.own(b))
            nodes = [
                [
                    node
                    for contour, each in enumerate(self.problem.parts)
                    if each == part
                    for node in self.problem.entries[contour]
                ]
                for part in key
            ]
            self.near[key] = any(self.crossed(v, w) & others == 0 for v in nodes[0] for w in nodes[1])
        return self.near[key]

    def own(self, part: int) -> int:
        """Return the contours of a part and of the parts that one of its contours lies in, as bits."""
        if not self._own:
            self._own = self._all_own()
        return self._own[part]

    def _all_own(self) -> list[int]:
        parts = self.problem.parts
        around = [{part} for part in range(max(parts) + 1)]
        for one, other in combinations(range(len(parts)), 2):
            inner, outer = lies_in((one, other), self.edges[one], self.edges[other], self.budget)
            around[parts[one]] |= {parts[other]} if inner else set()
            around[parts[other]] |= {parts[one]} if outer else set()
        return [
            sum(1 << contour for contour, part in enumerate(parts) if part in members) for members in around
        ]
