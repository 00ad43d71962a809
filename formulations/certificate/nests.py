r"""Which of two curves lies in the other, exactly, where no two ways to decide it can differ.

The library takes a point of the area in one curve and asks whether it is in the other. For simple curves that
do not cross all points give the same answer, and only then one is given here:

    (1) Corners and pieces of edges between meetings are inside the other curve, outside of it, or on it.
    (2) c lies in d      some of c is inside d, none outside, and none of d is inside c
    (3) they are apart   none of one is inside the other, and some of each is outside
    (4) equal corners    of equal curves the later one lies in the first

Anything else is refused, as are curves of nearly no area or of nearly equal areas. What a curve has inside or
outside of it is by an even number of crossings, so (2) and (3) are complete: areas that overlap have a piece of
one curve inside the other.
"""

from collections.abc import Iterator
from fractions import Fraction
from itertools import combinations, pairwise

from cutgap.formulations.certificate.proof import Budget
from cutgap.formulations.certificate.reading import require
from cutgap.formulations.certificate.segments import Edge, Place, between, box, doubled_area, inside, meet, turn

INSIDE, OUTSIDE, ON = "inside", "outside", "on"
LEAST_AREA = 10**12
"""A curve's area must not be below the square of the largest coordinate by this factor."""
NEARLY = 10**9
"""Of nested curves the areas must differ by this part."""
STEPS = 10
"""Elementary steps for an edge against an edge or a point."""


def lies_in(numbers: tuple[int, int], one: list[Edge], other: list[Edge], budget: Budget) -> tuple[bool, bool]:
    """Return whether the first of two curves lies in the second, and the second in the first."""
    (left, below, right, above), (west, south, east, north) = (
        box([p for p, _ in each]) for each in (one, other)
    )
    if right < west or east < left or above < south or north < below:
        return False, False
    names = f"curves: what lies in what is in doubt for contours {numbers[0]} and {numbers[1]}"
    require(_is_plain(one, budget) and _is_plain(other, budget), names)
    sides, others = _sides(one, other, budget), _sides(other, one, budget)
    if sides == others == {ON}:
        require([p for p, _ in one] == [p for p, _ in other], names)
        return numbers[0] > numbers[1], numbers[1] > numbers[0]
    areas = doubled_area(one), doubled_area(other)
    if INSIDE not in sides | others:
        require(OUTSIDE in sides and OUTSIDE in others, names)
        return False, False
    inner = INSIDE in sides
    within, around = (sides, others) if inner else (others, sides)
    less, more = areas if inner else areas[::-1]
    require(OUTSIDE not in within and INSIDE not in around and (more - less) * NEARLY >= more, names)
    return inner, not inner


def _is_plain(edges: list[Edge], budget: Budget) -> bool:
    """Whether a curve has an area to speak of and does not touch itself."""
    edges = [(p, q) for p, q in edges if p != q]
    largest = max((abs(value) for edge in edges for place in edge for value in place), default=1)
    if doubled_area(edges) * LEAST_AREA < largest * largest:
        return False
    budget.spend(STEPS * len(edges) * len(edges))
    last = len(edges) - 1
    # Edges next to each other may meet: where they overlap, the one before or behind meets one of them too.
    return not any(
        meet(*edges[i], *edges[j])
        for i, j in combinations(range(len(edges)), 2)
        if j != i + 1 and (i, j) != (0, last)
    )


def _sides(edges: list[Edge], others: list[Edge], budget: Budget) -> set[str]:
    """(1)."""
    found: set[str] = set()
    for edge in edges:
        budget.spend(STEPS * len(others))
        for place in _places(edge, others):
            budget.spend(STEPS * len(others))
            found.add(_side(place, others))
            if INSIDE in found and OUTSIDE in found:
                return found
    return found


def _places(edge: Edge, others: list[Edge]) -> Iterator[Place]:
    """Yield the first corner of an edge, and a point of each piece between its meetings with other edges."""
    (ax, ay), (bx, by) = edge
    yield ax, ay
    shares = {Fraction(0), Fraction(1)}
    for each in others:
        if meet(*edge, *each):
            shares |= set(_shares(edge, each))
    for low, high in pairwise(sorted(shares)):
        middle = (low + high) / 2
        yield ax + middle * (bx - ax), ay + middle * (by - ay)


def _shares(edge: Edge, other: Edge) -> list[Fraction]:
    """Return where on an edge it meets another, which it does; both ends where they lie along each other."""
    (ax, ay), (bx, by) = edge
    (cx, cy), (dx, dy) = other
    ux, uy, vx, vy = bx - ax, by - ay, dx - cx, dy - cy
    cross, length = ux * vy - uy * vx, ux * ux + uy * uy
    if cross != 0:
        return [Fraction((cx - ax) * vy - (cy - ay) * vx, cross)]
    shares = [Fraction((x - ax) * ux + (y - ay) * uy, length) for x, y in other] if length else []
    return [share for share in shares if 0 < share < 1]


def _side(place: Place, edges: list[Edge]) -> str:
    if any(turn(*edge, place) == 0 and between(*edge, place) for edge in edges):
        return ON
    return INSIDE if inside(place, edges) else OUTSIDE
