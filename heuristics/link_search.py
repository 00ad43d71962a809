"""Our search over links: which contours one pierce serves, by which links, and where it pays to pierce anew.

Ruin and recreate (``link_moves``) from the best of three plans:

    (1) the reference's (``euler_bridging``): doubled links of a spanning tree, one stroke;
    (2) its forest of the links that pay, 2 |pq| / v_cut < t_aux, joined by what costs least;
    (3) the tour of ``entry_search``, without links, where as many pierces are allowed as there are contours,
        they alone do not cost more than (1), and there are at most ``MOST_NODES`` entry points.

It is never worse than (1), nor than (3) where that is tried. New links lead between near entry points only.
"""

import time
from dataclasses import replace

import numpy as np

from cutgap.heuristics.effort import PIECE_SECONDS, SearchEffort
from cutgap.heuristics.entry_search import Incumbent, entry_search
from cutgap.heuristics.euler_bridging import euler_bridging
from cutgap.heuristics.link_moves import (
    BEST,
    BEST_PRICE,
    COST,
    PRICE,
    SCALE,
    iterate,
    recreate,
    score,
)
from cutgap.heuristics.link_rings import Rings, Sheet, copy, new_rings, total
from cutgap.heuristics.link_sheet import MOST_NODES, chosen_nodes, plan_of_rings, rings_of, sheet_of
from cutgap.heuristics.sides import Clock
from cutgap.instances import Instance, Plan, Rules
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.links.strokes import link_length
from cutgap.instances.progress import Watch, nobody


def link_search(
    instance: Instance,
    rules: Rules,
    *,
    rng: np.random.Generator,
    watch: Watch = nobody,
    time_limit: float | None = None,
    parameters: SearchEffort | None = None,
) -> Plan:
    """Plan one head whose contours may be joined by links, with any number of pierces that the rules allow.

    Stopped by the time limit (in s) or by Ctrl-C, it returns the best plan so far; the reference's plan is made
    in any case. Where clear links do not reach every contour, the plan may need more pierces than the rules
    allow, and ``check`` says so.

    Raises
    ------
    ValueError
        When the rules do not allow links, or do not suit the instance (see ``link_check.require_links``).
    """
    parameters = parameters or SearchEffort()
    clock = Clock(time_limit)
    incumbent = Incumbent(instance, rules, watch, clock)
    reference = euler_bridging(instance, rules, rng=rng)
    incumbent.offer(reference)
    try:
        if instance.contours and not clock.over:
            tour = _tour(instance, rules, rng, clock, incumbent.score[1])
            if tour is not None:
                incumbent.offer(tour)
            _search(incumbent, reference, tour, parameters, rng)
    except KeyboardInterrupt:
        pass
    assert incumbent.plan is not None  # the reference is offered before any look at the clock
    return incumbent.plan


def _tour(
    instance: Instance, rules: Rules, rng: np.random.Generator, clock: Clock, value: float
) -> Plan | None:
    """Return (3), with a third of the time, or ``None`` where it cannot beat ``value``, or is not tried."""
    contours, machine = len(instance.contours), instance.machine
    if rules.pierces is not None and rules.pierces < contours:
        return None
    least = contours * machine.t_aux + float(instance.perimeters.sum()) / machine.v_cut
    if (rules.objective == "makespan" and least >= value) or instance.node_count > MOST_NODES:
        return None
    left = None if clock.limit is None else (clock.limit - clock.seconds) / 3
    if left is not None and left <= 0:
        return None
    return entry_search(instance, replace(rules, links=False, pierces=None), rng=rng, time_limit=left)


def _forest(instance: Instance, rules: Rules, reference: Plan) -> Plan:
    """Return the links of (2), without visits."""
    machine = instance.machine
    if rules.objective == "travel":
        return Plan(((),), reference.links)
    pays = machine.v_cut * machine.t_aux
    return Plan(((),), tuple(link for link in reference.links if 2 * link_length(instance, link) < pays))


def _search(
    incumbent: Incumbent,
    reference: Plan,
    tour: Plan | None,
    parameters: SearchEffort,
    rng: np.random.Generator,
) -> None:
    """Search from the best of the three plans, and offer what is found."""
    instance, rules = incumbent.instance, incumbent.rules
    known = [plan for plan in (reference, tour) if plan is not None]
    wanted = {instance.node(*visit[:2]) for plan in known for visit in plan.tours[0]}
    wanted |= {instance.node(*end) for link in reference.links for end in (link[:2], link[2:4])}
    nodes = chosen_nodes(instance, wanted)
    search = _Run(sheet_of(instance, rules, nodes, reference), rng)
    for plan in known:
        search.take(rings_of(search.sheet, nodes, instance, plan))
    search.take(search.joined(rings_of(search.sheet, nodes, instance, _forest(instance, rules, reference))))
    search.set_scale(instance.machine.t_aux if rules.objective == "makespan" else 0.0)
    rounds, piece, offered = parameters.rounds_per_contour * len(instance.contours), 8, np.inf
    while True:
        if search.figures[BEST] < offered:
            offered = search.figures[BEST]
            price = float(search.figures[BEST_PRICE])
            incumbent.offer(plan_of_rings(search.sheet, nodes, instance, search.best, price))
        if search.done >= rounds or incumbent.clock.over:
            break
        began = time.perf_counter()
        search.run(min(rounds, search.done + piece), rounds)
        if time.perf_counter() - began < PIECE_SECONDS / 2:
            piece *= 2


class _Run:
    """A search: the current, the tried and the best cycles, with their figures (see ``link_moves``)."""

    def __init__(self, sheet: Sheet, rng: np.random.Generator) -> None:
        contours = len(sheet.first) - 2
        self.sheet, self.rng, self.done = sheet, rng, 0
        self.now, self.trial, self.best = (new_rings(sheet) for _ in range(3))
        self.figures: Floats = np.zeros(6)
        self.figures[[COST, BEST]] = np.inf
        if sheet.pierces < contours:
            # One pierce is asked for at any price; else the price adapts.
            self.figures[PRICE] = sheet.far * (1000.0 if sheet.pierces == 1 else 1.0)
        self.pieces: Ints = np.zeros(contours + 1, dtype=np.int64)
        self.stack: Ints = np.zeros(contours + 1, dtype=np.int64)

    def joined(self, rings: Rings) -> Rings:
        """Return the cycles with all pieces joined to the home."""
        recreate(self.sheet, rings, float(self.figures[PRICE]), self.pieces, self.stack, self.rng)
        return rings

    def take(self, rings: Rings) -> None:
        """Make a start the current one, and the best one, where it is better."""
        price = float(self.figures[PRICE])
        cost, plain, fine = score(self.sheet, rings, price, self.pieces, self.stack)
        if cost < self.figures[COST]:
            copy(rings, self.now)
            self.figures[COST] = cost
        if fine and plain < self.figures[BEST]:
            copy(rings, self.best)
            self.figures[[BEST, BEST_PRICE]] = plain, price

    def set_scale(self, pierce: float) -> None:
        """Measure temperatures in mean edges of the current cycles, without pierces and the home's rapids."""
        home = self.now.node[[0, self.now.after[0], self.now.before[0]]]
        price = float(self.figures[PRICE])
        cost, pierces = total(self.sheet, self.now, price)
        edges = cost - self.sheet.rapid[home[0], home[1]] - self.sheet.rapid[home[2], home[0]]
        self.figures[SCALE] = max(0.0, edges - (pierces - 1) * (price + pierce)) / len(self.pieces)

    def run(self, until: int, rounds: int) -> None:
        """Do the rounds up to ``until`` of ``rounds``."""
        iterate(self.sheet, self.now, self.trial, self.best, self.figures, self.done, until, rounds, self.rng)
        self.done = until
