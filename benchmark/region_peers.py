"""Discs in any order, ours and GCSOPT side by side in one run: ``python -m cutgap.benchmark.region_peers``.

GCSOPT (Marcucci, 2025; MIT licence) solves the tour as a mixed-integer conic programme over a graph of convex
sets, here undirected, its stronger model, with SCIP. A ratio of seconds compares with a run that may have
stopped at its limit; it is then marked ``>``. SCIP's values may be some 1e-5 below the true length, which is
its tolerance; ours are those of checked plans.
"""

import argparse
import sys
import warnings
from collections.abc import Iterator
from importlib.util import find_spec
from time import perf_counter
from typing import Any

import cvxpy as cp

from cutgap.benchmark.peers import Row, figures, number, print_rows, run_peer
from cutgap.benchmark.regions import random_discs
from cutgap.instances import Instance, Rules
from cutgap.instances.region import Ellipsoid

COUNTS = (6, 7, 8, 9, 10)
PEER_LIMIT_S = 300.0
INSTALL = "pip install 'cutgap[peers]'"
COLUMNS = ("instance", "method", "value", "bound", "gap %", "seconds", "times slower")
RULES = Rules("travel", free_entries=True)


def require_peer() -> None:
    """Raise ``ValueError`` with the command that installs what is missing."""
    for name in ("gcsopt", "pyscipopt"):
        if find_spec(name) is None:
            raise ValueError(f"peer {name}: not installed; {INSTALL}")


def gcsopt_tour(instance: Instance, limit_s: float) -> tuple[str, float | None, float]:
    """Return the peer's status, its value in mm and its seconds, building the model included.

    Raises
    ------
    ValueError
        When the peer is not installed, or a contour is no ellipsoid.
    """
    require_peer()
    from gcsopt import GraphOfConvexSets

    begun = perf_counter()
    graph = GraphOfConvexSets(directed=False)
    stops: list[tuple[Any, Any]] = []
    for contour in instance.contours:
        region = contour.region
        if not isinstance(region, Ellipsoid):
            raise ValueError(f"contour {contour.id!r}: the comparison takes ellipsoids")
        vertex = graph.add_vertex(contour.id)
        place, part = vertex.add_variable(2), vertex.add_variable(len(region.axes))
        vertex.add_constraint(place == region.centre[:2] + region.axes[:, :2].T @ part)
        vertex.add_constraint(cp.norm2(part) <= 1)
        stops.append((vertex, place))
    for i, (tail, start) in enumerate(stops):
        for head, end in stops[i + 1 :]:
            graph.add_edge(tail, head).add_cost(cp.norm2(start - end))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # cvxpy calls a run that reached its limit inaccurate
        try:
            graph.solve_traveling_salesman(solver=cp.SCIP, scip_params={"limits/time": limit_s})
        except ValueError:
            # A run that ends without a tour leaves the peer nothing to put together.
            return "stopped", None, perf_counter() - begun
    value = None if graph.value is None else float(graph.value)
    return str(graph.status), value, perf_counter() - begun


def rows(counts: tuple[int, ...], seed: int, method: str, limit_s: float) -> Iterator[Row]:
    """Yield a row for each of the two, the second with its ratio of seconds."""
    require_peer()
    for count in counts:
        instance = random_discs(count, seed)
        ours = run_peer(instance, RULES, method, limit_s)
        yield [instance.name, ours.method, *figures(ours), ""]
        status, value, seconds = gcsopt_tour(instance, limit_s)
        closed = status == "optimal"
        ratio = f"{'' if closed else '> '}{seconds / ours.seconds:.1f}"
        yield [instance.name, "gcsopt", number(value), "-", "-", f"{seconds:.2f}", ratio]


def main(arguments: list[str] | None = None) -> int:
    """Run the comparison that the command line names, and print its table."""
    parser = argparse.ArgumentParser(prog="python -m cutgap.benchmark.region_peers", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--discs", type=int, nargs="+", default=list(COUNTS), help="numbers of discs")
    parser.add_argument("--method", default="regions", help="our method: regions or perspective")
    parser.add_argument("--limit", type=float, default=PEER_LIMIT_S, help="time limit of each run in s")
    given = parser.parse_args(arguments)
    try:
        found = rows(tuple(given.discs), given.seed, given.method, given.limit)
        print_rows(f"discs in any order, seed {given.seed}", COLUMNS, found)
    except ValueError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
