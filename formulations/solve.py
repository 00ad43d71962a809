"""The front door: one call for all exact methods."""

from collections.abc import Callable

from cutgap.formulations.free import solve_free
from cutgap.formulations.split import solve_split
from cutgap.instances import Instance, Plan, Result, Rules
from cutgap.instances.progress import Watch, nobody

METHODS: dict[str, Callable[..., Result]] = {"split": solve_split, "free": solve_free}
"""Exact methods by name; ``auto`` chooses among them."""


def resolve(method: str, rules: Rules) -> str:
    """Return the name of an exact method; ``auto`` takes the threshold search wherever it applies."""
    if method == "auto":
        return "free" if rules.non_overlap is None or rules.balance is not None else "split"
    if method not in METHODS:
        raise ValueError(f"method: expected auto or one of {', '.join(METHODS)}, got {method!r}")
    return method


def solve(
    instance: Instance,
    rules: Rules,
    *,
    method: str = "auto",
    time_limit: float | None = None,
    start: Plan | None = None,
    certify: bool = False,
    watch: Watch = nobody,
) -> Result:
    """Solve an instance under rules, to proven optimality where the time allows.

    Parameters
    ----------
    method
        A name of ``METHODS``, or ``auto``.
    time_limit
        Seconds; a stopped run returns its best plan and its valid bound, as does Ctrl-C.
    start
        A plan to start from.
    certify
        Whether to add a certificate, verified in exact arithmetic, of the bound to the result.
    watch
        Called with the state of the run from time to time.

    Raises
    ------
    ValueError
        When the method is unknown or does not apply to the instance.
    """
    run = METHODS[resolve(method, rules)]
    return run(instance, rules, time_limit=time_limit, start=start, certify=certify, watch=watch)
