"""What every relaxation returns: a bound that a certificate proves, and how large the program was."""

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any


@dataclass(frozen=True, slots=True)
class Size:
    """Scalar variables, scalar rows (those of a matrix inequality included) and coefficients of a program."""

    variables: int
    constraints: int
    nonzeros: int


@dataclass(frozen=True, slots=True)
class RelaxationBound:
    """A lower bound on the objective of every allowed plan.

    Attributes
    ----------
    name
        Of the relaxation.
    bound
        At most what the certificate proves, in ``rules.unit``; ``None``: it proves that no plan is allowed.
    variables, constraints, nonzeros
        Size of the largest program that was solved, see ``Size``; 0 when none was needed.
    seconds
        Time taken, with writing and verifying the certificate.
    certificate
        Verified.
    """

    name: str
    bound: float | None
    variables: int
    constraints: int
    nonzeros: int
    seconds: float
    certificate: dict[str, Any]


def float_below(value: Fraction) -> float:
    """Return a float of at most the value, and no further from it than the next one."""
    near = float(value)
    return near if Fraction(near) <= value else math.nextafter(near, -math.inf)
