"""Certificates from the multipliers of a compact model's rows, as a solver of its relaxation returns them.

With m_i the multipliers in the model's units (mm and s), s the scale of lengths, K that of multipliers and
weight / v_jump = p / q as in ``certificate.compact.value``, integers stand for

    (1) m_i s q K               travel and weighted;   m_i s v_jump K       makespan       for most rows
    (2) m_i q K / v_jump                               m_i K                makespan       for rows of times

since rows of times are in units of 1 / (s v_jump) s there. Any integers prove something: inequalities' ones
are cut off at 0 and rounded down, and those of (2) that price the makespan or the imbalance are first scaled so
that they add up to no more than its cost. What the integers prove is computed exactly, and is the claim.
"""

from collections.abc import Mapping
from dataclasses import asdict
from fractions import Fraction
from math import floor, isfinite
from time import perf_counter
from typing import Any

from cutgap.formulations.certificate import CompactRows, compact_value, problem_of, rules_of
from cutgap.formulations.certificate.proof import Budget
from cutgap.formulations.certify import SCALE, Certificate, certificate_of
from cutgap.formulations.compact import compact_model
from cutgap.formulations.relaxations.bound import RelaxationBound, float_below
from cutgap.formulations.scope import require_no_peak
from cutgap.instances import Instance, Plan, Rules
from cutgap.instances.formats.json_format import format_instance

MULTIPLIER_SCALE = 2**40
"""Fine enough for multipliers of rows of times, which are at most about 1."""

PRICED = ("makespan", "imbalance")
"""Families of (2) whose multipliers add up to no more than a cost; ``balance`` is the third of (2)."""

CLOCK = ("clock", "clock-first", "late", "late-clear")
"""Families that are in models but in no certificate; without them the bound is only weaker."""

RowName = tuple[Any, ...]


def certified_bound(
    instance: Instance,
    rules: Rules,
    formulation: str,
    multipliers: Mapping[RowName, float],
    plan: Plan | None = None,
) -> tuple[float, Certificate]:
    """Return what multipliers prove, with a verified certificate.

    Parameters
    ----------
    multipliers
        By name of the row (docs/formulations.md), sets as tuples; mm, or s for the makespan, per unit of the
        row. The better they are, the more is proved; it may be no more than 0.
    plan
        An allowed plan for the certificate; left out where the checker does not value it.

    Returns
    -------
    tuple
        The bound in the rules' unit, rounded down, and the certificate.

    Raises
    ------
    ValueError
        For a row that the model has not, or an instance for which no certificates are known.
    """
    if not all(map(isfinite, multipliers.values())):
        name = next(name for name, value in multipliers.items() if not isfinite(value))
        raise ValueError(f"multipliers, row {name}: expected a finite number, got {multipliers[name]}")
    problem = problem_of(format_instance(instance))
    exact = rules_of(asdict(rules), problem)
    rows = CompactRows(problem, exact, formulation, SCALE, Budget())
    kept = {name: value for name, value in multipliers.items() if name[0] not in CLOCK}
    pairs = _integers(rows, kept)
    bound = compact_value(problem, exact, formulation, pairs, SCALE, MULTIPLIER_SCALE)
    if bound < 0:
        bound, pairs = 0, []
    proof = {"kind": "compact", "formulation": formulation, "multipliers": pairs}
    certificate = None
    for shown in (plan, None):
        if certificate is None:
            certificate = certificate_of(instance, rules, shown, MULTIPLIER_SCALE, lambda _: (bound, proof))
    assert certificate is not None, "the checker values the same multipliers"
    unit = SCALE * problem.v_jump if rules.objective == "makespan" else Fraction(SCALE)
    return float_below(bound / unit), certificate


def linear_bound(
    instance: Instance, rules: Rules, *, formulation: str, time_limit: float | None = None
) -> RelaxationBound:
    """Return the certified bound of a compact model's relaxation; the options are those of ``compact_model``.

    Raises
    ------
    ValueError
        When the model does not apply, or the solver ends without multipliers.
    """
    begun = perf_counter()
    require_no_peak(instance, rules, f"certified bound {formulation}")
    model = compact_model(instance, rules, formulation)
    relaxation = model.relax(time_limit=time_limit, with_clock=False)
    if relaxation.value is None:
        raise ValueError(f"instance {instance.name!r}, {formulation}: no bound, {relaxation.reason}")
    bound, certificate = certified_bound(instance, rules, formulation, relaxation.multipliers)
    return RelaxationBound(formulation, bound, *relaxation.size, perf_counter() - begun, certificate)


def _integers(rows: CompactRows, multipliers: Mapping[RowName, float]) -> list[list[Any]]:
    """Return pairs of a row, as in a certificate, and its integer; those that are 0 are left out."""
    problem, rules = rows.setting.problem, rows.setting.rules
    makespan = rules.objective == "makespan"
    times = MULTIPLIER_SCALE * rows.imbalance_price.denominator / (Fraction(1) if makespan else problem.v_jump)
    others = times * SCALE * problem.v_jump
    given = {name: Fraction(value) for name, value in multipliers.items()}
    priced = sum((value for name, value in given.items() if name[0] in PRICED and value > 0), Fraction(0))
    cost = Fraction(1) if makespan else rules.weight
    shrunk = times * min(Fraction(1), cost / priced) if priced > 0 else times
    pairs = []
    for name, value in given.items():
        row = [list(part) if isinstance(part, tuple) else part for part in name]
        factor = shrunk if name[0] in PRICED else times if name[0] == "balance" else others
        integer = round(value * factor) if rows.row(row).equality else max(0, floor(value * factor))
        if integer != 0:
            pairs.append([row, integer])
    return pairs
