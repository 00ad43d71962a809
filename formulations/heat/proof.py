"""Certificates of bounds under heat: the claim alone, since the checker searches the plate itself."""

from math import floor
from typing import Any

from cutgap.formulations.certify import MULTIPLIERS_UNUSED, SCALE, Certificate, certificate_of
from cutgap.instances import Instance, Rules

MARGINS = (5e-7,)
"""How far below the bound the claim lies, relative to it from 1 on: half of what counts as the bound."""

MOST_STEPS = 700_000_000
"""Elementary steps of the checker, half a minute, beyond which there is no certificate."""
STEPS_A_SECOND = 20_000_000
LEAST_SECONDS = 1.0
"""Seconds that a proof may take when the time is over."""


def heat_certificate(
    instance: Instance, rules: Rules, bound: float | None, seconds: float | None = None
) -> Certificate | None:
    """Return a verified certificate that no plan is worth less than ``bound``; ``None`` if it takes too long.

    Parameters
    ----------
    bound
        In the unit of the objective; ``None`` claims that no plan is within the cap.
    seconds
        About how long the checker may take; ``None`` for as long as ``MOST_STEPS`` take.
    """
    steps = MOST_STEPS
    if seconds is not None:
        steps = min(steps, int(STEPS_A_SECOND * max(LEAST_SECONDS, seconds)))
    unit = instance.machine.v_jump if rules.objective == "makespan" else 1.0

    def claim(margin: float) -> tuple[int | None, dict[str, Any]]:
        if bound is None:
            return None, {"kind": "heat"}
        kept = bound - margin * max(1.0, abs(bound))
        return floor(kept * unit * SCALE), {"kind": "heat"}

    return certificate_of(instance, rules, None, MULTIPLIERS_UNUSED, claim, margins=MARGINS, steps=steps)
