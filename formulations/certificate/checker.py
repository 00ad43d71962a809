"""Verification of a certificate: which problem, which claim, and whether the proof and the plan hold.

    {"format": "cutgap-certificate", "version": 1, "instance": hash, "rules": {...}, "scale": s,
     "multiplier_scale": K, "bound": B, "plan": null | [[[id, entry], ...] per head], "proof": {"kind": ...}}

With free entries a visit of the plan may be [id, entry, [x, y, z]]. With links the plan is an object: {"tours":
as above, "links": [[id, entry, id, entry, passes], ...]}.

The claim: every allowed plan is worth at least B, in units of 1 / (scale * v_jump) s for the makespan, of 1 /
scale deg C for the peak, and of 1 / scale mm for travel and weighted; ``null`` claims that no plan is allowed.
Kinds of proofs: ``tour`` (one head), ``gtsp`` (one head, several entry points), ``contour-dp`` (likewise, with
precedence and process rules), ``heat`` (likewise, with a cap on temperatures or for the peak), ``split`` (two
heads without overlap), ``two-heads`` (any two heads with homes), ``compact`` (any problem, by multipliers of
the rows of a compact model); with free entries ``regions`` and ``perspective`` (one head); with links ``links``
(one head).
"""

from dataclasses import dataclass
from fractions import Fraction
from math import floor
from typing import Any

from cutgap.formulations.certificate.compact import check_compact
from cutgap.formulations.certificate.contour_dp import check_contours
from cutgap.formulations.certificate.generalized import GeneralizedRelaxation
from cutgap.formulations.certificate.heat import check_heat
from cutgap.formulations.certificate.link_plan import linked_plan_value
from cutgap.formulations.certificate.links import check_links
from cutgap.formulations.certificate.perspective import perspective_length
from cutgap.formulations.certificate.plan import plan_value
from cutgap.formulations.certificate.problem import Problem, problem_of
from cutgap.formulations.certificate.proof import MAX_STEPS, Budget, check_tree
from cutgap.formulations.certificate.reading import (
    Refused,
    decimal,
    entries,
    fields,
    integer,
    read_document,
    require,
    show,
)
from cutgap.formulations.certificate.regions import check_regions, regions_of
from cutgap.formulations.certificate.rules import Rules, rules_of
from cutgap.formulations.certificate.split import Cells
from cutgap.formulations.certificate.tours import TourBounds, prove_tour
from cutgap.formulations.certificate.two_heads import TwoHeadsRelaxation

FREE_ENTRIES = ("regions", "perspective")
"""Kinds of proofs for contours that may be entered anywhere in their regions."""
WHOLE = {"links": check_links, "compact": check_compact, "heat": check_heat}
"""Kinds that take claim and proof as they are."""


@dataclass(frozen=True)
class Verdict:
    """What a certificate proves.

    Attributes
    ----------
    rules
        What was asked of a plan.
    bound
        Every allowed plan is worth at least this, in ``unit``; ``None``: no plan is allowed.
    value
        The certificate's plan is allowed and worth at most this; ``None`` without a plan.
    """

    rules: Rules
    bound: Fraction | None
    value: Fraction | None
    unit: str

    @property
    def gap(self) -> Fraction | None:
        """(value - bound) / value."""
        if self.bound is None or self.value is None:
            return None
        return (self.value - self.bound) / self.value if self.value > 0 else Fraction(0)

    @property
    def text(self) -> str:
        """What is proved, in words; figures are rounded to the safe side."""
        if self.bound is None:
            return "infeasible: no plan is allowed"
        proved = f"{self.rules.objective} at least {decimal(self.bound, 9)} {self.unit}"
        if self.value is None or self.gap is None:
            return proved
        within = f"{scientific(self.value - self.bound)} {self.unit}"
        if self.gap <= Fraction(1, 10**6):
            return f"optimal within {within}: {proved}"
        return f"gap {decimal(100 * self.gap, 4, up=True)} %, within {within}: {proved}"


def verify(
    certificate: str | dict[str, Any],
    instance_document: str | dict[str, Any],
    rules: dict[str, Any] | None = None,
    steps: int = MAX_STEPS,
) -> Verdict:
    """Check a certificate against an instance document, from first principles.

    Parameters
    ----------
    certificate, instance_document
        JSON texts or documents.
    rules
        The rules that the certificate must be about; ``None`` takes those it states.
    steps
        Elementary steps after which a proof is refused as too long.

    Raises
    ------
    Refused
        Naming what failed and where; then nothing is proved.
    """
    table = read_document(certificate) if isinstance(certificate, str) else certificate
    names = "format version instance rules scale multiplier_scale bound plan proof"
    is_one = isinstance(table, dict) and table.get("format") == "cutgap-certificate"
    require(is_one, "format: not a cutgap-certificate")
    table = fields(table, "certificate", names)
    require(table["version"] == 1, f"version: expected 1, got {show(table['version'])}")
    problem = problem_of(instance_document)
    require(table["instance"] == problem.digest, "instance: the certificate is about another instance")
    stated = rules_of(table["rules"], problem)
    require(rules is None or rules_of(rules, problem) == stated, "rules: the certificate is about other rules")
    scale = integer(table["scale"], "scale", least=1)
    bound = None if table["bound"] is None else integer(table["bound"], "bound")
    _check_proof(problem, stated, table, scale, bound, Budget(steps))
    unit = {"makespan": "s", "peak": "deg C"}.get(stated.objective, "mm")
    divisor = scale * problem.v_jump if unit == "s" else Fraction(scale)
    proved = None if bound is None else bound / divisor
    valued = linked_plan_value if stated.links else plan_value
    value = None if table["plan"] is None else valued(problem, stated, table["plan"])
    if value is not None:
        require(proved is not None, "plan: one is allowed, though the certificate claims that none is")
        require(value >= (proved or 0), "plan: it is below the proved bound; the proof rules contradict it")
    return Verdict(stated, proved, value, unit)


def _check_proof(
    problem: Problem, rules: Rules, table: dict[str, Any], scale: int, bound: int | None, budget: Budget
) -> None:
    """Refuse unless the proof shows the claim."""
    multiplier_scale = integer(table["multiplier_scale"], "multiplier_scale", least=1)
    proof = table["proof"]
    require(isinstance(proof, dict), "proof: expected an object")
    _require_kind(problem, rules, proof.get("kind"))
    if proof.get("kind") == "gtsp":
        _check_generalized(problem, rules, proof, (scale, multiplier_scale), bound, budget)
    elif proof.get("kind") == "tour":
        table = fields(proof, "proof", "kind tour")
        _check_tour(problem, rules, table["tour"], (scale, multiplier_scale), bound, budget)
    elif proof.get("kind") == "split":
        table = fields(proof, "proof", "kind tours ties")
        proved = []
        for number, tour in enumerate(entries(table["tours"], "tours")):
            try:
                proved.append(prove_tour(problem, rules, tour, scale, multiplier_scale, budget))
            except Refused as error:
                raise Refused(f"tours {number}: {error}") from None
        Cells(problem, rules, TourBounds(problem, proved), bound, scale, budget).check(table["ties"])
    elif proof.get("kind") == "two-heads":
        table = fields(proof, "proof", "kind rows nodes")
        relaxation = TwoHeadsRelaxation(problem, rules, scale, multiplier_scale, costless=bound is None)
        # Without costs a value above 0 contradicts weak duality: there is no solution.
        target = 1 if bound is None else multiplier_scale * relaxation.factor * bound
        check_tree(relaxation, table["rows"], table["nodes"], target, budget)
    elif proof.get("kind") == "regions":
        require(bound is not None, "regions: proves bounds, not that there is no plan")
        check_regions(regions_of(problem), proof, _length_of(problem, rules, scale, bound or 0), budget)
    elif proof.get("kind") == "perspective":
        length = perspective_length(problem, proof, scale, multiplier_scale, budget)
        _check_worth(problem, rules, length, scale, bound)
    elif proof.get("kind") == "contour-dp":
        require(bound is not None, "contour-dp: proves bounds, not that there is no plan")
        work = sum((problem.work(contour, scale) for contour in range(len(problem.ids))), Fraction(0))
        worth = (bound or 0) - (floor(work) if rules.objective == "makespan" else 0)
        check_contours(problem, rules, proof, worth, scale, budget)
    elif isinstance(proof.get("kind"), str) and proof["kind"] in WHOLE:
        WHOLE[proof["kind"]](problem, rules, proof, (scale, multiplier_scale), bound, budget)
    else:
        raise Refused(f"proof: no kind {show(proof.get('kind'))}")


def _require_kind(problem: Problem, rules: Rules, kind: Any) -> None:
    """Refuse kinds that say nothing about the objective, or about rules that allow more plans."""
    # What holds for given entry points says nothing about a plan that chooses its own.
    free = kind in FREE_ENTRIES
    asked = "free" if rules.free_entries else "given"
    require(rules.free_entries == free, f"proof: {show(kind)} is no kind for {asked} entries")
    linked = kind == "links"
    asked = "with" if rules.links else "without"
    require(rules.links == linked, f"proof: {show(kind)} is no kind for rules {asked} links")
    require(rules.objective != "peak" or kind == "heat", f"proof: {show(kind)} is no kind for peaks")
    if kind in ("tour", "split", "two-heads"):
        problem.require_plain(kind)


def _length_of(problem: Problem, rules: Rules, scale: int, bound: int) -> Fraction:
    """Return the length in mm that a tour of the only head must have to be worth the claim."""
    work = sum((problem.work(contour, scale) for contour in range(len(problem.ids))), Fraction(0))
    return (bound - (work if rules.objective == "makespan" else 0)) / Fraction(scale)


def _check_tour(
    problem: Problem, rules: Rules, tour: Any, scales: tuple[int, int], bound: int | None, budget: Budget
) -> None:
    """One head: all contours, so its tour length decides; the work is a constant."""
    require(len(problem.homes) == 1, "tour: needs one head")
    proved = prove_tour(problem, rules, tour, *scales, budget)
    require(proved.contours == (1 << len(problem.ids)) - 1, "tour: it leaves contours out")
    _check_worth(problem, rules, proved.length, scales[0], bound)


def _check_worth(problem: Problem, rules: Rules, length: int, scale: int, bound: int | None) -> None:
    """Refuse unless a tour length of the only head is worth the claim."""
    worth = Fraction(length)
    if rules.objective == "makespan":
        worth += sum((problem.work(contour, scale) for contour in range(len(problem.ids))), Fraction(0))
    require(bound is not None and worth >= bound, "the tour length proves less than the claimed bound")


def _check_generalized(
    problem: Problem, rules: Rules, proof: Any, scales: tuple[int, int], bound: int | None, budget: Budget
) -> None:
    """One head, one entry point of each contour; every tour's length is a multiple of ``step``."""
    table = fields(proof, "proof", "kind length", "rows nodes")
    length = integer(table["length"], "length")
    require(len(problem.homes) == 1, "gtsp: needs one head")
    # Precedence and process rules only forbid tours or add to their value, so the bound holds with them too.
    require(problem.is_symmetric(), "gtsp: takes symmetric lengths")
    if "rows" in table or "nodes" in table:
        budget.spend(10 * len(problem.places) ** 2)
        relaxation = GeneralizedRelaxation(problem, *scales)
        # The multiple of step below the length: what costs more costs the length.
        below = (length - 1) // relaxation.step * relaxation.step
        target = scales[1] * below + 1
        check_tree(relaxation, table.get("rows"), table.get("nodes"), target, budget)
    else:
        require(length <= 0, "a length above 0 needs rows and nodes")
    _check_worth(problem, rules, length, scales[0], bound)


def scientific(value: Fraction) -> str:
    """Return a value of at least 0 with one digit, rounded up, such as 2e-06."""
    if value == 0:
        return "0"
    exponent = 0
    while value * 10 ** max(0, -exponent) < 10 ** max(0, exponent):
        exponent -= 1
    while value > 9 * Fraction(10) ** exponent:
        exponent += 1
    digit = -(-value / Fraction(10) ** exponent).__floor__()
    return f"{digit}e{exponent}"
