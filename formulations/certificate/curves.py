r"""The curves of contours, exactly: what a rapid crosses, and which parts are neighbours.

    (1) The rapid from v to w crosses a contour when the segment from v + t (w - v) to w - t (w - v), t = 1e-6,
        meets the contour's closed polyline.
    (2) Contour c lies in contour d when d has the larger area (of equal ones, when d comes first) and some
        corner or middle of an edge of c that is not on d is inside of d; all lie on d only when both are equal.
    (3) Parts A and B are neighbours when some rapid between their entry points crosses no contour of another
        part; parts with a contour in which a contour of A or B lies do not count as other parts.

Coordinates are integers, multiplied so that t (w - v) is one too.
"""

from collections.abc import Iterable
from fractions import Fraction
from itertools import pairwise

from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.proof import Budget
from cutgap.formulations.certificate.reading import require

SHARE = 10**6
"""1 / t of (1)."""

Point = tuple[int, int]
Edge = tuple[Point, Point]
Place = tuple[int | Fraction, int | Fraction]


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
        self.boxes = [_box([point for point, _ in edges]) for edges in self.edges]
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
        low_x, low_y, high_x, high_y = _box([p, q])
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
        for inner in range(len(parts)):
            around[parts[inner]] |= {parts[outer] for outer in range(len(parts)) if self._lies_in(inner, outer)}
        return [
            sum(1 << contour for contour, part in enumerate(parts) if part in members) for members in around
        ]

    def _lies_in(self, inner: int, outer: int) -> bool:
        sizes = [abs(_doubled_area(self.edges[each])) for each in (inner, outer)]
        if inner == outer or (sizes[1], -outer) <= (sizes[0], -inner):
            return False
        self.budget.spend(20 * len(self.edges[inner]) * len(self.edges[outer]))
        for p, q in self.edges[inner]:
            for point in (p, ((p[0] + q[0]) // 2, (p[1] + q[1]) // 2)):
                if not any(_turn(*edge, point) == 0 and _between(*edge, point) for edge in self.edges[outer]):
                    return inside(point, self.edges[outer])
        return True


def meet(p: Point, q: Point, a: Point, b: Point) -> bool:
    """Whether the closed segments p q and a b have a point in common."""
    one, two = _turn(p, q, a), _turn(p, q, b)
    if one * two > 0:
        return False
    three, four = _turn(a, b, p), _turn(a, b, q)
    if three * four > 0:
        return False
    if one or two or three or four:
        return True
    return _between(p, q, a) or _between(p, q, b) or _between(a, b, p)


def _turn(a: Point, b: Point, c: Point) -> int:
    """Return 1, 0, -1 for a turn to the left, none, to the right."""
    area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return (area > 0) - (area < 0)


def _between(a: Point, b: Point, c: Point) -> bool:
    """Whether c, on the line through a and b, lies in their box."""
    return min(a[0], b[0]) <= c[0] <= max(a[0], b[0]) and min(a[1], b[1]) <= c[1] <= max(a[1], b[1])


def inside(point: Place, edges: Iterable[tuple[Place, Place]]) -> bool:
    """Whether a ray to the right leaves the curve an odd number of times; the point is not on it."""
    x, y = point
    odd = False
    for (ax, ay), (bx, by) in edges:
        if (ay > y) != (by > y):
            # The edge meets the ray when the point is on the left of it, seen upwards.
            left = (bx - ax) * (y - ay) - (by - ay) * (x - ax)
            odd ^= (left > 0) == (by > ay)
    return odd


def _doubled_area(edges: list[Edge]) -> int:
    return sum(a[0] * b[1] - a[1] * b[0] for a, b in edges)


def _box(points: list[Point]) -> tuple[int, int, int, int]:
    xs, ys = [x for x, _ in points], [y for _, y in points]
    return min(xs), min(ys), max(xs), max(ys)
