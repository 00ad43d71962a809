"""One way to call every method, exact or heuristic: a name in, a checked ``Result`` out."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from time import perf_counter

import numpy as np

from cutgap.formulations import METHODS, resolve, solve
from cutgap.heuristics import HEURISTICS
from cutgap.instances import Instance, Result, Rules, conclude
from cutgap.instances.progress import Watch, nobody

AUTO = "auto"
"""Name that leaves the choice of the exact method to ``cutgap.formulations.solve``."""

STARTERS = {"free": "local-search", "links": "link-search"}
"""Exact methods that start from a heuristic's plan."""

STARTER_SHARE = 0.25
"""Share of a time limit that such a heuristic may take: the rest is for the proof."""


def known_methods() -> tuple[str, ...]:
    """Return the names of all methods, exact ones first."""
    return (*METHODS, *HEURISTICS)


def default_methods(instances: Sequence[Instance], rules: Rules) -> tuple[str, ...]:
    """Return what a gap table compares: the exact method that suits, and what heuristics apply to any."""
    heuristics = [
        name
        for name, heuristic in HEURISTICS.items()
        if any(heuristic.applies(instance, rules) for instance in instances)
    ]
    return (AUTO, *heuristics)


def suits(method: str, instance: Instance, rules: Rules) -> bool:
    """Whether a method is meant for an instance and rules; of exact ones, whether it knows temperatures."""
    if not is_exact(method):
        return HEURISTICS[method].applies(instance, rules)
    try:
        resolve(method, instance, rules)
    except ValueError:
        return False
    return True


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
    """Run an exact method; some start from the plan of a heuristic."""
    begun, start = perf_counter(), None
    starter = STARTERS.get(resolve(method, instance, rules))
    if starter is not None:
        most, rng = None if time_limit is None else STARTER_SHARE * time_limit, np.random.default_rng(seed)
        with suppress(ValueError):
            start = HEURISTICS[starter](instance, rules, rng=rng, time_limit=most)
    spent = perf_counter() - begun
    left = None if time_limit is None else max(0.0, time_limit - spent)
    result = solve(instance, rules, method=method, time_limit=left, start=start, certify=certify, watch=watch)
    return replace(result, seconds=result.seconds + spent)


_WARM: set[tuple[object, ...]] = set()
"""What is warm in this process: methods, rules and kinds of instances."""


def warm_up(method: str, rules: Rules, instance: Instance) -> None:
    """Run a method on a few contours of an instance, so that loading and compiling count in no table.

    Once for a method, rules and kind of instance: heads, metric, entry points, precedence, geometry.
    """
    kind = (
        method,
        # Plates have caps of their own, which change nothing in what is compiled.
        rules if rules.temperature_cap is None else replace(rules, temperature_cap=0.0),
        tuple(head.home is None for head in instance.heads),
        instance.machine.metric,
        any(len(contour.entry_points) > 1 for contour in instance.contours),
        bool(instance.precedence),
        all(contour.geometry is not None for contour in instance.contours),
    )
    if kind in _WARM:
        return
    _WARM.add(kind)
    # Where a method refuses the instance or the rules, the run itself says so.
    with suppress(ValueError):
        run(method, excerpt(instance), rules, time_limit=60.0)


def excerpt(instance: Instance, *, contours: int = 6, entries: int = 3) -> Instance:
    """Return an instance with the first contours, and of each the first entry points, of another."""
    chosen = instance.contours[:contours]
    nodes = [
        instance.node(contour, entry)
        for contour, each in enumerate(chosen)
        for entry in range(min(entries, len(each.entry_points)))
    ]
    nodes += range(int(instance.first_node[-1]), instance.node_count)
    return replace(
        instance,
        contours=tuple(replace(each, entry_points=each.entry_points[:entries]) for each in chosen),
        precedence=tuple(pair for pair in instance.precedence if max(pair) < contours),
        matrix=None if instance.matrix is None else instance.matrix[np.ix_(nodes, nodes)],
    )
