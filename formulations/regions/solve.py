"""One head, contours entered anywhere in their regions: the shortest tour (see ``search``), with a certificate.

With one head the makespan is its travel over v_jump plus a constant and there is no imbalance, so all
objectives are the shortest tour's.
"""

import time
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from cutgap.formulations.certify import SCALE, certificate_of
from cutgap.formulations.regions.first_tours import find_tours
from cutgap.formulations.regions.orders import Orders
from cutgap.formulations.regions.proof import TreeTooLargeError, Writer
from cutgap.formulations.regions.search import RegionSearch
from cutgap.formulations.regions.shapes import shapes_of
from cutgap.instances import Instance, Plan, Result, Rules, Visit, check, conclude
from cutgap.instances.check import require_coordinates
from cutgap.instances.free_entries import region_of
from cutgap.instances.progress import Progress, Watch, nobody
from cutgap.instances.region import point_region

FIRST_NODES = 500
"""Nodes of the search before more tours are looked for: small instances need none."""
TOUR_ROUNDS = 600
TOUR_SHARE = 0.2
"""Rounds and largest share of the time for first tours."""
ROUNDING = 1e-13
"""Relative error of a bound by rounding, per region."""


def solve_regions(
    instance: Instance,
    rules: Rules,
    *,
    time_limit: float | None = None,
    start: Plan | None = None,
    certify: bool = False,
    watch: Watch = nobody,
) -> Result:
    """Solve an instance with one head and free entries; the options are those of ``solve``.

    Raises
    ------
    ValueError
        Without free entries, and for what the method does not take: several heads, another metric, via points,
        process rules, precedence without a home, contours without a convex region.
    """
    begun = time.perf_counter()
    _require(instance, rules)
    deadline = np.inf if time_limit is None else begun + time_limit
    if not instance.contours:
        seconds = time.perf_counter() - begun
        return conclude(instance, rules, Plan(((),)), method="regions", seconds=seconds, lower_bound=0.0)
    run = _Run(instance, rules, deadline, watch)
    complete = run.solve(start, TOUR_SHARE * (deadline - begun))
    result = conclude(
        instance,
        rules,
        run.plan(),
        method="regions",
        seconds=time.perf_counter() - begun,
        lower_bound=run.objective(run.safe_bound()),
        reason=None if complete else "stopped early",
    )
    return replace(result, certificate=run.certificate(result)) if certify else result


def _require(instance: Instance, rules: Rules) -> None:
    """Raise ``ValueError``, saying why, when the method does not apply."""
    name = f"instance {instance.name!r}, method regions"
    if not rules.free_entries:
        raise ValueError(
            f"{name}: its plans choose points of their own; ask for free entries, or another method"
        )
    if len(instance.heads) != 1:
        raise ValueError(f"{name}: needs one head, got {len(instance.heads)}")
    if instance.machine.metric != "euclidean":
        raise ValueError(f"{name}: needs Euclidean rapids, got {instance.machine.metric}")
    require_coordinates(instance, rules)
    for is_asked, rule in ((rules.via_points, "via points"), (bool(rules.process), ", ".join(rules.process))):
        if is_asked:
            raise ValueError(f"{name}: does not take {rule}")
    if instance.precedence and instance.heads[0].home is None:
        raise ValueError(f"{name}: takes precedence with a home alone; give the head one")


class _Run:
    """One run: the search in the terms of the instance."""

    def __init__(self, instance: Instance, rules: Rules, deadline: float, watch: Watch) -> None:
        self.instance, self.rules = instance, rules
        home = instance.heads[0].home
        self.regions = [region_of(instance, contour) for contour in range(len(instance.contours))]
        places = [*self.regions, *([] if home is None else [point_region(home)])]
        self.orders = Orders(shapes_of(places), home=home is not None, pairs=instance.precedence)
        self.search = RegionSearch(self.orders, deadline=deadline, watch=self._told(watch))

    def objective(self, length: float) -> float:
        """Return what a tour of so many mm is worth."""
        service = float(self.instance.service_times.sum())
        return length / self.instance.machine.v_jump + service if self.rules.objective == "makespan" else length

    def _told(self, watch: Watch) -> Watch:
        def tell(progress: Progress) -> None:
            value, bound = (
                None if each is None else self.objective(each)
                for each in (progress.value, progress.lower_bound)
            )
            watch(replace(progress, value=value, lower_bound=bound))

        return tell

    def solve(self, start: Plan | None, tour_seconds: float) -> bool:
        """Search; False when it was stopped."""
        search = self.search
        rng = np.random.default_rng(0)
        if start is not None and not check(self.instance, self.rules, start):
            order = [visit.contour for visit in start.tours[0]]
            search.offer(np.array([*([] if self.orders.home is None else [self.orders.home]), *order]))
        try:
            find_tours(search, 0, np.inf, rng)
            if not search.run(FIRST_NODES):
                return False
            if not search.is_closed:
                find_tours(search, TOUR_ROUNDS, time.perf_counter() + tour_seconds, rng)
        except KeyboardInterrupt:
            return False
        return search.run()

    def plan(self) -> Plan | None:
        """Return the best tour, from the home on."""
        if len(self.search.best) == 0:
            return None
        visits = []
        for region, place in zip(self.search.best.tolist(), self.search.points.tolist(), strict=True):
            if region != self.orders.home:
                height = self.orders.shapes.heights[region]
                x, y, z = (*place, float(height))[:3]
                visits.append(Visit(region, 0, (x, y, z)))
        return Plan((tuple(visits),))

    def safe_bound(self) -> float:
        """Return the search's bound less what rounding may add to it."""
        shapes = self.orders.shapes
        size = float(np.abs(shapes.centres).max(initial=0.0) + np.abs(shapes.bases).max(initial=0.0))
        return max(0.0, self.search.lower_bound - ROUNDING * size * len(shapes.centres))

    def certificate(self, result: Result) -> dict[str, Any] | None:
        """Return a verified certificate of the bound, ``None`` when it would be too large."""
        if self.search.root is None or result.lower_bound is None:
            return None
        writer = Writer(self.search, self.instance)
        makespan = self.rules.objective == "makespan"
        unit = Fraction(repr(self.instance.machine.v_jump)) if makespan else Fraction(1)
        work = sum((writer.problem.work(k, SCALE) for k in range(len(self.regions))), Fraction(0))

        def claim(margin: float) -> tuple[int | None, dict[str, Any]]:
            assert result.lower_bound is not None
            bound = int((Fraction(result.lower_bound) * unit - Fraction(margin)) * SCALE)
            length = (bound - (work if makespan else 0)) / Fraction(SCALE)
            return max(bound, 0), writer.proof(length)

        try:
            return certificate_of(self.instance, self.rules, result.plan, 1, claim)
        except TreeTooLargeError:
            return None
