"""From what a search remembers to a certificate: multipliers become integers, its tree a flat list.

The certificate's claims lie a margin below the search's floating-point bounds; it is verified before anyone
sees it, with wider margins until it holds.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from fractions import Fraction
from typing import Any

import numpy as np

from cutgap.formulations.branch_and_cut.engine import Node, Outcome
from cutgap.formulations.branch_and_cut.model import Fixing, Proof
from cutgap.formulations.branch_and_cut.separation import Cut
from cutgap.formulations.certificate import Refused, instance_hash, verify
from cutgap.formulations.certificate.proof import MAX_STEPS
from cutgap.formulations.sides import Side
from cutgap.instances import Instance, Plan, Rules
from cutgap.instances.formats.json_format import format_instance

SCALE = 10**9
"""Integer lengths are in units of 1 / SCALE mm."""

MARGINS_MM = (1e-6, 1e-5, 1e-4, 1e-3)
"""How far below the floating-point bound a certificate's claim may lie."""

CERTIFIED_PRECISION = 1e-6
"""Relative difference of a bound and what its certificate proves that comes from ``MARGINS_MM``."""

TOUR_MULTIPLIER_SCALE = 2**6
"""Multipliers of tours are rounded to this part of a length unit, which is small already."""

MULTIPLIERS_UNUSED = 1
"""Multiplier scale of proofs that have no rows."""

RAY_SURPLUS_MM = 1e6
"""A ray of value 1 is taken so often that no bound of a parent, however bad, keeps a leaf below the target."""

Certificate = dict[str, Any]
Family = tuple[Any, float]
"""A row's name in a certificate, and the factor from its floating-point multiplier to the integer one."""


def certificate_of(
    instance: Instance,
    rules: Rules,
    plan: Plan | None,
    multiplier_scale: int,
    claim: Callable[[float], tuple[int | None, dict[str, Any]]],
    scale: int = SCALE,
    margins: Sequence[float] = MARGINS_MM,
    steps: int = MAX_STEPS,
) -> Certificate | None:
    """Return a verified certificate, or ``None`` when none of the margins holds.

    Parameters
    ----------
    claim
        Takes a margin in mm and returns the integer bound and the proof.
    steps
        Most elementary steps of a verification.
    """
    document = format_instance(instance)
    visits: Any = None
    if plan is not None:
        ids = [contour.id for contour in instance.contours]
        visits = [[[ids[c], e] if p is None else [ids[c], e, [*p]] for c, e, p in tour] for tour in plan.tours]
        if rules.links:
            links = [[ids[a], e, ids[b], f, passes] for a, e, b, f, passes in plan.links]
            visits = {"tours": visits, "links": links}
    for margin in margins:
        bound, proof = claim(margin)
        certificate = {
            "format": "cutgap-certificate",
            "version": 1,
            "instance": instance_hash(document),
            "rules": asdict(rules),
            "scale": scale,
            "multiplier_scale": multiplier_scale,
            "bound": bound,
            "plan": visits,
            "proof": proof,
        }
        try:
            verify(certificate, document, steps=steps)
        except Refused:
            continue
        return certificate
    return None


def proved_bound(certificate: Certificate, instance: Instance) -> float | None:
    """Return the bound that a certificate claims, in the objective's unit; ``None``: no plan is allowed.

    It may be less than the bound of the result that carries it: few kinds of proofs take account of a cap.
    """
    if certificate["bound"] is None:
        return None
    unit = instance.machine.v_jump if certificate["rules"]["objective"] == "makespan" else 1.0
    return float(certificate["bound"] / certificate["scale"] / unit)


def proves(proved: float | None, lower_bound: float | None) -> bool:
    """Whether what a certificate proves is the bound, but for rounding and the margins."""
    if proved is None or lower_bound is None:
        return proved is lower_bound
    return proved >= lower_bound - CERTIFIED_PRECISION * max(1.0, abs(lower_bound))


class Rows:
    """The rows that a proof names, each once, in order of appearance."""

    def __init__(self, family: Callable[[Any], Family]) -> None:
        self.family = family
        self.names: list[Any] = []
        self._index: dict[Any, tuple[int, float]] = {}

    def multipliers(self, proof: Proof) -> list[list[int]]:
        """Return pairs of row and integer multiplier; inequalities' ones are rounded down."""
        pairs = []
        for name, value in proof:
            if name not in self._index:
                row, factor = self.family(name)
                self._index[name] = len(self.names), factor
                self.names.append(row)
            index, factor = self._index[name]
            integer = int(np.floor(value * factor))
            if integer != 0:
                pairs.append([index, integer])
        return pairs


def flat_tree(
    root: Node,
    fixes: Sequence[Proof],
    rows: Rows,
    variable: Callable[[Fixing], Any],
    target: float | None,
) -> list[dict[str, Any]]:
    """Return the search tree as a certificate's list of nodes, fixings at the root first."""
    nodes: list[dict[str, Any]] = []
    for number, proof in enumerate(fixes):
        nodes.append({"fix": rows.multipliers(proof), "then": number + 1})
    waiting: list[tuple[Node, dict[str, Any], str]] = [(root, {}, "root")]
    for node, parent, side in waiting:
        parent[side] = len(nodes)
        if node.children:
            fixing = node.children[0].fixings[-1]
            nodes.append({"branch": variable(fixing), "at": int(fixing.upper), "down": -1, "up": -1})
            waiting += [
                (child, nodes[-1], key) for child, key in zip(node.children, ("down", "up"), strict=True)
            ]
        else:
            nodes.append({"leaf": rows.multipliers(leaf_proof(node, target))})
    return nodes


def leaf_proof(node: Node, target: float | None) -> Proof:
    """Return multipliers that show a leaf's bound to reach the target, in mm.

    Without a target the ray alone counts. With one, as much of the ray is added to the parent's proof as the
    target asks for.
    """
    if not node.ray or target is None:
        return node.ray if target is None else node.proof
    total = dict(node.proof)
    for name, multiplier in node.ray:
        total[name] = total.get(name, 0.0) + multiplier * (2.0 * abs(target) + RAY_SURPLUS_MM)
    return tuple(total.items())


def tour_family(multiplier_scale: int) -> Callable[[Any], Family]:
    """Name the rows of the tour model."""

    def family(name: Any) -> Family:
        factor = float(SCALE * multiplier_scale)
        if isinstance(name, Cut):
            return ["cut", [sorted(members) for members in name.sets]], factor
        return list(name), factor

    return family


def tour_tree(outcome: Outcome, nodes: int, multiplier_scale: int) -> dict[str, Any]:
    """Return ``rows`` and ``nodes`` of a tour's proof."""
    assert outcome.root is not None
    rows = Rows(tour_family(multiplier_scale))

    def variable(fixing: Fixing) -> list[Any]:
        return ["x", *divmod(fixing.variable, nodes)]

    tree = flat_tree(outcome.root, outcome.fixes, rows, variable, outcome.lower_bound)
    return {"rows": rows.names, "nodes": tree}


def side_proof(head: int, side: Side, ids: Sequence[str], margin: float, multiplier_scale: int) -> Certificate:
    """Return the proof of a tour length of one side: a tree, else a 1-tree; nothing up to 3 nodes."""
    proof: Certificate = {"head": head, "contours": [ids[contour] for contour in side.contours]}
    if side.nodes <= 3:
        return proof | {"length": _floor(side.own_lower - margin)}
    if side.search is not None and side.search.lower_bound == side.own_lower:
        length = _floor(side.search.lower_bound - margin)
        return proof | {"length": length} | tour_tree(side.search, side.nodes, multiplier_scale)
    assert side.one_tree is not None
    bound, potentials = side.one_tree
    integers = [round(float(each) * SCALE * multiplier_scale) for each in potentials]
    return proof | {"length": _floor(bound - margin), "one_tree": {"potentials": integers}}


def _floor(length: float) -> int:
    """Return a length in mm as integer units."""
    return max(0, int(np.floor(length * SCALE)))


def two_heads_family(instance: Instance, rules: Rules, multiplier_scale: int) -> Callable[[Any], Family]:
    """Name the rows of the model of two heads."""
    factor = float(multiplier_scale * price_denominator(instance, rules))

    def family(name: Any) -> Family:
        if isinstance(name, Cut):
            return ["comb", [sorted(members) for members in name.sets]], factor * SCALE
        if name[0] == "connect":
            return [*name[:3], [sorted(name[3])]], factor * SCALE
        if name[0] in ("makespan", "imbalance", "balance"):
            # Their lengths are integers already; the multipliers of the first two must not add up beyond 1.
            return list(name), factor * (1.0 - 1e-11)
        return list(name), factor * SCALE

    return family


def price_denominator(instance: Instance, rules: Rules) -> int:
    """Return q of weight / v_jump = p / q in lowest terms: two-head costs are multiplied by it."""
    return (Fraction(repr(rules.weight)) / Fraction(repr(instance.machine.v_jump))).denominator
