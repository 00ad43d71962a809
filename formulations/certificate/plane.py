"""Points of the plane as the library has them: the doubles that are nearest to the numbers of a document."""

from collections.abc import Sequence
from fractions import Fraction

from cutgap.formulations.certificate.reading import Refused, show

Spot = tuple[int, int]


def as_doubles(groups: Sequence[Sequence[tuple[Fraction, ...]]]) -> list[tuple[Spot, ...]]:
    """Return x, y of the points of each group as doubles, in integers over one denominator."""
    ratios = [[(_double(x), _double(y)) for x, y, *_ in group] for group in groups]
    unit = max((below for group in ratios for place in group for _, below in place), default=1)
    return [
        tuple((x * (unit // under), y * (unit // below)) for (x, under), (y, below) in group)
        for group in ratios
    ]


def _double(value: Fraction) -> tuple[int, int]:
    """Return a double as a whole number over a power of two."""
    try:
        return float(value).as_integer_ratio()
    except OverflowError:
        raise Refused(f"the number {show(value)} is out of range") from None
