"""One run on an instance: the best allowed plan so far, valued exactly, the clock, and its watch."""

import time
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from cutgap.formulations.heat.annealing import MUCH, anneal, travel_of
from cutgap.formulations.heat.branching import ENDLESS, PEAK, TRAVEL, Limits
from cutgap.formulations.heat.plates import Plate, plan_of, plate_of, points_of, rise_limit
from cutgap.instances import Instance, Plan, Rules, check, evaluate
from cutgap.instances.arrays import Ints
from cutgap.instances.entry_tours import EntrySearch, entry_task
from cutgap.instances.progress import Progress, Watch

ROUNDS = 1000
"""Moves per contour of the first annealing; the next one is twice as long, up to ``LONGEST`` times."""
LONGEST = 128
FIRST_ROUNDS = 50
"""Rounds per contour of the search for a first plan, without heat."""
HOT, COLD = 0.05, 1e-4
"""Temperatures of the annealing, as shares of the objective."""
PRICES = (0.01, 0.03, 0.1)
"""Prices of one K, or mm, beyond a limit, as shares of the objective, in turn."""
STRICT = 300.0
"""For the peak they are prices of this part of the travel allowed, not of one mm."""
LOW_PRICES = (0.01, 0.005, 0.02)
"""Those with which an annealing begins afresh."""


class Run:
    """The state of one run.

    Attributes
    ----------
    most_travel
        Limit on travel and backward price besides the rules, mm (a point of the front asks for it).
    price
        Price of going back, in the rules or besides them.
    best, value
        The best allowed plan within all limits and its objective in ``rules.unit``.
    bound
        Proved bound on every such plan, same unit; ``None`` before there is one.
    """

    def __init__(
        self,
        instance: Instance,
        rules: Rules,
        watch: Watch,
        time_limit: float | None = None,
        most_travel: float = np.inf,
        backward_price: float = 0.0,
    ) -> None:
        self.instance, self.rules, self.watch = instance, rules, watch
        self.begun = time.perf_counter()
        self.deadline = np.inf if time_limit is None else self.begun + time_limit
        self.most_travel = most_travel
        # A price goes with no rules for the peak, yet counts in its limit on travel.
        self.price = max(rules.backward_price, backward_price)
        priced = replace(rules, objective="travel", weight=0.0, backward_price=self.price)
        self.plate: Plate = plate_of(instance, priced)
        self.best: Plan | None = None
        self.value: float | None = None
        self.bound: float | None = None
        self.service = float(instance.service_times.sum())

    @property
    def by_travel(self) -> bool:
        """Whether the objective is travel, or what follows from it."""
        return self.rules.objective != "peak"

    @property
    def seconds(self) -> float:
        """Since the run began."""
        return time.perf_counter() - self.begun

    @property
    def left(self) -> float | None:
        """Seconds until the time has run out; ``None`` without a limit."""
        return None if np.isinf(self.deadline) else float(self.deadline - time.perf_counter())

    @property
    def is_over(self) -> bool:
        """Whether the time has run out."""
        return time.perf_counter() >= self.deadline

    def limits(self) -> Limits:
        """Return the limits of a search: travel and rise allowed at most, with their slack."""
        slack = 1e-11 * max(1.0, self.most_travel) if np.isfinite(self.most_travel) else 0.0
        return Limits(
            self.most_travel + slack,
            rise_limit(self.instance, self.rules),
            self.instance.machine.v_jump,
            TRAVEL if self.by_travel else PEAK,
        )

    def objective(self, internal: float) -> float:
        """Return the objective, in ``rules.unit``, for travel in mm or the largest rise in K."""
        if self.by_travel:
            if self.rules.objective == "makespan":
                return internal / self.instance.machine.v_jump + self.service
            return internal
        assert self.instance.material is not None
        return self.instance.material.ambient_c + internal

    def internal(self, plan: Plan) -> float:
        """Return travel (price included) in mm, or the largest rise in K, of a plan."""
        evaluation = evaluate(self.instance, plan)
        if self.by_travel:
            return evaluation.total_travel_mm + self.price * sum(evaluation.backward_mm)
        assert evaluation.peak_temperature_c is not None
        assert self.instance.material is not None
        return evaluation.peak_temperature_c - self.instance.material.ambient_c

    @property
    def cutoff(self) -> float:
        """The objective of the best plan, inside, less what rounding may add; infinite without a plan."""
        if self.best is None:
            return np.inf
        internal = min(self.internal(self.best), ENDLESS)
        return internal - 1e-11 * max(1.0, abs(internal))

    def offer(self, plan: Plan) -> bool:
        """Keep a plan that is within all limits, and better; return whether it is within them."""
        if check(self.instance, self.rules, plan):
            return False
        evaluation = evaluate(self.instance, plan)
        travel = evaluation.total_travel_mm + self.price * sum(evaluation.backward_mm)
        if travel > self.limits().travel:
            return False
        value = evaluation.objective(self.rules)
        if self.value is None or value < self.value:
            self.best, self.value = plan, value
            self.report()
        return True

    def report(self) -> None:
        """Tell the watch."""
        self.watch(Progress(self.seconds, self.value, self.bound))

    def first_path(self) -> Ints:
        """Return the points of a short plan that was sought without heat; it may break rules."""
        rounds = FIRST_ROUNDS * len(self.instance.contours)
        search = EntrySearch(entry_task(self.instance, self.rules), rounds, rng=np.random.default_rng(0))
        search.run(rounds)
        plan = Plan((search.best.visits,))
        self.offer(plan)
        return points_of(self.plate, plan)

    def improve(self, pieces: Iterator[None], seconds: float) -> None:
        """Go on with ``annealing`` for so many seconds, or to its end."""
        until = min(self.deadline, time.perf_counter() + seconds)
        while time.perf_counter() < until:
            if next(pieces, self) is self:
                return

    def annealing(self, start: Ints, longest: int = LONGEST, *, afresh: bool = False) -> Iterator[None]:
        """Anneal piece by piece, in ever longer runs, until four of the longest found nothing better.

        A run begins with the best plan, or with ``start`` where there is none. With ``afresh`` every other one
        begins with ``start``, prices are low, and there is no end.
        """
        prices = LOW_PRICES if afresh else PRICES
        rng, limits, idle, turn = np.random.default_rng(0), self.limits(), 0, 0
        while (afresh or idle < 4) and len(start) > 1:
            anew = afresh and turn % 2 == 0
            path = start.copy() if self.best is None or anew else points_of(self.plate, self.best)
            if not np.isfinite(travel_of(self.plate, path)):
                return
            scale = min(MUCH, max(1e-3, self.internal(plan_of(self.plate, path))))
            price = prices[turn % len(prices)] * scale
            if not self.by_travel and np.isfinite(limits.travel):
                price *= STRICT / max(1e-3, limits.travel)
            length, before = min(longest, 2**turn), self.value
            heats = np.geomspace(HOT * scale, COLD * scale, length + 1)
            for hot, cold in pairwise(heats.tolist()):
                moves = ROUNDS * len(path)
                value, found = anneal(self.plate, limits, path, price, hot, cold, moves, rng)
                if np.isfinite(value):
                    self.offer(plan_of(self.plate, found))
                yield
            better = self.value is not None and (before is None or self.value < before)
            idle = 0 if better or length < longest else idle + 1
            turn += 1
