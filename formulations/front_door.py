"""The front door: one call for all exact methods."""

from collections.abc import Callable
from dataclasses import replace
from time import perf_counter
from typing import Any, NamedTuple

from cutgap.formulations.contour_dp.contour_split import solve_contour_split
from cutgap.formulations.contour_dp.search import MOST_CONTOURS
from cutgap.formulations.contour_dp.solve import solve_contours
from cutgap.formulations.generalized_tour import solve_generalized_tour
from cutgap.formulations.heat.solve import solve_heat
from cutgap.formulations.tour import solve_tour
from cutgap.formulations.two_heads.free import solve_free
from cutgap.formulations.two_heads.split import solve_split
from cutgap.instances import Instance, Plan, Result, Rules, Status
from cutgap.instances.progress import Watch, nobody


def _solve_cpsat(instance: Instance, rules: Rules, **options: Any) -> Result:
    """Load CP-SAT, which takes a second, when it is asked for."""
    from cutgap.formulations.cpsat.solving import solve_cpsat

    return solve_cpsat(instance, rules, **options)


def _solve_regions(instance: Instance, rules: Rules, **options: Any) -> Result:
    """Load the kernels for regions when they are asked for."""
    from cutgap.formulations.regions.solve import solve_regions

    return solve_regions(instance, rules, **options)


def _solve_perspective(instance: Instance, rules: Rules, **options: Any) -> Result:
    """Load cvxpy, which takes a second, when it is asked for."""
    from cutgap.formulations.regions.perspective import solve_perspective

    return solve_perspective(instance, rules, **options)


def _solve_links(instance: Instance, rules: Rules, **options: Any) -> Result:
    """Load the kernels for links when they are asked for."""
    from cutgap.formulations.links.solve import solve_links

    return solve_links(instance, rules, **options)


METHODS: dict[str, Callable[..., Result]] = {
    "tour": solve_tour,
    "contour-dp": solve_contours,
    "contour-split": solve_contour_split,
    "gtsp": solve_generalized_tour,
    "split": solve_split,
    "free": solve_free,
    "cpsat": _solve_cpsat,
    "regions": _solve_regions,
    "perspective": _solve_perspective,
    "heat": solve_heat,
    "links": _solve_links,
}
"""Exact methods by name; ``auto`` takes CP-SAT, whose bounds are claims, only where no other one applies."""


FREE_ENTRIES = ("regions", "perspective")
"""Methods for contours that may be entered anywhere in their regions."""

HEAT = ("heat",)
"""Methods that know temperatures."""

LINKS = ("links",)
"""Methods that join contours by links."""


class Choice(NamedTuple):
    """An exact method by name, and why it suits."""

    method: str
    why: str


FEW_CONTOURS, FEW_POINTS = 36, 6
"""Up to so many contours their dynamic programme closes faster than branch and cut; with more points a contour
than this on average it does so beyond, since the linear programme enters and leaves contours at two points."""


def _suits_edges(instance: Instance) -> bool:
    """Whether branch and cut is the better method for one head, contours in any order and symmetric lengths."""
    count = len(instance.contours)
    return count > MOST_CONTOURS or (count > FEW_CONTOURS and instance.node_count <= FEW_POINTS * count)


def choose(instance: Instance, rules: Rules) -> Choice:
    """Return the most special exact method that applies, and why."""
    if rules.free_entries:
        return Choice("regions", "contours that are entered anywhere in their regions")
    if rules.links:
        return Choice("links", "contours may be joined by links")
    if rules.speaks_of_heat:
        return Choice("heat", "temperatures are asked for")
    return _for_one_head(instance, rules) if len(instance.heads) == 1 else _for_more_heads(instance, rules)


def _for_one_head(instance: Instance, rules: Rules) -> Choice:
    ordered = bool(instance.precedence) or bool(rules.process)
    symmetric = _is_symmetric(instance)
    if _has_single_entries(instance) and symmetric and not ordered:
        return Choice("tour", "one head and one entry point for each contour, in any order")
    if rules.via_points:
        return Choice("cpsat", "via points among entry points")
    if ordered and symmetric and len(instance.contours) > MOST_CONTOURS:
        return Choice(
            "gtsp", f"one head, more than {MOST_CONTOURS} contours; its bound leaves rules on order out"
        )
    if ordered:
        asked = ", ".join([*(["precedence"] if instance.precedence else []), *rules.process])
        return Choice("contour-dp", f"one head under {asked}")
    if not symmetric:
        return Choice("contour-dp", "one head, entry points, lengths that differ by direction")
    if _suits_edges(instance):
        return Choice("gtsp", "one head, many contours in any order, few entry points each")
    return Choice("contour-dp", "one head, not too many contours, entry points")


def _for_more_heads(instance: Instance, rules: Rules) -> Choice:
    if len(instance.heads) > 2 or instance.precedence or rules.process:
        return Choice("cpsat", "two heads under precedence or process rules")
    symmetric = _is_symmetric(instance)
    if not _has_single_entries(instance) or not symmetric:
        special = "entry points" if symmetric else "lengths that differ by direction"
        if rules.via_points or any(head.home is None for head in instance.heads):
            return Choice("cpsat", f"two heads, {special}, with via points or without homes")
        return Choice("contour-split", f"two heads, {special}, in any order")
    if rules.non_overlap is None:
        return Choice("free", "two heads whose ranges may overlap")
    return Choice("split", "two heads whose ranges must not overlap")


def _is_symmetric(instance: Instance) -> bool:
    return instance.matrix is None or bool((instance.matrix == instance.matrix.T).all())


def _has_single_entries(instance: Instance) -> bool:
    return all(len(contour.entry_points) == 1 for contour in instance.contours)


def resolve(method: str, instance: Instance, rules: Rules) -> str:
    """Return the name of an exact method; ``auto`` takes the one of ``choose``."""
    if method != "auto" and method not in METHODS:
        raise ValueError(f"method: expected auto or one of {', '.join(METHODS)}, got {method!r}")
    name = choose(instance, rules).method if method == "auto" else method
    if rules.free_entries and name not in FREE_ENTRIES:
        raise ValueError(
            f"method {name}: its bound holds for given entry points, not for free entries; "
            f"take {' or '.join(FREE_ENTRIES)}"
        )
    if rules.links and name not in LINKS:
        raise ValueError(
            f"method {name}: pierces each contour, its bound does not hold with links; "
            f"take {' or '.join(LINKS)}"
        )
    if rules.speaks_of_heat and name not in HEAT:
        raise ValueError(f"method {name}: does not know temperatures; take {' or '.join(HEAT)}")
    return name


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
    begun = perf_counter()
    options = {"certify": certify, "watch": watch}
    result = METHODS[resolve(method, instance, rules)](
        instance, rules, time_limit=time_limit, start=start, **options
    )
    if method != "auto" or result.method != "split" or result.reason or _is_closed(result):
        return result
    if any(head.home is None for head in instance.heads):
        return result
    # What the threshold search leaves open, because longer tours would pay, the general model closes.
    left = None if time_limit is None else max(0.0, time_limit - (perf_counter() - begun))
    other = METHODS["free"](instance, rules, time_limit=left, start=result.plan, **options)
    better = other if _is_closed(other) or (other.lower_bound or 0.0) > (result.lower_bound or 0.0) else result
    return replace(better, seconds=perf_counter() - begun)


def _is_closed(result: Result) -> bool:
    return result.status in (Status.OPTIMAL, Status.INFEASIBLE)
