r"""Which reading of L, t and units gives the printed peaks: ``python -m cutgap.benchmark.heat_readings``.

    T(L, t) = k / sqrt(t) exp(-L^2 / (4 a t)),   k and a from SI constants (``instances.heat``)

    L   curve       to the nearest point of the contour (the library's own)
        line        to the infinite line through the nearest edge, "the axis along which the source runs"
        zero        as if every contour ran through every start point
    t   passed      from the end of the contour to the start of the later one (the library's own)
        rapids      the same without the time of cutting in between
        own leg     perimeter and next rapid of the earlier contour alone
        last rapid  the rapid to the later contour alone
    in  SI          s and m^2/s
        minutes     t in min, as speeds in m/min give it, while k and a stay in SI units
        a in 1/min  a in m^2/min with t in s

A point outside a circle lies on one of its tangents: by ``line`` circles and ellipses heat it as from L = 0.

Source: Yang, Liu, Ju (2012), table 1: the shortest route 38.87 m and 350.99 deg C, the coolest 142.37 deg C.
"""

import argparse
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise, product
from statistics import fmean
from typing import Literal, get_args

import numpy as np

from cutgap.benchmark.peers import Row, print_rows
from cutgap.heuristics import entry_search
from cutgap.heuristics.dual_coded_fitness import ROOM_C
from cutgap.heuristics.hot_routes import Plate, plan_of_route, plate_of, random_route
from cutgap.instances import Instance, Plan, Rules
from cutgap.instances.arrays import Floats
from cutgap.instances.generate import generate
from cutgap.instances.heat import curve_distances, diffusivity, kernel_constant

Distance = Literal["curve", "line", "zero"]
Lag = Literal["passed", "rapids", "own leg", "last rapid"]
Units = Literal["SI", "minutes", "a in 1/min"]

RULES = Rules("travel", clear_rapids=True)
MINUTE = 60.0
PRINTED_HOT_C = (300.0, 351.0)
"""Printed for the routes that mind travel alone."""


@dataclass(frozen=True, slots=True)
class Reading:
    """One way to read L, t and the units."""

    distance: Distance = "curve"
    lag: Lag = "passed"
    units: Units = "SI"

    def __str__(self) -> str:
        return f"{self.distance}, {self.lag}, {self.units}"


def all_readings() -> list[Reading]:
    """Return every combination."""
    return [Reading(*each) for each in product(get_args(Distance), get_args(Lag), get_args(Units))]


@lru_cache(maxsize=8)
def line_distances(instance: Instance) -> Floats:
    """Return L from entry points to the nearest line through an edge, shape (points, contours), mm."""
    places = instance.points[: int(instance.first_node[-1]), :2]
    columns = []
    for contour in instance.contours:
        corners = np.asarray(contour.geometry)
        edges = np.roll(corners, -1, axis=0) - corners
        normals = np.column_stack((-edges[:, 1], edges[:, 0])) / np.linalg.norm(edges, axis=1)[:, None]
        columns.append(np.abs((places @ normals.T) - (corners * normals).sum(axis=1)).min(axis=1))
    return np.column_stack(columns)


def distances(instance: Instance, reading: Reading) -> Floats:
    """Return L, shape (points, contours), mm."""
    if reading.distance == "line":
        return line_distances(instance)
    near = curve_distances(instance)
    return near if reading.distance == "curve" else np.zeros_like(near)


def lags(instance: Instance, plan: Plan, reading: Reading) -> Floats:
    """Return t in s of each contour of the tour (rows) for each earlier one, shape (contours, contours)."""
    tour = plan.tours[0]
    nodes = [instance.node(*visit[:2]) for visit in tour]
    rapids = np.array([instance.rapid_length(a, b) for a, b in pairwise(nodes)]) / instance.machine.v_jump
    cuts = instance.service_times[[visit.contour for visit in tour]]
    if reading.lag == "own leg":
        return np.tile(np.append(rapids + cuts[:-1], np.inf), (len(tour), 1))
    if reading.lag == "last rapid":
        return np.tile(np.append(np.inf, rapids)[:, None], len(tour))
    between = cuts if reading.lag == "passed" else np.zeros_like(cuts)
    starts = np.append(0.0, np.cumsum(between[:-1] + rapids))
    return starts[:, None] - (starts + between)


def peak_c(instance: Instance, plan: Plan, reading: Reading) -> float:
    """Return the peak temperature of one head's plan by a reading, deg C from ``ROOM_C``."""
    tour = plan.tours[0]
    nodes, contours = [instance.node(*visit[:2]) for visit in tour], [visit.contour for visit in tour]
    spread, constant = diffusivity(instance), kernel_constant(instance)
    t = lags(instance, plan, reading) / (MINUTE if reading.units == "minutes" else 1.0)
    spread *= MINUTE if reading.units == "a in 1/min" else 1.0
    earlier = np.tri(len(tour), k=-1, dtype=bool)
    t = np.where(earlier, t, np.inf)
    length = distances(instance, reading)[np.ix_(nodes, contours)]
    rises = constant / np.sqrt(t) * np.exp(-(length**2) / (4.0 * spread * t))
    return ROOM_C + float(rises.sum(axis=1).max(initial=0.0))


def plate_by(instance: Instance, rules: Rules, reading: Reading) -> Plate:
    """Return the plate on which the genetic algorithms run by a reading of ``passed`` or ``rapids``.

    Raises
    ------
    ValueError
        For other lags, which do not add up along a route.
    """
    if reading.lag not in ("passed", "rapids"):
        raise ValueError(f"reading: routes are made by t passed or rapids, got {reading.lag!r}")
    plate = plate_of(instance, rules)
    cooling = distances(instance, reading) ** 2 / (4.0 * diffusivity(instance))
    faster = {"SI": 1.0, "minutes": MINUTE, "a in 1/min": 1.0 / MINUTE}[reading.units]
    warmer = MINUTE**0.5 if reading.units == "minutes" else 1.0
    resting = plate.services if reading.lag == "passed" else np.zeros_like(plate.services)
    return plate._replace(cooling=cooling * faster, warmth=plate.warmth * warmer, services=resting)


def routes(instance: Instance, seed: int) -> tuple[Plan, Plan]:
    """Return a short route, and a random one of those that cross nothing."""
    rng = np.random.default_rng(seed)
    short = entry_search(instance, RULES, rng=rng)
    order, starts = np.zeros((2, len(instance.contours)), dtype=np.int64)
    random_route(plate_of(instance, RULES), order, starts, rng)
    return short, plan_of_route(order, starts)


def rows(plates: int) -> Iterator[Row]:
    """Yield a row for each reading: mean peaks over the plates, and whether short ones are as printed."""
    instances = [generate("plate", seed=seed) for seed in range(plates)]
    drawn = [routes(instance, seed) for seed, instance in enumerate(instances)]
    for reading in all_readings():
        short, other = (
            fmean(peak_c(instance, pair[k], reading) for instance, pair in zip(instances, drawn, strict=True))
            for k in (0, 1)
        )
        near = "yes" if PRINTED_HOT_C[0] <= short <= PRINTED_HOT_C[1] else ""
        yield [reading.distance, reading.lag, reading.units, f"{short:.0f}", f"{other:.0f}", near]


def main(arguments: list[str] | None = None) -> int:
    """Print the table of readings."""
    parser = argparse.ArgumentParser(prog="python -m cutgap.benchmark.heat_readings", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--plates", type=int, default=20, help="seeded plates of 30 contours")
    given = parser.parse_args(arguments)
    if given.plates < 1:
        parser.error(f"argument --plates: expected at least 1, got {given.plates}")
    columns = ("L", "t", "in", "short route, deg C", "random route, deg C", "300 to 351")
    print_rows(f"{given.plates} plates of 10 m x 5 m, mean peaks", columns, rows(given.plates))
    return 0


if __name__ == "__main__":
    sys.exit(main())
