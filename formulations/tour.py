"""One head: its shortest tour of all contours, by branch and cut (see ``branch_and_cut.tour``).

With one head the makespan is its travel over v_jump plus a constant and there is no imbalance, so all
objectives are the shortest tour's.
"""

import time
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from cutgap.formulations.certify import SCALE, TOUR_MULTIPLIER_SCALE, certificate_of, side_proof
from cutgap.formulations.scope import require_single_entries
from cutgap.formulations.sides import Side, Sides
from cutgap.instances import Instance, Plan, Result, Rules, conclude
from cutgap.instances.progress import Progress, Watch, nobody
from cutgap.instances.scene import Scene


def solve_tour(
    instance: Instance,
    rules: Rules,
    *,
    time_limit: float | None = None,
    start: Plan | None = None,
    certify: bool = False,
    watch: Watch = nobody,
) -> Result:
    """Solve an instance with one head; the options are those of ``solve``, and ``start`` is not needed.

    Raises
    ------
    ValueError
        When there are several heads, several entry points, precedence pairs or asymmetric lengths.
    """
    begun = time.perf_counter()
    if len(instance.heads) != 1:
        raise ValueError(f"instance {instance.name!r}, method tour: needs one head, got {len(instance.heads)}")
    require_single_entries(instance, rules, "tour")
    deadline = np.inf if time_limit is None else begun + time_limit
    sides = Sides(instance, 0, via_points=rules.via_points, inherits=False)
    everything = (1 << len(instance.contours)) - 1
    side = sides.tour(everything)
    speed = instance.machine.v_jump

    def objective(length: float) -> float:
        return length / speed + side.service_s if rules.objective == "makespan" else length

    def report(progress: Progress) -> None:
        bound = max(side.lower, progress.lower_bound or 0.0)
        seen = replace(progress, seconds=time.perf_counter() - begun, lower_bound=bound)
        watch(seen.seen_as(objective, sides.nodes(side.contours).tolist()))

    complete = True
    while not side.is_exact and complete and (side.search is None or not side.search.complete):
        complete = sides.tighten(everything, np.inf, deadline, report)
        text = (
            "Trees with prices bound the tour (Held-Karp)." if side.search is None else "The search has ended."
        )
        scene = partial(Scene, text, bound=side.lower)
        report(Progress(0.0, side.upper if np.isfinite(side.upper) else None, scene=scene))
    result = conclude(
        instance,
        rules,
        Plan.of_contours([side.order]),
        method="tour",
        seconds=time.perf_counter() - begun,
        lower_bound=objective(side.lower),
        reason=None if complete else "stopped early",
    )
    return replace(result, certificate=_certificate(instance, rules, side, result)) if certify else result


def _certificate(instance: Instance, rules: Rules, side: Side, result: Result) -> dict[str, Any] | None:
    ids = [contour.id for contour in instance.contours]
    unit = instance.machine.v_jump if rules.objective == "makespan" else 1.0

    def claim(margin: float) -> tuple[int | None, dict[str, Any]]:
        assert result.lower_bound is not None
        bound = max(0, int(np.floor((result.lower_bound * unit - 2 * margin) * SCALE)))
        return bound, {"kind": "tour", "tour": side_proof(0, side, ids, margin, TOUR_MULTIPLIER_SCALE)}

    return certificate_of(instance, rules, result.plan, TOUR_MULTIPLIER_SCALE, claim)
