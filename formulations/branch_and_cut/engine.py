"""Branch and cut: best-bound search over the relaxations of a ``Model``.

Each node is a set of fixings. Its relaxation is solved, cut and priced until nothing is violated; it is
dropped when its bound reaches the limit, else it is branched on the variable whose two children, solved for a
few simplex iterations, promise most (strong branching; Applegate, Bixby, Chvatal, Cook, 1995).

The search remembers its tree with the multipliers that prove each leaf, from which a certificate is written.
"""

import heapq
import time
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from cutgap.formulations.branch_and_cut.model import Fixing, Model, Proof
from cutgap.formulations.branch_and_cut.observing import Event, scene_of
from cutgap.instances.progress import Progress, Watch, nobody

STRONG_CANDIDATES = 8
STRONG_ITERATIONS = 50
TAIL_ROUNDS = 6
TAIL_SHARE = 0.02
"""Cuts that solutions do not need end when ``TAIL_ROUNDS`` rounds close less than this share of the gap."""


@dataclass(order=True, slots=True)
class Node:
    """A subproblem; the least bound goes first, then the deepest.

    ``proof`` shows the bound. A subproblem without solutions has an infinite one, which ``ray``, scaled to the
    value 1, and the proof of its parent show together. ``children`` are set once it is branched on.
    """

    bound: float
    order: tuple[int, int]
    fixings: tuple[Fixing, ...] = field(compare=False)
    proof: Proof = field(compare=False, default=())
    ray: Proof = field(compare=False, default=())
    children: tuple["Node", ...] = field(compare=False, default=())
    parent: int | None = field(compare=False, default=None)

    @property
    def number(self) -> int:
        """Name of the node: 0 for the root, 2 k and 2 k + 1 for the children of the k-th node worked on."""
        return self.order[1]


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a search proved: no solution costs less than ``lower_bound``.

    ``solution`` is the best one found (or given), ``value`` its cost. When the search is ``complete``, the
    bound meets the cutoff or the value within the tolerance. ``root`` is the tree of proofs, ``fixes`` the
    proofs by which variables were dropped at the root.
    """

    lower_bound: float
    value: float | None
    solution: Any | None
    complete: bool
    nodes: int
    root: Node | None = None
    fixes: tuple[Proof, ...] = ()


class BranchAndCut:
    """One search over a model.

    Parameters
    ----------
    incumbent
        A known solution: its value and itself.
    cutoff
        Solutions of this value or more are of no interest.
    tolerance
        A node is dropped when its bound is this near, relative to the larger of 1 and their size, to the
        incumbent or the cutoff.
    step
        A length that divides every value, 0 when none is known: a node is dropped when all of this lies not
        between its bound and the incumbent, but for a thousandth that covers rounding.
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
        step: float = 0.0,
        deadline: float = np.inf,
        watch: Watch = nobody,
    ) -> None:
        self.model = model
        self.incumbent = incumbent
        self.cutoff = cutoff
        self.tolerance = tolerance
        self.step = step
        self.deadline = deadline
        self.watch = watch
        self.started = time.perf_counter()
        self.nodes = 0
        self.root = Node(-np.inf, (0, 0), ())
        self.fixes: list[Proof] = []
        self.open: list[Node] = [self.root]
        self.current: Node | None = None  # taken off the heap and being worked on
        self.closed_bound = np.inf

    @property
    def limit(self) -> float:
        """The bound at which a node is dropped."""
        value = np.inf if self.incumbent is None else self.incumbent[0]
        target = min(value, self.cutoff)
        slack = max(self.tolerance * max(1.0, abs(target)), 0.999 * self.step)
        return target - slack if np.isfinite(target) else target

    @property
    def lower_bound(self) -> float:
        """What is proved so far: the least bound among open and closed nodes.

        Solutions with variables that were dropped at the root are only known to reach the limit.
        """
        bounds = [self.closed_bound]
        bounds += [] if self.incumbent is None else [self.incumbent[0]]
        bounds += [self.limit] if self.fixes else []
        bounds += [node.bound for node in (self.current, *self.open[:1]) if node is not None]
        return float(min(bounds))

    def run(self) -> Outcome:
        """Search until nothing below the limit is open, until the deadline or Ctrl-C."""
        complete = True
        self._report(self.root, "began")
        try:
            while self.open and self.open[0].bound < self.limit and complete:
                self.current = heapq.heappop(self.open)
                complete = self._process(self.current)
                if complete:
                    self.current = None
        except KeyboardInterrupt:
            complete = False
        value, solution = self.incumbent if self.incumbent is not None else (None, None)
        return Outcome(self.lower_bound, value, solution, complete, self.nodes, self.root, tuple(self.fixes))

    def _process(self, node: Node) -> bool:
        """Close a node or push its children; False when the deadline passed first."""
        self.nodes += 1
        self.model.apply(node.fixings)
        bounds: list[float] = []
        while True:
            if time.perf_counter() > self.deadline:
                return False
            self.model.solve()
            bound = self.model.bound()
            bounds.append(bound)
            self._raise(node, bound)
            if np.isfinite(bound):
                self._round()
            if node.bound >= self.limit:
                self.closed_bound = min(self.closed_bound, node.bound)
                self._report(node, "bound" if np.isfinite(node.bound) else "infeasible")
                return True
            self._report(node, "relaxed")
            if not node.fixings:
                proof = self.model.proof()
                self.fixes += [proof] if self.model.tighten(self.limit) else []
            added = self.model.separate(thorough=self._gains(bounds))
            if added == 0:
                break
            self._report(node, "cut", added)
        self._branch(node)
        return True

    def _gains(self, bounds: list[float]) -> bool:
        """Whether the last rounds closed a fair share of the gap."""
        if len(bounds) <= TAIL_ROUNDS or not np.isfinite(self.limit):
            return True
        before = bounds[-1 - TAIL_ROUNDS]
        return bounds[-1] - before >= TAIL_SHARE * (self.limit - before)

    def _round(self) -> None:
        """Keep a better solution."""
        found = self.model.round()
        if found is not None and (self.incumbent is None or found[0] < self.incumbent[0]):
            self.incumbent = found

    def _report(self, node: Node, event: Event, added: int = 0) -> None:
        """Tell the watch what happened at a node."""
        value = None if self.incumbent is None else self.incumbent[0]
        bound = self.lower_bound
        message = f"{self.nodes} nodes, {len(self.open)} open"
        scene = partial(scene_of, self, node, event, added)
        seconds = time.perf_counter() - self.started
        self.watch(Progress(seconds, value, bound if np.isfinite(bound) else None, message, scene))

    def _branch(self, node: Node) -> None:
        """Push the node's two children, or close it when its point is a solution."""
        candidates = self.model.candidates(STRONG_CANDIDATES)
        if not candidates:
            self.closed_bound = min(self.closed_bound, node.bound)
            self._report(node, "solution")
            return
        node.children = self._strongest(node, candidates)
        for child in node.children:
            heapq.heappush(self.open, child)
        self._report(node, "divided")

    def _strongest(self, node: Node, candidates: list[int]) -> tuple[Node, ...]:
        """Return the children with the best product of gains among the candidates."""
        basis = self.model.lp.save_basis()
        # The sides are those of this node's point, so all are taken before a look ahead replaces it.
        pairs = [self.model.children(variable) for variable in candidates]
        best: tuple[Node, ...] = ()
        best_score = -1.0
        for pair in pairs:
            children = tuple(self._child(node, fixing) for fixing in pair)
            if len(candidates) > 1:
                for child in children:
                    self._look_ahead(child)
                    self.model.lp.restore_basis(basis)
            gains = [max(min(child.bound, self.limit) - node.bound, 1e-6) for child in children]
            if gains[0] * gains[1] > best_score:
                best, best_score = children, gains[0] * gains[1]
        return best

    def _child(self, node: Node, fixing: Fixing) -> Node:
        """Return a child with what its parent proved."""
        order = (-len(node.fixings), 2 * self.nodes + int(fixing.lower > 0))
        return Node(node.bound, order, (*node.fixings, fixing), node.proof, parent=node.number)

    def _look_ahead(self, child: Node) -> None:
        """Raise a child's bound by a few simplex iterations."""
        self.model.apply(child.fixings)
        self.model.solve(STRONG_ITERATIONS)
        self._raise(child, self.model.bound())

    def _raise(self, node: Node, bound: float) -> None:
        """Keep a better bound with what proves it."""
        if np.isinf(bound) and bound > 0:
            node.bound, node.ray = bound, self.model.proof()
        elif bound > node.bound:
            node.bound, node.proof = bound, self.model.proof()
