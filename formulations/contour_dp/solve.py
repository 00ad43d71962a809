"""The method ``contour-dp``: one head, any entry points, precedence and process rules, to proven optimality."""

import time
from collections.abc import Iterable
from dataclasses import replace
from functools import partial

import numpy as np

from cutgap.formulations.contour_dp.closing import Closing, Incumbent
from cutgap.formulations.contour_dp.proof import contour_certificate
from cutgap.formulations.contour_dp.scenes import PassMaker, scene_of
from cutgap.formulations.contour_dp.walks import Walks, walk_problems
from cutgap.instances import Instance, Plan, Result, Rules, Visit, check, conclude, evaluate
from cutgap.instances.arrays import Ints
from cutgap.instances.check import require_coordinates
from cutgap.instances.entry_tours import EntrySearch, entry_task
from cutgap.instances.progress import Progress, Watch, nobody
from cutgap.instances.scene import Scene, plan_nodes

NAME = "contour-dp"

START_ROUNDS, START_PIECE = 50, 200
"""Rounds per contour of the search for a first plan, and rounds between looks at the clock."""


def solve_contours(
    instance: Instance,
    rules: Rules,
    *,
    time_limit: float | None = None,
    start: Plan | None = None,
    certify: bool = False,
    watch: Watch = nobody,
) -> Result:
    """Solve an instance with one head by dynamic programming over contours.

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
        When there are several heads, via points are asked for, or a rule needs curves that are not there.
    """
    begun = time.perf_counter()
    _require_scope(instance, rules)
    if not instance.contours or (len(instance.contours) == 1 and instance.heads[0].home is None):
        return _stay(instance, rules, certify)
    search = ContourSearch(instance, rules, start, begun, time_limit, watch)
    complete = search.run()
    proved = search.bound
    result = conclude(
        instance,
        rules,
        search.plan,
        method=NAME,
        seconds=time.perf_counter() - begun,
        lower_bound=search.objective(max(0.0, proved)) if np.isfinite(proved) else None,
        infeasible=complete and search.plan is None,
        reason=None if complete else "stopped early",
    )
    if not certify or result.lower_bound is None:
        return result
    step = search.incumbent.step
    certificate = contour_certificate(instance, rules, search.plan, proved, step, search.closings)
    return replace(result, certificate=certificate)


def _stay(instance: Instance, rules: Rules, certify: bool) -> Result:
    """Return the plan of a head that stays where it is, as no rapid is needed."""
    plan = Plan.of_contours([range(len(instance.contours))])
    value = conclude(instance, rules, plan, method=NAME, seconds=0.0).value
    result = conclude(instance, rules, plan, method=NAME, seconds=0.0, lower_bound=value)
    return (
        replace(result, certificate=contour_certificate(instance, rules, plan, 0.0, 0.0, []))
        if certify
        else result
    )


def _require_scope(instance: Instance, rules: Rules) -> None:
    name = f"instance {instance.name!r}, method {NAME}"
    if len(instance.heads) != 1:
        raise ValueError(f"{name}: needs one head, got {len(instance.heads)}")
    if rules.via_points:
        raise ValueError(f"{name}: does not take via points")
    require_coordinates(instance, rules)


class ContourSearch:
    """All walk problems of an instance, and the best plan over them."""

    def __init__(
        self,
        instance: Instance,
        rules: Rules,
        start: Plan | None,
        begun: float,
        time_limit: float | None,
        watch: Watch,
    ) -> None:
        self.instance, self.rules, self.begun, self.watch = instance, rules, begun, watch
        self.deadline = np.inf if time_limit is None else begun + time_limit
        self.service = float(instance.service_times.sum())
        self.plan, cost = self._start(start)
        problems = walk_problems(instance, rules)
        self.incumbent = Incumbent(cost, length_step(problems))
        self.closings = [Closing(walks, self.incumbent, self.deadline, self._report) for walks in problems]

    def run(self) -> bool:
        """Close all problems; False when the time or the memory ended before."""
        try:
            while self.advance():
                pass
        except KeyboardInterrupt:
            self._report()
            return False
        return self.closed

    def advance(self) -> bool:
        """Work on the open problem of least bound; False when there is none or the time is over."""
        open_ones = [each for each in self.closings if not each.closed and not each.stuck]
        if not open_ones or time.perf_counter() >= self.deadline:
            return False
        min(open_ones, key=lambda each: each.bound).advance()
        self._report()
        return True

    @property
    def closed(self) -> bool:
        """Whether the best plan is optimal, or there is none."""
        return all(each.closed for each in self.closings)

    @property
    def bound(self) -> float:
        """No plan costs less, mm; a closed problem has shown that none is below the limit."""
        best = self.incumbent.cost if self.incumbent.step > 0.0 else self.incumbent.limit
        return min((best if each.closed else min(best, each.bound) for each in self.closings), default=np.inf)

    def objective(self, cost: float) -> float:
        """Return the objective of a plan whose rapids cost so many mm."""
        if self.rules.objective == "makespan":
            return cost / self.instance.machine.v_jump + self.service
        return cost

    def _start(self, start: Plan | None) -> tuple[Plan | None, float]:
        """Return the better of the given plan and a quick search's, if it keeps the rules; its cost in mm."""
        search = EntrySearch(
            entry_task(self.instance, self.rules),
            START_ROUNDS * len(self.instance.contours),
            rng=np.random.default_rng(0),
        )
        while not search.over and (search.done == 0 or time.perf_counter() < self.deadline):
            search.run(START_PIECE)
        best: tuple[Plan | None, float] = None, np.inf
        for plan in (start, Plan((search.best.visits,))):
            if plan is not None and not check(self.instance, self.rules, plan):
                evaluation = evaluate(self.instance, plan)
                backward = self.rules.backward_price * sum(evaluation.backward_mm)
                if evaluation.total_travel_mm + backward < best[1]:
                    best = plan, evaluation.total_travel_mm + backward
        return best

    def _report(self, passed: PassMaker | None = None) -> None:
        """Tell the watch, and turn a better walk into a plan."""
        if self.incumbent.best is not None:
            self.plan = plan_of(*self.incumbent.best)
        value = self.objective(self.incumbent.cost) if self.plan is not None else None
        bound = self.objective(self.bound) if np.isfinite(self.bound) else None
        scene = None if passed is None else partial(self._scene, passed)
        self.watch(Progress(time.perf_counter() - self.begun, value, bound, scene=scene))

    def _scene(self, passed: PassMaker) -> Scene:
        best = None if self.plan is None else plan_nodes(self.instance, self.plan)
        return scene_of(self.instance, passed(), best).with_bounds(self.objective)


def plan_of(walks: Walks, walk: Ints) -> Plan:
    """Return the plan of a walk."""
    visits: list[Visit] = [*walks.prefix, *(walks.visits[point] for point in walk)]
    return Plan((tuple(visits),))


def length_step(problems: Iterable[Walks]) -> float:
    """Return 1 when all costs are whole numbers, so that plans differ by at least 1 mm, else 0."""
    for walks in problems:
        for costs in (walks.costs, walks.start, walks.end):
            finite = costs[np.isfinite(costs)]
            if (finite != np.round(finite)).any():
                return 0.0
    return 1.0
