"""Plans with links on tiny sheets, all of them, from the definitions alone.

    link      a straight cut between entry points of different contours, made once or twice; no two links join
              the same points; no point of it lies in material deeper than ``DEPTH`` times the extent of all
              curves
    material  what lies inside an odd number of curves
    group     contours that links join, directly or by others; each group has one stroke
    stroke    starts at an entry point of its group. If no entry point is the end of an odd number of passes it
              ends there; if two are, it starts at one of them and ends at the other; else there is none
    travel    rapids from home to stroke to stroke to home, and passes of links                     [mm]
    makespan  rapids / v_jump + (passes + perimeters) / v_cut + t_aux * strokes                     [s]

Link by link (not made, once, twice) a table holds, for each division into groups and each set of odd entry
points, the least length or the number of choices. What follows, starts and order of strokes, is tried out.

Calls no method of an ``Instance``. Source: Chen, Li, Chu; a stroke may end elsewhere than it starts.
"""

import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations, pairwise

import numpy as np

from cutgap.instances import Instance, Rules

DEPTH = Fraction(1, 10**7)
SAMPLES = 16
"""Places at which a piece of a link inside material is measured; on coarse coordinates deep ones are deep in
the middle, and those of rounded points nowhere."""

Point = tuple[Fraction, Fraction]
Division = tuple[int, ...]
"""For each contour the least contour of its group."""
Visit = tuple[int, int]
"""Contour, entry point."""
LinkOf = tuple[int, int, int, int, int]
"""Contour, entry point, contour, entry point, passes."""


@dataclass(frozen=True)
class Strokes:
    """Nodes (entry points, then the home) with their lengths, and which links are clear.

    Attributes
    ----------
    of
        Contour of each entry point.
    rapids, cuts
        Lengths of rapids and of links between nodes, mm.
    links
        Pairs of entry points with a clear link.
    """

    of: tuple[int, ...]
    contours: int
    rapids: tuple[tuple[float, ...], ...]
    cuts: tuple[tuple[float, ...], ...]
    links: tuple[tuple[int, int], ...]
    rapid_price: float
    link_price: float
    stroke_price: float
    fixed_price: float
    most_strokes: int

    def price(self, strokes: list[tuple[int, int]], linked: float) -> float:
        """Return the value of strokes (start, end) in order with links of a total length."""
        home = len(self.of)
        ways = pairwise([home, *(node for stroke in strokes for node in stroke), home])
        rapids = [self.rapids[a][b] for a, b in list(ways)[::2]] if strokes else []
        return (
            self.rapid_price * math.fsum(rapids)
            + self.link_price * linked
            + self.stroke_price * len(strokes)
            + self.fixed_price
        )


def strokes_of(instance: Instance, rules: Rules) -> Strokes:
    """Copy what matters of an instance with one head that has a home, and no precedence."""
    assert len(instance.heads) == 1
    assert not instance.precedence
    places = [
        (index, tuple(map(float, row))) for index, c in enumerate(instance.contours) for row in c.entry_points
    ]
    points = [*(place for _, place in places), tuple(map(float, instance.heads[0].home))]
    of = tuple(index for index, _ in places)
    cuts = tuple(tuple(math.dist(a, b) for b in points) for a in points)
    if instance.matrix is not None:
        rapids = tuple(tuple(map(float, row)) for row in instance.matrix)
    elif instance.machine.metric == "chebyshev":
        rapids = tuple(
            tuple(max(abs(x - y) for x, y in zip(a, b, strict=True)) for b in points) for a in points
        )
    else:
        rapids = cuts
    curves = [[(Fraction(x), Fraction(y)) for x, y in c.geometry.tolist()] for c in instance.contours]
    flat = [(Fraction(x), Fraction(y)) for x, y, _ in points]
    links = tuple(
        (u, v)
        for u, v in combinations(range(len(of)), 2)
        if of[u] != of[v] and not is_blocked(flat[u], flat[v], curves)
    )
    machine, timed = instance.machine, rules.objective == "makespan"
    perimeters = math.fsum(contour.perimeter for contour in instance.contours)
    return Strokes(
        of,
        len(instance.contours),
        rapids,
        cuts,
        links,
        rapid_price=1 / machine.v_jump if timed else 1.0,
        link_price=1 / machine.v_cut if timed else 1.0,
        stroke_price=machine.t_aux if timed else 0.0,
        fixed_price=perimeters / machine.v_cut if timed else 0.0,
        most_strokes=len(instance.contours) if rules.pierces is None else rules.pierces,
    )


def least_value(instance: Instance, rules: Rules) -> float | None:
    """Return the least value of all allowed plans; ``None`` when there is none."""
    given = strokes_of(instance, rules)
    table = _table(given, np.inf, 0.0, np.minimum, lambda before, length: before + length)
    rows = [
        (float(lengths[odd]), division, int(odd))
        for division, lengths in table.items()
        for odd in np.flatnonzero(np.isfinite(lengths))
        if len(set(division)) <= given.most_strokes
    ]
    best = math.inf
    for linked, division, odd in sorted(rows):
        least = given.fixed_price + given.link_price * linked + given.stroke_price * len(set(division))
        if least < best:
            for strokes in _all_strokes(given, division, odd):
                best = min(best, given.price(strokes, linked))
    return None if math.isinf(best) else best


def plan_count(instance: Instance, rules: Rules) -> int:
    """Return the number of allowed plans, links without order; a stroke counts by its start."""
    given = strokes_of(instance, rules)
    table = _table(given, 0, 1, np.add, lambda before, _: before)
    total = 0
    for division, counts in table.items():
        groups = sorted(set(division))
        if len(groups) > given.most_strokes:
            continue
        for odd in np.flatnonzero(counts):
            starts = [len(_ends(given, division, group, int(odd))) for group in groups]
            total += int(counts[odd]) * math.prod(starts) * math.factorial(len(groups))
    return total


def is_allowed(given: Strokes, visits: list[Visit], links: list[LinkOf]) -> bool:
    """Whether a plan of known contours and entry points is allowed."""
    joined = [tuple(sorted((_node(given, a, e), _node(given, b, f)))) for a, e, b, f, _ in links]
    if len(set(joined)) < len(joined) or not set(joined) <= set(given.links):
        return False
    division, odd = _division_and_odd(given, links)
    starts = Counter(division[contour] for contour, _ in visits)
    if set(starts.values()) - {1} or set(starts) != set(division) or len(visits) > given.most_strokes:
        return False
    ends = [{start for start, _ in _ends(given, division, division[contour], odd)} for contour, _ in visits]
    return all(_node(given, *visit) in nodes for visit, nodes in zip(visits, ends, strict=True))


def value(given: Strokes, visits: list[Visit], links: list[LinkOf]) -> float:
    """Return the value of an allowed plan."""
    division, odd = _division_and_odd(given, links)
    strokes = [
        stroke
        for contour, entry in visits
        for stroke in _ends(given, division, division[contour], odd)
        if stroke[0] == _node(given, contour, entry)
    ]
    linked = math.fsum(
        passes * given.cuts[_node(given, a, e)][_node(given, b, f)] for a, e, b, f, passes in links
    )
    return given.price(strokes, linked)


def _node(given: Strokes, contour: int, entry: int) -> int:
    return given.of.index(contour) + entry


def _division_and_odd(given: Strokes, links: list[LinkOf]) -> tuple[Division, int]:
    """Return the groups, and the set of odd entry points as bits."""
    division, odd = tuple(range(given.contours)), 0
    for a, e, b, f, passes in links:
        division = _joined(division, a, b)
        if passes == 1:
            odd ^= 1 << _node(given, a, e) ^ 1 << _node(given, b, f)
    return division, odd


def _table(
    given: Strokes,
    nothing: float,
    start: float,
    add: Callable[[np.ndarray, np.ndarray], np.ndarray],
    extend: Callable[[np.ndarray, float], np.ndarray],
) -> dict[Division, np.ndarray]:
    """Return, for each division and set of odd points, what all choices of links give when added up."""
    sets = np.arange(1 << len(given.of))
    first = np.full(len(sets), nothing, dtype=float if isinstance(nothing, float) else object)
    first[0] = start
    table = {tuple(range(given.contours)): first}
    for u, v in given.links:
        after = {division: each.copy() for division, each in table.items()}
        for division, before in table.items():
            joined = _joined(division, given.of[u], given.of[v])
            once, twice = before[sets ^ (1 << u | 1 << v)], before
            for passes, each in ((1, once), (2, twice)):
                more = extend(each, passes * given.cuts[u][v])
                after[joined] = add(after[joined], more) if joined in after else more
        table = after
    return table


def _joined(division: Division, a: int, b: int) -> Division:
    one, other = sorted((division[a], division[b]))
    return tuple(one if group == other else group for group in division)


def _ends(given: Strokes, division: Division, group: int, odd: int) -> list[tuple[int, int]]:
    """Return all (start, end) of a group's stroke."""
    nodes = [node for node, contour in enumerate(given.of) if division[contour] == group]
    ends = [node for node in nodes if odd >> node & 1]
    if not ends:
        return [(node, node) for node in nodes]
    return [(ends[0], ends[1]), (ends[1], ends[0])] if len(ends) == 2 else []


def _all_strokes(given: Strokes, division: Division, odd: int) -> Iterator[list[tuple[int, int]]]:
    """Yield all orders of strokes with all starts."""
    choices = {group: _ends(given, division, group, odd) for group in set(division)}

    def go_on(made: list[tuple[int, int]], left: frozenset[int]) -> Iterator[list[tuple[int, int]]]:
        if not left:
            yield made
        for group in left:
            for stroke in choices[group]:
                yield from go_on([*made, stroke], left - {group})

    yield from go_on([], frozenset(choices))


def is_blocked(p: Point, q: Point, curves: list[list[Point]]) -> bool:
    """Whether a link from p to q has a point in material, deeper than allowed."""
    edges = [edge for curve in curves for edge in zip(curve, curve[1:] + curve[:1], strict=True)]
    spread = [
        max(c[i] for curve in curves for c in curve) - min(c[i] for curve in curves for c in curve)
        for i in (0, 1)
    ]
    deep = (DEPTH * max(spread)) ** 2
    marks = sorted({Fraction(0), Fraction(1), *(t for a, b in edges for t in _meetings(p, q, a, b))})
    for begin, end in pairwise(marks):
        if not _is_material(_between(p, q, (begin + end) / 2), curves):
            continue
        for step in range(1, SAMPLES):
            place = _between(p, q, begin + (end - begin) * Fraction(step, SAMPLES))
            if all(_distance_squared(place, a, b) > deep for a, b in edges):
                return True
    return False


def _between(p: Point, q: Point, t: Fraction) -> Point:
    return (p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1]))


def _cross(a: Point, b: Point, c: Point) -> Fraction:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _meetings(p: Point, q: Point, a: Point, b: Point) -> list[Fraction]:
    """Return where, in 0 .. 1 along p q, its line may change sides of the segment a b."""
    if max(p[0], q[0]) < min(a[0], b[0]) or max(a[0], b[0]) < min(p[0], q[0]):
        return []
    if max(p[1], q[1]) < min(a[1], b[1]) or max(a[1], b[1]) < min(p[1], q[1]):
        return []
    one, other = _cross(a, b, p), _cross(a, b, q)
    if one != other:
        t = one / (one - other)
        return [t] if 0 < t < 1 else []
    if one != 0 or p == q:
        return []
    axis = 0 if p[0] != q[0] else 1
    ends = [(c[axis] - p[axis]) / (q[axis] - p[axis]) for c in (a, b)]
    return [t for t in ends if 0 < t < 1]


def _is_material(point: Point, curves: list[list[Point]]) -> bool:
    """Whether a point lies inside an odd number of curves; one on a curve counts either way, it is not deep."""
    x, y = point
    odd = False
    for curve in curves:
        for a, b in zip(curve, curve[1:] + curve[:1], strict=True):
            if (a[1] > y) != (b[1] > y):
                odd ^= x < a[0] + (y - a[1]) * (b[0] - a[0]) / (b[1] - a[1])
    return odd


def _distance_squared(point: Point, a: Point, b: Point) -> Fraction:
    dx, dy = b[0] - a[0], b[1] - a[1]
    t = ((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / (dx * dx + dy * dy)
    x, y = _between(a, b, min(max(t, Fraction(0)), Fraction(1)))
    return (point[0] - x) ** 2 + (point[1] - y) ** 2
