"""Entry points, exactly: ``python -m cutgap.benchmark.entry_points NAME``; each run has its own process.

    suite SUITE   every instance of a suite under its own rules, with published values and bounds beside
    rules         the shipped nest under all process rules, and without each of them: the price of each rule
    wall          contours of the shipped nest, ever more of them, without precedence: time and memory
    two-heads     contours spread over that nest, two heads from its left and right side: travel and makespan

The seconds do not contain loading and compiling; the memory is the process's peak, both included.
"""

import argparse
import resource
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context

import numpy as np

from cutgap.benchmark.best_known import published_runs
from cutgap.benchmark.methods import AUTO, run, warm_up
from cutgap.benchmark.peers import Row, figures, print_rows
from cutgap.benchmark.tasks import SUITE_RULES, find_suite
from cutgap.instances import Head, Instance, Result, Rules
from cutgap.instances.formats import NO_OVERRIDES
from cutgap.instances.rules import Objective
from cutgap.instances.suites import load_suite

WALL_SIZES = (20, 25, 30, 35, 40, 47)
TWO_HEADS_SIZES = (10, 20, 30, 47)
OBJECTIVES: tuple[Objective, ...] = ("travel", "makespan")
COLUMNS = (
    "instance",
    "contours",
    "points",
    "pairs",
    "method",
    "value",
    "bound",
    "gap %",
    "seconds",
    "peak MiB",
    "published",
)
NEST = "nest28"


@dataclass(frozen=True, slots=True)
class Measured:
    """A run's result and its process's peak memory in MiB."""

    result: Result
    peak_mib: float


def measure(instance: Instance, rules: Rules, method: str, limit_s: float) -> Measured:
    """Run a method in a fresh process."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as executor:
        return executor.submit(_measured, instance, rules, method, limit_s).result()


def _measured(instance: Instance, rules: Rules, method: str, limit_s: float) -> Measured:
    warm_up(method, rules, instance)
    result = run(method, instance, rules, time_limit=limit_s)
    return Measured(result, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)


def row(name: str, instance: Instance, measured: Measured, published: str) -> Row:
    """Return the cells of a run."""
    points = sum(len(contour.entry_points) for contour in instance.contours)
    sizes = [str(len(instance.contours)), str(points), str(len(instance.precedence))]
    cells = [name, *sizes, measured.result.method, *figures(measured.result)]
    return [*cells, f"{measured.peak_mib:.0f}", published]


def suite_rows(name: str, method: str, limit_s: float) -> Iterator[Row]:
    """Every instance of a suite, the smallest first."""
    suite = find_suite(name, NO_OVERRIDES)
    for instance in sorted(suite.instances, key=lambda each: (len(each.contours), each.node_count)):
        known = published(name.partition(":")[0], instance.name)
        yield row(instance.name, instance, measure(instance, suite.rules, method, limit_s), known)


def published(suite: str, instance: str) -> str:
    """Return what others report of an instance, in words."""
    texts = []
    for each in published_runs():
        if (each.suite, each.instance) == (suite, instance):
            bound = "" if each.lower_bound is None else f", bound {each.lower_bound:g}"
            seconds = "" if each.seconds is None else f", {each.seconds:g} s"
            texts.append(f"{each.method} {each.value:g}{bound}{seconds}")
    return "; ".join(texts) or "-"


def rules_rows(method: str, limit_s: float) -> Iterator[Row]:
    """The price of each process rule: the nest under all of them, without each, and without any."""
    (nest,), rules = load_suite(NEST), SUITE_RULES[NEST]
    variants = {
        "all process rules": rules,
        "without parts in one go": replace(rules, parts_in_one_go=False),
        "without neighbours only": replace(rules, neighbours_only=False),
        "without clear rapids": replace(rules, clear_rapids=False),
        "without backward price": replace(rules, backward_price=0.0),
        "without any": Rules("travel"),
    }
    for name, asked in variants.items():
        yield row(name, nest, measure(nest, asked, method, limit_s), "-")


def wall_rows(method: str, limit_s: float) -> Iterator[Row]:
    """The first contours of the nest, as holes that nothing orders."""
    (nest,) = load_suite(NEST)
    for size in WALL_SIZES:
        part = replace(nest, contours=nest.contours[:size], precedence=())
        yield row(f"{size} contours", part, measure(part, Rules("travel"), method, limit_s), "-")


def two_heads_rows(method: str, limit_s: float) -> Iterator[Row]:
    """Two heads whose ranges do not overlap, over contours spread evenly through the nest, as holes."""
    (nest,) = load_suite(NEST)
    heads = (Head("left", np.array([-100.0, 900.0, 0.0])), Head("right", np.array([3100.0, 900.0, 0.0])))
    for size in TWO_HEADS_SIZES:
        chosen = np.linspace(0, len(nest.contours) - 1, size).round().astype(int)
        contours = tuple(nest.contours[place] for place in chosen)
        part = replace(nest, contours=contours, heads=heads, precedence=())
        for objective in OBJECTIVES:
            rules = Rules(objective)
            yield row(f"{size} contours, {objective}", part, measure(part, rules, method, limit_s), "-")


def main(arguments: list[str] | None = None) -> int:
    """Run the benchmark that the command line names, and print its table."""
    parser = argparse.ArgumentParser(prog="python -m cutgap.benchmark.entry_points", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("name", choices=["suite", "rules", "wall", "two-heads"])
    parser.add_argument("suite", nargs="?", help="for suite: as for cutgap gaps, such as pcgtsp:DIR")
    parser.add_argument("--method", default=AUTO)
    parser.add_argument("--limit", type=float, default=600.0, help="time limit in s")
    given = parser.parse_args(arguments)
    if (given.name == "suite") != (given.suite is not None):
        parser.error("a suite goes with the benchmark suite, and only with it")
    if given.name == "suite":
        rows = suite_rows(given.suite, given.method, given.limit)
    else:
        made = {"rules": rules_rows, "wall": wall_rows, "two-heads": two_heads_rows}[given.name]
        rows = made(given.method, given.limit)
    print_rows(f"{given.name}, method {given.method}, limit {given.limit:g} s", COLUMNS, rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
