r"""Proofs about free entries, by prices of a tour through convex regions in any order (``perspective``).

    regions v = 0 .. n-1, n >= 3: those of the contours, then the head's home; edges u < v in the order
    (0, 1), (0, 2), ..., (1, 2), ...; an edge has an end at each of its regions

    steps       w_e, a vector for each edge, in parts of K = ``multiplier_scale``; |w_e| <= K
    shifts      g_ev, a vector for each end: of all edges at u, then of all edges at v, likewise
    potentials  pi_v, in mm * scale

Let a closed tour touch each region v at one point p_v, and T be its edges. For any such vectors, as |w| <= 1,

    length >= sum over e in T of w_e.(p_u - p_v)
            + sum over all ends (e, v), 0 where e in T and else at most 0, of  g_ev.p_v - h(g_ev)

with h_v(g) a number not below the greatest g.x over R_v. The second sum is the one over all ends, less the ends
in T. Each region has two of these, so with G_v = sum of the g_ev at v

    (1) a_ev = +-w_e + G_v / 2 - g_ev         + at u, - at v
    (2) c_e  = sum over its ends of  (least a_ev.x over R_v) + h_v(g_ev)
    (3) length >= sum over e in T of c_e - sum over all ends of h_v(g_ev)

and the first sum of (3) is at least the bound of 1-trees for the lengths c_e, whatever their signs.
"""

from collections.abc import Sequence
from itertools import combinations
from typing import Any

from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.proof import Budget, one_tree_value
from cutgap.formulations.certificate.reading import entries, fields, integer, require
from cutgap.formulations.certificate.regions import Shape, regions_of


def perspective_length(problem: Problem, proof: Any, scale: int, multiplier_scale: int, budget: Budget) -> int:
    """Return a lower bound on the tour's length in mm * scale, at least 0.

    Raises
    ------
    Refused
        When the proof is about another kind of problem, or a vector w is too long.
    """
    table = fields(proof, "proof", "kind steps shifts potentials")
    require(problem.metric == "euclidean", "perspective: takes the metric euclidean")
    given = regions_of(problem)
    regions = given.shapes
    count = len(regions)
    require(count >= 3, "perspective: needs 3 regions, homes included")
    edges = list(combinations(range(count), 2))
    budget.spend(40 * len(edges) * max(len(region.points) + len(region.axes) for region in regions))
    steps = _vectors(table["steps"], "steps", len(edges))
    shifts = _vectors(table["shifts"], "shifts", 2 * len(edges))
    listed = entries(table["potentials"], "potentials", count=count)
    potentials = [integer(each, "potentials") for each in listed]
    for step in steps:
        require(sum(each * each for each in step) <= multiplier_scale**2, "steps: a vector is longer than 1")
    costs, rests = _prices(regions, edges, steps, shifts, (scale, multiplier_scale * given.unit))

    def lengths(u: int, others: list[int]) -> list[int]:
        return [costs[min(u, v), max(u, v)] for v in others]

    return max(0, one_tree_value(lengths, potentials, [], 1) - rests)


def _prices(
    regions: Sequence[Shape],
    edges: list[tuple[int, int]],
    steps: list[list[int]],
    shifts: list[list[int]],
    units: tuple[int, int],
) -> tuple[dict[tuple[int, int], int], int]:
    """Return c_e of (2), not rounded up, and the last sum of (3), not rounded down."""
    scale, below = units
    ends = [(u, step, 1) for (u, _), step in zip(edges, steps, strict=True)]
    ends += [(v, step, -1) for (_, v), step in zip(edges, steps, strict=True)]
    sums = [[0, 0, 0] for _ in regions]
    for (v, _, _), shift in zip(ends, shifts, strict=True):
        sums[v] = [a + b for a, b in zip(sums[v], shift, strict=True)]
    costs, rests = dict.fromkeys(edges, 0), 0
    for edge, (v, step, sign), shift in zip(edges + edges, ends, shifts, strict=True):
        # Twice a_ev, so that it is whole.
        tilt = [2 * sign * w + total - 2 * g for w, total, g in zip(step, sums[v], shift, strict=True)]
        least = scale * regions[v].least(tilt) // (2 * below)
        most = -(scale * regions[v].least([-g for g in shift]) // below)
        costs[edge] += least + most
        rests += most
    return costs, rests


def _vectors(value: Any, where: str, count: int) -> list[list[int]]:
    rows = [entries(row, where, count=3) for row in entries(value, where, count=count)]
    return [[integer(each, where) for each in row] for row in rows]
