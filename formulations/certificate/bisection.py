r"""A bound on the spread of a division of the contours between two sides, proved by integer vectors.

    {"format": "cutgap-bisection", "version": 1, "instance": hash, "limit": delta, "scale": m, "bound": B,
     "price": p, "factors": [[f_1, ..., f_n], ...]}

    Data    q_ij    squared straight distance of the entry points of contours i and j        [mm^2]
            w_i     work: perimeter / v_cut + t_aux                                          [s]
            delta   largest difference of the work of the two sides                          [s]
    Choose  s in {-1, 1}^n with |sum_i w_i s_i| <= delta
    Claim   (1) spread = sum of q_ij over the pairs i < j on one side >= B / m               [mm^2]

It says nothing about tours, so it is no bound on a plan and has a format of its own. With the matrix Q of the
q_ij,

    (2) 4 m spread = m sum_ij q_ij + m s'Qs
    (3) m s'Qs >= sum_i R_ii - sum_{i != j} |R_ij| - p delta^2,   R = m Q + p w w' - sum f f',   p >= 0

(3): m s'Qs = s'Rs + sum (f's)^2 - p (w's)^2, and s_i s_j is 1 on the diagonal and 1 or -1 elsewhere. So any
integers prove something; good ones make R nearly diagonal. No spread is below 0, whatever they prove. ``null``
for B claims that there is no such s: for m = 0 the left side of (3) is 0, so a right side above 0 shows it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import lcm
from operator import mul
from typing import Any

from cutgap.formulations.certificate.cosines import vector
from cutgap.formulations.certificate.problem import Problem, problem_of
from cutgap.formulations.certificate.reading import (
    entries,
    fields,
    integer,
    number,
    read_document,
    require,
    show,
)

FORMAT = "cutgap-bisection"
MAX_CONTOURS = 300


@dataclass(frozen=True)
class SpreadVerdict:
    """Every division within the ``limit`` (s) has a spread of at least ``bound`` (mm^2); ``None``: none is."""

    limit: Fraction
    bound: Fraction | None


def verify_bisection(
    certificate: str | dict[str, Any], instance_document: str | dict[str, Any]
) -> SpreadVerdict:
    """Check a certificate of spread against an instance document.

    Raises
    ------
    Refused
        Naming what failed; then nothing is proved.
    """
    table = read_document(certificate) if isinstance(certificate, str) else certificate
    require(isinstance(table, dict) and table.get("format") == FORMAT, f"format: not a {FORMAT}")
    table = fields(table, "certificate", "format version instance limit scale bound price factors")
    require(table["version"] == 1, f"version: expected 1, got {show(table['version'])}")
    problem = problem_of(instance_document)
    require(table["instance"] == problem.digest, "instance: the certificate is about another instance")
    scale = integer(table["scale"], "scale", least=1)
    price = integer(table["price"], "price", least=0)
    limit = number(table["limit"], "limit", least=0)
    bound = None if table["bound"] is None else integer(table["bound"], "bound")
    count = len(problem.ids)
    require(count <= MAX_CONTOURS, f"{count} contours are too many, the most is {MAX_CONTOURS}")
    given = entries(table["factors"], "factors")
    require(len(given) <= count, f"factors: expected at most {count}, got {len(given)}")
    factors = [vector(each, count) for each in given]
    total, value = spread_value(problem, limit, scale if bound is not None else 0, price, factors)
    if bound is None:
        require(value > 0, "factors: they do not show that no division keeps the limit")
        return SpreadVerdict(limit, None)
    require(bound <= 0 or 4 * bound <= total + value, "factors: they prove less than the claimed bound")
    return SpreadVerdict(limit, Fraction(bound, scale))


def spread_value(
    problem: Problem, limit: Fraction, scale: int, price: int, factors: Sequence[Sequence[int]]
) -> tuple[Fraction, Fraction]:
    """Return the sum of m q_ij, and the right side of (3), for the scale m."""
    squares = squared_distances(problem)
    unit = problem.denominator**2
    work = problem.seconds
    share = lcm(*{each.denominator for each in work})
    works = [int(each * share) for each in work]
    columns = list(zip(*factors, strict=True)) if factors else [()] * len(works)
    # Everything below is an integer, in units of 1 / (unit * share^2).
    total = value = 0
    for i, row in enumerate(squares):
        for j in range(i + 1):
            entry = scale * row[j] * share**2 + price * works[i] * works[j] * unit
            entry -= sum(map(mul, columns[i], columns[j])) * unit * share**2
            value += entry if i == j else -2 * abs(entry)
            total += 2 * scale * row[j]  # the diagonal is 0
    return Fraction(total, unit), Fraction(value, unit * share**2) - price * limit**2


def squared_distances(problem: Problem) -> list[list[int]]:
    """Return the q_ij in units of 1 / denominator^2."""
    require(problem.metric != "matrix", "bisection: needs coordinates, and the metric is a matrix")
    require(all(len(nodes) == 1 for nodes in problem.entries), "bisection: takes one entry point a contour")
    places = [problem.places[nodes[0]] for nodes in problem.entries]
    return [[sum((a - b) ** 2 for a, b in zip(one, other, strict=True)) for other in places] for one in places]
