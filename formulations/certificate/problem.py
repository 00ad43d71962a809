"""The exact problem: the numbers of an instance file as fractions, rapid lengths and work as integers.

    d_uv     rapid length between two nodes                                   [mm]
    (1) l_uv = floor(scale * d_uv)                                            [mm / scale]
    (2) w_i  = scale * v_jump * (perimeter_i / v_cut + t_aux)                 [mm / scale]
    (3) scale * v_jump * T_a = sum of scale * d_uv + sum of w_i >= sum of l_uv + sum of w_i

Coordinates are integers over one common denominator, so a Euclidean l_uv is an integer square root. Nodes are
numbered as in the library: the entry points of the contours in order of the file, then the homes of the heads
that have one. With one entry point a contour, contours and nodes have the same numbers.
"""

import hashlib
import json
from dataclasses import dataclass
from fractions import Fraction
from itertools import accumulate
from math import gcd, isqrt, lcm
from operator import add
from typing import Any

from cutgap.formulations.certificate.plane import Spot, as_doubles
from cutgap.formulations.certificate.reading import (
    entries,
    fields,
    flag,
    number,
    read_document,
    require,
    show,
    text_of,
)
from cutgap.formulations.certificate.sheet import Sheet, sheet_of

MAX_NODES = 10_000

Pair = tuple[int, int]
Point = tuple[Fraction, ...]
Curve = tuple[Point, ...]
Ellipsoid = tuple[Point, tuple[Point, ...]]
"""Centre and half axes."""
ContourFields = tuple[str, tuple[Point, ...], Fraction, str | None, Curve, Ellipsoid | None]


@dataclass(frozen=True)
class Problem:
    """What a proof is about.

    Attributes
    ----------
    homes
        Node of each head's home; ``None`` where its tour is closed.
    entries
        Nodes of each contour's entry points.
    parts
        Number of each contour's part, in order of appearance; a contour without one is a part of its own.
    precedence
        Pairs of contours of which the first is cut before the second.
    xs
        Place of each entry point along x, mm.
    seconds
        perimeter / v_cut + t_aux of each contour, s.
    denominator, places
        ``places[node]`` holds integers: x, y, z, or the node's row of the matrix, in mm * denominator.
    plane, curves
        x, y of each entry point, and the closed polyline of each contour (empty without one), as the doubles
        that the library has for them, in integers of a unit of their own.
    contours
        The fields of each contour as the file has them.
    material
        ``None`` without temperatures.
    """

    digest: str
    ids: tuple[str, ...]
    homes: tuple[int | None, ...]
    entries: tuple[range, ...]
    parts: tuple[int, ...]
    precedence: tuple[Pair, ...]
    xs: tuple[Fraction, ...]
    seconds: tuple[Fraction, ...]
    v_jump: Fraction
    v_cut: Fraction
    t_aux: Fraction
    metric: str
    denominator: int
    places: tuple[tuple[int, ...], ...]
    located: bool
    plane: tuple[Spot, ...]
    curves: tuple[tuple[Spot, ...], ...]
    contours: tuple[ContourFields, ...]
    material: Sheet | None

    def lengths(self, node: int, others: list[int], scale: int) -> list[int]:
        """Return (1) from one node to others."""
        here, there, below = self.places[node], [self.places[other] for other in others], self.denominator
        if self.metric == "matrix":
            return [here[other] * scale // below for other in others]
        x, y, z = here
        if self.metric == "chebyshev":
            return [max(abs(x - a), abs(y - b), abs(z - c)) * scale // below for a, b, c in there]
        squares = [(x - a) * (x - a) + (y - b) * (y - b) + (z - c) * (z - c) for a, b, c in there]
        common = gcd(scale, below)
        over, under = (scale // common) ** 2, (below // common) ** 2
        if under == 1:
            return [isqrt(square * over) for square in squares]
        # floor(sqrt(q)) = isqrt(floor(q)) for every fraction q.
        return [isqrt(square * over // under) for square in squares]

    def range_of(self, node: int, other: int, scale: int) -> tuple[int, int]:
        """Return floor and ceiling of scale * d_uv, for a scale that the denominator divides."""
        require(scale % self.denominator == 0, "the scale must be a multiple of the denominator")
        length = self.lengths(node, [other], scale)[0]
        if self.metric != "euclidean":
            return length, length
        square = sum((a - b) ** 2 for a, b in zip(self.places[node], self.places[other], strict=True))
        exact = length * length == square * (scale // self.denominator) ** 2
        return length, length + (not exact)

    def length_key(self, node: int, other: int) -> int:
        """Return a number that is equal for legs of equal length: the square of it, where that is exact."""
        if self.metric != "euclidean":
            return self.lengths(node, [other], self.denominator)[0]
        return sum((a - b) ** 2 for a, b in zip(self.places[node], self.places[other], strict=True))

    def work(self, contour: int, scale: int) -> Fraction:
        """Return (2)."""
        return scale * self.v_jump * self.seconds[contour]

    def is_metric(self) -> bool:
        """Whether no detour is shorter than the direct way; coordinates are always metric."""
        if self.metric != "matrix":
            return True
        columns = list(zip(*self.places, strict=True))
        return all(
            length <= min(map(add, row, column))
            for row in self.places
            for column, length in zip(columns, row, strict=True)
        )

    def is_symmetric(self) -> bool:
        """Whether all lengths are the same both ways."""
        if self.metric != "matrix":
            return True
        columns = zip(*self.places, strict=True)
        return all(row == column for row, column in zip(self.places, columns, strict=True))

    def region(self, contour: int) -> tuple[tuple[Point, ...], tuple[Point, ...]]:
        """Return where a contour may be entered with free entries: points and axes.

        With axes it is the ellipsoid around the only point; else the hull of the points: the contour's curve at
        the height of its entry points, or its only entry point.
        """
        require(self.located, "regions: the points carry no coordinates")
        name, points, _, _, curve, ellipsoid = self.contours[contour]
        if ellipsoid is not None:
            return (ellipsoid[0],), ellipsoid[1]
        height = points[0][2]
        if curve:
            require(
                all(z == height for _, _, z in points), f"contour {show(name)}: its entry points differ in z"
            )
            return tuple((x, y, height) for x, y in curve), ()
        require(len(points) == 1, f"contour {show(name)}: several entry points and no region")
        return points, ()

    def require_plain(self, kind: str) -> None:
        """Refuse what proofs of symmetric tours over contours of one entry point each say nothing about."""
        require(all(len(nodes) == 1 for nodes in self.entries), f"{kind}: takes one entry point a contour")
        require(not self.precedence, f"{kind}: takes no precedence")
        require(self.is_symmetric(), f"{kind}: takes symmetric lengths")


def instance_hash(document: str | dict[str, Any]) -> str:
    """Return the hash of an instance document: equal problems, equal hash, whatever the layout of the file."""
    return problem_of(document).digest


def problem_of(document: str | dict[str, Any]) -> Problem:
    """Return the exact problem of an instance document."""
    table = read_document(document) if isinstance(document, str) else document
    table = fields(
        table, "instance", "format version name machine heads contours", "precedence matrix material located"
    )
    require(table["format"] == "cutgap-instance" and table["version"] == 1, "instance: not a cutgap-instance 1")
    machine = fields(table["machine"], "machine", "v_jump v_cut t_aux metric")
    speeds = [number(machine[name], f"machine.{name}", least=0) for name in ("v_jump", "v_cut", "t_aux")]
    require(speeds[0] > 0 and speeds[1] > 0, "machine: speeds must be above 0")
    metric = machine["metric"]
    require(metric in ("euclidean", "chebyshev", "matrix"), "machine.metric: not one that proofs are known for")
    contours = [_contour(each, i) for i, each in enumerate(entries(table["contours"], "contours"))]
    heads = [_head(each, i) for i, each in enumerate(entries(table["heads"], "heads"))]
    names = [contour[0] for contour in contours]
    points = [point for contour in contours for point in contour[1]]
    count = len(points)
    points += [home for _, home in heads if home is not None]
    require(len(points) <= MAX_NODES, f"contours: more than {MAX_NODES} points")
    _check_names(names, [head for head, _ in heads])
    precedence = _precedence(table.get("precedence", []), names)
    located = flag(table.get("located", True), "located")
    require(located or metric == "matrix", "located: without coordinates the metric must be matrix")
    matrix = _matrix(table.get("matrix"), len(points)) if metric == "matrix" else None
    require(matrix is not None or table.get("matrix") is None, "matrix: given, but the metric is another")
    rows = points if matrix is None else matrix
    denominator = lcm(*{value.denominator for row in rows for value in row})
    places = tuple(tuple(int(value * denominator) for value in row) for row in rows)
    plane, *curves = as_doubles([[p for contour in contours for p in contour[1]], *(c[4] for c in contours)])
    material = sheet_of(table.get("material"))
    has_home = [home is not None for _, home in heads]
    homes = [count + sum(has_home[:head]) if has_home[head] else None for head in range(len(heads))]
    return Problem(
        digest=_digest([speeds, metric, heads, contours, precedence, matrix, located, *(material or ())]),
        ids=tuple(names),
        homes=tuple(homes),
        entries=_entries([len(contour[1]) for contour in contours]),
        parts=_parts([contour[3] for contour in contours]),
        precedence=precedence,
        xs=tuple(point[0] for point in points[:count]),
        seconds=tuple(contour[2] / speeds[1] + speeds[2] for contour in contours),
        v_jump=speeds[0],
        v_cut=speeds[1],
        t_aux=speeds[2],
        metric=metric,
        denominator=denominator,
        places=places,
        located=located,
        plane=plane,
        curves=tuple(curves),
        contours=tuple(contours),
        material=material,
    )


def _contour(value: Any, index: int) -> ContourFields:
    """Return id, entry points, perimeter, part, curve and region."""
    where = f"contours[{index}]"
    table = fields(value, where, "id entry_points perimeter", "part ring geometry region")
    given = entries(table["entry_points"], f"{where}.entry_points")
    require(given != [], f"{where}.entry_points: expected at least one")
    points = tuple(_point(each, f"{where}.entry_points[{i}]") for i, each in enumerate(given))
    perimeter = number(table["perimeter"], f"{where}.perimeter", least=0)
    part = table.get("part")
    require(part is None or isinstance(part, str), f"{where}.part: expected a text, got {show(part)}")
    rows = entries(table.get("geometry") or [], f"{where}.geometry")
    curve = tuple(_point(each, f"{where}.geometry[{i}]", 2) for i, each in enumerate(rows))
    region = _ellipsoid(table.get("region"), f"{where}.region")
    return text_of(table["id"], f"{where}.id"), points, perimeter, part, curve, region


def _ellipsoid(value: Any, where: str) -> Ellipsoid | None:
    if value is None:
        return None
    table = fields(value, where, "centre axes")
    axes = entries(table["axes"], f"{where}.axes")
    require(1 <= len(axes) <= 3, f"{where}.axes: expected 1 to 3, got {len(axes)}")
    return _point(table["centre"], f"{where}.centre"), tuple(_point(each, f"{where}.axes") for each in axes)


def _head(value: Any, index: int) -> tuple[str, Point | None]:
    table = fields(value, f"heads[{index}]", "id", "home")
    home = table.get("home")
    return text_of(table["id"], f"heads[{index}].id"), None if home is None else _point(
        home, f"heads[{index}].home"
    )


def _point(value: Any, where: str, count: int = 3) -> Point:
    return tuple(number(each, where) for each in entries(value, where, count=count))


def _check_names(contours: list[str], heads: list[str]) -> None:
    require(len(heads) in (1, 2), f"heads: proofs are known for one and two, not for {len(heads)}")
    for kind, names in (("contour", contours), ("head", heads)):
        require(len(set(names)) == len(names), f"two of the {kind}s have one id")


def _entries(sizes: list[int]) -> tuple[range, ...]:
    """Return the nodes of contours with so many entry points."""
    ends = list(accumulate(sizes))
    return tuple(range(end - size, end) for end, size in zip(ends, sizes, strict=True))


def _parts(names: list[str | None]) -> tuple[int, ...]:
    numbers: dict[str | int, int] = {}
    keys = [contour if name is None else name for contour, name in enumerate(names)]
    return tuple(numbers.setdefault(key, len(numbers)) for key in keys)


def _precedence(value: Any, names: list[str]) -> tuple[Pair, ...]:
    """Return the pairs in a fixed order, each once."""
    numbers = {name: contour for contour, name in enumerate(names)}
    pairs = set()
    for index, each in enumerate(entries(value, "precedence")):
        pair = entries(each, f"precedence[{index}]", count=2)
        for name in pair:
            require(isinstance(name, str) and name in numbers, f"precedence: no contour {show(name)}")
        pairs.add((numbers[pair[0]], numbers[pair[1]]))
    return tuple(sorted(pairs))


def _matrix(value: Any, count: int) -> tuple[tuple[Fraction, ...], ...]:
    """Return the matrix with the diagonal at 0: to stay costs nothing, whatever the file says."""
    rows = [entries(row, f"matrix[{i}]", count) for i, row in enumerate(entries(value, "matrix", count))]
    return tuple(
        tuple(Fraction(0) if i == j else number(cell, f"matrix[{i}]", least=0) for j, cell in enumerate(row))
        for i, row in enumerate(rows)
    )


def _digest(content: list[Any]) -> str:
    text = "cutgap-problem 3 " + json.dumps(content, default=str)
    return hashlib.sha256(text.encode("ascii")).hexdigest()
