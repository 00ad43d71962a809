"""One way to call every method, exact or heuristic: a name in, a checked ``Result`` out."""

from contextlib import suppress
from dataclasses import replace
from functools import cache
from time import perf_counter

import numpy as np

from cutgap.formulations import METHODS, resolve, solve
from cutgap.heuristics import HEURISTICS
from cutgap.instances import Contour, Head, Instance, Result, Rules, conclude
from cutgap.instances.progress import Watch, nobody

AUTO = "auto"
"""Name that leaves the choice of the exact method to ``cutgap.formulations.solve``."""


def known_methods() -> tuple[str, ...]:
    """Return the names of all methods, exact ones first."""
    return (*METHODS, *HEURISTICS)


def default_methods() -> tuple[str, ...]:
    """Return what a gap table compares: the exact method that suits the rules, and all heuristics."""
    return (AUTO, *HEURISTICS)


def is_exact(method: str) -> bool:
    """Whether the method proves bounds; such a method gives the same result for every seed."""
    return method == AUTO or method in METHODS


def require_known(method: str) -> None:
    """Raise ``ValueError`` for a name that is no method."""
    if not is_exact(method) and method not in HEURISTICS:
        raise ValueError(f"method: expected one of {', '.join((AUTO, *known_methods()))}, got {method!r}")


def run(
    method: str,
    instance: Instance,
    rules: Rules,
    *,
    seed: int = 0,
    time_limit: float | None = None,
    certify: bool = False,
    watch: Watch = nobody,
) -> Result:
    """Run one method on one instance.

    Parameters
    ----------
    method
        A name of ``known_methods()``, or ``auto``.
    seed
        Seed of the random numbers; exact methods use none.
    time_limit
        Limit in s; ``None`` sets none.
    certify
        Whether an exact method adds a verified certificate of its bound.
    watch
        Told of every better plan or bound.

    Raises
    ------
    ValueError
        When the method is unknown, or refuses the instance or the rules.
    """
    require_known(method)
    if is_exact(method):
        return _run_exact(method, instance, rules, seed, time_limit, certify, watch)
    start = perf_counter()
    rng = np.random.default_rng(seed)
    plan = HEURISTICS[method](instance, rules, rng=rng, watch=watch, time_limit=time_limit)
    return conclude(instance, rules, plan, method=method, seconds=perf_counter() - start, seed=seed)


def _run_exact(
    method: str,
    instance: Instance,
    rules: Rules,
    seed: int,
    time_limit: float | None,
    certify: bool,
    watch: Watch,
) -> Result:
    """Run an exact method; where the partition is free it starts from a plan of the local search."""
    begun, start = perf_counter(), None
    if resolve(method, instance, rules) == "free":
        with suppress(ValueError):
            start = HEURISTICS["local-search"](instance, rules, rng=np.random.default_rng(seed))
    spent = perf_counter() - begun
    left = None if time_limit is None else max(0.0, time_limit - spent)
    result = solve(instance, rules, method=method, time_limit=left, start=start, certify=certify, watch=watch)
    return replace(result, seconds=result.seconds + spent)


@cache
def warm_up(method: str, rules: Rules) -> None:
    """Run a method once on six points, so that loading and compiling count in no table."""
    angles = np.linspace(0.0, 5.0, 6)
    points = np.column_stack([100 * np.cos(angles), 100 * np.sin(angles), np.zeros(6)])
    contours = tuple(Contour(str(number), point[None], 10.0) for number, point in enumerate(points))
    heads = (Head("left", np.array([-200.0, 0, 0])), Head("right", np.array([200.0, 0, 0])))
    # Where a method refuses the rules, the run itself says so.
    with suppress(ValueError):
        run(method, Instance("warm-up", contours, heads), rules, time_limit=10.0)
