r"""The method ``perspective``: a tour through convex regions in any order, by its mixed-integer conic model.

The model is that of ``relaxations.perspective``, for at most ``MOST_WHOLE`` regions. Two ways to solve it:

    highs   Outer approximation: a cone |x| <= b becomes tangents u.x <= b, |u| <= 1. A round solves the linear
            mixed-integer model with the tangents and subtour constraints so far; its bound holds for all tours.
            Then it adds tangents where the solution breaks a cone, and those of the tour that it takes.
    scip    The conic model itself, in rounds of subtour constraints.

The tangents of a tour are multipliers u of its own problem, the shortest way in its order: with them the linear
model knows how long this tour is. The rounds end when value and bound differ by ``CLOSED``.

Such bounds are the solver's, within its tolerance: for HiGHS 1e-9 of the extent in each row, for SCIP 1e-6. The
bound of the relaxation is proved in exact arithmetic; with a certificate it is the bound of the result.

Source: Duran and Grossmann (1986) for outer approximation.
"""

import time
import warnings
from collections.abc import Sequence
from dataclasses import replace
from importlib.util import find_spec
from typing import Any, Literal

import cvxpy as cp
import numpy as np

from cutgap.formulations.relaxations.perspective import (
    PerspectiveModel,
    Relaxed,
    relaxed_solution,
    scaled_region,
    solve_relaxation,
)
from cutgap.formulations.relaxations.perspective_proof import (
    NAME,
    perspective_certificate,
    proved_bound,
    proved_length,
    tour_regions,
)
from cutgap.instances import Instance, Plan, Result, Rules, Visit, check, conclude, evaluate
from cutgap.instances.arrays import Floats
from cutgap.instances.progress import Progress, Watch, nobody
from cutgap.instances.region import Hull, Region
from cutgap.instances.tours import improve_tour, nearest_neighbour_tour

MOST_WHOLE = 12
"""Regions, the home included; with 10 a round takes some 20 s."""
CLOSED = 1e-6
"""Relative distance of value and bound at which the rounds end."""
TOLERANCE = 1e-9
"""HiGHS's tolerance on rows and whole variables; with its default, 1e-6, bounds are too low by 1e-4."""
LINEAR_ROUNDS = 8
"""Most rounds of tangents for the relaxation, before edges must be whole."""
START_ROUNDS = 5
Solver = Literal["highs", "scip"]


def solve_perspective(
    instance: Instance,
    rules: Rules,
    *,
    time_limit: float | None = None,
    start: Plan | None = None,
    certify: bool = False,
    watch: Watch = nobody,
    solver: Solver = "highs",
) -> Result:
    """Solve an instance with one head and free entries.

    Parameters
    ----------
    time_limit
        Seconds after which the best plan and the bound so far are returned, but not before the relaxation's
        are there. Ctrl-C does the same after a round.
    start
        A plan to start from; one that breaks rules is ignored.
    certify
        Whether to prove the relaxation's bound in exact arithmetic, and to return this bound.
    solver
        ``highs`` or, where it is installed, ``scip``.

    Raises
    ------
    ValueError
        When the method does not apply, a region is not convex, there are too few or too many, or no SCIP.
    """
    begun = time.perf_counter()
    regions = tour_regions(instance, rules)
    if len(regions) > MOST_WHOLE:
        raise ValueError(
            f"instance {instance.name!r}, method {NAME}: takes up to {MOST_WHOLE} regions with the home, "
            f"got {len(regions)}; take the method regions, or relax_perspective for a bound"
        )
    if solver == "scip" and find_spec("pyscipopt") is None:
        raise ValueError("solver scip: not installed; pip install 'pyscipopt>=5'")
    search = PerspectiveSearch(instance, rules, regions, begun, time_limit, watch)
    reason = search.run(start, solver)
    bound: float | None = search.objective(min(search.bound, search.length))
    certificate = None
    if certify and search.relaxed is not None:
        certificate = perspective_certificate(instance, rules, None, search.relaxed.prices)
        bound = proved_bound(instance, certificate)
    result = conclude(
        instance,
        rules,
        search.plan,
        method=NAME,
        seconds=time.perf_counter() - begun,
        lower_bound=bound,
        reason=reason,
    )
    return replace(result, certificate=certificate)


class PerspectiveSearch:
    """The rounds, and the best plan and bound so far; lengths are mm."""

    def __init__(
        self,
        instance: Instance,
        rules: Rules,
        regions: Sequence[Region],
        begun: float,
        time_limit: float | None,
        watch: Watch,
    ) -> None:
        self.instance, self.rules, self.regions = instance, rules, regions
        self.begun, self.watch = begun, watch
        self.deadline = np.inf if time_limit is None else begun + time_limit
        self.model = PerspectiveModel(regions, whole=True)
        self.plan: Plan | None = None
        self.length, self.bound = np.inf, 0.0
        self.relaxed: Relaxed | None = None

    def run(self, start: Plan | None, solver: Solver) -> str | None:
        """Close the gap; return why it is open, if it is."""
        goes_on = True
        try:
            if start is not None and not check(self.instance, self.rules, start):
                self._offer(start)
            self._relax()
            while goes_on and not self.closed and time.perf_counter() < self.deadline:
                goes_on = self._linear_round() if solver == "highs" else self._conic_round()
        except KeyboardInterrupt:
            return "stopped early"
        if self.closed:
            return None
        return "stopped early" if time.perf_counter() >= self.deadline else "closed to the solver's tolerance"

    @property
    def closed(self) -> bool:
        """Whether value and bound meet."""
        return self.bound >= (1.0 - CLOSED) * self.length

    def objective(self, length: float) -> float:
        """Return the objective of a tour of that length."""
        if self.rules.objective != "makespan":
            return length
        return length / self.instance.machine.v_jump + float(self.instance.service_times.sum())

    def _relax(self) -> None:
        """Solve the relaxation; its subtour constraints and tangents, and a first tour, go into the model."""
        relaxation = PerspectiveModel(self.regions, whole=False)
        solve_relaxation(relaxation)
        self.relaxed = relaxed_solution(relaxation)
        self._raise(proved_length(self.instance, self.relaxed.prices))
        for cone in relaxation.cones:
            cone.cut_off(-np.inf)
        for _ in range(LINEAR_ROUNDS):
            relaxation.problem(conic=False).solve(solver=cp.HIGHS)
            if relaxation.size * relaxation.lengths.value.sum() > (1.0 - 1e-4) * self.relaxed.value:
                break
            for cone in relaxation.cones:
                cone.cut_off()
        for members in relaxation.sets:
            self.model.add_subtour(members)
        for cone, known in zip(self.model.cones, relaxation.cones, strict=True):
            cone.rows, cone.directions = known.rows, known.directions
        self._start(self.relaxed.touch)

    def _start(self, touch: Floats) -> None:
        """Find a first tour: the best through the touch points, which then move to their best places."""
        least = np.inf
        for _ in range(START_ROUNDS):
            lengths = np.linalg.norm(touch[:, None] - touch, axis=2)
            order = improve_tour(lengths, nearest_neighbour_tour(lengths), kicks=20, seed=0)
            touch = self._take(order.tolist())
            if self.length >= least:
                break
            least = self.length

    def _linear_round(self) -> bool:
        """Learn the linear model's bound and cut its solution off; False when nothing is left to cut."""
        problem, left = self.model.problem(conic=False), self.deadline - time.perf_counter()
        options = {} if left == np.inf else {"time_limit": max(0.0, left)}
        tolerances = dict.fromkeys(("primal_feasibility_tolerance", "mip_feasibility_tolerance"), TOLERANCE)
        solve_quietly(problem, solver=cp.HIGHS, mip_rel_gap=CLOSED / 10, **tolerances, **options)
        self._raise(float(problem.solver_stats.extra_stats.mip_dual_bound) * self.model.size)
        if problem.status != cp.OPTIMAL:
            return False
        if self.model.add_broken_subtours():
            return True
        broken = [cone.cut_off(10 * TOLERANCE) for cone in self.model.cones]
        self._take_solution()
        return any(broken)

    def _conic_round(self) -> bool:
        """Solve the conic model; False when its solution is a tour, and so the best one."""
        problem, left = self.model.problem(conic=True), self.deadline - time.perf_counter()
        options = {} if left == np.inf else {"limits/time": max(0.0, left)}
        solve_quietly(problem, solver=cp.SCIP, scip_params=options)
        if problem.status != cp.OPTIMAL:
            return False
        self._raise(float(problem.value) * self.model.size)
        if self.model.add_broken_subtours():
            return True
        self._take_solution()
        return False

    def _take_solution(self) -> None:
        order = self.model.order()
        if order is not None:
            self._take(order)

    def _take(self, order: list[int]) -> Floats:
        """Find the shortest way in an order, offer it as a plan, add its tangents and return its points, mm."""
        model = self.model
        scaled, multipliers = shortest_in_order(model, order)
        for place in range(len(order)):
            pull = multipliers[place - 1] - multipliers[place]
            add_tangents(model, order, place, multipliers[place], pull)
        solved = model.origin + model.size * scaled
        points = np.array([self.regions[v].nearest(p) for v, p in zip(order, solved, strict=True)])
        home = len(self.instance.contours)
        turn = order.index(home) + 1 if home in order else 0
        stops = [*range(turn, len(order)), *range(turn)]
        visits = [Visit(order[k], 0, tuple(points[k].tolist())) for k in stops if order[k] != home]
        self._offer(Plan((tuple(visits),)))
        return points[np.argsort(order)]

    def _offer(self, plan: Plan) -> None:
        """Keep a plan if it is allowed and the shortest so far."""
        length = evaluate(self.instance, plan).total_travel_mm
        if length < self.length and not check(self.instance, self.rules, plan):
            self.plan, self.length = plan, length
            self._report()

    def _raise(self, bound: float) -> None:
        if np.isfinite(bound) and bound > self.bound:
            self.bound = bound
            self._report()

    def _report(self) -> None:
        value = None if self.plan is None else self.objective(self.length)
        bound = self.objective(min(self.bound, self.length))
        self.watch(Progress(time.perf_counter() - self.begun, value, bound))


def solve_quietly(problem: cp.Problem, **options: Any) -> None:
    """Solve without the warning that a run which reached its time limit is inaccurate: its status says so."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        problem.solve(**options)


def shortest_in_order(model: PerspectiveModel, order: Sequence[int]) -> tuple[Floats, Floats]:
    """Return touch points in an order, and a multiplier for each leg to the next one, |u| <= 1; model's units.

    min sum_k |d_k|   s.t.   d_k = p_{k+1} - p_k   (u_k),   p_k in region k
    """
    count = len(order)
    points, legs = cp.Variable((count, 3)), cp.Variable((count, 3))
    following = np.roll(np.arange(count), -1)
    placed = legs == points[following] - points
    constraints = [placed]
    for place, number in enumerate(order):
        linear, cones = scaled_region(model.regions[number], points[place : place + 1], np.ones(1))
        constraints += [*linear, *(cone.exact() for cone in cones)]
    problem = cp.Problem(cp.Minimize(cp.sum(cp.norm(legs, 2, axis=1))), constraints)
    problem.solve(solver=cp.CLARABEL)
    multipliers = -np.array(placed.dual_value)
    return points.value, multipliers / np.maximum(1.0, np.linalg.norm(multipliers, axis=1, keepdims=True))


def add_tangents(
    model: PerspectiveModel, order: Sequence[int], place: int, along: Floats, pull: Floats
) -> None:
    """Add the tangents of a tour at one place: of its leg to the next one, and of its region.

    ``along`` is the leg's multiplier u, ``pull`` the vector s = u_{k-1} - u_k: the point is at the least s.x.
    """
    here, following = order[place], order[(place + 1) % len(order)]
    edge = model.edge(here, following)
    # The step of an edge goes from its larger region to the smaller one.
    sign = 1.0 if here > following else -1.0
    model.cone_of_steps.add(np.array([edge]), sign * along[None])
    region = model.regions[here]
    if isinstance(region, Hull):
        return
    outward = -region.axes @ pull
    length = float(np.linalg.norm(outward))
    if length > 0.0:
        rows = np.arange(len(order) - 1)
        for cone in model.cones_of[here]:
            cone.add(rows, np.tile(outward / length, (len(rows), 1)))
