r"""A lower bound on walks by relaxed dynamic programming: prices by subgradient steps, memories grow.

    (1) L(p) = min over relaxed walks of cost + sum_a p_a (visits of a - 1)   <= every walk, for all prices p
    (2) p <- p + theta * (limit - L) / |g|^2 * g,   g_a = visits of a - 1
    (3) where the best relaxed walk breaks a rule because it forgot a contour, those on the way remember it
    (4) point v is allowed at position k only while F_k(v, M) + R_k(v, M) < limit for some M (``completion``)

(4) keeps what one round learned for the next, whatever its prices are. A ``Stage`` holds the prices and
memories of a round: from them alone a bound can be computed again.

Sources: Baldacci, Mingozzi, Roberti (2011, 2012) for (1) and (3); Polyak (1969) for (2).
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from cutgap.formulations.contour_dp.completion import completions
from cutgap.formulations.contour_dp.memory import MOST_MEMBERS, Members, Memory, build_memory, start_members
from cutgap.formulations.contour_dp.passes import backward_pass, best_walk, forward_pass
from cutgap.formulations.contour_dp.scenes import Passed, PassMaker, states_of
from cutgap.formulations.contour_dp.walks import Bools, Walks
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.process import WORD

STEPS = 60
"""Most subgradient steps of a round."""
PATIENCE = 4
"""Steps without a better bound after which theta shrinks."""
SHRINK = 0.6
STALL_STEPS, STALL_SHARE = 12, 0.03
"""A round ends when so many steps close less than this share of the gap."""
GUESS = 0.03
"""Share by which a bound is hoped to rise while no limit is known."""
START_MEMBERS, GROWTH = 4, 3
"""Members of a memory at first (and mates of the part), and most members that it gains in a round."""
CELLS = 60_000_000
"""Most numbers in the table of a forward pass."""


@dataclass(frozen=True, slots=True)
class Stage:
    """Prices (mm) of each contour, and memories."""

    prices: tuple[float, ...]
    members: Members


@dataclass(slots=True)
class Relaxed:
    """What the relaxation showed of one walk problem.

    Attributes
    ----------
    bound
        No walk costs less; ``limit`` once no walk below the limit is left.
    stages
        By which the bound was found, in order.
    allowed
        Points at positions that a walk below the limit may still use, shape (n, points).
    walk
        Points of a walk below the limit that keeps all rules, which then costs ``bound``.
    """

    limit: float
    bound: float
    allowed: Bools
    stages: list[Stage] = field(default_factory=list)
    walk: Ints | None = None
    exhausted: bool = False


def possible(walks: Walks) -> Bools:
    """Return which points the precedence lets come at which position, shape (n, points)."""
    positions, of_point = np.arange(walks.count)[:, None], walks.contour_of
    allowed: Bools = (positions >= walks.earliest[of_point]) & (positions <= walks.latest[of_point])
    return allowed


class Climb:
    """The subgradient steps (2) of a round: theta shrinks where the bound does not rise."""

    def __init__(self, prices: Floats) -> None:
        self.best, self.best_prices = -np.inf, prices
        self.theta, self.failures = 1.0, 0
        self.history: list[float] = []

    def note(self, bound: float, prices: Floats) -> None:
        """Keep the best bound of the round and its prices."""
        self.failures += 1
        if bound > self.best:
            self.best, self.best_prices, self.failures = bound, prices, 0
        self.history.append(self.best)

    def stalls(self, limit: float) -> bool:
        """Whether the last steps closed little of the gap."""
        if len(self.history) <= STALL_STEPS:
            return False
        return self.best - self.history[-1 - STALL_STEPS] < STALL_SHARE * (self._aim(limit) - self.best)

    def step(self, bound: float, prices: Floats, excess: Floats, limit: float) -> Floats:
        """Return the next prices by (2), for a walk of this bound and excess of visits."""
        if self.failures >= PATIENCE:
            self.theta, self.failures = SHRINK * self.theta, 0
        return prices + self.theta * (self._aim(limit) - bound) / float(excess @ excess) * excess

    def _aim(self, limit: float) -> float:
        """Return what the bound is hoped to reach: the limit, or a guess without one."""
        return limit if np.isfinite(limit) else self.best + GUESS * abs(self.best)


class Ascent:
    """The rounds over one walk problem; ``limit`` in mm: dearer walks are of no interest."""

    def __init__(self, walks: Walks, limit: float, deadline: float, watch: Callable[[PassMaker], None]) -> None:
        self.walks, self.deadline, self.watch = walks, deadline, watch
        self.found = Relaxed(limit, -np.inf, possible(walks))
        self.members = start_members(walks, START_MEMBERS)
        self.prices = np.zeros(walks.count)
        self.forgotten: list[Forgotten] = []

    def round(self) -> None:
        """Let memories grow by what the last round's walks forgot, and improve the prices for them."""
        if self.forgotten:
            grown = self._grown(self.forgotten)
            self.found.exhausted = grown == self.members
            self.members = grown
        if not self.found.exhausted:
            self.forgotten = self._improve(build_memory(self.walks, self.members))

    def _improve(self, memory: Memory) -> list["Forgotten"]:
        """Improve the prices for one memory; return what the walks of the last steps forgot."""
        found, prices, climb = self.found, self.prices, Climb(self.prices)
        forgotten: list[Forgotten] = []
        for step in range(STEPS):
            bound, walk = self._relax(memory, prices)
            climb.note(bound, prices)
            found.bound = max(found.bound, min(bound, found.limit))
            self.watch(partial(self._passed, step, memory, prices, bound, walk))
            if bound >= found.limit:
                break
            missed = forgotten_by(self.walks, walk)
            if not missed:
                found.walk = walk
                break
            forgotten = [*missed, *forgotten[: 20 * self.walks.count]]
            visits = np.bincount(self.walks.contour_of[walk], minlength=self.walks.count)
            excess = (visits - 1).astype(np.float64)
            over = climb.stalls(found.limit) or time.perf_counter() > self.deadline
            if over or not excess.any():
                break
            prices = climb.step(bound, prices, excess, found.limit)
        self.prices = climb.best_prices
        self._finish(memory, self.prices)
        return forgotten

    def _relax(self, memory: Memory, prices: Floats) -> tuple[float, Ints]:
        value = self._forward(memory, prices)
        total, walk = best_walk(
            self.walks.costs,
            self.walks.end,
            prices,
            self.walks.first,
            memory.following,
            memory.offset,
            memory.crossed,
            value,
        )
        return (total - prices.sum() if np.isfinite(total) else self.found.limit), walk

    def _forward(self, memory: Memory, prices: Floats) -> Floats:
        walks = self.walks
        completion = backward_pass(
            walks.costs, walks.end, prices, walks.first, walks.closed, self.found.allowed
        )
        return forward_pass(
            walks.costs,
            walks.start,
            prices,
            walks.first,
            memory.following,
            memory.offset,
            memory.crossed,
            completion,
            self.found.limit + float(prices.sum()),
        )

    def _passed(self, step: int, memory: Memory, prices: Floats, bound: float, walk: Ints) -> Passed:
        """Return what a pass showed to whoever watches; its table is made once more."""
        text = f"Round {len(self.found.stages) + 1} of memories, step {step + 1} of prices"
        left = bound < self.found.limit
        text += ": the best relaxed walk." if left else ": no relaxed walk is left below the limit."
        states = states_of(self._forward(memory, prices))
        return Passed(text, self.walks, bound, walk if left else None, prices, memory.members, states)

    def _finish(self, memory: Memory, prices: Floats) -> None:
        """Keep the round's stage, and (4)."""
        self.found.stages.append(Stage(tuple(prices.tolist()), memory.members))
        limit = self.found.limit + float(prices.sum())
        onward, _ = completions(self.walks, memory, prices, self.found.allowed, limit)
        value = self._forward(memory, prices) + onward
        alive = np.zeros_like(self.found.allowed)
        for a in range(self.walks.count):
            points = slice(self.walks.first[a], self.walks.first[a + 1])
            table = value[:, memory.offset[a] : memory.offset[a + 1]].reshape(
                self.walks.count, -1, points.stop - points.start
            )
            alive[:, points] = (table < limit).any(axis=1)
        self.found.allowed &= alive

    def _grown(self, forgotten: list["Forgotten"]) -> Members:
        """Return memories with what was forgotten by (3), the shortest gaps first, while the tables fit."""
        grown = [set(each) for each in self.members]
        sizes = np.diff(self.walks.first)
        for contour, holders in sorted(set(forgotten), key=lambda each: len(each[1])):
            for holder in holders:
                most = min(MOST_MEMBERS, len(self.members[holder]) + GROWTH)
                if contour not in grown[holder] and len(grown[holder]) < most:
                    cells = sum(int(size) << len(each) for size, each in zip(sizes, grown, strict=True))
                    if self.walks.count * (cells + (int(sizes[holder]) << len(grown[holder]))) <= CELLS:
                        grown[holder].add(contour)
        return tuple(tuple(sorted(each)) for each in grown)


Forgotten = tuple[int, tuple[int, ...]]
"""A contour, and the contours that have to remember it to rule a walk out."""


def forgotten_by(walks: Walks, walk: Ints) -> list[Forgotten]:
    """Return what a relaxed walk forgot where it breaks a rule; nothing when it is a walk of the problem.

    A step into position j is forbidden by a contour cut at position i <= j - 1 that is cut again, had to come
    later than what is cut at j, or is crossed by the step.
    """
    order = walks.contour_of[walk].tolist()
    missed = []
    for j in range(1, len(order)):
        for i in range(j - 1, -1, -1):
            old, new = order[i], order[j]
            if old == new or walks.before[new, old] or _crosses(walks, walk[j - 1], walk[j], old):
                missed.append((old, tuple(dict.fromkeys(each for each in order[i + 1 : j] if each != old))))
                break
    return missed


def _crosses(walks: Walks, v: int, w: int, contour: int) -> bool:
    if walks.crossed is None:
        return False
    return bool(walks.crossed[v, w, contour // WORD] >> np.uint64(contour % WORD) & np.uint64(1))
