r"""How warm an earlier cut leaves a start point at least, in integers: the temperature model, rounded down.

    (1) T(L, t) = k exp(-L^2 / (4 a t)) / sqrt(t)                                                 [K]
        k = q / (v h sqrt(4 pi lambda c rho)),  a = lambda / (c rho)
    (2) the least T over t from t_1 to t_2 is at an end: T rises up to t = L^2 / (2 a) and falls after it
    (3) e^-x >= e^-i e^(-j / 2^10) e^(-l / 2^20) (1 - r),  x = i + j / 2^10 + l / 2^20 + r

L is the distance from the start point to the closed polyline of the earlier contour, in x and y, t the time
from its end. Times are integers of 1 / SECOND s, rises of 1 / KELVIN K. Whatever is rounded makes T smaller: k
down, x and the root of t up; the powers of (3) are products, rounded down, of e^(-1 / 2^20), for which the
alternating series stops at a negative term.

The library knows L and t as floats only. So L counts as longer by 10^-12 of the largest coordinate, and those
who ask take t as uncertain by 10^-12 of the longest time there is: far more than floats can be off, and what is
proved holds for every T that floats may see. Only at a corner of the polyline L is 0 in floats too. There T
falls from infinity on; elsewhere on the polyline it may be anything from 0 on where t is 0, as (1) has no limit
there.

Source: Yang, Liu, Ju (2012).
"""

from fractions import Fraction
from functools import cache
from itertools import pairwise
from math import ceil, factorial, isqrt

from cutgap.formulations.certificate.cosines import greatest_pi
from cutgap.formulations.certificate.material import Place, square_to_edge
from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.reading import require, show

SECOND = 2**40
KELVIN = 2**48
FLOATS = Fraction(1, 10**12)
"""Share by which lengths and times of the library may be off."""

BITS = 64
"""Powers of e are in units of 2^-BITS."""
EXPONENT = 40
"""Exponents x are in units of 2^-EXPONENT."""
STEP = 10
"""Bits of j and of l in (3)."""
LOWEST = 44
"""From e^-LOWEST on, below 2^-63, powers count as 0."""
MM = Fraction(1, 1000)
ORDINARY = Fraction(1, 10**30), Fraction(10**30)
"""Between these, figures of materials and speeds neither vanish nor overflow in the floats of the library."""
FALLING = -(10**100)
"""Before all times: where L is 0, T never rises."""


@cache
def _powers() -> tuple[list[int], list[int], list[int]]:
    """Return e^-i, e^(-j / 2^STEP) and e^(-l / 4^STEP), rounded down."""
    small, guarded = Fraction(1, 4**STEP), 2 * BITS
    base = sum(((-small) ** k / factorial(k) for k in range(6)), Fraction(0))
    factor = int(base * 2**guarded)
    tables = []
    for size in (2**STEP, 2**STEP, LOWEST):
        table = [2**guarded]
        for _ in range(size):
            table.append(table[-1] * factor >> guarded)
        # The last power is the base of the next table.
        factor = table.pop()
        tables.append([value >> guarded - BITS for value in table])
    fine, middle, whole = tables
    return whole, middle, fine


class Warmth:
    """T of a problem's start points and contours."""

    def __init__(self, problem: Problem) -> None:
        material = problem.material
        require(material is not None, "heat: the instance has no material")
        assert material is not None
        figures = (*material[:-1], problem.v_cut, problem.v_jump)
        require(all(ORDINARY[0] <= each <= ORDINARY[1] for each in figures), "heat: figures beyond 1e30")
        stored = material.conductivity * material.capacity
        # k^2, with pi rounded up.
        line = material.power / (problem.v_cut * MM * material.thickness)
        square = line * line / (4 * greatest_pi() * stored)
        shift = KELVIN * 2**40
        self.constant = isqrt(int(square * shift * shift))
        diffusivity = material.conductivity / material.capacity / MM**2
        self.whole, self.middle, self.fine = _powers()
        lengths = _longest_distances(problem)
        unit = SECOND * 2**EXPONENT
        self.exponents = [[ceil(each * each / (4 * diffusivity) * unit) for each in row] for row in lengths]
        self.rising = [
            [int(each * each / (2 * diffusivity) * SECOND) if each > 0 else FALLING for each in row]
            for row in lengths
        ]

    def at(self, point: int, contour: int, lag: int) -> int:
        """Return (1), rounded down, for a time above 0; what is not above 0 has no warmth."""
        if lag <= 0:
            return 0
        x = self.exponents[point][contour] // lag + 1
        i = x >> EXPONENT
        if i >= LOWEST:
            return 0
        power = self.whole[i] * self.middle[x >> 30 & 1023] >> BITS
        power = power * self.fine[x >> 20 & 1023] >> BITS
        power = power * ((1 << EXPONENT) - (x & 0xFFFFF))
        return (self.constant * power >> BITS + EXPONENT) // (isqrt(lag << 40) + 1)

    def least(self, point: int, contour: int, soonest: int, latest: int) -> int:
        """Return (2), rounded down."""
        rising = self.rising[point][contour]
        if latest <= rising:
            return self.at(point, contour, soonest)
        if soonest > rising:
            return self.at(point, contour, latest)
        return min(self.at(point, contour, soonest), self.at(point, contour, latest))


def _longest_distances(problem: Problem) -> list[list[Fraction]]:
    """Return L for each entry point and contour, mm: 0 at corners, elsewhere rounded up."""
    unit = 10**12
    curves = []
    for name, _, _, _, curve, _ in problem.contours:
        require(bool(curve), f"heat: contour {show(name)} has no geometry")
        curves.append([(x, y) for x, y in curve])
    points = [(x, y) for contour in problem.contours for x, y, _ in contour[1]]
    every = [*points, *(corner for corners in curves for corner in corners)]
    extent = max((abs(value) for place in every for value in place), default=Fraction(0))
    margin = ceil(extent * FLOATS * unit) + 1

    def longest(point: Place, corners: list[Place]) -> Fraction:
        if point in corners:
            return Fraction(0)
        square = min(square_to_edge(point, edge) for edge in pairwise([*corners, corners[0]]))
        return Fraction(isqrt(int(square * unit * unit)) + margin, unit)

    return [[longest(point, corners) for corners in curves] for point in points]
