r"""One head's tours as walks over entry points, in integers: what a proof by dynamic programming speaks of.

    (1) c_vw = l_vw + floor(scale * backward price * max(0, x_v - x_w))   a step between entry points
        s_v = l_(base, v),  t_v = l_(v, base)                             the first and the last leg

The base is the head's home, or the entry point at which a closed tour begins; its contour is then no contour of
the walk. Which beginnings have to be looked at:

(2) Nothing but the order around a closed tour matters when there is no precedence, no process rule and no
    backward price. Then it may be turned to begin with any contour, so one contour's entry points are enough.
(3) Otherwise a tour may begin with any contour that the precedence lets be first.
"""

from dataclasses import dataclass
from fractions import Fraction
from math import gcd

from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.reading import require
from cutgap.formulations.certificate.rules import Rules

Visit = tuple[int, int]
"""A contour and a node."""


@dataclass(frozen=True)
class Walks:
    """Walks over ``contours``, each once.

    Attributes
    ----------
    nodes
        Nodes of each contour of the walk.
    steps
        ``steps[a][b]`` holds for each node of b the list of c from the nodes of a.
    start, end
        s and t for the nodes of each contour.
    before
        Contours that must be cut before each contour, as a set of bits.
    mates
        Other contours of the same part, as bits, where parts are cut in one go; else 0.
    openers
        Contours that may come first, as bits: when parts are cut in one go, a closed tour that begins in a part
        of several contours goes on in it.
    """

    contours: list[int]
    nodes: list[list[int]]
    steps: list[list[list[list[int]]]]
    start: list[list[int]]
    end: list[list[int]]
    before: list[int]
    mates: list[int]
    openers: int


def beginnings(problem: Problem, rules: Rules) -> list[list[Visit | None]]:
    """Return the sets of beginnings of which a proof has to cover one; ``None`` is the home."""
    require(len(problem.homes) == 1, "contour-dp: needs one head")
    if problem.homes[0] is not None:
        return [[None]]
    choices: list[list[Visit | None]] = [
        [(contour, node) for node in nodes] for contour, nodes in enumerate(problem.entries)
    ]
    turned = rules.parts_in_one_go or rules.neighbours_only or rules.clear_rapids or rules.backward_price > 0
    if not problem.precedence and not turned:
        return choices
    later = {after for _, after in problem.precedence}
    return [[visit for contour, each in enumerate(choices) if contour not in later for visit in each]]


def walks_from(problem: Problem, rules: Rules, beginning: Visit | None, scale: int) -> Walks:
    """Return the walks of the head from its home or from a beginning."""
    base = problem.homes[0] if beginning is None else beginning[1]
    assert base is not None
    begun = -1 if beginning is None else beginning[0]
    contours = [contour for contour in range(len(problem.ids)) if contour != begun]
    nodes = [list(problem.entries[contour]) for contour in contours]
    flat = [node for each in nodes for node in each]
    legs = {node: dict(zip(flat, step_costs(problem, rules, node, flat, scale), strict=True)) for node in flat}
    return Walks(
        contours=contours,
        nodes=nodes,
        steps=[[[[legs[v][w] for v in a] for w in b] for b in nodes] for a in nodes],
        start=[first_costs(problem, rules, base, each, scale, beginning is not None) for each in nodes],
        end=[[problem.lengths(v, [base], scale)[0] for v in each] for each in nodes],
        before=preceding(problem, contours),
        mates=mates_of(problem, rules, contours),
        openers=_openers(problem, rules, contours, begun),
    )


def step_costs(problem: Problem, rules: Rules, node: int, others: list[int], scale: int) -> list[int]:
    """Return (1) from one entry point to others."""
    lengths = problem.lengths(node, others, scale)
    if rules.backward_price == 0:
        return lengths
    price, x = rules.backward_price * scale, problem.xs
    backs = (price * max(Fraction(0), x[node] - x[other]) for other in others)
    return [length + back.__floor__() for length, back in zip(lengths, backs, strict=True)]


def first_costs(
    problem: Problem, rules: Rules, base: int, others: list[int], scale: int, is_entry: bool
) -> list[int]:
    """Return s; the first leg of a closed tour is a step between entry points, that from a home is not."""
    return step_costs(problem, rules, base, others, scale) if is_entry else problem.lengths(base, others, scale)


def length_unit(problem: Problem, rules: Rules, scale: int) -> int:
    """Return a number of which all c, s and t of all walks are multiples: 1 where nothing better is known."""
    if problem.metric != "matrix" or rules.backward_price > 0:
        return 1
    unit = gcd(*(length for row in problem.places for length in row)) * scale
    return max(1, unit // problem.denominator) if unit % problem.denominator == 0 else 1


def preceding(problem: Problem, contours: list[int]) -> list[int]:
    """Return what precedes each contour, by the pairs and what follows from them, without what is cut."""
    numbers = {contour: number for number, contour in enumerate(contours)}
    before = [0] * len(problem.ids)
    for _ in problem.ids:
        for first, second in problem.precedence:
            before[second] |= before[first] | 1 << first
    return [
        sum(1 << numbers[other] for other in contours if before[contour] >> other & 1) for contour in contours
    ]


def _openers(problem: Problem, rules: Rules, contours: list[int], begun: int) -> int:
    everything = (1 << len(contours)) - 1
    if begun < 0 or not rules.parts_in_one_go:
        return everything
    part = problem.parts[begun]
    return sum(1 << a for a, c in enumerate(contours) if problem.parts[c] == part) or everything


def mates_of(problem: Problem, rules: Rules, contours: list[int]) -> list[int]:
    """Return the ``mates`` of walks over contours."""
    if not rules.parts_in_one_go:
        return [0] * len(contours)
    parts = [problem.parts[contour] for contour in contours]
    return [
        sum(1 << other for other, part in enumerate(parts) if part == parts[a] and other != a)
        for a in range(len(parts))
    ]
