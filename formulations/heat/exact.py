"""Branch and bound on a small plate: least travel under a cap, or least peak, to proven optimality.

The head starts at its home, or a closed tour begins at each entry point in turn (a *root*): times count from
the first contour, so where it begins matters. For the peak without a limit on travel one root serves for all.
"""

from collections.abc import Iterator

import numpy as np

from cutgap.formulations.heat.branching import (
    DONE,
    ENDLESS,
    FOUND,
    Bounds,
    advance,
    begin,
    bounds_of,
    new_stack,
    open_bound,
)
from cutgap.formulations.heat.plates import Plate, plan_of
from cutgap.formulations.heat.run import Run
from cutgap.formulations.heat.tables import (
    no_warmth,
    peak_table,
    rooms,
    subset_cells,
    travel_table,
    warm_table,
)
from cutgap.instances.arrays import Floats, Ints

MOST_CELLS = 50_000_000
"""Most numbers in the table of least rises."""
NODES = 20_000
"""Nodes between looks at the clock."""
FIRST_SECONDS, FIRST_LONGEST = 2.0, 8
"""Most seconds of annealing before the search, and its longest runs."""


def fits(first: Ints) -> bool:
    """Whether the tables of so many contours and points fit."""
    return subset_cells(first) <= MOST_CELLS


class ExactSearch:
    """The branch and bound over all roots of a run."""

    def __init__(self, run: Run, start: Ints) -> None:
        self.run, self.plate = run, run.plate
        run.improve(run.annealing(start, FIRST_LONGEST), FIRST_SECONDS)
        self.refused = np.inf
        self.ends = self._ends()
        self.bounds, self.root_peak = self._tables()
        self.root_bounds = [self._root_bound(root) for root in range(len(self.ends))]
        self._note(min(self.root_bounds, default=np.inf))

    def _ends(self) -> list[tuple[int, Floats]]:
        """Return the first point of each root, -1 for any, and the ways that end its tours."""
        back, limited = self.plate.back, np.isfinite(self.run.most_travel)
        if self.run.instance.heads[0].home is not None:
            return [(-1, np.ascontiguousarray(back[:, 0]))]
        if not self.run.by_travel and not limited:
            return [(-1, np.zeros(len(back)))]
        return [
            (f, np.ascontiguousarray(back[:, f]))
            for f in range(len(back))
            if self.plate.before[self.plate.contour_of[f]] == 0
        ]

    def _tables(self) -> tuple[Bounds, float]:
        """Return the tables of the search, travel without cap, and a bound on the peak rise of any plan."""
        plate, run, limits = self.plate, self.run, self.run.limits()
        limit = min(limits.travel, run.cutoff) if run.by_travel else limits.travel
        loose = np.min([end for _, end in self.ends], axis=0)
        bare = travel_table(plate, loose, no_warmth(), np.inf)
        room = rooms(plate, bare, limit - float(plate.out.min()), limits.speed)
        self.warm = warm_table(plate, room)
        cap = limits.rise if run.by_travel else min(limits.rise, run.cutoff)
        peak = peak_table(plate, self.warm, cap)
        return bounds_of(plate, bare, peak, self.warm), _least_of(plate, peak, 0.0 * plate.out)

    def _travel(self, end: Floats) -> Floats:
        return travel_table(self.plate, end, self.warm, self.run.limits().rise)

    def _root_bound(self, root: int) -> float:
        """Return a bound on the objective of the plans of a root."""
        if not self.run.by_travel:
            return min(self.root_peak, ENDLESS)
        table, first = self._travel(self.ends[root][1]), self.ends[root][0]
        return _least_of(self.plate, table, self.plate.out, first)

    def _note(self, internal: float) -> None:
        """Keep a bound on all plans, which no better plan than the best one contradicts."""
        internal = min(
            internal, self.refused, np.inf if self.run.best is None else self.run.internal(self.run.best)
        )
        if internal < ENDLESS:
            bound = self.run.objective(internal)
            self.run.bound = bound if self.run.bound is None else max(self.run.bound, bound)

    def run_roots(self) -> bool:
        """Search all roots, most promising first; False when the time ended before."""
        order = np.argsort(self.root_bounds, kind="stable").tolist()
        for turn, root in enumerate(order):
            later = min((self.root_bounds[each] for each in order[turn + 1 :]), default=np.inf)
            for open_one in self._search(root):
                self._note(min(open_one, later))
                self.run.report()
                if self.run.is_over:
                    return False
            self._note(later)
        return True

    def _search(self, root: int) -> Iterator[float]:
        """Search one root, yielding the bound on what is open from time to time."""
        run, plate, limits = self.run, self.plate, self.run.limits()
        first, end = self.ends[root]
        if self.root_bounds[root] >= run.cutoff:
            return
        bounds = self.bounds._replace(travel=self._travel(end))
        stack = new_stack(len(plate.service), len(plate.contour_of))
        begin(plate, bounds, limits, stack, first)
        while True:
            state = advance(plate, bounds, limits, stack, run.cutoff, NODES)
            if state == DONE:
                return
            if state == FOUND:
                path = stack.order[: len(plate.service)].copy()
                if not run.offer(plan_of(plate, path)):
                    # Refused by a hair: it bounds as if it were allowed.
                    self.refused = min(self.refused, run.internal(plan_of(plate, path)))
            yield open_bound(stack)


def _least_of(plate: Plate, table: Floats, out: Floats, first: int = -1) -> float:
    """Return the least entry of a table, and ``out``, over all first points or for one."""
    points = range(len(plate.contour_of)) if first < 0 else [first]
    entries = [
        float(out[w] + table[1 << int(plate.contour_of[w]), w])
        for w in points
        if plate.before[plate.contour_of[w]] == 0
    ]
    return min(entries, default=np.inf)
