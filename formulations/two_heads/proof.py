"""What a threshold search proved, as a certificate: tour lengths of sides, and how ties are divided."""

from typing import TYPE_CHECKING, Any

import numpy as np

from cutgap.formulations.certify import SCALE, TOUR_MULTIPLIER_SCALE, Certificate, certificate_of, side_proof
from cutgap.instances import Result, Status

if TYPE_CHECKING:
    from cutgap.formulations.two_heads.split import SplitSearch


def split_certificate(search: "SplitSearch", result: Result) -> Certificate | None:
    """Return a verified certificate of a search's result; ``None`` when it proved nothing."""
    if result.lower_bound is None and result.status is not Status.INFEASIBLE:
        return None
    instance, rules = search.instance, search.rules
    unit = instance.machine.v_jump if rules.objective == "makespan" else 1.0
    ids = [contour.id for contour in instance.contours]

    def claim(margin: float) -> tuple[int | None, dict[str, Any]]:
        tours = [
            side_proof(head, side, ids, margin, TOUR_MULTIPLIER_SCALE)
            for head, sides in enumerate(search.sides)
            for _, side in sides.proved()
        ]
        if search.free_right is not search.sides[1]:
            tours += [
                side_proof(1, side, ids, margin, TOUR_MULTIPLIER_SCALE) | {"via": False}
                for _, side in search.free_right.proved()
            ]
        bound, least = None, -np.inf
        if result.lower_bound is not None:
            bound = max(0, int(np.floor((result.lower_bound * unit - 3 * margin) * SCALE)))
            least = result.lower_bound - margin / unit
        ties = [_tie_tree(search, *cell, least) for cell in search.first_cells() if cell[2]]
        return bound, {"kind": "split", "tours": tours, "ties": ties}

    return certificate_of(instance, rules, result.plan, TOUR_MULTIPLIER_SCALE, claim)


def _tie_tree(
    search: "SplitSearch", left: int, right: int, free: tuple[int, ...], least: float
) -> list[dict[str, Any]]:
    """Return a tree of divisions of a group of equal x whose leaves have the bound ``least``."""
    nodes: list[dict[str, Any]] = []
    waiting: list[tuple[int, int, tuple[int, ...], dict[str, Any], str]] = [(left, right, free, {}, "")]
    for one, two, rest, parent, key in waiting:
        parent[key] = len(nodes)
        if not rest or (search.metric and search.bound(one, two, rest) >= least):
            nodes.append({"leaf": True})
            continue
        bit = 1 << rest[0]
        nodes.append({"branch": search.instance.contours[rest[0]].id})
        waiting.append((one | bit, two, rest[1:], nodes[-1], "left"))
        waiting.append((one, two | bit, rest[1:], nodes[-1], "right"))
    return nodes
