"""Travel against imbalance: the front of least travel under ever tighter limits (epsilon constraint).

    for each limit b:   min L_1 + L_2   s.t.   |T_1 - T_2| <= b   and the other rules

The first point has no limit; its imbalance is the widest limit that means anything. A hard limit may be met by
a longer tour of the head that would be done first, so between two limits the front is nearly continuous: it
is sampled, and every sample comes with its proved bound.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from cutgap.formulations.front_door import solve
from cutgap.instances import Instance, Plan, Result, Rules
from cutgap.instances.progress import Watch, nobody


def pareto_front(
    instance: Instance,
    rules: Rules,
    *,
    limits: Sequence[float] | None = None,
    points: int = 8,
    time_limit: float | None = None,
    watch: Watch = nobody,
) -> Iterator[Result]:
    """Yield the point of least travel without a limit, then one for each limit on imbalance, tightest first.

    Parameters
    ----------
    rules
        Their objective and balance limit are replaced.
    limits
        In s; by default ``points - 1`` of them, evenly spread in the logarithm from half the first point's
        imbalance down to a fiftieth of it.
    time_limit
        Seconds for each point; an unfinished one still has its plan and its valid bound.

    Raises
    ------
    ValueError
        When a limit is negative, or the instance is none for two heads.
    """
    free = replace(rules, objective="travel", weight=0.0, balance=None)
    first = solve(instance, free, time_limit=time_limit, certify=True, watch=watch)
    yield first
    if first.evaluation is None:
        return
    widest = first.evaluation.imbalance_s
    if limits is None:
        limits = np.geomspace(widest / 2, widest / 50, points - 1).tolist() if widest > 0 else []
    plan: Plan | None = None
    for limit in sorted(limits):
        asked = replace(free, balance=float(limit))
        # A plan within a tighter limit is within this one too.
        result = solve(instance, asked, time_limit=time_limit, start=plan, certify=True, watch=watch)
        plan = result.plan
        yield result
