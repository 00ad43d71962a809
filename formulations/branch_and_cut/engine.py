"""Branch and cut: best-bound search over the relaxations of a ``Model``.

Each node is a set of fixings. Its relaxation is solved, cut and priced until nothing is violated; it is
dropped when its bound reaches the limit, else it is branched on the variable whose two children, solved for a
few simplex iterations, promise most (strong branching; Applegate, Bixby, Chvatal, Cook, 1995).
"""

import heapq
import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cutgap.formulations.branch_and_cut.model import Fixing, Model
from cutgap.instances.progress import Progress, Watch, nobody

STRONG_CANDIDATES = 8
STRONG_ITERATIONS = 50
TAIL_ROUNDS = 6
TAIL_SHARE = 0.02
"""Cuts that solutions do not need end when ``TAIL_ROUNDS`` rounds close less than this share of the gap."""


@dataclass(order=True, slots=True)
class Node:
    """An open subproblem; the least bound goes first, then the deepest."""

    bound: float
    order: tuple[int, int]
    fixings: tuple[Fixing, ...] = field(compare=False)


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a search proved: no solution costs less than ``lower_bound``.

    ``solution`` is the best one found (or given), ``value`` its cost. When the search is ``complete``, the
    bound meets the cutoff or the value within the tolerance.
    """

    lower_bound: float
    value: float | None
    solution: Any | None
    complete: bool
    nodes: int


class BranchAndCut:
    """One search over a model.

    Parameters
    ----------
    incumbent
        A known solution: its value and itself.
    cutoff
        Solutions of this value or more are of no interest.
    tolerance
        A node is dropped when its bound is this near to the incumbent or the cutoff.
    deadline
        ``time.perf_counter()`` at which to stop.
    """

    def __init__(
        self,
        model: Model,
        *,
        incumbent: tuple[float, Any] | None = None,
        cutoff: float = np.inf,
        tolerance: float = 0.0,
        deadline: float = np.inf,
        watch: Watch = nobody,
    ) -> None:
        self.model = model
        self.incumbent = incumbent
        self.cutoff = cutoff
        self.tolerance = tolerance
        self.deadline = deadline
        self.watch = watch
        self.started = time.perf_counter()
        self.nodes = 0
        self.closed_bound = np.inf
        self.open = [Node(-np.inf, (0, 0), ())]

    @property
    def limit(self) -> float:
        """The bound at which a node is dropped."""
        value = np.inf if self.incumbent is None else self.incumbent[0]
        return min(value, self.cutoff) - self.tolerance

    @property
    def lower_bound(self) -> float:
        """What is proved so far: the least bound among open and closed nodes."""
        value = np.inf if self.incumbent is None else self.incumbent[0]
        return float(min(self.closed_bound, value, self.open[0].bound if self.open else np.inf))

    def run(self) -> Outcome:
        """Search until nothing below the limit is open, until the deadline or Ctrl-C."""
        complete = True
        try:
            while self.open and self.open[0].bound < self.limit:
                # The node stays on the heap while it is worked on: a stop leaves its bound in place.
                if not self._process(self.open[0]):
                    complete = False
                    break
        except KeyboardInterrupt:
            complete = False
        value, solution = self.incumbent if self.incumbent is not None else (None, None)
        return Outcome(self.lower_bound, value, solution, complete, self.nodes)

    def _process(self, node: Node) -> bool:
        """Close a node, pushing its children; False when the deadline passed first."""
        self.nodes += 1
        self.model.apply(node.fixings)
        bounds = [node.bound]
        while True:
            if time.perf_counter() > self.deadline:
                return False
            if not self.model.solve():
                self._close(node, np.inf)
                return True
            bounds.append(max(bounds[-1], self.model.bound()))
            self._round(bounds[-1])
            if bounds[-1] >= self.limit:
                self._close(node, bounds[-1])
                return True
            if not node.fixings:
                self.model.tighten(self.limit)
                node.bound = bounds[-1]
            if not self.model.separate(thorough=self._gains(bounds)):
                break
        self._branch(node, bounds[-1])
        return True

    def _gains(self, bounds: list[float]) -> bool:
        """Whether the last rounds closed a fair share of the gap."""
        if len(bounds) <= TAIL_ROUNDS + 1 or not np.isfinite(self.limit):
            return True
        before = bounds[-1 - TAIL_ROUNDS]
        return bounds[-1] - before >= TAIL_SHARE * (self.limit - before)

    def _round(self, bound: float) -> None:
        """Keep a better solution, and report."""
        found = self.model.round()
        if found is not None and (self.incumbent is None or found[0] < self.incumbent[0]):
            self.incumbent = found
        value = None if self.incumbent is None else self.incumbent[0]
        proved = bound if self.nodes == 1 else self.lower_bound
        message = f"{self.nodes} nodes, {len(self.open)} open"
        self.watch(Progress(time.perf_counter() - self.started, value, proved, message))

    def _close(self, node: Node, bound: float) -> None:
        """Take the node, which is the first of the heap, off it."""
        heapq.heappop(self.open)
        self.closed_bound = min(self.closed_bound, bound)

    def _branch(self, node: Node, bound: float) -> None:
        """Replace the node by its two children, or close it when the point is a solution."""
        candidates = self.model.candidates(STRONG_CANDIDATES)
        if not candidates:
            self._close(node, bound)
            return
        heapq.heappop(self.open)
        variable, child_bounds = self._strongest(node, bound, candidates)
        for fixing, child_bound in zip(self.model.children(variable), child_bounds, strict=True):
            order = (-len(node.fixings), self.nodes * 2 + int(fixing.lower))
            heapq.heappush(self.open, Node(child_bound, order, (*node.fixings, fixing)))

    def _strongest(self, node: Node, bound: float, candidates: list[int]) -> tuple[int, list[float]]:
        """Return the candidate with the best product of gains, and the bounds of its children."""
        if len(candidates) == 1:
            return candidates[0], [bound, bound]
        basis = self.model.save_basis()
        best, best_score, best_bounds = candidates[0], -1.0, [bound, bound]
        for variable in candidates:
            bounds = []
            for fixing in self.model.children(variable):
                self.model.apply((*node.fixings, fixing))
                feasible = self.model.solve(STRONG_ITERATIONS)
                bounds.append(max(bound, self.model.bound()) if feasible else np.inf)
                self.model.restore_basis(basis)
            gains = [max(min(each, self.limit) - bound, 1e-6) for each in bounds]
            if gains[0] * gains[1] > best_score:
                best, best_score, best_bounds = variable, gains[0] * gains[1], bounds
        return best, best_bounds
