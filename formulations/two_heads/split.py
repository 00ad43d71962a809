r"""Two heads that must not overlap, by search over thresholds in x.

    Data       x_i, s_i   pierce point and service time of hole i             [mm], [s]
               F          least partition gap                                 [mm]
               w          weight of imbalance                                 [mm/s]
    Decide     S          the left head's holes; the right head has the rest
    Values     L_1(S), L_2(S)   shortest tours of the heads                   [mm]
               T_a(S) = L_a(S) / v_jump + sum of s_i                          [s]

    (1) makespan  max(T_1, T_2)          (2) weighted  L_1 + L_2 + w |T_1 - T_2|

Non-overlap leaves few S: with holes sorted by x, S is a prefix that ends where x jumps by F or more. For F = 0
holes of equal x may go either side, so a prefix may also end inside a group of equal x with any part of it.

The search keeps *cells* (left set, right set, free holes of one group of equal x) on a heap by lower bound. It
takes the cell of least bound, branches on a free hole or tightens a tour length that holds the bound down, and
stops when the best plan meets the least bound. Bounds are valid because

(3) in a metric, L_a grows with its set, so bounds pass from sets to supersets (``sides``), and the decided
    sets of a cell bound all of its plans; with via points this holds for the left head only: its leftmost
    holes stay the same, while dropping the right head's leftmost hole changes the via point. So in cells
    with free holes the right head counts with its shortest tour without via point;
(4) for w <= v_jump, (2) does not fall when a tour gets longer: shortest tours are best. For w > v_jump a plan
    can gain by a longer tour, so |T_1 - T_2| is priced at min(w, v_jump) in the bound, which stays valid;
(5) max(T_1, T_2) >= (T_1 + T_2) / 2;
(6) under a hard limit |T_1 - T_2| <= b, what shortest tours differ beyond b is made up by longer tours, which
    costs v_jump for each second in (2). This bound stays valid, but may be below the optimum, and the tours
    that meet the limit are found by detours (``lengthening``); ``free`` closes what is left.

Source: proof of (3) and (4) in ``docs/two-heads.md``; the problem is that of Wang et al. (2025).
"""

import heapq
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import groupby, pairwise

import numpy as np

from cutgap.formulations.scope import require_two_heads
from cutgap.formulations.sides import Side, Sides
from cutgap.formulations.two_heads.bound import objective_bound
from cutgap.formulations.two_heads.lengthening import balanced
from cutgap.formulations.two_heads.proof import split_certificate
from cutgap.formulations.two_heads.scenes import moved, split_scene, tightened
from cutgap.instances import Instance, Plan, Result, Rules, conclude
from cutgap.instances.arrays import difference
from cutgap.instances.progress import Progress, Watch, nobody
from cutgap.instances.result import OPTIMALITY_TOLERANCE


@dataclass(order=True, slots=True)
class Cell:
    """Plans whose left head has at least ``left``, whose right head at least ``right`` (bit masks)."""

    bound: float
    number: int
    left: int = field(compare=False)
    right: int = field(compare=False)
    free: tuple[int, ...] = field(compare=False, default=())


def solve_split(
    instance: Instance,
    rules: Rules,
    *,
    time_limit: float | None = None,
    start: Plan | None = None,
    certify: bool = False,
    watch: Watch = nobody,
) -> Result:
    """Solve the two-head problem under non-overlap to proven optimality.

    Parameters
    ----------
    time_limit
        Seconds after which the best plan and the bound proved so far are returned; Ctrl-C does the same.
    start
        A plan to start from; one that breaks rules is ignored.
    certify
        Whether to add a verified certificate of the bound.

    Raises
    ------
    ValueError
        When the instance or the rules are outside of this method (see ``require_scope``).
    """
    require_scope(instance, rules)
    search = SplitSearch(instance, rules, time_limit, watch)
    result = search.run(start)
    return replace(result, certificate=split_certificate(search, result)) if certify else result


def require_scope(instance: Instance, rules: Rules) -> None:
    """Raise ``ValueError``, saying why, when the threshold search does not apply."""
    require_two_heads(instance, rules, "split")
    if rules.non_overlap is None:
        raise ValueError(f"instance {instance.name!r}, method split: needs a non-overlap limit")


def obeys_triangle_inequality(instance: Instance) -> bool:
    """Whether no rapid gets shorter by way of a third node."""
    if instance.matrix is None:
        return True
    return all((instance.matrix <= row[:, None] + row[None, :]).all() for row in instance.matrix)


class SplitSearch:
    """One search; see the module."""

    def __init__(self, instance: Instance, rules: Rules, time_limit: float | None, watch: Watch) -> None:
        self.instance, self.rules, self.watch = instance, rules, watch
        self.started = time.perf_counter()
        self.deadline = np.inf if time_limit is None else self.started + time_limit
        self.least_gap = rules.non_overlap if rules.non_overlap is not None else 0.0
        self.metric = obeys_triangle_inequality(instance)
        via = rules.via_points
        self.sides = (
            Sides(instance, 0, via_points=via, inherits=self.metric),
            Sides(instance, 1, via_points=via, inherits=self.metric and not via),
        )
        self.free_right = Sides(instance, 1, via_points=False, inherits=self.metric) if via else self.sides[1]
        self.heap: list[Cell] = []
        self.seen: set[tuple[int, int]] = set()
        self.numbers = 0
        self.best: Plan | None = None
        self.value = np.inf
        self.closed_bound = np.inf  # of cells that cannot be tightened further (balance, w > v_jump)

    def run(self, start: Plan | None) -> Result:
        """Search until the least bound meets the best plan."""
        if start is not None:
            self._offer(start)
        for left, right, free in self.first_cells():
            self._push(left, right, free)
        if not self.heap:
            return self._result(infeasible=True, reason=self._why_infeasible())
        reason = None
        try:
            while self.heap and self.heap[0].bound < self._limit():
                if not self._step(self.heap[0]):
                    reason = "time limit"
                    break
        except KeyboardInterrupt:
            reason = "interrupted"
        if reason and self.best is None:
            self._offer_any()
        return self._result(reason=reason)

    # Cells

    def first_cells(self) -> Iterator[tuple[int, int, tuple[int, ...]]]:
        """Yield prefixes at jumps of x by F or more and, for F = 0, the groups of equal x."""
        xs = self.instance.points[: len(self.instance.contours), 0]
        order = np.argsort(xs, kind="stable").tolist()
        everything = (1 << len(order)) - 1
        left, last_x = 0, None
        for x, group in groupby(order, key=lambda contour: float(xs[contour])):
            holes = tuple(group)
            if last_x is None or difference(last_x, x) >= self.least_gap:
                yield left, everything & ~left, ()
            members = sum(1 << hole for hole in holes)
            if self.least_gap == 0 and len(holes) > 1:
                yield left, everything & ~(left | members), holes
            left, last_x = left | members, x
        yield everything, 0, ()

    def _allowed(self, left: int, right: int) -> bool:
        if self.rules.empty_heads or len(self.instance.contours) < 2:
            return True
        return left != 0 and right != 0

    def _push(self, left: int, right: int, free: tuple[int, ...]) -> None:
        """Put a cell on the heap, once."""
        if not free:
            if (left, right) in self.seen or not self._allowed(left, right):
                return
            self.seen.add((left, right))
        self.numbers += 1
        heapq.heappush(self.heap, Cell(self.bound(left, right, free), self.numbers, left, right, free))

    def _step(self, cell: Cell) -> bool:
        """Replace the first cell by stronger ones; False when the deadline passed first."""
        if time.perf_counter() > self.deadline:
            return False
        bound = self.bound(cell.left, cell.right, cell.free)
        if bound > cell.bound:
            heapq.heapreplace(self.heap, Cell(bound, cell.number, cell.left, cell.right, cell.free))
            self._report(cell, lambda: moved(cell, "its bound rises by what other thresholds proved."))
            return True
        if cell.free and not self._is_loose(cell):
            heapq.heappop(self.heap)
            bit, rest = 1 << cell.free[0], cell.free[1:]
            self._push(cell.left | bit, cell.right, rest)
            self._push(cell.left, cell.right | bit, rest)
            self._report(cell, lambda: moved(cell, "divided by the head that cuts the next one."))
            return True
        head = self._loose_head(cell)
        if head is None:
            # Both tours may be known from other cells, which offered them with other partners.
            self._offer_tours(cell)
            heapq.heappop(self.heap)
            self.closed_bound = min(self.closed_bound, cell.bound)
            self._report(cell, lambda: moved(cell, "both tours are known, nothing is left to prove."))
            return True
        members = (cell.left, cell.right)[head]
        before = self.pair(cell)[head].lower
        complete = self._sides(cell.free)[head].tighten(members, self._cutoff(cell, head), self.deadline)
        if not cell.free:
            self._offer_tours(cell)
        self._report(cell, lambda: tightened(self, cell, head, before))
        return complete

    def _is_loose(self, cell: Cell) -> bool:
        """Whether a cell with free holes deserves a Held-Karp bound before it is divided."""
        pair = self._pair(cell.left, cell.right, cell.free)
        return self.metric and any(not side.relaxed and not side.is_exact for side in pair)

    def _loose_head(self, cell: Cell) -> int | None:
        """Return the head whose tour bound to tighten: what was not relaxed yet, then what counts more."""
        pairs = self._pair(cell.left, cell.right, cell.free)
        open_heads = [head for head, side in enumerate(pairs) if not side.is_exact]
        if not open_heads:
            return None
        fresh = [head for head in open_heads if not pairs[head].relaxed]
        speed = self.instance.machine.v_jump
        return max(fresh or open_heads, key=lambda head: pairs[head].lower / speed + pairs[head].service_s)

    def _sides(self, free: tuple[int, ...]) -> tuple[Sides, Sides]:
        """Return what bounds the two heads in a cell with these free holes, see (3)."""
        return self.sides[0], self.free_right if free else self.sides[1]

    def pair(self, cell: Cell) -> tuple[Side, Side]:
        """Return what is known about the tours of a cell's decided sets."""
        return self._pair(cell.left, cell.right, cell.free)

    def _pair(self, left: int, right: int, free: tuple[int, ...] = ()) -> tuple[Side, Side]:
        sides = self._sides(free)
        return sides[0].side(left), sides[1].side(right)

    # Bounds

    def bound(self, left: int, right: int, free: tuple[int, ...]) -> float:
        """Lower bound on the objective of a cell's plans; without a metric, decided sets say nothing."""
        one, two = self._pair(left, right, free)
        usable = self.metric or not free
        floating_s = float(self.instance.service_times[list(free)].sum())
        lengths = (one.lower, two.lower) if usable else (0.0, 0.0)
        return self._objective(lengths, (one.service_s, two.service_s), floating_s)

    def _objective(
        self, lengths: tuple[float, float], services_s: tuple[float, float], floating_s: float = 0.0
    ) -> float:
        """Return (1) or (2) for tour lengths (mm) and service times; floating service goes to either head."""
        return objective_bound(self.instance.machine, self.rules, lengths, services_s, floating_s)

    def _cutoff(self, cell: Cell, head: int) -> float:
        """Return the tour length of a head from which on the cell cannot beat the best plan.

        The objective is convex and does not fall in the length, so doubling and bisection find it.
        """
        limit = self._limit()
        pair = self._pair(cell.left, cell.right)
        if cell.free or not np.isfinite(limit):
            return np.inf

        def objective(length: float) -> float:
            lengths = (length, pair[1].lower) if head == 0 else (pair[0].lower, length)
            return self._objective(lengths, (pair[0].service_s, pair[1].service_s))

        low, high = pair[head].lower, pair[head].upper
        if not np.isfinite(high) or objective(high) < limit:
            return np.inf
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (low, middle) if objective(middle) >= limit else (middle, high)
        return high

    def _limit(self) -> float:
        """Cells with this bound cannot hold a better plan."""
        if not np.isfinite(self.value):
            return np.inf
        return self.value - OPTIMALITY_TOLERANCE / 2 * max(1.0, abs(self.value))

    # Plans

    def _offer(self, plan: Plan) -> None:
        """Keep a plan if it is allowed and better than the best."""
        result = conclude(self.instance, self.rules, plan, method="split", seconds=0.0)
        if not result.violations and result.value is not None and result.value < self.value:
            self.best, self.value = plan, result.value

    def _offer_tours(self, cell: Cell) -> None:
        """Offer the plan of a cell's best tours, if its bound leaves hope."""
        if self.bound(cell.left, cell.right, ()) >= self._limit():
            return
        one, two = self.sides[0].tour(cell.left), self.sides[1].tour(cell.right)
        if self._objective((one.upper, two.upper), (one.service_s, two.service_s)) < self.value:
            self._offer(balanced(self.instance, self.rules, Plan.of_contours([one.order, two.order])))

    def _offer_any(self) -> None:
        """After an early stop without a plan: tours for the most balanced prefix."""
        splits = [cell for cell in self.heap if not cell.free]
        if not splits:
            return
        cell = min(splits, key=lambda each: abs(each.left.bit_count() - each.right.bit_count()))
        for sides, members in zip(self.sides, (cell.left, cell.right), strict=True):
            if not sides.side(members).is_exact:
                sides.tighten(members, np.inf, np.inf)
        self._offer_tours(cell)

    # Reports

    def _lower_bound(self) -> float:
        return min(self.closed_bound, self.heap[0].bound if self.heap else np.inf, self.value)

    def _report(self, cell: Cell, text: Callable[[], str]) -> None:
        """Tell the watch of a step at a cell."""
        value = self.value if np.isfinite(self.value) else None
        seconds = time.perf_counter() - self.started
        message = f"{len(self.heap)} splits open"
        scene = partial(split_scene, self, cell, text)
        self.watch(Progress(seconds, value, self._lower_bound(), message, scene))

    def _result(self, *, infeasible: bool = False, reason: str | None = None) -> Result:
        return conclude(
            self.instance,
            self.rules,
            self.best,
            method="split",
            seconds=time.perf_counter() - self.started,
            lower_bound=None if infeasible else float(self._lower_bound()),
            infeasible=infeasible,
            reason=reason,
        )

    def _why_infeasible(self) -> str:
        xs = np.sort(self.instance.points[: len(self.instance.contours), 0])
        widest = max((difference(a, b) for a, b in pairwise(xs.tolist())), default=0.0)
        return (
            f"no threshold in x leaves a partition gap of {self.least_gap:g} mm with work for both heads; "
            f"the widest gap between neighbouring contours is {widest:g} mm"
        )
