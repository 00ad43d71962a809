r"""Fitness of the dual-coded genetic algorithm (Yang, Liu, Ju, 2012, section 2.2), and its parameters.

    (1) F' = mu / f_1 + 1 / f_2                        raw fitness; 1 / f_1 alone without mu
    (2) f_2 = f_2' + M max(0, f_2' - T_s)              penalty above the allowed temperature T_s
    (3) F = m + k_1 c_1^n (F' - m) / (max - m) m       in generation n, for F' >= m, the mean of F'
        F = m + k_2 c_2^n (m - F') / (m - min) m       for F' < m; max and min are those of F' too

**Units.** The source prints none in (1), and they decide what mu means. Here f_1 is the time of rapids in s,
15 s a metre at its 4 m/min, and f_2 is in deg C, counted from ``ROOM_C`` so that it stays away from 0 where
nothing is warm. By the figures of its table the plan printed for mu = 4 is then the fittest of all at mu = 4,
and that for mu = 0.6 at 0.6. With f_1 in metres neither is: the shortest printed route beats both. Any unit of
f_1 from 14 to 94 mm of travel agrees with the table.

**Translation.** Where rapids take 0.5 m instead of 40, every such mu asks for travel alone. By default the unit
of f_1 is therefore chosen such that, on the plate at hand, mu / f_1 and 1 / f_2 of a nearest-neighbour route
are in the ratio in which the table has them for its shortest route (``SHORTEST_S``, ``SHORTEST_C``).

1 / f_2 does not fall below 0, so (2) takes away what heat adds to (1) and no more, whatever M.
"""

from dataclasses import dataclass

import numpy as np

from cutgap.heuristics.hot_routes import Plate, nearest_neighbours, peak_rise, travel_of
from cutgap.instances.arrays import Floats, finite_number

ROOM_C = 20.0
"""f_2 where nothing is warm, deg C, whatever the ambient temperature."""

SHORTEST_S, SHORTEST_C = 38.87 * 60.0 / 4.0, 350.99
"""f_1 and f_2 of the shortest route that is printed: 38.87 m at 4 m/min."""

SMALLEST = 1e-3
"""f_1 counts as this at least in (1)."""


@dataclass(frozen=True, slots=True)
class DualCodedParameters:
    """Parameters; k_1 to c_2, population, generations and both mu are the source's.

    Parameters
    ----------
    mu
        Weight of travel against heat in (1), above 0; ``None`` takes 1 / f_1 alone.
    conventional
        Whether F = F', and crossover and mutation are the conventional ones.
    printed_units
        Whether mu is not translated.
    population, generations
        At least 2, at least 1.
    crossover_probability, mutation_probability
        Per pair, and per child.
    k_1, k_2, c_1, c_2
        Of (3); k_2 c_2^generations must be at least -1, or F would fall below 0.
    penalty
        M of (2), above 0.
    start_shape
        b of ``non_uniform``, at least 0.
    tries
        Times that a child is generated at most, at least 1.
    """

    mu: float | None = 4.0
    conventional: bool = False
    printed_units: bool = False
    population: int = 100
    generations: int = 300
    crossover_probability: float = 0.9
    mutation_probability: float = 0.9
    k_1: float = 0.1
    k_2: float = -0.05
    c_1: float = 1.01
    c_2: float = 1.01
    penalty: float = 100.0
    start_shape: float = 2.0
    tries: int = 20

    def __post_init__(self) -> None:
        self._check_effort()
        self._check_scaling()

    def _check_effort(self) -> None:
        for name, least in (("population", 2), ("generations", 1), ("tries", 1)):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or value < least:
                raise ValueError(
                    f"dual-coded, {name}: expected a whole number of at least {least}, got {value!r}"
                )
        for name in ("crossover_probability", "mutation_probability"):
            value = finite_number(getattr(self, name), f"dual-coded, {name}", least=0.0)
            if value > 1.0:
                raise ValueError(f"dual-coded, {name}: expected at most 1, got {value:g}")

    def _check_scaling(self) -> None:
        if self.mu is not None:
            finite_number(self.mu, "dual-coded, mu", above=0.0)
        for name in ("c_1", "c_2", "penalty"):
            finite_number(getattr(self, name), f"dual-coded, {name}", above=0.0)
        for name in ("k_1", "start_shape"):
            finite_number(getattr(self, name), f"dual-coded, {name}", least=0.0)
        finite_number(self.k_2, "dual-coded, k_2")
        with np.errstate(over="ignore"):
            highest, lowest = (
                k * max(1.0, float(np.power(c, self.generations)))
                for k, c in ((self.k_1, self.c_1), (self.k_2, self.c_2))
            )
        if not highest < np.inf:
            raise ValueError(f"dual-coded, c_1: c_1^{self.generations} is no finite number, got {self.c_1:g}")
        if not -1.0 <= lowest <= 0.0:
            most = 20.0 ** (1 / self.generations) - 5e-6
            raise ValueError(
                f"dual-coded, k_2: expected k_2 c_2^n from -1 to 0 in all {self.generations} generations, "
                f"got {lowest:g}; with k_2 = -0.05 take c_2 = {most:.5f} at most"
            )


def travel_unit(plate: Plate, parameters: DualCodedParameters) -> float:
    """Return how many mm of travel count 1 in f_1."""
    if parameters.printed_units:
        return plate.speed
    order, starts = nearest_neighbours(plate)
    rise = peak_rise(plate, order, starts, np.empty(len(order)))
    seconds = travel_of(plate, order, starts) / plate.speed
    factor = seconds / SHORTEST_S * SHORTEST_C / (ROOM_C + rise)
    # A route of no length, or through the end of a contour, is no measure.
    return plate.speed * (factor if 0.0 < factor < np.inf else 1.0)


def raw_fitness(f_1: Floats, rises: Floats, room: float, parameters: DualCodedParameters) -> Floats:
    """Return (1) with (2).

    Parameters
    ----------
    f_1
        Travel in its unit.
    rises
        Peak above ambient, K.
    room
        T_s above ambient, K; infinite without one.
    """
    short = 1.0 / np.maximum(f_1, SMALLEST)
    if parameters.mu is None:
        return short
    f_2 = ROOM_C + rises + parameters.penalty * np.maximum(0.0, rises - room)
    return parameters.mu * short + 1.0 / f_2


def scaled(raw: Floats, generation: int, parameters: DualCodedParameters) -> Floats:
    """Return (3); where all are equal, they stay as they are."""
    mean = float(raw.mean())
    above, below = float(raw.max()) - mean, mean - float(raw.min())
    if above <= 0.0 or below <= 0.0:
        return raw
    rate_1 = parameters.k_1 * parameters.c_1**generation
    rate_2 = parameters.k_2 * parameters.c_2**generation
    return np.where(
        raw >= mean,
        mean + rate_1 * (raw - mean) / above * mean,
        mean + rate_2 * (mean - raw) / below * mean,
    )
