"""A plan with links checked and valued exactly: its links are clear, its strokes can be made, each cut once."""

from collections import Counter
from fractions import Fraction
from itertools import pairwise
from math import isqrt
from typing import Any

from cutgap.formulations.certificate.material import Material
from cutgap.formulations.certificate.plan import FINE
from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.reading import entries, fields, integer, require, show
from cutgap.formulations.certificate.rules import Rules

Link = tuple[int, int, int]
"""Two nodes, and how often the link between them is passed."""


def linked_plan_value(problem: Problem, rules: Rules, value: Any) -> Fraction:
    """Return an upper bound on the objective of an allowed plan, s or mm; refuses plans that break a rule."""
    table = fields(value, "plan", "tours links")
    require(not problem.precedence, "plan: precedence is not checked with links here: leave it out")
    home = problem.homes[0]
    require(len(problem.homes) == 1 and home is not None, "plan: links need one head with a home")
    assert home is not None
    numbers = {name: number for number, name in enumerate(problem.ids)}
    (tour,) = entries(table["tours"], "plan", count=1)
    visits = [_node(problem, numbers, *entries(each, "visit", count=2)) for each in entries(tour, "tour")]
    links = [_link(problem, numbers, each) for each in entries(table["links"], "links")]
    pairs = [(p, q) for p, q, _ in links]
    require(len(set(pairs)) == len(pairs), "plan: two links join the same nodes")
    material = Material(problem) if links else None
    for p, q, _ in links:
        require(
            material is None or material.is_clear(p, q),
            f"plan: the link from node {p} to {q} is not surely clear",
        )
    require(rules.pierces is None or len(visits) <= rules.pierces, "plan: too many pierces")
    ends = _ends(problem, visits, links)
    stops = [home, *(node for pair in ends for node in pair), home]
    legs = list(pairwise(stops))[::2] if ends else []
    scale = problem.denominator * FINE
    rapids = Fraction(sum(problem.range_of(u, v, scale)[1] for u, v in legs), scale)
    linked = sum((passes * _most(problem, p, q) for p, q, passes in links), Fraction(0))
    if rules.objective == "travel":
        return rapids + linked
    perimeter = sum((contour[2] for contour in problem.contours), Fraction(0))
    return rapids / problem.v_jump + (linked + perimeter) / problem.v_cut + problem.t_aux * len(visits)


def _node(problem: Problem, numbers: dict[str, int], name: Any, entry: Any) -> int:
    require(isinstance(name, str) and name in numbers, f"plan: no contour {show(name)}")
    nodes = problem.entries[numbers[name]]
    known = integer(entry, "plan, entry", least=0) < len(nodes)
    require(known, f"plan: contour {show(name)} has no entry point {show(entry)}")
    return nodes[entry]


def _link(problem: Problem, numbers: dict[str, int], value: Any) -> Link:
    name, entry, other, at, passes = entries(value, "plan, link", count=5)
    require(name != other, "plan: a link leads to its own contour")
    require(integer(passes, "plan, passes") in (1, 2), "plan: a link is passed once or twice")
    p, q = sorted((_node(problem, numbers, name, entry), _node(problem, numbers, other, at)))
    return p, q, passes


def _ends(problem: Problem, visits: list[int], links: list[Link]) -> list[tuple[int, int]]:
    """Return where each stroke starts and ends; refuses unless all contours are cut once."""
    contour_of = [contour for contour, nodes in enumerate(problem.entries) for _ in nodes]
    group = list(range(len(problem.ids)))
    odd: Counter[int] = Counter()
    for p, q, passes in links:
        old, new = group[contour_of[p]], group[contour_of[q]]
        group = [new if each == old else each for each in group]
        odd.update({p: passes, q: passes})
    visited = [group[contour_of[node]] for node in visits]
    require(sorted(visited) == sorted(set(group)), "plan: it must cut each contour once")
    ends = []
    for start, mine in zip(visits, visited, strict=True):
        loose = [node for node, count in odd.items() if count % 2 and group[contour_of[node]] == mine]
        fits = not loose or (len(loose) == 2 and start in loose)
        require(fits, "plan: an odd number of links meets at a node")
        ends.append((start, next((node for node in loose if node != start), start)))
    return ends


def _most(problem: Problem, p: int, q: int) -> Fraction:
    """Return an upper bound on the length of a link, mm."""
    points = [point for contour in problem.contours for point in contour[1]]
    square = FINE**2 * sum(((a - b) ** 2 for a, b in zip(points[p], points[q], strict=True)), Fraction(0))
    root = isqrt(square.numerator // square.denominator)
    return Fraction(root + (root * root != square), FINE)
