"""How often to pierce as ignition gets dearer: ``python -m cutgap.benchmark.pierces FILE --t-aux 0.5 2 10 80``.

For each ignition time the least makespan that is found over all numbers of pierces (``link-search``), beside
two plans that do not choose: one stroke over doubled links (``euler-bridging``), as flames ask for, and the
tour without links (``entry-search``), as for lasers. Where there is an exact method for links, its bound is
shown, and its plan where it is better.

Entry points are link points (``links.points``), unless the file's own are asked for; the home is the origin
unless it is given.
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from cutgap.benchmark.methods import run
from cutgap.benchmark.peers import Row, number, print_rows
from cutgap.formulations import METHODS
from cutgap.instances import Instance, Plan, Result, Rules, evaluate
from cutgap.instances.formats import read_instance
from cutgap.instances.formats.options import MachineOptions

FREE = Rules("makespan", links=True)
"""Any number of pierces."""

EXACT = "links"
T_AUX = (0.5, 2.0, 10.0, 80.0)
"""Ignition times in s, from laser to flame."""

COLUMNS = ("t_aux", "method", "pierces", "links mm", "rapids mm", "time s", "bound s", "gap %", "seconds")


@dataclass(frozen=True, slots=True)
class Point:
    """A point of the curve.

    Attributes
    ----------
    t_aux
        Ignition time, s.
    instance
        The sheet with it.
    best
        The best plan over all numbers of pierces, with the bound where there is one.
    one_stroke, tour
        The plans that do not choose.
    """

    t_aux: float
    instance: Instance
    best: Result
    one_stroke: Result
    tour: Result


def curve(
    instance: Instance, t_aux: Sequence[float], *, seed: int = 0, time_limit: float | None = None
) -> Iterator[Point]:
    """Yield the point of each ignition time.

    Parameters
    ----------
    t_aux
        Ignition times, s.
    time_limit
        Limit in s of each method on each of them.

    Raises
    ------
    ValueError
        When links do not suit the instance (see ``link_check.require_links``).
    """
    for each in t_aux:
        sheet = replace(instance, machine=replace(instance.machine, t_aux=each))
        ours, one_stroke, tour = (
            run(method, sheet, FREE, seed=seed, time_limit=time_limit)
            for method in ("link-search", "euler-bridging", "entry-search")
        )
        best = min((ours, one_stroke, tour), key=_value)
        if EXACT in METHODS:
            exact = run(EXACT, sheet, FREE, seed=seed, time_limit=time_limit)
            best = exact if _value(exact) <= _value(best) else replace(best, lower_bound=exact.lower_bound)
        yield Point(each, sheet, best, one_stroke, tour)


def _value(result: Result) -> float:
    return float("inf") if result.value is None else result.value


def rows(points: Iterator[Point]) -> Iterator[Row]:
    """Return three rows a point: the best plan, one stroke, the tour."""
    for point in points:
        for result in (point.best, point.one_stroke, point.tour):
            figures = ["-"] * 3 if result.plan is None else plan_figures(point.instance, result.plan)
            gap = "-" if result.gap is None else f"{100 * result.gap:.4f}"
            bound = number(result.lower_bound)
            seconds = f"{result.seconds:.2f}"
            yield [f"{point.t_aux:g}", result.method, *figures, number(result.value), bound, gap, seconds]


def plan_figures(instance: Instance, plan: Plan) -> Row:
    """Return pierces, length of links, and of rapids."""
    evaluation = evaluate(instance, plan)
    links = sum(evaluation.link_mm)
    return [str(sum(evaluation.pierces)), number(links), number(evaluation.total_travel_mm - links)]


def main(arguments: list[str] | None = None) -> int:
    """Print the curve of a file."""
    parser = argparse.ArgumentParser(prog="python -m cutgap.benchmark.pierces", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("file", help="a nest, or any file whose contours have curves")
    parser.add_argument("--t-aux", type=float, nargs="+", default=T_AUX, help="ignition times in s")
    parser.add_argument("--home", type=float, nargs=2, default=(0.0, 0.0), metavar=("X", "Y"), help="mm")
    parser.add_argument("--v-jump", type=float, default=None, help="speed of rapids in mm/s")
    parser.add_argument("--v-cut", type=float, default=None, help="speed of cutting in mm/s")
    parser.add_argument("--own-points", action="store_true", help="the file's own entry points")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--limit", type=float, default=60.0, help="time limit in s of each method")
    given = parser.parse_args(arguments)
    options = MachineOptions(
        homes=(tuple(given.home),),
        v_jump=given.v_jump,
        v_cut=given.v_cut,
        link_points=not given.own_points,
    )
    instance = read_instance(given.file, options)
    found = curve(instance, given.t_aux, seed=given.seed, time_limit=given.limit)
    print_rows(f"{instance.name}: least makespan", COLUMNS, rows(found))
    return 0


if __name__ == "__main__":
    sys.exit(main())
