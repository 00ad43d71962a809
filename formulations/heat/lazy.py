"""Least travel under a cap on larger plates: walk problems, and runs of visits forbidden as they appear.

First the problem without heat, whose bound holds under every cap. Then, for a head with a home, rounds: the
best walk without the runs known so far (``runs``) bounds every plan; it is the best plan, or shows new runs.
Annealing gives plans in between. Without a home times count from where the tour begins, which the walk problem
leaves open: there the bound without heat is all.
"""

import time
from dataclasses import replace

import numpy as np

from cutgap.formulations.contour_dp.closing import Closing, Incumbent
from cutgap.formulations.contour_dp.solve import ContourSearch
from cutgap.formulations.contour_dp.walks import Walks, walk_problems
from cutgap.formulations.heat.plates import plan_of
from cutgap.formulations.heat.run import Run
from cutgap.formulations.heat.runs import Run as Visits
from cutgap.formulations.heat.runs import States, too_warm, widened, without_hot_pairs
from cutgap.instances import Plan, Rules
from cutgap.instances.arrays import Ints
from cutgap.instances.progress import nobody

ANNEAL_SECONDS = 60.0
"""Longest first annealing; later ones take at most as long as the round before."""
LONG = 8
"""Visits of a run beyond which it rules out little."""
SHARE = 0.3
"""Share of the time that is left that an annealing may take, and half of the one without heat."""


def without_heat(rules: Rules) -> Rules:
    """Return the rules of the problem without heat, for travel."""
    objective = "travel" if rules.objective == "peak" else rules.objective
    return replace(rules, objective=objective, temperature_cap=None)


def plain_search(run: Run, seconds: float | None) -> ContourSearch:
    """Return the search for least travel without heat."""
    return ContourSearch(run.instance, without_heat(run.rules), None, time.perf_counter(), seconds, nobody)


class LazySearch:
    """The rounds of a run.

    Attributes
    ----------
    plain
        The search without heat.
    runs
        The runs known so far.
    """

    def __init__(self, run: Run, start: Ints) -> None:
        self.run = run
        self.annealings = (run.annealing(start), run.annealing(start, afresh=True))
        self.cap = run.limits().rise
        self.runs: list[Visits] = []
        left = run.deadline - time.perf_counter()
        self.plain = plain_search(run, 2.0 * SHARE * max(0.0, left) if np.isfinite(left) else None)

    def search(self) -> bool:
        """Run to the end; False when the time ended before."""
        run = self.run
        while self.plain.advance():
            pass
        closed = self.plain.closed
        self._note(self.plain.bound)
        self._offer_turned()
        if closed and self.plain.plan is None:
            return True
        if (
            closed
            and run.best is not None
            and run.internal(run.best) <= self.plain.incumbent.cost * (1.0 + 1e-12)
        ):
            return True
        self._anneal(self._share(ANNEAL_SECONDS))
        if run.instance.heads[0].home is None:
            return False
        return self._rounds()

    def _offer_turned(self) -> None:
        """Offer the best plan without heat; without a home, from wherever it may begin."""
        if self.plain.plan is None:
            return
        tour, turns = self.plain.plan.tours[0], 1
        if self.run.instance.heads[0].home is None:
            turns = len(tour)
        for turn in range(turns):
            self.run.offer(Plan((tour[turn:] + tour[:turn],)))

    def _anneal(self, seconds: float) -> None:
        """Look for plans for so many seconds, in both ways: neither is the better one on all plates."""
        for pieces in self.annealings:
            self.run.improve(pieces, seconds / len(self.annealings))

    def _share(self, most: float) -> float:
        left = self.run.deadline - time.perf_counter()
        return min(most, SHARE * left) if np.isfinite(left) else most

    def _note(self, internal: float) -> None:
        """Keep a bound."""
        run = self.run
        internal = min(internal, np.inf if run.best is None else run.internal(run.best))
        if np.isfinite(internal):
            bound = run.objective(max(0.0, internal))
            run.bound = bound if run.bound is None else max(run.bound, bound)
        run.report()

    def _rounds(self) -> bool:
        run = self.run
        walks = without_hot_pairs(run.plate, walk_problems(run.instance, without_heat(run.rules))[0], self.cap)
        prices = None
        while not run.is_over:
            begun = time.perf_counter()
            problem, point_of = States(walks, self.runs).problem()
            closing, incumbent = self._close(problem, prices)
            prices = closing.ascent.prices
            if incumbent.best is None:
                return closing.closed
            walk = point_of[incumbent.best[1]]
            if run.offer(plan_of(run.plate, walk)):
                if closing.closed:
                    return True
                continue
            if not self._learn(walk):
                return False
            self._anneal(self._share(time.perf_counter() - begun))
        return False

    def _close(self, problem: Walks, prices: np.ndarray | None) -> tuple[Closing, Incumbent]:
        """Work on the walk problem of a round until it is closed, or the time is over."""
        run = self.run
        incumbent = Incumbent(np.inf if run.best is None else run.internal(run.best), 0.0)
        closing = Closing(problem, incumbent, run.deadline, lambda _: run.report())
        if prices is not None:
            closing.ascent.prices = prices
        while not closing.closed and not closing.stuck and not run.is_over:
            closing.advance()
            self._note(min(closing.bound, incumbent.limit))
        if closing.closed:
            self._note(incumbent.limit)
        return closing, incumbent

    def _learn(self, walk: Ints) -> bool:
        """Add the runs that a walk shows, one long one at most; False when rounding hides them."""
        known, shown = len(self.runs), sorted(too_warm(self.run.plate, walk, self.cap), key=len)
        for number, points in enumerate(shown):
            if number > 0 and len(points) > LONG:
                break
            run = widened(self.run.plate, points, self.cap)
            if run not in self.runs:
                self.runs.append(run)
        return len(self.runs) > known
