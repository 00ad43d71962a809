"""Brute force over plans with links on sheets of convex shapes; shares no code with the package.

Every link is left out, passed once or passed twice. What the links join is cut from one pierce at one node,
or between the only two nodes at which an odd number of passes ends; all orders of these strokes are tried.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, permutations, product
from math import dist

Spot = tuple[float, float]
Node = tuple[int, int]
"""Shape and entry point."""


@dataclass(frozen=True)
class Sheet:
    """Convex shapes by their corners, counter-clockwise, entry points, home and machine."""

    shapes: list[list[Spot]]
    entries: list[list[Spot]]
    home: Spot
    v_jump: float
    v_cut: float
    t_aux: float


def runs_through(start: Spot, end: Spot, shape: Sequence[Spot], depth: float) -> bool:
    """Whether a segment has a point inside a convex shape, farther from its edges than ``depth``."""
    low, high = 0.0, 1.0
    for (ax, ay), (bx, by) in zip(shape, [*shape[1:], shape[0]], strict=True):
        length = dist((ax, ay), (bx, by))
        inside = [((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / length - depth for x, y in (start, end)]
        if max(inside) <= 0:
            return False
        if min(inside) < 0:
            share = inside[0] / (inside[0] - inside[1])
            low, high = (max(low, share), high) if inside[0] < 0 else (low, min(high, share))
    return low < high


def clear_links(sheet: Sheet) -> list[tuple[Node, Node, float]]:
    """Return the links that lead through no shape, with their lengths."""
    corners = [corner for shape in sheet.shapes for corner in shape]
    extent = max(max(values) - min(values) for values in zip(*corners, strict=True))
    nodes = [(shape, each) for shape, spots in enumerate(sheet.entries) for each in range(len(spots))]
    found = []
    for one, other in combinations(nodes, 2):
        a, b = (sheet.entries[shape][each] for shape, each in (one, other))
        if one[0] != other[0] and not any(runs_through(a, b, s, 1e-7 * extent) for s in sheet.shapes):
            found.append((one, other, dist(a, b)))
    return found


def least(sheet: Sheet, objective: str, pierces: int | None) -> float | None:
    """Return the value of the best plan, s or mm; ``None`` when there is none."""
    links = clear_links(sheet)
    price = sheet.v_jump / sheet.v_cut if objective == "makespan" else 1.0
    pierce = sheet.t_aux * sheet.v_jump if objective == "makespan" else 0.0
    best = None
    work: list[tuple[int, list[int], float]] = [(0, [], 0.0)]
    while work:
        number, passes, cost = work.pop()
        if best is not None and cost >= best:
            continue
        if number == len(links):
            for rapid, count in _tours(sheet, links, passes):
                value = cost + rapid + pierce * count
                if (pierces is None or count <= pierces) and (best is None or value < best):
                    best = value
            continue
        for each in (2, 1, 0):
            work.append((number + 1, [*passes, each], cost + each * price * links[number][2]))
    if best is None or objective == "travel":
        return best
    perimeter = sum(
        dist(a, b) for shape in sheet.shapes for a, b in zip(shape, [*shape[1:], shape[0]], strict=True)
    )
    return best / sheet.v_jump + perimeter / sheet.v_cut


def _tours(
    sheet: Sheet, links: list[tuple[Node, Node, float]], passes: list[int]
) -> Iterator[tuple[float, int]]:
    """Yield the length of rapids and the number of strokes for every way of making strokes of passed links."""
    group = list(range(len(sheet.shapes)))
    odd: dict[Node, int] = {}
    for (one, other, _), count in zip(links, passes, strict=True):
        if count:
            old, new = group[one[0]], group[other[0]]
            group = [new if each == old else each for each in group]
            for node in (one, other):
                odd[node] = odd.get(node, 0) + count
    choices: list[list[tuple[Spot, Spot]]] = []
    for leader in sorted(set(group)):
        shapes = [shape for shape, each in enumerate(group) if each == leader]
        ends = [sheet.entries[s][e] for (s, e), count in odd.items() if count % 2 and s in shapes]
        if len(ends) > 2:
            return
        if ends:
            choices.append([(ends[0], ends[1]), (ends[1], ends[0])])
        else:
            choices.append([(spot, spot) for shape in shapes for spot in sheet.entries[shape]])
    for order in permutations(choices):
        for strokes in product(*order):
            at, length = sheet.home, 0.0
            for start, end in strokes:
                length += dist(at, start)
                at = end
            yield length + dist(at, sheet.home), len(strokes)
