"""The exact problem: the numbers of an instance file as fractions, rapid lengths and work as integers.

    d_uv     rapid length between two nodes                                   [mm]
    (1) l_uv = floor(scale * d_uv)                                            [mm / scale]
    (2) w_i  = scale * v_jump * (perimeter_i / v_cut + t_aux)                 [mm / scale]
    (3) scale * v_jump * T_a = sum of scale * d_uv + sum of w_i >= sum of l_uv + sum of w_i

Coordinates are integers over one common denominator, so a Euclidean l_uv is an integer square root. Nodes are
numbered as in the library: the contours in order of the file, then the homes of the heads that have one.
"""

import hashlib
import json
from dataclasses import dataclass
from fractions import Fraction
from math import gcd, isqrt, lcm
from operator import add
from typing import Any

from cutgap.formulations.certificate.reading import (
    Refused,
    entries,
    fields,
    flag,
    number,
    read_document,
    require,
    text_of,
)

MAX_CONTOURS = 10_000


@dataclass(frozen=True)
class Problem:
    """What a proof is about.

    Attributes
    ----------
    homes
        Node of each head's home; ``None`` where its tour is closed.
    xs
        Place of each contour along x, mm.
    seconds
        perimeter / v_cut + t_aux of each contour, s.
    denominator, places
        ``places[node]`` holds integers: x, y, z, or the node's row of the matrix, in mm * denominator.
    """

    digest: str
    ids: tuple[str, ...]
    homes: tuple[int | None, ...]
    xs: tuple[Fraction, ...]
    seconds: tuple[Fraction, ...]
    v_jump: Fraction
    metric: str
    denominator: int
    places: tuple[tuple[int, ...], ...]
    located: bool

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
        return all(
            length <= min(map(add, row, other))
            for row in self.places
            for other, length in zip(self.places, row, strict=True)
        )


def instance_hash(document: str | dict[str, Any]) -> str:
    """Return the hash of an instance document: equal problems, equal hash, whatever the layout of the file."""
    return problem_of(document).digest


def problem_of(document: str | dict[str, Any]) -> Problem:
    """Return the exact problem of an instance document; refuses what no proof is known for."""
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
    _refuse_unknown_proofs(table, contours, heads)
    points = [point for _, point, _ in contours] + [home for _, home in heads if home is not None]
    located = flag(table.get("located", True), "located")
    require(located or metric == "matrix", "located: without coordinates the metric must be matrix")
    matrix = _matrix(table.get("matrix"), len(points)) if metric == "matrix" else None
    require(matrix is not None or table.get("matrix") is None, "matrix: given, but the metric is another")
    rows = points if matrix is None else matrix
    denominator = lcm(*{value.denominator for row in rows for value in row})
    places = tuple(tuple(int(value * denominator) for value in row) for row in rows)
    has_home = [home is not None for _, home in heads]
    homes = [len(contours) + sum(has_home[:head]) if has_home[head] else None for head in range(len(heads))]
    return Problem(
        digest=_digest([speeds, metric, heads, contours, matrix, located]),
        ids=tuple(name for name, _, _ in contours),
        homes=tuple(homes),
        xs=tuple(point[0] for _, point, _ in contours),
        seconds=tuple(perimeter / speeds[1] + speeds[2] for _, _, perimeter in contours),
        v_jump=speeds[0],
        metric=metric,
        denominator=denominator,
        places=places,
        located=located,
    )


def _contour(value: Any, index: int) -> tuple[str, tuple[Fraction, ...], Fraction]:
    where = f"contours[{index}]"
    table = fields(value, where, "id entry_points perimeter", "part ring geometry")
    points = entries(table["entry_points"], f"{where}.entry_points")
    require(len(points) == 1, f"{where}: proofs for several entry points are not known")
    perimeter = number(table["perimeter"], f"{where}.perimeter", least=0)
    return text_of(table["id"], f"{where}.id"), _point(points[0], f"{where}.entry_points[0]"), perimeter


def _head(value: Any, index: int) -> tuple[str, tuple[Fraction, ...] | None]:
    table = fields(value, f"heads[{index}]", "id", "home")
    home = table.get("home")
    return text_of(table["id"], f"heads[{index}].id"), None if home is None else _point(
        home, f"heads[{index}].home"
    )


def _point(value: Any, where: str) -> tuple[Fraction, ...]:
    return tuple(number(each, where) for each in entries(value, where, count=3))


def _refuse_unknown_proofs(table: dict[str, Any], contours: list[Any], heads: list[Any]) -> None:
    require(len(heads) in (1, 2), f"heads: proofs are known for one and two, not for {len(heads)}")
    require(len(contours) <= MAX_CONTOURS, f"contours: more than {MAX_CONTOURS}")
    require(not table.get("precedence"), "precedence: proofs with precedence are not known")
    for kind, names in (("contour", [each[0] for each in contours]), ("head", [each[0] for each in heads])):
        require(len(set(names)) == len(names), f"two of the {kind}s have one id")


def _matrix(value: Any, count: int) -> tuple[tuple[Fraction, ...], ...]:
    """Return the matrix with the diagonal at 0: to stay costs nothing, whatever the file says."""
    rows = [entries(row, f"matrix[{i}]", count) for i, row in enumerate(entries(value, "matrix", count))]
    exact = tuple(
        tuple(Fraction(0) if i == j else number(cell, f"matrix[{i}]", least=0) for j, cell in enumerate(row))
        for i, row in enumerate(rows)
    )
    if any(row != column for row, column in zip(exact, zip(*exact, strict=True), strict=True)):
        raise Refused("matrix: proofs for asymmetric lengths are not known")
    return exact


def _digest(content: list[Any]) -> str:
    text = "cutgap-problem 1 " + json.dumps(content, default=str)
    return hashlib.sha256(text.encode("ascii")).hexdigest()


@dataclass(frozen=True)
class Rules:
    """What is asked of a plan; fields as in the library's ``Rules``.

    The last four, the process rules, are optional in a document. They only forbid plans or add to their
    value, so proofs may leave them out of account.
    """

    objective: str
    weight: Fraction
    non_overlap: Fraction | None
    balance: Fraction | None
    via_points: bool
    empty_heads: bool
    parts_in_one_go: bool
    neighbours_only: bool
    clear_rapids: bool
    backward_price: Fraction


def rules_of(value: Any, problem: Problem) -> Rules:
    """Return the rules of a certificate."""
    table = fields(
        value,
        "rules",
        "objective weight non_overlap balance via_points empty_heads",
        "parts_in_one_go neighbours_only clear_rapids backward_price",
    )
    limits = {
        name: None if table[name] is None else number(table[name], f"rules.{name}", least=0)
        for name in ("non_overlap", "balance")
    }
    rules = Rules(
        objective=text_of(table["objective"], "rules.objective"),
        weight=number(table["weight"], "rules.weight", least=0),
        via_points=flag(table["via_points"], "rules.via_points"),
        empty_heads=flag(table["empty_heads"], "rules.empty_heads"),
        parts_in_one_go=flag(table.get("parts_in_one_go", False), "rules.parts_in_one_go"),
        neighbours_only=flag(table.get("neighbours_only", False), "rules.neighbours_only"),
        clear_rapids=flag(table.get("clear_rapids", False), "rules.clear_rapids"),
        backward_price=number(table.get("backward_price", 0), "rules.backward_price", least=0),
        **limits,
    )
    require(rules.objective in ("makespan", "travel", "weighted"), "rules.objective: not known")
    require(
        rules.weight == 0 or rules.objective == "weighted", "rules.weight: goes with the objective weighted"
    )
    speaks_of_x = rules.via_points or (rules.non_overlap is not None and len(problem.homes) > 1)
    require(problem.located or not speaks_of_x, "rules: they speak of x, and the points carry no coordinates")
    return rules


def may_rest(problem: Problem, rules: Rules) -> bool:
    """Whether a head may stay without work."""
    return rules.empty_heads or len(problem.ids) < len(problem.homes)
