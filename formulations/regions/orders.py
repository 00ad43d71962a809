"""Orders of some regions: where another may be inserted, and in which order a tour touches all of them."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from cutgap.formulations.regions.shapes import Shapes
from cutgap.formulations.regions.touching import misses, touch
from cutgap.instances.arrays import Floats, Ints

SLACK = 1e-9
"""How far outside a region (in its own coordinates) a relaxed tour may pass and still count as touching."""


class Orders:
    """Orders of regions under precedence.

    Parameters
    ----------
    shapes
        All regions; a home is the last one.
    home
        Whether there is a home. Orders begin with it.
    pairs
        Pairs (a, b) of regions: a is touched before b, both after the home is left.
    """

    def __init__(self, shapes: Shapes, *, home: bool, pairs: Sequence[tuple[int, int]] = ()) -> None:
        self.shapes = shapes
        self.count = len(shapes.centres)
        self.home = self.count - 1 if home else None
        self.inverses = np.ascontiguousarray(np.linalg.pinv(shapes.bases))
        self.before = _closure(self.count, pairs)
        self.is_ordered = bool(self.before.any())
        # A region has more regions before it than any of these has; the home comes first.
        rank = self.before.sum(axis=0)
        if self.home is not None:
            rank[self.home] = -1
        self.turn = np.argsort(rank, kind="stable")

    def places(self, order: Ints, region: int) -> range:
        """Return the places of an order behind which a region may be inserted."""
        if not self.is_ordered:
            return range(len(order))
        earlier = np.flatnonzero(self.before[order, region])
        later = np.flatnonzero(self.before[region, order])
        return range(int(earlier.max(initial=0)), int(later.min(initial=len(order))))

    def misses(self, order: Ints, p: Floats, slack: float = SLACK) -> Floats:
        """Return how far the tour through an order misses each region, mm; 0 for those in the order."""
        gaps = np.empty(self.count)
        misses(self.shapes, self.inverses, p, slack, gaps)
        gaps[order] = 0.0
        return gaps

    def all_in_order(self, order: Ints, p: Floats) -> Ints | int:
        """Return the order in which a tour touches all regions, or a region that it cannot touch in its turn.

        Each is touched as early as precedence allows, or, without precedence, deep inside.
        """
        places = np.full(self.count, -1.0)
        places[order] = np.arange(len(order))
        known = np.zeros(self.count, dtype=np.bool_)
        known[order] = True
        for region in self.turn.tolist():
            earlier = np.flatnonzero(self.before[:, region])
            since = float(places[earlier].max(initial=0.0))
            if known[region]:
                late = earlier[places[earlier] > places[region]]
                if len(late) > 0:
                    return int(late[0])
                continue
            low, high = touch(self.shapes, self.inverses, region, p, 10 * SLACK, since)
            if low < 0.0:
                return region
            places[region] = low if self.is_ordered else (low + high) / 2
        return self.turn[np.argsort(places[self.turn], kind="stable")]


def _closure(count: int, pairs: Sequence[tuple[int, int]]) -> npt.NDArray[np.bool_]:
    """Return which region is before which, given or by way of others."""
    before: npt.NDArray[np.bool_] = np.zeros((count, count), dtype=np.bool_)
    for a, b in pairs:
        before[a, b] = True
    for middle in range(count):
        before |= np.outer(before[:, middle], before[middle])
    return before
