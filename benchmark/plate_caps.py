"""What is asked of suites of hot plates: least travel, least peak, and least travel half way between the two.

The caps half way, between the peak of the coolest shortest plan and the least possible one, are kept in
``plate_caps.csv``: everybody asks the same of a plate, where on larger ones both peaks are only the best found.
``python -m cutgap.benchmark.plate_caps`` makes the file anew. ``plate30`` has no caps, since all its peaks are
ambient.
"""

import csv
import io
import sys
from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from importlib.resources import files

import numpy as np

from cutgap.formulations import solve
from cutgap.formulations.heat.solve import solve_heat
from cutgap.instances import Instance, Rules
from cutgap.instances.suites import load_suite

FILE = "plate_caps.csv"
COLUMNS = ("suite", "instance", "shortest_peak_c", "coolest_peak_c", "cap_c")
PLATE_RULES = Rules("travel", clear_rapids=True)
PLATE_SUITES = ("plate30", "plate30-dense", "small-plates")
SECONDS = 90.0
"""For each of the three runs behind a cap."""


def further_rules(suite: str) -> dict[str, tuple[Rules, ...]]:
    """Return what a suite asks for besides ``PLATE_RULES``, by names of instances; of other suites nothing."""
    if suite not in PLATE_SUITES:
        return {}
    caps, peak = halfway_caps(suite), replace(PLATE_RULES, objective="peak")
    names = [instance.name for instance in load_suite(suite)]
    capped = {name: (replace(PLATE_RULES, temperature_cap=cap),) for name, cap in caps.items()}
    return {name: (peak, *capped.get(name, ())) for name in names}


@cache
def halfway_caps(suite: str) -> dict[str, float]:
    """Return the caps of a suite by names of instances, deg C."""
    text = files("cutgap.benchmark").joinpath(FILE).read_text(encoding="utf-8")
    rows = csv.DictReader(io.StringIO(text))
    return {row["instance"]: float(row["cap_c"]) for row in rows if row["suite"] == suite}


def cap_row(suite: str, instance: Instance, time_limit: float = SECONDS) -> dict[str, object]:
    """Return a row of the file: what three runs find in so many seconds each.

    Raises
    ------
    ValueError
        When they find nothing.
    """
    shortest, peak = solve(instance, PLATE_RULES, time_limit=time_limit), replace(PLATE_RULES, objective="peak")
    if shortest.plan is None or shortest.value is None:
        raise ValueError(f"instance {instance.name!r}: no plan in {time_limit:g} s; give more time")
    hot, cool = (
        solve_heat(instance, peak, time_limit=time_limit, start=shortest.plan, most_travel=most).value
        for most in (shortest.value, np.inf)
    )
    if hot is None or cool is None:
        raise ValueError(f"instance {instance.name!r}: no cooler plan in {time_limit:g} s; give more time")
    figures = (round(hot, 2), round(cool, 2), round((hot + cool) / 2, 1))
    return dict(zip(COLUMNS, (suite, instance.name, *figures), strict=True))


def write_caps(suites: Iterable[str] = ("small-plates", "plate30-dense")) -> None:
    """Print the file; each row takes up to three times ``SECONDS``."""
    writer = csv.DictWriter(sys.stdout, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for suite in suites:
        for instance in load_suite(suite):
            writer.writerow(cap_row(suite, instance))


if __name__ == "__main__":
    write_caps()
