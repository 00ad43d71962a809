r"""Cosines of parts of a turn between integers, and integer vectors for rows that are quadratic forms.

    (1) pi = 16 arctan(1/5) - 4 arctan(1/239),   arctan(1/m) = sum_k (-1)^k / ((2k + 1) m^(2k + 1))
    (2) cos t = sum_k (-1)^k t^(2k) / (2k)!

Both series alternate, so once their terms fall in size, what is left out is at most the last term taken. The
terms of (1) always fall; those of (2), for t <= 3.15, from k = 1 on, since t^2 < 10 < 3 * 4. In units of
1 / UNIT, with a rational t at most one unit from the angle, the sum of (2) is at most two units off: one for
the angle, as |cos a - cos b| <= |a - b|, and one for what is left out, as the last term is at most one unit.

Source: Machin (1706) for (1).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from math import ceil, floor
from typing import Any

from cutgap.formulations.certificate.reading import entries, integer, require, show

UNIT = 2**100
MACHIN_TERMS = 60
"""The last terms of (1) are then below 2^-270."""
MAX_ENTRY = 10**12
"""Largest number in a vector."""


@cache
def _pi() -> Fraction:
    """Return pi with an error far below 1 / UNIT."""

    def arctan(m: int) -> Fraction:
        return sum(
            (Fraction((-1) ** k, (2 * k + 1) * m ** (2 * k + 1)) for k in range(MACHIN_TERMS)), Fraction(0)
        )

    return 16 * arctan(5) - 4 * arctan(239)


def greatest_pi() -> Fraction:
    """Return a fraction above pi, by less than 2 / UNIT."""
    return _pi() + Fraction(1, UNIT)


@cache
def cosine(steps: int, count: int) -> tuple[int, int]:
    """Return integers around UNIT * cos(2 pi steps / count), at most five apart."""
    nearest = min(steps % count, -steps % count)
    # The angle is at most pi; rounding moves it by half a unit.
    angle = Fraction(round(UNIT * 2 * nearest * _pi() / count), UNIT)
    total = term = Fraction(1)
    k = 0
    while abs(term) * UNIT > 1:
        k += 2
        term *= -angle * angle / (k * (k - 1))
        total += term
    return floor(total * UNIT) - 2, ceil(total * UNIT) + 2


def vector(value: Any, count: int) -> list[int]:
    """Return a list of ``count`` whole numbers of limited size."""
    numbers = [integer(each, "vector") for each in entries(value, "vector", count)]
    for each in numbers:
        require(abs(each) <= MAX_ENTRY, f"vector: {show(each)} is beyond {MAX_ENTRY}")
    return numbers


@dataclass(frozen=True, slots=True)
class Coefficients:
    """Corrections of a row that has one for each variable, made whenever they are asked for.

    A row that follows from n numbers takes the memory of n numbers.
    """

    make: Callable[[], Iterator[tuple[int, Sequence[int]]]]

    def __iter__(self) -> Iterator[tuple[int, Sequence[int]]]:
        return self.make()
