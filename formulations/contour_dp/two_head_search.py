r"""Two heads by dynamic programming: a search over regions (``division``), the one of least bound first.

    Values     f(T_0, T_1)   the objective, from shortest tours where longer ones do not pay
    (1)  f >= the least switch walk of the region (``two_heads``), with its prices
    (2)  f >= f(shortest tours of the decided contours, the free work on either head): in a metric a tour gets
         no shorter by more contours or fewer points
    (3)  a region without free contours: both tours by themselves (``sides``)

A region is left when its bound reaches the best plan, or when all switch walks below it are plans that cost
just as much. Else it is divided: at a threshold between the ranges of a walk whose ranges overlap (neither half
holds that walk), or by giving a free contour to either head.
"""

import heapq
import time
from dataclasses import dataclass, field

import numpy as np

from cutgap.formulations.contour_dp.ascent import Ascent
from cutgap.formulations.contour_dp.closing import Closing, Incumbent, walk_cost
from cutgap.formulations.contour_dp.division import FREE, Division, Region
from cutgap.formulations.contour_dp.first_divisions import first_divisions
from cutgap.formulations.contour_dp.sides import Side, Sides
from cutgap.formulations.contour_dp.solve import length_step
from cutgap.formulations.contour_dp.two_heads import Price, plan_of_switch_walk, switch_points, switch_walks
from cutgap.formulations.contour_dp.walks import Walks
from cutgap.formulations.two_heads.bound import objective_bound
from cutgap.formulations.two_heads.split import obeys_triangle_inequality
from cutgap.instances import Instance, Plan, Rules, check, evaluate
from cutgap.instances.arrays import Ints
from cutgap.instances.progress import Progress, Watch
from cutgap.instances.result import OPTIMALITY_TOLERANCE

FEW = 10
"""With so many free contours all switch walks of a region are looked for; with more it is divided first."""
FAR = 0.1
"""A region is not divided while its bound is farther than this share from the best plan."""


class Judge(Incumbent):
    """Takes switch walks: those that cost what their plan costs, and one that does not."""

    def __init__(self, search: "TwoHeadSearch", step: float) -> None:
        super().__init__(search.value, step)
        self.search = search
        self.cheaper: Plan | None = None

    def offer(self, walks: Walks, walk: Ints) -> None:
        """Offer the plan of a walk; keep it as ``cheaper`` when the walk costs less than the best plan then."""
        plan = plan_of_switch_walk(walks, walk)
        self.search.offer(plan)
        self.cost = self.search.value
        if walk_cost(walks, walk) < self.limit:
            self.cheaper = plan


@dataclass(order=True, slots=True)
class Cell:
    """A region with its bound, and the walk problem of it or of the region that it comes from.

    Attributes
    ----------
    walk_bound
        Bound (1).
    tried
        Whether tours of the decided contours were bounded, (2).
    """

    bound: float
    number: int
    region: Region = field(compare=False)
    walk_bound: float = field(compare=False, default=-np.inf)
    closing: Closing | None = field(compare=False, default=None)
    parent: "Cell | None" = field(compare=False, default=None)
    tried: bool = field(compare=False, default=False)


class TwoHeadSearch:
    """One search; see the module."""

    def __init__(self, instance: Instance, rules: Rules, time_limit: float | None, watch: Watch) -> None:
        self.instance, self.rules, self.watch = instance, rules, watch
        self.begun = time.perf_counter()
        self.deadline = np.inf if time_limit is None else self.begun + time_limit
        self.division = Division(instance, rules)
        self.sides = Sides(instance, self.begun, time_limit)
        self.metric = obeys_triangle_inequality(instance)
        half = Price(0.5 / instance.machine.v_jump, 0.5)
        # Only travel is what walks over both heads cost; other objectives need the heads apart in the end.
        self.linear = rules.objective == "travel"
        self.price = half if rules.objective == "makespan" else Price(1.0, 0.0)
        self.heap: list[Cell] = []
        self.number = 0
        self.best: Plan | None = None
        self.value = np.inf
        self.closed_bound = np.inf  # of regions that cannot be divided further (balance, weight > v_jump)
        self.current = np.inf  # of the region in hand

    def run(self, start: Plan | None) -> str | None:
        """Search until the least bound meets the best plan; return why it stopped before."""
        if start is not None:
            self.offer(start)
        whole = self.division.everything
        if whole is None:
            return None
        self.current = -np.inf
        try:
            self._first_plans(whole)
            self._push(Cell(-np.inf, 0, whole))
            while self.heap and self.heap[0].bound < self.limit:
                if time.perf_counter() >= self.deadline:
                    self.current = np.inf
                    return "time limit"
                cell = heapq.heappop(self.heap)
                self.current = cell.bound
                for each in self._step(cell):
                    self._push(each)
                self.current = np.inf
                self._report()
        except KeyboardInterrupt:
            return "interrupted"
        return None

    @property
    def limit(self) -> float:
        """Regions of this bound cannot hold a better plan."""
        if not np.isfinite(self.value):
            return np.inf
        return self.value - OPTIMALITY_TOLERANCE / 2 * max(1.0, abs(self.value))

    @property
    def lower_bound(self) -> float:
        """No plan costs less."""
        first = self.heap[0].bound if self.heap else np.inf
        return float(min(self.closed_bound, self.current, first, self.limit))

    def offer(self, plan: Plan) -> None:
        """Keep a plan if it is allowed and better than the best."""
        value = evaluate(self.instance, plan).objective(self.rules)
        if value < self.value and not check(self.instance, self.rules, plan):
            self.best, self.value = plan, value

    def _first_plans(self, whole: Region) -> None:
        for region in first_divisions(self.instance, self.rules, self.division, whole):
            one, two = self._tours(region)
            self.offer(Plan((one.tour, two.tour)))
            if time.perf_counter() >= self.deadline:
                return

    def _push(self, cell: Cell) -> None:
        if cell.bound < self.limit:
            self.number += 1
            cell.number = self.number
            heapq.heappush(self.heap, cell)

    def _step(self, cell: Cell) -> list[Cell]:
        """Return what takes the place of a region: itself with a better bound, or its parts."""
        if not cell.region.free:
            return self._step_tours(cell)
        if self.metric and not self.linear and not cell.tried:
            cell.tried = True
            cell.bound = max(cell.bound, self._decided_bound(cell.region))
            return [cell]
        # Where the tours of decided contours bound better, walks over both heads are not worth their time.
        if cell.closing is None and cell.parent is not None and cell.walk_bound < cell.bound:
            return self._divided(cell, None)
        return self._step_walk(cell)

    # Regions without free contours

    def _tours(self, region: Region) -> tuple[Side, Side]:
        left, right = self.division.points(region)
        return self.sides.side(0, left), self.sides.side(1, right)

    def _step_tours(self, cell: Cell) -> list[Cell]:
        """Work on the tours of a region without free contours, (3)."""
        pair = self._tours(cell.region)
        one, two = pair
        cell.bound = max(cell.bound, self._bound(one, two))
        if cell.bound >= self.limit:
            return []
        self.offer(Plan((one.tour, two.tour)))
        speed = self.instance.machine.v_jump
        for side in sorted(pair, key=lambda each: -(each.lower / speed + each.service_s)):
            if not side.closed and side.advance():
                return [cell]
        halves = self.division.halves(cell.region, Plan((one.tour, two.tour)))
        if halves is not None:
            return self._children(cell, halves)
        self.closed_bound = min(self.closed_bound, cell.bound)
        return []

    def _bound(self, one: Side, two: Side, floating_s: float = 0.0) -> float:
        works = one.service_s, two.service_s
        return objective_bound(self.instance.machine, self.rules, (one.lower, two.lower), works, floating_s)

    # Regions with free contours

    def _decided_bound(self, region: Region) -> float:
        """Return (2), after a round on each tour."""
        decided = region.side[self.division.contour_of] != FREE
        left, right = self.division.points(region)
        one, two = self.sides.side(0, left & decided), self.sides.side(1, right & decided)
        floating_s = float(self.instance.service_times[region.free].sum())
        for side in (one, two):
            if side.lower == 0.0:
                side.advance()
        return self._bound(one, two, floating_s)

    def _step_walk(self, cell: Cell) -> list[Cell]:
        """Work on the switch walks of a region, (1)."""
        if cell.closing is None:
            cell.closing = self._closing(cell)
        closing, judge = cell.closing, cell.closing.incumbent
        assert isinstance(judge, Judge)
        judge.cost = self.value
        few = self.linear and len(cell.region.free) <= FEW
        (closing.advance if few else closing.relax)()
        cell.walk_bound = max(cell.walk_bound, closing.bound)
        cell.bound = max(cell.bound, min(cell.walk_bound, judge.limit))
        if judge.cheaper is not None:
            return self._divided(cell, judge.cheaper)
        if closing.closed:
            return []
        if closing.ascent.found.exhausted and (closing.stuck or not few):
            return self._divided(cell, None)
        # Memories grow better before a division, which passes them on, while the bound is far off.
        far = self.linear and self.limit - cell.walk_bound > FAR * self.limit
        return [cell] if few or far else self._divided(cell, None)

    def _closing(self, cell: Cell) -> Closing:
        """Return the walk problem of a region, which begins with what was learned from its parent."""
        walks = switch_walks(self.instance, self.division, cell.region, self.price)
        step = length_step([walks]) if self.rules.objective == "travel" else 0.0
        closing = Closing(walks, Judge(self, step), self.deadline, lambda _: self._report())
        parent = cell.parent
        if parent is not None and parent.closing is not None:
            _inherit(closing.ascent, parent.closing.ascent, self._kept(cell.region, parent.region))
        return closing

    def _kept(self, region: Region, larger: Region) -> Ints:
        """Return the place of each point of a region among those of a larger one."""
        keys = [
            2 * nodes + is_right
            for nodes, is_right in (switch_points(self.division, each) for each in (larger, region))
        ]
        place = {key: i for i, key in enumerate(keys[0].tolist())}
        return np.array([place[key] for key in keys[1].tolist()])

    # Division

    def _divided(self, cell: Cell, plan: Plan | None) -> list[Cell]:
        """Return the parts of a region: at a threshold that rules the plan out, or by a contour."""
        halves = None if plan is None else self.division.halves(cell.region, plan)
        if halves is None:
            contour = self._pivot(cell.region)
            halves = cell.region.decided(contour, 0), cell.region.decided(contour, 1)
        return self._children(cell, halves)

    def _pivot(self, region: Region) -> int:
        """Return the free contour in the middle, which decides most others; of equals the one of most work."""
        centre = self.division.least + self.division.most
        free = region.free
        middle = float(np.median(centre[free]))
        work = self.instance.service_times
        return min(free, key=lambda contour: (abs(centre[contour] - middle), -work[contour]))

    def _children(self, cell: Cell, regions: tuple[Region, Region]) -> list[Cell]:
        narrow = [self.division.narrowed(region) for region in regions]
        return [
            Cell(
                cell.bound,
                0,
                region,
                cell.walk_bound,
                parent=cell if cell.closing is not None else cell.parent,
                tried=(region.side == cell.region.side).all(),
            )
            for region in narrow
            if region is not None
        ]

    def _report(self) -> None:
        value = self.value if np.isfinite(self.value) else None
        bound = self.lower_bound if np.isfinite(self.lower_bound) else None
        seconds = time.perf_counter() - self.begun
        self.watch(Progress(seconds, value, bound, f"{len(self.heap)} regions open"))


def _inherit(ascent: Ascent, parent: Ascent, kept: Ints) -> None:
    """Begin with the prices, memories, bound and allowed points of a problem with more points."""
    ascent.prices, ascent.members = parent.prices, parent.members
    ascent.found.bound = min(parent.found.bound, ascent.found.limit)
    ascent.found.allowed &= parent.found.allowed[:, kept]
