r"""Is 5 % more travel worth half the peak? ``python -m cutgap.benchmark.heat_claims plate`` or ``dense-plate``.

The four algorithms of table 1 of Yang, Liu, Ju (2012) run on seeded plates of 30 contours, rapids clear. Their
figures are divided by those of the single-objective improved one on the same plate, as in the source:

    travel / improved, peak / improved in deg C, rise / improved above ambient: mean +- standard deviation

``best within 5 %`` is the coolest individual in any generation of the four that travels at most 5 % further
than the improved one's answer. ``--reading`` takes L, t and units as ``heat_readings`` lists them, such as
``line,passed,minutes``; ``--printed-units`` does not translate mu to the plate (``dual_coded_fitness``).
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cutgap.benchmark.heat_readings import RULES, Reading, all_readings, plate_by
from cutgap.benchmark.peers import Row, print_rows
from cutgap.heuristics import COOL, IMPROVED, PLAIN
from cutgap.heuristics.dual_coded import evolve
from cutgap.heuristics.dual_coded_fitness import ROOM_C, DualCodedParameters
from cutgap.instances import Instance
from cutgap.instances.arrays import Floats
from cutgap.instances.generate import generate

VARIANTS = {"plain": PLAIN, "improved": IMPROVED, "mu = 4": DualCodedParameters(), "mu = 0.6": COOL}
PRINTED = {
    "plain": (42.74, 300.56),
    "improved": (38.87, 350.99),
    "mu = 4": (40.82, 156.45),
    "mu = 0.6": (75.23, 142.37),
}
"""Time distance in m, peak in deg C."""

BEST = "best within 5 %"
MORE_TRAVEL = 1.05
HALF = 0.5
COLUMNS = (
    "algorithm",
    "travel, m",
    "peak, deg C",
    "travel / improved",
    "printed",
    "peak / improved",
    "printed",
    "rise / improved",
)


@dataclass(frozen=True, slots=True)
class Outcome:
    """What an algorithm reached on a plate: travel in mm and rise above ambient in K."""

    travel: float
    rise: float


def run_plate(
    instance: Instance, seed: int, reading: Reading, *, printed_units: bool = False
) -> dict[str, Outcome]:
    """Run the four algorithms, each with the same seed."""
    plate = plate_by(instance, RULES, reading)
    found: dict[str, Outcome] = {}
    seen: list[tuple[float, float]] = []
    for name, parameters in VARIANTS.items():
        chosen = replace(parameters, printed_units=printed_units)
        population = evolve(instance, RULES, chosen, plate, np.random.default_rng(seed))
        found[name] = Outcome(*population.figures)
        seen += zip(population.front[0].tolist(), population.front[1].tolist(), strict=True)
    limit = MORE_TRAVEL * found["improved"].travel
    coolest = min((point for point in seen if point[0] <= limit), key=lambda point: point[1])
    return {**found, BEST: Outcome(*coolest)}


def ratios(outcomes: Sequence[dict[str, Outcome]], name: str) -> tuple[Floats, Floats, Floats]:
    """Return travel, peak and rise of an algorithm as shares of those of the improved one, plate by plate."""
    pairs = [(each[name], each["improved"]) for each in outcomes]
    return (
        np.array([one.travel / base.travel for one, base in pairs]),
        np.array([(ROOM_C + one.rise) / (ROOM_C + base.rise) for one, base in pairs]),
        np.array([one.rise / base.rise if base.rise > 0 else np.nan for one, base in pairs]),
    )


def rows(outcomes: Sequence[dict[str, Outcome]]) -> Iterator[Row]:
    """Yield a row for each algorithm."""
    for name in (*VARIANTS, BEST):
        travel = np.mean([each[name].travel for each in outcomes]) / 1000.0
        peak = ROOM_C + np.mean([each[name].rise for each in outcomes])
        cells = [f"{each.mean():.2f} +- {each.std():.2f}" for each in ratios(outcomes, name)]
        printed = ["", ""]
        if name in PRINTED:
            printed = [f"{a / b:.2f}" for a, b in zip(PRINTED[name], PRINTED["improved"], strict=True)]
        yield [name, f"{travel:.3f}", f"{peak:.1f}", cells[0], printed[0], cells[1], printed[1], cells[2]]


def verdict(outcomes: Sequence[dict[str, Outcome]]) -> str:
    """Return on how many plates the claim holds."""
    texts = []
    for name in ("mu = 4", BEST):
        travel, peak, rise = ratios(outcomes, name)
        short = travel <= MORE_TRAVEL
        counts = [int(each.sum()) for each in (short, short & (peak <= HALF), short & (rise <= HALF))]
        texts.append(
            f"{name}: at most 5 % more travel on {counts[0]} of {len(outcomes)} plates, and with it at most "
            f"half the peak in deg C on {counts[1]}, half the rise on {counts[2]}"
        )
    return "\n".join(texts)


def main(arguments: list[str] | None = None) -> int:
    """Run the algorithms, and print the table and the verdict."""
    parser = argparse.ArgumentParser(prog="python -m cutgap.benchmark.heat_claims", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("kind", choices=["plate", "dense-plate"])
    parser.add_argument("--plates", type=int, default=20, help="number of plates, with seeds 0, 1, ...")
    parser.add_argument("--contours", type=int, default=30)
    parser.add_argument("--printed-units", action="store_true", help="mu is not translated to the plate")
    parser.add_argument("--reading", default=str(Reading()), help="L,t,units as in heat_readings")
    given = parser.parse_args(arguments)
    known = {str(reading).replace(", ", ","): reading for reading in all_readings()}
    reading = known.get(given.reading.replace(", ", ","))
    if reading is None or reading.lag not in ("passed", "rapids"):
        able = [name for name, each in known.items() if each.lag in ("passed", "rapids")]
        parser.error(f"argument --reading: expected one of {'; '.join(able)}, got {given.reading!r}")
    if given.plates < 1:
        parser.error(f"argument --plates: expected at least 1, got {given.plates}")
    outcomes = []
    for seed in range(given.plates):
        instance = generate(given.kind, holes=given.contours, seed=seed)
        outcomes.append(run_plate(instance, seed, reading, printed_units=given.printed_units))
    print_rows(f"{given.plates} plates, {given.kind}, {reading}", COLUMNS, rows(outcomes))
    print(verdict(outcomes))
    return 0


if __name__ == "__main__":
    sys.exit(main())
