"""Plans of a heuristic between travel and peak, each evaluated and checked."""

from time import perf_counter

import numpy as np

from cutgap.heuristics import GENETIC, HEURISTICS
from cutgap.heuristics.dual_coded import front_of_population
from cutgap.instances import Instance, Result, Rules, conclude


def heuristic_front(
    method: str, instance: Instance, rules: Rules, seed: int = 0, time_limit: float | None = None
) -> list[Result]:
    """Return what a heuristic offers by rising travel: a genetic one its population's front, others one plan.

    Parameters
    ----------
    rules
        Their objective is replaced by travel.
    seed, time_limit
        Of the one run; the limit in s.

    Raises
    ------
    ValueError
        When the method is no heuristic, or refuses the instance or the rules.
    """
    require_heuristic(method)
    rules, rng, begun = rules.constraints, np.random.default_rng(seed), perf_counter()
    if method in GENETIC:
        plans = front_of_population(instance, rules, rng=rng, time_limit=time_limit, parameters=GENETIC[method])
    else:
        plans = [HEURISTICS[method](instance, rules, rng=rng, time_limit=time_limit)]
    seconds = perf_counter() - begun
    return [conclude(instance, rules, plan, method=method, seconds=seconds, seed=seed) for plan in plans]


def require_heuristic(method: str) -> None:
    """Raise ``ValueError`` for a name that is no heuristic."""
    if method not in HEURISTICS:
        raise ValueError(f"method: expected one of the heuristics {', '.join(HEURISTICS)}, got {method!r}")
