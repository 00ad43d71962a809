"""The modern yardstick: local search under the rules, for comparison with the published heuristics.

With non-overlap the plan is a split of the contours in x (see the threshold theorem in the documentation):
all splits are surveyed with tours of a few kicks, each started from its neighbour's; the best are then
searched with many. Contours of equal x next to the split, which may go either side, and all contours where
overlap is allowed, are reassigned by ruin and recreate.
"""

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cutgap.heuristics.reassignment import reassign, work_shares
from cutgap.heuristics.side_search import adapt_tour, search_side
from cutgap.heuristics.sides import (
    Clock,
    Score,
    SideTour,
    allowed_splits,
    contour_xs,
    plan_of,
    require_plain,
    require_two_sides,
    score,
)
from cutgap.instances import Instance, Plan, Rules
from cutgap.instances.arrays import Ints
from cutgap.instances.progress import Progress, Watch, nobody

SURVEYED = 128
"""Most splits that are surveyed evenly; of more, those near the best follow."""

Sides = tuple[SideTour, ...]


@dataclass(frozen=True, slots=True)
class LocalSearchParameters:
    """Effort of the local search.

    Parameters
    ----------
    kicks
        Perturbations per tour of a promising split; the best one gets four times as many in the end.
    survey_kicks
        Perturbations per tour when all splits are surveyed.
    finalists
        Splits that get the full ``kicks``.
    reassignments
        Rounds of ruin and recreate.
    """

    kicks: int = 500
    survey_kicks: int = 10
    finalists: int = 7
    reassignments: int = 200

    def __post_init__(self) -> None:
        for name, least in (("kicks", 0), ("survey_kicks", 0), ("finalists", 1), ("reassignments", 0)):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or value < least:
                raise ValueError(
                    f"local search, {name}: expected a whole number of at least {least}, got {value!r}"
                )


class Incumbent:
    """The best plan so far, told to the watch when it improves."""

    def __init__(self, instance: Instance, rules: Rules, watch: Watch, clock: Clock) -> None:
        self.instance, self.rules, self.watch, self.clock = instance, rules, watch, clock
        self.sides: Sides | None = None
        self.score: Score = (np.inf, np.inf)

    def offer(self, sides: Sequence[SideTour]) -> bool:
        """Take the tours if they are better, and say whether they were."""
        offered = score(self.instance, self.rules, sides)
        if offered >= self.score:
            return False
        self.sides, self.score = tuple(sides), offered
        self.watch(Progress(self.clock.seconds, value=offered[1] if offered[0] == 0 else None))
        return True


def local_search(
    instance: Instance,
    rules: Rules,
    *,
    rng: np.random.Generator,
    watch: Watch = nobody,
    time_limit: float | None = None,
    parameters: LocalSearchParameters | None = None,
) -> Plan:
    """Plan one head, two heads without overlap, or any number of heads where overlap is allowed.

    Stopped by the time limit (in s) or by Ctrl-C, it returns the best plan so far; the first plan is made in
    any case.

    Raises
    ------
    ValueError
        For several entry points, precedence, more than two heads without overlap, or rules in x without
        coordinates.
    """
    require_plain(instance, "local-search")
    if rules.via_points and not instance.located:
        raise ValueError("local-search: via points need coordinates, and the instance has only a matrix")
    parameters = parameters or LocalSearchParameters()
    incumbent = Incumbent(instance, rules, watch, Clock(time_limit))
    try:
        if len(instance.heads) > 1 and rules.non_overlap is not None:
            require_two_sides(instance, "local-search")
            search_splits(incumbent, parameters, rng)
        else:
            search_overlapping(incumbent, parameters, rng)
    except KeyboardInterrupt:
        if incumbent.sides is None:
            raise
    assert incumbent.sides is not None  # both searches offer a plan before they look at the clock
    return plan_of(incumbent.sides)


def search_overlapping(
    incumbent: Incumbent, parameters: LocalSearchParameters, rng: np.random.Generator
) -> None:
    """Search plans whose ranges may overlap, from a partition into equal work along x."""
    instance, rules = incumbent.instance, incumbent.rules
    sides = []
    for head, share in enumerate(work_shares(instance)):
        start = adapt_tour(instance, head, (), share)
        sides.append(search_side(instance, rules, head, start, kicks=parameters.kicks, rng=rng))
    incumbent.offer(sides)
    if len(sides) > 1:
        everything = np.arange(len(instance.contours))
        reassign(incumbent, everything, parameters.reassignments, parameters.survey_kicks, rng)
        polish(incumbent, parameters.kicks, rng)


def polish(incumbent: Incumbent, kicks: int, rng: np.random.Generator) -> None:
    """Search the tours of the incumbent once more, with their contours as they are."""
    assert incumbent.sides is not None
    if not incumbent.clock.over:
        incumbent.offer(
            [
                search_side(incumbent.instance, incumbent.rules, head, side.contours, kicks=kicks, rng=rng)
                for head, side in enumerate(incumbent.sides)
            ]
        )


class SplitSearch:
    """Tours of both heads for the splits seen so far, over contours sorted by x, then y."""

    def __init__(self, incumbent: Incumbent, rng: np.random.Generator) -> None:
        instance = incumbent.instance
        ys = instance.points[instance.first_node[:-1], 1]
        self.incumbent, self.rng = incumbent, rng
        self.order: Ints = np.lexsort((ys, contour_xs(instance)))
        self.planned: dict[int, Sides] = {}

    def plan(self, split: int, kicks: int) -> Score:
        """Search both tours of a split, from what is known of it or of the nearest split; keep the better."""
        instance, rules = self.incumbent.instance, self.incumbent.rules
        near = min(self.planned, key=lambda other: (abs(other - split), other), default=None)
        sides = []
        for head, contours in enumerate((self.order[:split], self.order[split:])):
            known = () if near is None else self.planned[near][head].contours
            start = adapt_tour(instance, head, known, contours)
            side = search_side(instance, rules, head, start, kicks=kicks, rng=self.rng)
            if near == split and self.planned[near][head].travel_mm < side.travel_mm:
                side = self.planned[near][head]
            sides.append(side)
        self.planned[split] = tuple(sides)
        self.incumbent.offer(sides)
        return self.score(split)

    def score(self, split: int) -> Score:
        """Return the score of a planned split."""
        return score(self.incumbent.instance, self.incumbent.rules, self.planned[split])


def search_splits(incumbent: Incumbent, parameters: LocalSearchParameters, rng: np.random.Generator) -> None:
    """Survey the splits, search the promising ones, then reassign the contours of equal x at the best one."""
    search = SplitSearch(incumbent, rng)
    splits = allowed_splits(incumbent.instance, incumbent.rules, search.order)
    for index in survey(len(splits)):
        search.plan(splits[index], parameters.survey_kicks)
        if incumbent.clock.over:
            return
    searched: set[int] = set()
    while len(searched) < min(parameters.finalists, len(splits)) and not incumbent.clock.over:
        best = min(search.planned, key=search.score)
        at = bisect_left(splits, best)
        for beside in splits[max(0, at - 1) : at + 2]:
            if beside not in search.planned:
                search.plan(beside, parameters.survey_kicks)
        waiting = [split for split in search.planned if split not in searched]
        # Every other finalist is away from those before: the survey cannot rank distant splits well.
        apart = [split for split in waiting if all(abs(split - other) > 2 for other in searched)]
        split = min(apart if apart and len(searched) % 2 else waiting, key=search.score)
        searched.add(split)
        search.plan(split, parameters.kicks)
    movable = contours_of_equal_x(incumbent)
    if len(movable):
        reassign(incumbent, movable, parameters.reassignments, parameters.survey_kicks, rng)
    polish(incumbent, 4 * parameters.kicks, rng)


def survey(count: int) -> list[int]:
    """Return indices into ``count`` splits: the middle one first, as a stopped run should have it."""
    indices = np.unique(np.linspace(0, count - 1, min(count, SURVEYED)).round().astype(int)).tolist()
    middle = len(indices) // 2
    return indices[middle:] + indices[:middle][::-1]


def contours_of_equal_x(incumbent: Incumbent) -> Ints:
    """Return the contours beside the split that share their x with another and so may change sides."""
    if incumbent.rules.non_overlap != 0 or incumbent.sides is None:
        return np.empty(0, dtype=np.int64)
    xs = contour_xs(incumbent.instance)
    left, right = (xs[list(side.contours)] for side in incumbent.sides)
    edges = [*([left.max()] if len(left) else []), *([right.min()] if len(right) else [])]
    groups = [np.flatnonzero(xs == edge) for edge in set(edges)]
    shared = [group for group in groups if len(group) > 1]
    return np.sort(np.concatenate(shared)) if shared else np.empty(0, dtype=np.int64)
