r"""Proved tour lengths: L_a(C) >= length for one head a and one set C of contours, and the sets this holds for.

    nodes   the head's home (if any), then the contours as listed
    proof   rows and nodes (``proof``) of the relaxation that "model" names, edges (``TourRelaxation``) or
            distances (``DistancesRelaxation``), or one_tree, or nothing up to 3 nodes, whose only tour is
            summed up

A proof *uses via points* if the rules ask for them, the head has a home (a closed tour can start anywhere), the
contours of C differ in x (else each is a leftmost one) and it does not set "via" to false. One that does not
use them holds with and without via points.

(1) Supersets: let no detour be shorter than the direct way, and C within S. A shortest allowed tour of S, with
    the contours outside C skipped, is a tour of C and no longer. If the proof for C uses no via points, so
    L_a(S) >= length. If it does, the skipping must keep the first contour, a leftmost one of S, since otherwise
    the rest may begin with any contour of C: so (1) then asks that *every leftmost contour of S is in C*. The
    first contour is then in C, and a leftmost one of C.
"""

from dataclasses import dataclass
from typing import Any

from cutgap.formulations.certificate.distances import DistancesRelaxation
from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.proof import Budget, check_tree, one_tree_value
from cutgap.formulations.certificate.reading import Refused, entries, fields, flag, integer, require, show
from cutgap.formulations.certificate.relaxation import TourRelaxation
from cutgap.formulations.certificate.rules import Rules


@dataclass(frozen=True)
class ProvedTour:
    """L_head(contours) >= length / scale; sets are bit masks of contour numbers."""

    head: int
    contours: int
    length: int
    via: bool


def bit_mask(contours: list[int]) -> int:
    """Return the set of contours as bits."""
    return sum(1 << contour for contour in set(contours))


def leftmost(problem: Problem, contours: list[int]) -> list[int]:
    """Return the contours of smallest x."""
    least = min((problem.xs[contour] for contour in contours), default=None)
    return [contour for contour in contours if problem.xs[contour] == least]


def tour_relaxation(
    problem: Problem,
    head: int,
    contours: list[int],
    via: bool,
    scale: int,
    multiplier_scale: int,
    model: Any = "edges",
) -> TourRelaxation | DistancesRelaxation:
    """Return the relaxation of a head's tours of contours; ``via`` if the first one is a leftmost one."""
    nodes, firsts = tour_nodes(problem, head, contours, via)
    if model == "edges":
        return TourRelaxation(problem, nodes, firsts, scale, multiplier_scale)
    if model == "distances":
        return DistancesRelaxation(problem, nodes, firsts, scale, multiplier_scale)
    raise Refused(f"model: no {show(model)}")


def tour_nodes(problem: Problem, head: int, contours: list[int], via: bool) -> tuple[list[int], list[int]]:
    """Return the nodes of a tour, and which of them may come first if that is asked."""
    home = problem.homes[head]
    nodes = contours if home is None else [home, *contours]
    least = leftmost(problem, contours)
    firsts = [place for place, contour in enumerate(contours, 1) if contour in least] if via else []
    return nodes, firsts


def prove_tour(
    problem: Problem, rules: Rules, value: Any, scale: int, multiplier_scale: int, budget: Budget
) -> ProvedTour:
    """Check the proof of one tour length."""
    table = fields(value, "tour", "head contours length", "via rows nodes one_tree model")
    head, length = integer(table["head"], "head", least=0), integer(table["length"], "length")
    require(head < len(problem.homes), f"head {show(head)}: there is none")
    numbers = {name: number for number, name in enumerate(problem.ids)}
    names = entries(table["contours"], "contours")
    for name in names:
        require(isinstance(name, str) and name in numbers, f"contours: no contour {show(name)}")
    contours = [numbers[name] for name in names]
    require(len(set(contours)) == len(contours), "contours: one is listed twice")
    asked = rules.via_points and problem.homes[head] is not None
    via = flag(table.get("via", asked), "via")
    require(asked or not via, "via: the rules ask for no via points here")
    nodes, firsts = tour_nodes(problem, head, contours, via)
    target = multiplier_scale * length
    require("model" not in table or "rows" in table, "model: goes with rows and nodes")
    if "one_tree" in table:
        _one_tree(problem, table, nodes, firsts, scale, multiplier_scale, budget)
    elif "rows" in table or "nodes" in table:
        budget.spend(10 * len(nodes) ** 2)
        model = table.get("model", "edges")
        relaxation = tour_relaxation(problem, head, contours, via, scale, multiplier_scale, model)
        check_tree(relaxation, table.get("rows"), table.get("nodes"), target, budget)
    else:
        require(len(nodes) <= 3, f"a tour of {len(nodes)} nodes needs rows and nodes, or one_tree")
        legs = zip(nodes, nodes[1:] + nodes[:1], strict=True)
        proved = sum(problem.lengths(u, [v], scale)[0] for u, v in legs)
        require(proved >= length, f"the tour has length {show(proved)}, not {show(length)}")
    differ = len(leftmost(problem, contours)) < len(contours)
    return ProvedTour(head, bit_mask(contours), length, via and differ)


def _one_tree(
    problem: Problem,
    table: dict[str, Any],
    nodes: list[int],
    firsts: list[int],
    scale: int,
    multiplier_scale: int,
    budget: Budget,
) -> None:
    require(
        "rows" not in table and "nodes" not in table, "one_tree: stands for rows and nodes, not beside them"
    )
    require(len(nodes) >= 4, "one_tree: needs 4 nodes or more")
    given = fields(table["one_tree"], "one_tree", "potentials")["potentials"]
    potentials = [integer(each, "potentials") for each in entries(given, "potentials", count=len(nodes))]
    budget.spend(20 * len(nodes) ** 2)

    def lengths(u: int, others: list[int]) -> list[int]:
        return problem.lengths(nodes[u], [nodes[v] for v in others], scale)

    value = one_tree_value(lengths, potentials, firsts, multiplier_scale)
    target = multiplier_scale * table["length"]
    require(value >= target, "one_tree: its value is below the length")


class TourBounds:
    """The best proved length for any set of a head."""

    def __init__(self, problem: Problem, proved: list[ProvedTour]) -> None:
        self.problem = problem
        self.metric = problem.is_metric()
        self.of_head = [[tour for tour in proved if tour.head == head] for head in range(len(problem.homes))]

    def length(self, head: int, contours: list[int], floating: list[int]) -> int:
        """Return a lower bound for every set of ``contours`` and any of ``floating``, by (1); 0 at least."""
        least = leftmost(self.problem, contours)
        # Floating contours beside or left of all others would change which ones are leftmost.
        keeps = all(self.problem.xs[each] > self.problem.xs[first] for first in least[:1] for each in floating)
        members, first_ones = bit_mask(contours), bit_mask(least)
        best = 0
        for tour in self.of_head[head]:
            same = tour.contours == members and not floating
            within = tour.contours & members == tour.contours
            kept = not tour.via or (keeps and first_ones & tour.contours == first_ones)
            if tour.length > best and (same or (self.metric and within and kept)):
                best = tour.length
        return best
