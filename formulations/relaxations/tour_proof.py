"""From a relaxation of one tour, solved in floating point, to a proved integer length.

The multipliers become integers, and the length is what the checker's own arithmetic says that these prove: no
tolerance of a solver can make it too large.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from cutgap.formulations.certificate import Problem, Row, leaf_value, one_tree_value, tour_relaxation
from cutgap.formulations.certificate.tours import ProvedTour, bit_mask, leftmost, tour_nodes
from cutgap.formulations.certify import SCALE
from cutgap.formulations.relaxations.bound import Size
from cutgap.instances.arrays import Floats, Ints

MULTIPLIER_SCALE = 2**70
"""Rows of integer vectors have coefficients up to 1e18, so their multipliers are small and need many digits."""

Table = dict[str, Any]


@dataclass(frozen=True, slots=True)
class TourProof:
    """What a relaxation says about one tour of four nodes or more.

    Attributes
    ----------
    value
        The relaxation's value as the solver gives it, mm.
    rows
        Names of rows of ``model`` as certificates have them, each with its multiplier in mm.
    model
        ``edges`` or ``distances``, see ``certificate.tours``.
    potentials
        Of a 1-tree, mm; then there are no rows.
    """

    value: float
    size: Size
    rows: tuple[tuple[list[Any], float], ...] = ()
    model: str = "edges"
    potentials: Floats | None = None


TourRelaxation = Callable[[Floats, Ints], TourProof]
"""Takes lengths, shape (n, n), mm, symmetric, n >= 4, and the nodes of which one comes next to node 0, or none.

Raises ``ValueError`` when there are more nodes than it can take.
"""


def prove(
    problem: Problem, head: int, contours: list[int], via: bool, proof: TourProof | None
) -> tuple[ProvedTour, Table]:
    """Return the length that a proof shows for a head's tours of contours, and the certificate's tour.

    Parameters
    ----------
    via
        Whether the tours are those that begin with a leftmost contour; needs a home.
    proof
        ``None`` for tours of up to three nodes, which have one length.
    """
    nodes, firsts = tour_nodes(problem, head, contours, via)
    table: Table = {"head": head, "contours": [problem.ids[contour] for contour in contours], "via": via}
    if proof is None:
        length = sum(problem.lengths(u, [v], SCALE)[0] for u, v in pairwise([*nodes, *nodes[:1]]))
    elif proof.potentials is not None:
        potentials = [round(float(each) * SCALE * MULTIPLIER_SCALE) for each in proof.potentials]
        table["one_tree"] = {"potentials": potentials}

        def lengths(u: int, others: list[int]) -> list[int]:
            return problem.lengths(nodes[u], [nodes[v] for v in others], SCALE)

        length = one_tree_value(lengths, potentials, firsts, MULTIPLIER_SCALE) // MULTIPLIER_SCALE
    else:
        relaxation = tour_relaxation(problem, head, contours, via, SCALE, MULTIPLIER_SCALE, proof.model)
        pairs: list[tuple[Row, int]] = []
        table |= {"rows": [], "nodes": [{"leaf": []}], "model": proof.model}
        for name, multiplier in proof.rows:
            whole = int(np.floor(multiplier * SCALE * MULTIPLIER_SCALE))
            row = relaxation.row(name)
            if whole > 0 or (whole < 0 and row.equality):
                table["nodes"][0]["leaf"].append([len(pairs), whole])
                table["rows"].append(name)
                pairs.append((row, whole))
        length = leaf_value(relaxation, relaxation.start, pairs)[0] // MULTIPLIER_SCALE
    table["length"] = length = max(0, length)
    if length == 0 and proof is not None:
        # Lengths are not negative, whatever the multipliers say.
        table |= {"rows": [], "nodes": [{"leaf": []}], "model": "edges"}
        table.pop("one_tree", None)
    differ = len(leftmost(problem, contours)) < len(contours)
    return ProvedTour(head, bit_mask(contours), length, via and differ), table
