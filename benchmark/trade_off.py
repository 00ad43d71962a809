"""Travel and peak of each plan against a bound on each: the table of plates that heat up.

For a plate several things are asked: least travel, least peak, least travel under a cap. A bound on one figure
holds for every plan that keeps the rules under which it was proved, whatever the plan was made for; also where
a cap is added to these rules, since it only forbids plans.

    (1) gap of travel = (travel - bound) / travel
    (2) gap of a peak = (peak - bound) / (peak - ambient)

(2) is a share of the rise: shares of deg C would depend on where their scale begins. Within ``NOTHING_K`` of
its bound a peak counts as having met it, or plates that stay cold would have gaps of 100 %.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from statistics import fmean
from typing import Literal

from cutgap.benchmark.records import Record
from cutgap.instances import Rules
from cutgap.instances.result import OPTIMALITY_TOLERANCE, relative_gap

NOTHING_K = 0.005
"""A difference of temperatures that no table shows."""
Figure = Literal["travel", "peak"]


class ContradictionError(Exception):
    """An allowed plan is better than a proved bound, or exists where none was proved to: a defect."""


@dataclass(frozen=True, slots=True)
class Against:
    """One figure of a method's plans against the best bound on it.

    Attributes
    ----------
    lower_bound, proved, certified
        The best bound proved under these rules; whether an allowed plan meets it; whether a certificate of it
        was verified. ``None`` and false where there is none.
    gap, gaps
        Of the run that is shown, and of each allowed run.
    """

    lower_bound: float | None
    proved: bool
    certified: bool
    gap: float | None
    gaps: tuple[float, ...]

    @property
    def mean_gap(self) -> float | None:
        """Mean gap of the allowed runs."""
        return fmean(self.gaps) if self.gaps else None


def speaks_of_heat(records: Sequence[Record]) -> bool:
    """Whether a temperature is asked for in any of the problems."""
    return any(record.result.rules.speaks_of_heat for record in records)


def against(records: Sequence[Record], group: Sequence[Record], shown: Record, figure: Figure) -> Against:
    """Compare the runs ``group`` of one method and problem, of which one is shown.

    Parameters
    ----------
    records
        All runs on the same instance, under whatever rules.

    Raises
    ------
    ContradictionError
        When a plan is below a bound that holds for it.
    """
    rules = shown.result.rules
    weaker = [each for each in records if _holds_for(each.result.rules, rules)]
    bounds = [
        (each.result.lower_bound, each.certified)
        for each in weaker
        if _is_bound_on(each.result.rules, figure) and each.result.lower_bound is not None
    ]
    bound = max((value for value, _ in bounds), default=None)
    if bound is None:
        return Against(None, False, False, None, ())
    for each in group:
        value = _value(each, figure)
        if value is not None and value < bound - slack(bound):
            place = f"{each.result.method} on {each.instance!r}, seed {each.seed}: {figure} {value}"
            raise ContradictionError(f"{place} is below the proved bound {bound}")
    zero = (shown.result.ambient_c or 0.0) if figure == "peak" else 0.0
    best, least = _value(shown, figure), NOTHING_K if figure == "peak" else 0.0

    def share(value: float) -> float:
        """Return (1) or (2)."""
        return 0.0 if value - bound < least else gap_to(value, bound, zero)

    return Against(
        lower_bound=bound,
        proved=any(
            value <= bound + slack(bound)
            for each in weaker
            if _keeps(each, rules) and (value := _value(each, figure)) is not None
        ),
        certified=any(certified and value >= bound - slack(bound) for value, certified in bounds),
        gap=None if best is None else share(best),
        gaps=tuple(share(value) for each in group if (value := _value(each, figure)) is not None),
    )


def slack(value: float) -> float:
    """Return how far a value may be from a bound that it meets."""
    return OPTIMALITY_TOLERANCE * max(1.0, abs(value))


def gap_to(value: float, bound: float, zero: float = 0.0) -> float:
    """Return ``relative_gap``; 0 when the value meets the bound."""
    return 0.0 if value <= bound + slack(bound) else relative_gap(value, bound, zero)


def _value(record: Record, figure: Figure) -> float | None:
    """Return a figure of a plan that keeps the rules."""
    evaluation = record.result.evaluation
    if record.result.violations or evaluation is None:
        return None
    return evaluation.total_travel_mm if figure == "travel" else evaluation.peak_temperature_c


def _holds_for(weaker: Rules, rules: Rules) -> bool:
    """Whether a bound under ``weaker`` is one under ``rules``: equal constraints, with or without the cap."""
    same = rules.constraints
    return weaker.constraints in (same, replace(same, temperature_cap=None))


def _keeps(record: Record, rules: Rules) -> bool:
    """Whether a plan made under the same or weaker rules is within the cap."""
    cap, evaluation = rules.temperature_cap, record.result.evaluation
    if cap is None or record.result.rules.constraints == rules.constraints:
        return True
    peak = None if evaluation is None else evaluation.peak_temperature_c
    return peak is not None and peak <= cap


def _is_bound_on(rules: Rules, figure: Figure) -> bool:
    return rules.objective == figure and rules.backward_price == 0.0
