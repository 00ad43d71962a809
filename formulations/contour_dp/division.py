r"""Which entry points either of two heads may use, and what follows when contours or thresholds are decided.

    r_v        rank of the x of entry point v among all different x, ascending
    k          thresholds: the left head may use points of r <= upto_k, the right one those of r >= since_k
    (1)        since_k is the first rank whose x is upto_k's x plus F or more
    (2)        of thresholds with the same since, the one of largest upto holds all plans of the others

A plan keeps non-overlap if and only if some threshold holds it: take the largest x of the left head for (1).
Where ranges may overlap all ranks are 0, and one threshold holds everything.

A *region* is a set of plans: thresholds lo..hi, and the head of some contours. Narrowing it drops thresholds at
which some contour has no point left, and decides contours that have points for one head only.
"""

from bisect import bisect_left
from dataclasses import dataclass
from functools import partial

import numpy as np

from cutgap.formulations.contour_dp.walks import Bools
from cutgap.instances import Instance, Plan, Rules
from cutgap.instances.arrays import Ints, difference

FREE, LEFT, RIGHT = 0, 1, 2


@dataclass(frozen=True, eq=False)
class Region:
    """Thresholds low..high, and FREE, LEFT or RIGHT for each contour."""

    low: int
    high: int
    side: Ints

    @property
    def free(self) -> list[int]:
        """Contours that either head may have."""
        return np.flatnonzero(self.side == FREE).tolist()

    def decided(self, contour: int, head: int) -> "Region":
        """Return the region with a contour given to head 0 or 1."""
        side = self.side.copy()
        side[contour] = (LEFT, RIGHT)[head]
        return Region(self.low, self.high, side)


class Division:
    """Ranks and thresholds of an instance with two heads, see the module."""

    def __init__(self, instance: Instance, rules: Rules) -> None:
        count = len(instance.contours)
        self.contour_of = np.repeat(np.arange(count), np.diff(instance.first_node))
        self.first = instance.first_node
        self.may_rest = rules.empty_heads or count < 2
        points = int(instance.first_node[-1])
        if rules.non_overlap is None:
            self.rank = np.zeros(points, dtype=np.int64)
            self.upto, self.since = np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.int64)
        else:
            xs, rank = np.unique(instance.points[:points, 0], return_inverse=True)
            self.rank = rank.astype(np.int64)
            self.upto, self.since = _thresholds(xs.tolist(), rules.non_overlap)
        self.least = np.minimum.reduceat(self.rank, self.first[:-1]) if count else self.rank
        self.most = np.maximum.reduceat(self.rank, self.first[:-1]) if count else self.rank

    @property
    def everything(self) -> Region | None:
        """All plans; ``None`` when there are none."""
        return self.narrowed(Region(0, len(self.upto) - 1, np.full(len(self.least), FREE)))

    def narrowed(self, region: Region) -> Region | None:
        """Return the same plans as a region with fewer thresholds and free contours; ``None`` without plans."""
        low, high, side = region.low, region.high, region.side
        while True:
            lefts = (self.least <= self.upto[low : high + 1, None]) & (side != RIGHT)
            rights = (self.most >= self.since[low : high + 1, None]) & (side != LEFT)
            fits = np.flatnonzero((lefts | rights).all(axis=1))
            if len(fits) == 0:
                return None
            new = np.where(lefts[fits].any(axis=0), side, RIGHT)
            new = np.where(rights[fits].any(axis=0), new, LEFT)
            low, high = low + int(fits[0]), low + int(fits[-1])
            if (new == side).all():
                break
            side = new
        if not self.may_rest and ((side == LEFT).all() or (side == RIGHT).all()):
            return None
        return Region(low, high, side)

    def points(self, region: Region) -> tuple[Bools, Bools]:
        """Return which entry points the left and the right head may use."""
        side = region.side[self.contour_of]
        left = (self.rank <= self.upto[region.high]) & (side != RIGHT)
        right = (self.rank >= self.since[region.low]) & (side != LEFT)
        return left, right

    def halves(self, region: Region, plan: Plan) -> tuple[Region, Region] | None:
        """Return two regions with all plans that keep non-overlap, without this plan; ``None`` if it does."""
        ranks = [[int(self.rank[self.first[c] + entry]) for c, entry, _ in tour] for tour in plan.tours]
        if not all(ranks):
            return None
        first = int(np.searchsorted(self.upto, max(ranks[0])))
        last = int(np.searchsorted(self.since, min(ranks[1]), side="right")) - 1
        if first <= last:
            return None
        cut = (last + first - 1) // 2
        return Region(region.low, cut, region.side), Region(cut + 1, region.high, region.side)


def _thresholds(xs: list[float], gap: float) -> tuple[Ints, Ints]:
    """Return upto and since of (1), without what (2) makes needless; rank -1 is a left head without work."""
    since = {0: -1}
    for rank, x in enumerate(xs):
        reached = bisect_left(xs, gap, lo=rank, key=partial(difference, x))
        since[reached] = rank
    return np.array(list(since.values()), dtype=np.int64), np.array(list(since), dtype=np.int64)
