r"""Is 5 % more travel worth half the peak, by optima? ``python -m cutgap.benchmark.heat_bounds --contours 12``.

On each of several seeded dense plates, rapids clear:

    t_0   least travel,  p_0  least peak within travel t_0: the coolest of the shortest plans
    p_5   least peak within 1.05 t_0
    t_h   least travel with a peak of at most p_0 / 2 (in deg C), or with half the rise above ambient

The claim holds on a plate when a plan within 1.05 t_0 has at most half the peak; it is refuted when t_h is
proved to be beyond 1.05 t_0, or no plan has so low a peak. On plates that branch and bound closes, all are
optima, marked =. On larger ones t_0 is one, p_0 and p_5 are peaks of plans that were found, and t_h lies
between a bound and a plan; what these leave open is counted as open.
"""

import argparse
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cutgap.benchmark.heat_claims import HALF, MORE_TRAVEL
from cutgap.benchmark.heat_readings import RULES
from cutgap.benchmark.peers import Row, print_rows
from cutgap.formulations import solve
from cutgap.formulations.heat.solve import solve_heat
from cutgap.instances import Instance, Result, Rules, Status
from cutgap.instances.generate import generate
from cutgap.instances.heat import require_heat

COOL = Rules("peak", clear_rapids=True)
COLUMNS = (
    "plate",
    "t_0, mm",
    "p_0, deg C",
    "p_5 / p_0",
    "t_h / t_0",
    "claim",
    "half the rise: t_h / t_0",
    "claim",
)


@dataclass(frozen=True, slots=True)
class Answer:
    """What a plate says: the runs for t_0, p_0 and p_5, and those for t_h, by deg C and by rise."""

    shortest: Result
    coolest: Result
    within: Result
    halves: tuple[Result, Result]

    def claim(self, half: Result) -> str:
        """Return whether the claim holds by one of the readings of half."""
        assert self.shortest.value is not None
        limit = MORE_TRAVEL * self.shortest.value
        if half.value is not None and half.value <= limit:
            return "holds"
        bound = np.inf if half.status is Status.INFEASIBLE else half.lower_bound
        return "refuted" if bound is not None and bound > limit else "open"

    def price(self, half: Result) -> str:
        """Return t_h as a share of t_0: its value, the range it lies in, or that no plan is so cool."""
        assert self.shortest.value is not None
        if half.status is Status.INFEASIBLE:
            return "no plan"
        low = "?" if half.lower_bound is None else f"{half.lower_bound / self.shortest.value:.2f}"
        high = "?" if half.value is None else f"{half.value / self.shortest.value:.2f}"
        return f"= {high}" if half.status is Status.OPTIMAL else f"{low} to {high}"


def ask(instance: Instance, seconds: float) -> Answer:
    """Answer for a plate, with so many seconds for each run."""
    ambient = require_heat(instance).ambient_c
    shortest = solve(instance, RULES, time_limit=seconds)
    assert shortest.value is not None
    runs = [shortest]
    for limit in (1.0, MORE_TRAVEL):
        most = limit * shortest.value
        runs.append(solve_heat(instance, COOL, time_limit=seconds, start=runs[-1].plan, most_travel=most))
    peak = runs[1].value
    assert peak is not None
    caps = (HALF * peak, ambient + HALF * (peak - ambient))
    halves = [
        solve_heat(instance, replace(RULES, temperature_cap=cap), time_limit=seconds, start=runs[2].plan)
        for cap in caps
    ]
    return Answer(runs[0], runs[1], runs[2], (halves[0], halves[1]))


def rows(answers: Iterable[Answer]) -> Iterator[Row]:
    """Yield a row for each plate."""
    for seed, answer in enumerate(answers):
        assert answer.within.value is not None
        assert answer.coolest.value is not None
        closed = answer.within.status is Status.OPTIMAL and answer.coolest.status is Status.OPTIMAL
        share = answer.within.value / answer.coolest.value
        yield [
            str(seed),
            f"{answer.shortest.value:.1f}",
            f"{'= ' if answer.coolest.status is Status.OPTIMAL else ''}{answer.coolest.value:.1f}",
            f"{'= ' if closed else ''}{share:.2f}",
            *(cell for half in answer.halves for cell in (answer.price(half), answer.claim(half))),
        ]


def verdict(answers: Sequence[Answer]) -> str:
    """Return on how many plates the claim holds, and what 5 % more travel and half the peak are worth."""
    texts = []
    for number, name in enumerate(("peak in deg C", "rise above ambient")):
        claims = [each.claim(each.halves[number]) for each in answers]
        costs = [
            half.value / each.shortest.value
            for each in answers
            if (half := each.halves[number]).value is not None and each.shortest.value is not None
        ]
        impossible = sum(each.halves[number].status is Status.INFEASIBLE for each in answers)
        cost = f"{np.mean(costs):.2f} (median {np.median(costs):.2f}) times" if costs else "?"
        texts.append(
            f"half the {name} for 5 % more travel: holds on {claims.count('holds')} of {len(claims)} plates, "
            f"refuted on {claims.count('refuted')} (no plan has it on {impossible}), open on "
            f"{claims.count('open')}; plans that have it travel {cost} as far"
        )
    shares = [
        each.within.value / each.coolest.value
        for each in answers
        if each.within.value is not None and each.coolest.value is not None
    ]
    texts.append(f"5 % more travel: {np.mean(shares):.2f} +- {np.std(shares):.2f} of the peak")
    return "\n".join(texts)


def main(arguments: list[str] | None = None) -> int:
    """Ask all plates, and print the table and the verdict."""
    parser = argparse.ArgumentParser(prog="python -m cutgap.benchmark.heat_bounds", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--plates", type=int, default=20, help="number of plates, with seeds 0, 1, ...")
    parser.add_argument("--contours", type=int, default=12)
    parser.add_argument("--seconds", type=float, default=60.0, help="time limit of each of five runs a plate")
    given = parser.parse_args(arguments)
    if given.plates < 1:
        parser.error(f"argument --plates: expected at least 1, got {given.plates}")
    answers: list[Answer] = []

    def asked() -> Iterator[Answer]:
        for seed in range(given.plates):
            answers.append(ask(generate("dense-plate", holes=given.contours, seed=seed), given.seconds))
            yield answers[-1]

    print_rows(f"{given.plates} dense plates of {given.contours} contours", COLUMNS, rows(asked()))
    print(verdict(answers))
    return 0


if __name__ == "__main__":
    sys.exit(main())
