"""The yardstick for entry points: order and entries of one head's tour, searched together under all its rules.

Ruin and recreate over the order of contours, in which each insertion is priced with all entries chosen anew
(``instances.entry_tours``). Precedence and parts in one go hold in every tour; a rapid between parts that are
no neighbours, or across a contour that is cut, has a price that adapts. The plan is the best one without such
rapids, or one with few of them where none was found: ``check`` then names them.
"""

import time

import numpy as np

from cutgap.heuristics.effort import PIECE_SECONDS, SearchEffort
from cutgap.heuristics.sides import Clock
from cutgap.instances import Instance, Plan, Rules, check, evaluate
from cutgap.instances.check import require_coordinates
from cutgap.instances.entry_tours import EntrySearch, entry_task
from cutgap.instances.progress import Progress, Watch, nobody


class Incumbent:
    """The best plan so far: fewest violations, then least value; told to the watch when it improves."""

    def __init__(self, instance: Instance, rules: Rules, watch: Watch, clock: Clock) -> None:
        self.instance, self.rules, self.watch, self.clock = instance, rules, watch, clock
        self.plan: Plan | None = None
        self.score = (np.inf, np.inf)

    def offer(self, plan: Plan) -> None:
        """Take the plan if it is better."""
        violations = len(check(self.instance, self.rules, plan))
        value = evaluate(self.instance, plan).objective(self.rules)
        if (violations, value) < self.score:
            self.plan, self.score = plan, (violations, value)
            self.watch(Progress(self.clock.seconds, value=None if violations else value))


def entry_search(
    instance: Instance,
    rules: Rules,
    *,
    rng: np.random.Generator,
    watch: Watch = nobody,
    time_limit: float | None = None,
    parameters: SearchEffort | None = None,
) -> Plan:
    """Plan one head, with any number of entry points.

    Stopped by the time limit (in s) or by Ctrl-C, it returns the best plan so far; the first plan is made in
    any case.

    Raises
    ------
    ValueError
        For more than one head, via points, or process rules without geometry.
    """
    if len(instance.heads) != 1:
        raise ValueError(
            f"entry-search: expected one head, got {len(instance.heads)}; "
            "local-search takes more, with one entry point per contour"
        )
    require_coordinates(instance, rules)
    parameters = parameters or SearchEffort()
    incumbent = Incumbent(instance, rules, watch, Clock(time_limit))
    if not instance.contours:
        return Plan(((),))
    try:
        search_pieces(incumbent, parameters.rounds_per_contour * len(instance.contours), rng)
    except KeyboardInterrupt:
        if incumbent.plan is None:
            raise
    assert incumbent.plan is not None  # the first tour is offered before any look at the clock
    return incumbent.plan


def search_pieces(incumbent: Incumbent, rounds: int, rng: np.random.Generator) -> None:
    """Run the search in pieces, and offer what each improves."""
    search = EntrySearch(entry_task(incumbent.instance, incumbent.rules), rounds, rng=rng)
    piece = 8
    known = (search.barred, search.cost)
    incumbent.offer(Plan((search.best.visits,)))
    while not search.over and not incumbent.clock.over:
        began = time.perf_counter()
        search.run(piece)
        if time.perf_counter() - began < PIECE_SECONDS / 2:
            piece *= 2
        if (search.barred, search.cost) < known:
            known = (search.barred, search.cost)
            incumbent.offer(Plan((search.best.visits,)))
