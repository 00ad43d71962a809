"""Travel against peak: plans that no other plan beats in both.

    (1) t_1 = least travel,  p_1 = least peak within travel t_1
    (2) t_(k+1) = least travel with a peak below p_k,  p_(k+1) = least peak within travel t_(k+1)

On plates that branch and bound closes this is the exact front, up to differences below the tolerance of a cap:
a plan that is not on it is beaten by the last point that travels no more. Larger plates get points of least
travel under evenly spread caps instead, each with its proved bound.
"""

import time
from dataclasses import replace

import numpy as np

from cutgap.formulations.heat.exact import fits
from cutgap.formulations.heat.proof import heat_certificate
from cutgap.formulations.heat.solve import NAME, solve_heat
from cutgap.instances import Instance, Result, Rules, Status, conclude
from cutgap.instances.check import TOLERANCE
from cutgap.instances.heat import require_heat
from cutgap.instances.progress import Watch, nobody

POINTS = 8
ENDLESS = 1e15
"""A cap that only infinite peaks exceed, deg C."""


def heat_front(
    instance: Instance,
    rules: Rules,
    *,
    points: int = POINTS,
    time_limit: float | None = None,
    certify: bool = False,
    watch: Watch = nobody,
) -> list[Result]:
    """Return points of the front, shortest travel first, each for the rules with its peak as the cap.

    Where no plan keeps the rules there is one result, which says so.

    Parameters
    ----------
    rules
        Their objective is replaced by travel; their cap is that of the first point.
    points
        How many points a larger plate gets.
    time_limit
        Seconds for all points. The exact front ends where they do, its last point unproved or without a plan.
    certify
        Whether to add verified certificates: no plan within a point's peak travels less than its bound.

    Raises
    ------
    ValueError
        Where ``solve_heat`` does not apply.
    """
    free = replace(rules, objective="travel", weight=0.0)
    deadline = np.inf if time_limit is None else time.perf_counter() + time_limit
    if fits(instance.first_node):
        return _exact_front(instance, free, deadline, certify, watch)
    return _sampled_front(instance, free, points, deadline, certify, watch)


def _left(deadline: float, share: float = 1.0) -> float | None:
    return None if np.isinf(deadline) else max(0.0, share * (deadline - time.perf_counter()))


def _exact_front(
    instance: Instance, rules: Rules, deadline: float, certify: bool, watch: Watch
) -> list[Result]:
    front: list[Result] = []
    asked, ambient = rules, require_heat(instance).ambient_c
    while True:
        shortest = solve_heat(instance, asked, time_limit=_left(deadline), watch=watch)
        if shortest.plan is None or shortest.value is None:
            # What closes a front is no point of it, but a run that was stopped has to be seen.
            return front if front and shortest.status is Status.INFEASIBLE else [*front, shortest]
        coolest = solve_heat(
            instance,
            replace(asked, objective="peak", backward_price=0.0),
            time_limit=_left(deadline),
            start=shortest.plan,
            watch=watch,
            most_travel=shortest.value,
            backward_price=rules.backward_price,
        )
        peak = coolest.value
        if coolest.plan is None or peak is None:
            return [*front, shortest]
        # Where all of these peaks are infinite there is no bound, but a complete search gives no reason.
        proved = shortest.status is Status.OPTIMAL and coolest.reason is None
        kept = replace(rules, temperature_cap=peak) if np.isfinite(peak) else rules
        point = conclude(
            instance,
            kept,
            coolest.plan,
            method=NAME,
            seconds=shortest.seconds + coolest.seconds,
            lower_bound=shortest.lower_bound,
            reason=None if proved else "stopped early",
        )
        if certify and point.lower_bound is not None:
            proof = heat_certificate(instance, kept, point.lower_bound, _left(deadline))
            point = replace(point, certificate=proof)
        front.append(point)
        if not proved:
            return front
        cap = peak - 3.0 * TOLERANCE * max(1.0, peak - ambient) if np.isfinite(peak) else ENDLESS
        asked = replace(rules, temperature_cap=cap)


def _sampled_front(
    instance: Instance, rules: Rules, points: int, deadline: float, certify: bool, watch: Watch
) -> list[Result]:
    left = _left(deadline, 1.0 / (points + 1))
    first = solve_heat(instance, rules, time_limit=left, certify=certify, watch=watch)
    if first.evaluation is None or first.evaluation.peak_temperature_c is None or points < 2:
        return [first]
    cool = replace(rules, objective="peak", backward_price=0.0)
    coolest = solve_heat(
        instance, cool, time_limit=_left(deadline, 1.0 / points), start=first.plan, watch=watch
    )
    highest, lowest = first.evaluation.peak_temperature_c, coolest.value
    if lowest is None or not lowest < highest or np.isinf(highest):
        return [first]
    front, start = [], coolest.plan
    caps = np.linspace(lowest, highest, points)[:-1]
    for turn, cap in enumerate(caps.tolist()):
        asked = replace(rules, temperature_cap=cap)
        left = _left(deadline, 1.0 / (len(caps) - turn))
        # A plan within a tighter cap is within this one too.
        result = solve_heat(instance, asked, time_limit=left, start=start, certify=certify, watch=watch)
        start = result.plan or start
        front.append(result)
    return [first, *reversed(front)]
