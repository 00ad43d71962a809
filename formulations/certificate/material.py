"""What lies within parts: whether a link surely leads through material, or surely does not.

Curves inside one another bound parts, holes, parts in holes: what an odd number of curves has around it is
material. A link is blocked when some point of it is in material, farther from every curve than ``DEPTH`` times
the largest extent of all curves. As the library decides this in floats, a proof has to show twice that depth.
"""

from fractions import Fraction
from itertools import pairwise

from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.reading import require, show
from cutgap.formulations.certificate.segments import inside

DEPTH = Fraction(1, 10**7)
"""How deep a link may run in a part, relative to the largest extent of all curves."""

HALVINGS = 12
"""How often a piece of a link is divided to show that all of it is near a curve."""

Place = tuple[Fraction, Fraction]
Edge = tuple[Place, Place]


class Material:
    """The curves of a problem whose every contour has one, in the units of ``Problem.plane``."""

    def __init__(self, problem: Problem) -> None:
        self.places: list[Place] = [(Fraction(x), Fraction(y)) for x, y in problem.plane]
        self.edges: list[list[Edge]] = []
        for name, curve in zip(problem.ids, problem.curves, strict=True):
            require(bool(curve), f"links: contour {show(name)} has no geometry")
            points = [(Fraction(x), Fraction(y)) for x, y in curve]
            self.edges.append(list(pairwise([*points, points[0]])))
        self.boxes = [_box([point for point, _ in edges]) for edges in self.edges]
        left, below, right, above = (list(side) for side in zip(*self.boxes, strict=True))
        self.depth = DEPTH * max(max(right) - min(left), max(above) - min(below))

    def is_blocked(self, tail: int, head: int, share: Fraction) -> bool:
        """Whether the point at a share of the way from one node to another is surely inside a part."""
        point = _along(self.places[tail], self.places[head], share)
        margin = 2 * self.depth
        odd = False
        for edges in self._near(point, point, margin):
            if any(square_to_edge(point, edge) <= margin * margin for edge in edges):
                return False
            odd ^= inside(point, edges)
        return odd

    def is_clear(self, tail: int, head: int) -> bool:
        """Whether each piece of a link between curves is surely outside of parts, or near one edge."""
        a, b = self.places[tail], self.places[head]
        if a == b:
            return True
        near = self._near(a, b, self.depth)
        meetings = {share for edges in near for edge in edges for share in _meetings(a, b, edge)}
        marks = sorted({Fraction(0), Fraction(1), *meetings})
        return all(self._is_clear(a, b, piece, near, HALVINGS) for piece in pairwise(marks))

    def _is_clear(
        self, a: Place, b: Place, piece: tuple[Fraction, Fraction], near: list[list[Edge]], halvings: int
    ) -> bool:
        """Whether a piece of the link from a to b that crosses no curve is outside of parts or near edges."""
        low, high = piece
        middle = (low + high) / 2
        point = _along(a, b, middle)
        if sum(inside(point, each) for each in near) % 2 == 0:
            return True
        ends = _along(a, b, low), _along(a, b, high)
        limit, edges = self.depth * self.depth, [edge for each in near for edge in each]
        if any(all(square_to_edge(end, edge) <= limit for end in ends) for edge in edges):
            return True
        if halvings == 0 or all(square_to_edge(point, edge) > limit for edge in edges):
            return False
        parts = (low, middle), (middle, high)
        return all(self._is_clear(a, b, part, near, halvings - 1) for part in parts)

    def _near(self, a: Place, b: Place, margin: Fraction) -> list[list[Edge]]:
        """Return the curves whose boxes come near to that of a segment: no other one goes round its points."""
        left, below, right, above = _box([a, b])
        return [
            edges
            for edges, box in zip(self.edges, self.boxes, strict=True)
            if box[0] <= right + margin
            and left - margin <= box[2]
            and box[1] <= above + margin
            and below - margin <= box[3]
        ]


def _box(points: list[Place]) -> tuple[Fraction, Fraction, Fraction, Fraction]:
    xs, ys = [x for x, _ in points], [y for _, y in points]
    return min(xs), min(ys), max(xs), max(ys)


def _along(a: Place, b: Place, share: Fraction) -> Place:
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])


def square_to_edge(point: Place, edge: Edge) -> Fraction:
    """Return the square of the distance of a point from a segment."""
    (ax, ay), (bx, by) = edge
    dx, dy = bx - ax, by - ay
    length = dx * dx + dy * dy
    share = Fraction(0) if length == 0 else ((point[0] - ax) * dx + (point[1] - ay) * dy) / length
    x, y = _along((ax, ay), (bx, by), min(max(share, Fraction(0)), Fraction(1)))
    return (point[0] - x) ** 2 + (point[1] - y) ** 2


def _meetings(a: Place, b: Place, edge: Edge) -> list[Fraction]:
    """Return the shares of the way from a to b at which it meets an edge; both ends where it lies along it."""
    (cx, cy), (dx, dy) = edge
    ux, uy, vx, vy = b[0] - a[0], b[1] - a[1], dx - cx, dy - cy
    cross = ux * vy - uy * vx
    if cross == 0:
        length = ux * ux + uy * uy
        shares = [((x - a[0]) * ux + (y - a[1]) * uy) / length for x, y in edge]
        return [share for share in shares if 0 < share < 1]
    share = ((cx - a[0]) * vy - (cy - a[1]) * vx) / cross
    along = ((cx - a[0]) * uy - (cy - a[1]) * ux) / cross
    return [share] if 0 <= share <= 1 and 0 <= along <= 1 else []
