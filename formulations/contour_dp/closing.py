"""Closing walk problems: rounds of the ascent and ever wider searches, until bound and best walk meet.

A problem is closed when the best relaxed walk is a walk of it, when the relaxation leaves no walk below the
limit (``ascent``), or when a search left no state out (``search``). A better walk must stay below the limit.
"""

import time
from collections.abc import Callable
from functools import partial

import numpy as np

from cutgap.formulations.contour_dp.ascent import Ascent
from cutgap.formulations.contour_dp.scenes import Passed, PassMaker
from cutgap.formulations.contour_dp.search import MOST_CONTOURS, Searched, search
from cutgap.formulations.contour_dp.walks import Walks
from cutgap.instances.arrays import Ints
from cutgap.instances.result import OPTIMALITY_TOLERANCE

FIRST_WIDTH, WIDER = 1000, 4
"""Rows of a layer in the first search, and how many times as wide the next one is."""
ROWS_CELLS = 150_000_000
"""Most numbers in the layers of a search."""


class Incumbent:
    """The least cost known, over all walk problems of an instance, mm."""

    def __init__(self, cost: float, step: float) -> None:
        self.cost, self.step = cost, step
        self.best: tuple[Walks, Ints] | None = None

    @property
    def limit(self) -> float:
        """Only walks that cost less are of interest; with whole lengths, a step less than the best."""
        if not np.isfinite(self.cost):
            return np.inf
        if self.step > 0.0:
            return self.cost - self.step * (1.0 - 1e-6)
        return self.cost - OPTIMALITY_TOLERANCE / 2 * max(1.0, abs(self.cost))

    def offer(self, walks: Walks, walk: Ints) -> None:
        """Keep a walk if it is cheaper."""
        cost = walk_cost(walks, walk)
        if cost < self.cost:
            self.cost, self.best = cost, (walks, walk)


def walk_cost(walks: Walks, walk: Ints) -> float:
    """Return s + sum c + t, mm."""
    return float(walks.start[walk[0]] + walks.costs[walk[:-1], walk[1:]].sum() + walks.end[walk[-1]])


class Closing:
    """One walk problem on its way to be closed.

    Attributes
    ----------
    bound
        No walk costs less than this, or than the incumbent.
    closed
        Whether it is known that no walk is below the limit.
    """

    def __init__(
        self, walks: Walks, incumbent: Incumbent, deadline: float, watch: Callable[[PassMaker], None]
    ) -> None:
        self.walks, self.incumbent, self.deadline, self.watch = walks, incumbent, deadline, watch
        self.ascent = Ascent(walks, incumbent.limit, deadline, watch)
        self.width = FIRST_WIDTH
        self.searched_bound = -np.inf
        self.closed = False
        cells = int(np.diff(walks.first).sum())
        self.widest = max(FIRST_WIDTH, ROWS_CELLS // max(1, cells))

    @property
    def bound(self) -> float:
        """No walk costs less than this, or than the incumbent."""
        return max(self.ascent.found.bound, self.searched_bound)

    def advance(self) -> None:
        """Do a round of the ascent (none when its memories are full), and searches that take about as long."""
        begun = time.perf_counter()
        found = self.ascent.found
        self.relax()
        if self.closed:
            return
        if self.walks.count > MOST_CONTOURS:
            return
        spent = time.perf_counter() - begun
        while not self.closed and time.perf_counter() < self.deadline:
            begun = time.perf_counter()
            complete = self._search()
            if complete or self.width >= self.widest:
                break
            self.width = min(WIDER * self.width, self.widest)
            if not found.exhausted and WIDER * (time.perf_counter() - begun) > spent:
                break

    def relax(self) -> None:
        """Do a round of the ascent, none when its memories are full."""
        found = self.ascent.found
        found.limit = min(found.limit, self.incumbent.limit)
        if not found.exhausted:
            self.ascent.round()
        if found.walk is not None:
            self.incumbent.offer(self.walks, found.walk)
            self.closed = True
        elif found.bound >= found.limit:
            self.closed = True

    def _search(self) -> bool:
        """Search once; True when there is nothing left below the limit."""
        found = self.ascent.found
        result = search(self.walks, found, self.width)
        if result.walk is not None:
            self.incumbent.offer(self.walks, result.walk)
            found.limit = min(found.limit, self.incumbent.limit)
        self.searched_bound = max(self.searched_bound, min(result.bound, result.cost, found.limit))
        self.closed = result.complete
        self.watch(partial(self._passed, result))
        return self.closed

    def _passed(self, result: Searched) -> Passed:
        """Return what a search showed to whoever watches."""
        stage = self.ascent.found.stages[-1]
        text = f"Exact search over sets of contours, at most {self.width} states a position: "
        text += "none was left out, so nothing better exists." if result.complete else "some were left out."
        prices = np.array(stage.prices)
        return Passed(text, self.walks, self.bound, result.walk, prices, stage.members, result.layers)

    @property
    def stuck(self) -> bool:
        """Whether neither memories nor searches can grow."""
        full = self.walks.count > MOST_CONTOURS or self.width >= self.widest
        return self.ascent.found.exhausted and full
