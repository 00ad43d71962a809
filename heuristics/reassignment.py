"""Moves of contours between heads by ruin and recreate (Schrimpf et al., 2000).

A round takes a few neighbouring contours off their heads, puts each back where the score then is best (now
and then on a random head), and searches the changed tours. The outcome is kept unless it is worse.
"""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from cutgap.heuristics.side_search import cheapest_insertion, search_side
from cutgap.heuristics.sides import Clock, Score, SideTour, contour_xs, score, side_tour
from cutgap.instances import Instance, Rules
from cutgap.instances.arrays import Ints

MOST_REMOVED = 8
"""Most contours taken off in one round."""

RANDOM_HEAD = 0.1
"""Chance that a contour goes back to a random head: the way out of a local optimum."""


class Best(Protocol):
    """The best plan so far, to which better ones are offered."""

    instance: Instance
    rules: Rules
    clock: Clock
    sides: tuple[SideTour, ...] | None

    def offer(self, sides: Sequence[SideTour]) -> bool:
        """Take the tours if they are better, and say whether they were."""
        ...


def work_shares(instance: Instance) -> list[Ints]:
    """Return contours per head: runs along x (as listed, without coordinates) of about equal service time."""
    n, heads = len(instance.contours), len(instance.heads)
    order = np.argsort(contour_xs(instance), kind="stable") if instance.located else np.arange(n)
    # One more second each, so that contours without any work are shared out, too.
    work = np.cumsum(instance.service_times[order] + 1.0)
    middle = work - (instance.service_times[order] + 1.0) / 2
    share = np.minimum((heads * middle / work[-1]).astype(np.int64), heads - 1) if n else np.empty(0)
    return [order[share == head] for head in range(heads)]


def reassign(best: Best, movable: Ints, rounds: int, kicks: int, rng: np.random.Generator) -> None:
    """Run rounds of ruin and recreate on the movable contours, from the best plan so far."""
    assert best.sides is not None
    current = best.sides
    value = score(best.instance, best.rules, current)
    for _ in range(rounds if len(movable) else 0):
        if best.clock.over:
            return
        tried = ruin_and_recreate(best.instance, best.rules, current, movable, kicks, rng)
        tried_value = score(best.instance, best.rules, tried)
        if tried_value <= value:
            current, value = tried, tried_value
            best.offer(current)


def ruin_and_recreate(
    instance: Instance,
    rules: Rules,
    sides: tuple[SideTour, ...],
    movable: Ints,
    kicks: int,
    rng: np.random.Generator,
) -> tuple[SideTour, ...]:
    """Return the plan after one round."""
    removed = neighbouring(instance, movable, rng)
    gone = set(removed)
    trial = [
        side_tour(instance, h, [c for c in side.contours if c not in gone]) for h, side in enumerate(sides)
    ]
    for contour in removed:
        options = [insertion(instance, head, side, contour) for head, side in enumerate(trial)]
        if rng.random() < RANDOM_HEAD:
            head = int(rng.integers(len(trial)))
        else:
            head = min(range(len(trial)), key=lambda h: score_with(instance, rules, trial, h, options[h]))
        trial[head] = options[head]
    for head, side in enumerate(trial):
        if side.contours != sides[head].contours:
            same = sorted(side.contours) == sorted(sides[head].contours)
            start = sides[head].contours if same else side.contours
            trial[head] = search_side(instance, rules, head, start, kicks=kicks, rng=rng)
    return tuple(trial)


def neighbouring(instance: Instance, movable: Ints, rng: np.random.Generator) -> list[int]:
    """Return a random movable contour and some of the movable ones nearest to it, in random order."""
    count = 1 + int(rng.integers(min(MOST_REMOVED, len(movable))))
    nodes = instance.first_node[movable]
    centre = nodes[int(rng.integers(len(movable)))]
    nearest = np.argsort(instance.rapids[centre, nodes], kind="stable")[:count]
    return [int(c) for c in movable[rng.permutation(nearest)]]


def insertion(instance: Instance, head: int, side: SideTour, contour: int) -> SideTour:
    """Return a head's tour with one more contour in the cheapest place (via points set right later)."""
    extra, index = cheapest_insertion(instance, head, side.contours, contour)
    contours = (*side.contours[:index], contour, *side.contours[index:])
    seconds = extra / instance.machine.v_jump + float(instance.service_times[contour])
    return SideTour(contours, side.travel_mm + extra, side.time_s + seconds)


def score_with(instance: Instance, rules: Rules, sides: Sequence[SideTour], head: int, side: SideTour) -> Score:
    """Return the score with one head's tour replaced; equal makespans are told apart by travel."""
    replaced = [side if h == head else other for h, other in enumerate(sides)]
    excess, value = score(instance, rules, replaced)
    return excess, value + 1e-9 * sum(each.travel_mm for each in replaced)
