"""How sampled entry points approach continuous ones: ``python -m cutgap.benchmark.continuous NAME``.

    discs, mix, plate   convex regions: the optimum with m entry points on each curve, and the continuous one
    nest                curves that are not convex: the continuous optimum is between the bound for their hulls
                        and the best plan whose points moved along the curves (``polished``)

m doubles, so that each sample contains the one before, and the optimum falls. Columns: the sampled optimum
(method ``contour-dp``) and its plan polished, how far they are above the continuous bound, and the most that
the sampled optimum can be above by

    (1) sampled optimum - continuous optimum <= (sum of the lengths of the curves) / m

if a best continuous tour meets each curve: it does unless it is all inside of a region, which then meets all
others. Proof: a curve of length P has a sample within P / (2 m) of the point where the tour meets it. To enter
there instead makes the rapids before and after longer by that at most. The estimate is rough: where the tour is
reflected by a smooth curve its length has a minimum there, so the error falls with 1 / m^2.
"""

import argparse
import sys
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import shapely

from cutgap.benchmark.peers import Row, number, print_rows
from cutgap.benchmark.regions import convex_plate, random_discs, random_mix
from cutgap.formulations import solve
from cutgap.instances import Instance, Result, Rules, evaluate
from cutgap.instances.polish import polished
from cutgap.instances.sampling import curve_of, sampled
from cutgap.instances.suites import load_suite

COUNTS = (1, 2, 4, 8, 16, 32)
SAMPLED, FREE = Rules("travel"), Rules("travel", free_entries=True)
COLUMNS = ("instance", "m", "optimum", "polished", "above %", "polished %", "estimate %", "seconds")


def nest_instance(count: int, seed: int) -> Instance:
    """Return the first contours of the shipped nest, as holes in any order."""
    (nest,) = load_suite("nest28")
    return replace(nest, name=f"nest-{count}", contours=nest.contours[:count], precedence=())


def with_hulls(instance: Instance) -> Instance:
    """Return the instance with the convex hull of each curve; its optimum is a lower bound."""
    contours = []
    for contour in instance.contours:
        if contour.geometry is not None:
            hull = shapely.MultiPoint(contour.geometry).convex_hull
            contour = replace(contour, geometry=np.array(hull.exterior.coords[:-1]))
        contours.append(contour)
    return replace(instance, contours=tuple(contours))


def estimate(instance: Instance, count: int) -> float:
    """Return (1), mm."""
    curves = [curve_of(contour) for contour in instance.contours]
    return sum(shapely.LinearRing(curve).length for curve in curves if len(curve) > 2) / count


def rows(instance: Instance, method: str, counts: tuple[int, ...], limit_s: float) -> Iterator[Row]:
    """Yield the continuous optimum (or its bound), then a row for each m."""
    continuous = solve(with_hulls(instance), FREE, method=method, time_limit=limit_s)
    bound = continuous.lower_bound
    yield [instance.name, "all", number(continuous.value), "-", *["-"] * 3, f"{continuous.seconds:.2f}"]
    yield [instance.name, "bound", number(bound), "-", *["-"] * 3, ""]
    for count in counts:
        result = solve(sampled(instance, count), SAMPLED, method="contour-dp", time_limit=limit_s)
        yield [instance.name, str(count), *cells(instance, count, result, bound), f"{result.seconds:.2f}"]


def cells(instance: Instance, count: int, result: Result, bound: float | None) -> Row:
    """Return optimum, polished value, and how much they are above the bound, and (1), in % of the bound."""
    best = None
    if result.plan is not None:
        best = evaluate(instance, polished(sampled(instance, count), result.plan)).total_travel_mm
    figures = [result.value, best]
    shares = [
        *(None if each is None or bound is None else each - bound for each in figures),
        estimate(instance, count),
    ]
    percent = ["-" if each is None or not bound else f"{100 * each / bound:.4f}" for each in shares]
    stopped = "" if result.reason is None else "*"
    return [number(result.value) + stopped, number(best), *percent]


INSTANCES = {
    "discs": (random_discs, 10),
    "mix": (random_mix, 10),
    "plate": (lambda count, seed: convex_plate(4, -(-count // 4), seed), 12),
    "nest": (nest_instance, 12),
}
"""What makes the instance from number and seed, and the usual number of contours."""


def main(arguments: list[str] | None = None) -> int:
    """Print the table of the instance that the command line names."""
    parser = argparse.ArgumentParser(prog="python -m cutgap.benchmark.continuous", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("name", choices=list(INSTANCES))
    parser.add_argument("--contours", type=int, default=None)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--samples", type=int, nargs="+", default=list(COUNTS), help="numbers m of entry points"
    )
    parser.add_argument(
        "--method", default="regions", help="for the continuous problem: regions or perspective"
    )
    parser.add_argument("--limit", type=float, default=120.0, help="time limit of each run in s")
    given = parser.parse_args(arguments)
    make, count = INSTANCES[given.name]
    instance = make(given.contours or count, given.seed)
    found = rows(instance, given.method, tuple(given.samples), given.limit)
    print_rows(f"{instance.name}: m entry points a curve, * stopped early", COLUMNS, found)
    return 0


if __name__ == "__main__":
    sys.exit(main())
