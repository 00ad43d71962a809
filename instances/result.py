"""The outcome of one run, which cannot lie: values come from ``evaluate``, bounds are proved or ``None``."""

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from cutgap.instances.arrays import finite_number
from cutgap.instances.check import check
from cutgap.instances.evaluate import Evaluation, evaluate
from cutgap.instances.instance import Instance
from cutgap.instances.plan import Plan
from cutgap.instances.rules import Rules
from cutgap.instances.violation import Violation

OPTIMALITY_TOLERANCE = 1e-9
"""Relative distance of value and bound within which a plan counts as optimal."""


class Status(StrEnum):
    """What a run established."""

    OPTIMAL = "optimal"  # an allowed plan, and a bound that meets it
    FEASIBLE = "feasible"  # an allowed plan
    INFEASIBLE = "infeasible"  # proved: there is no allowed plan
    UNKNOWN = "unknown"  # neither


@dataclass(frozen=True, slots=True)
class Result:
    """Outcome of one run, with ``lower_bound <= optimum <= value``; build it with ``conclude``.

    ``None`` means not found or not proved; 0 and inf are never sentinels.

    Attributes
    ----------
    value
        Objective of the plan in ``rules.unit``, recomputed by ``evaluate``.
    lower_bound
        Proved bound on every allowed plan, same unit.
    violations
        What the plan breaks; a plan that breaks something proves nothing and is never ``feasible``.
    reason
        Why the problem is infeasible, or why the run stopped early.
    certificate
        A verified proof of the bound, or of infeasibility; ``None`` when it is the solver's claim alone.
    ambient_c
        Ambient temperature, from which the gap of a peak counts, deg C; ``None`` without a material.
    """

    status: Status
    rules: Rules
    method: str
    seconds: float
    plan: Plan | None = None
    evaluation: Evaluation | None = None
    violations: tuple[Violation, ...] = ()
    value: float | None = None
    lower_bound: float | None = None
    seed: int | None = None
    reason: str | None = None
    certificate: dict[str, Any] | None = None
    ambient_c: float | None = None

    @property
    def gap(self) -> float | None:
        """(value - lower_bound) / value for an allowed plan and a proved bound; of a peak, of its rise."""
        if self.value is None or self.lower_bound is None or self.violations:
            return None
        return max(0.0, relative_gap(self.value, self.lower_bound, self.zero))

    @property
    def zero(self) -> float:
        """The value of which gaps are shares, the ambient temperature for a peak, else 0."""
        return (self.ambient_c or 0.0) if self.rules.objective == "peak" else 0.0


def relative_gap(value: float, bound: float, zero: float = 0.0) -> float:
    """Return (value - bound) / (value - zero); 0 for a value of ``zero``, 1 for an infinite one."""
    if value == zero:
        return 0.0
    return 1.0 if math.isinf(value) else (value - bound) / (value - zero)


def conclude(
    instance: Instance,
    rules: Rules,
    plan: Plan | None,
    *,
    method: str,
    seconds: float,
    lower_bound: float | None = None,
    seed: int | None = None,
    infeasible: bool = False,
    reason: str | None = None,
) -> Result:
    """Evaluate and check a run's plan and return what the run established.

    Raises
    ------
    ValueError
        When the bound is not a finite number or exceeds the value of an allowed plan, or a plan exists
        where none should.
    """
    if lower_bound is not None:
        lower_bound = finite_number(lower_bound, f"{method}, lower bound")
    if plan is None:
        status = Status.INFEASIBLE if infeasible else Status.UNKNOWN
        bound = None if infeasible else lower_bound
        return Result(status, rules, method, seconds, lower_bound=bound, seed=seed, reason=reason)
    evaluation = evaluate(instance, plan)
    violations = tuple(check(instance, rules, plan))
    value, material = evaluation.objective(rules), instance.material
    status = Status.UNKNOWN if violations else Status.FEASIBLE
    if infeasible and not violations:
        raise ValueError(f"{method}: claims that no plan exists, yet one was found with value {value}")
    if lower_bound is not None and not violations:
        slack = OPTIMALITY_TOLERANCE * max(1.0, abs(value))
        if lower_bound > value + slack:
            raise ValueError(f"{method}: lower bound {lower_bound} exceeds value {value}")
        if lower_bound >= value - slack:
            status = Status.OPTIMAL
    return Result(
        status,
        rules,
        method,
        seconds,
        plan,
        evaluation,
        violations,
        value,
        lower_bound,
        seed,
        reason,
        ambient_c=None if material is None else material.ambient_c,
    )
