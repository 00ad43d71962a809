"""The method ``links``: the cheapest plan with links, for given entry points, proved.

Precedence is left out of the model: it only forbids plans, so the bound holds with it. Where the cheapest
plan breaks it, a plan to start from stands in.
"""

import time
from dataclasses import replace

import numpy as np

from cutgap.formulations.branch_and_cut.engine import BranchAndCut
from cutgap.formulations.branch_and_cut.tour import TOLERANCE
from cutgap.formulations.certify import proved_bound, proves
from cutgap.formulations.links.graph import LinkGraph, Pair
from cutgap.formulations.links.model import LinkModel
from cutgap.formulations.links.plans import cost, first_plans, passes_of, plan_of
from cutgap.formulations.links.proof import bound_certificate, empty_certificate, infeasibility_certificate
from cutgap.formulations.scope import require_symmetric
from cutgap.instances import Instance, Plan, Result, Rules, Status, check, conclude
from cutgap.instances.check import require_coordinates
from cutgap.instances.links.strokes import groups
from cutgap.instances.plan import Link
from cutgap.instances.progress import Progress, Watch, nobody


def solve_links(
    instance: Instance,
    rules: Rules,
    *,
    time_limit: float | None = None,
    start: Plan | None = None,
    certify: bool = False,
    watch: Watch = nobody,
) -> Result:
    """Solve an instance under rules with links; the options are those of ``solve``.

    Raises
    ------
    ValueError
        When the rules allow no links, or the instance does not suit them (``require_links``).
    """
    begun = time.perf_counter()
    if not rules.links:
        raise ValueError(f"instance {instance.name!r}, method links: the rules allow no links")
    require_coordinates(instance, rules)
    require_symmetric(instance, "links")
    timed = rules.objective == "makespan"
    work = float(instance.perimeters.sum()) / instance.machine.v_cut

    def objective(length: float) -> float:
        return length / instance.machine.v_jump + work if timed else length

    def report(state: Progress) -> None:
        value = None if state.value is None else objective(state.value)
        bound = None if state.lower_bound is None else objective(max(0.0, state.lower_bound))
        watch(replace(state, value=value, lower_bound=bound))

    if not instance.contours:
        return _empty(instance, rules, begun, certify)
    graph = LinkGraph(instance, rules)
    tree = graph.tree()
    if rules.pierces is not None and len(instance.contours) - len(tree) > rules.pierces:
        return _infeasible(instance, rules, graph, tree, begun, certify)
    known = list(first_plans(graph, tree))
    if start is not None and not check(instance, rules, start):
        known.append(passes_of(instance, start))
    best = min(known, key=lambda passes: cost(graph, passes))
    outcome = BranchAndCut(
        LinkModel(graph, best),
        incumbent=(cost(graph, best), best),
        tolerance=TOLERANCE,
        deadline=np.inf if time_limit is None else begun + time_limit,
        watch=report,
    ).run()
    result = conclude(
        instance,
        rules,
        _allowed(instance, rules, plan_of(instance, outcome.solution or {}), start),
        method="links",
        seconds=time.perf_counter() - begun,
        lower_bound=objective(max(0.0, outcome.lower_bound)),
        reason=None if outcome.complete else "stopped early",
    )
    if not certify:
        return result
    plan = None if result.violations or instance.precedence else result.plan
    certificate = bound_certificate(instance, rules, graph, outcome, plan)
    return _as_proved(replace(result, certificate=certificate), instance)


def _as_proved(result: Result, instance: Instance) -> Result:
    """Return a result whose bound is no more than its certificate proves, but for rounding.

    The checker counts links that only graze a part as clear, so a proof may fall short of the search.
    """
    if result.certificate is None or result.lower_bound is None:
        return result
    proved = proved_bound(result.certificate, instance)
    if proved is None or (result.status is Status.OPTIMAL and proves(proved, result.lower_bound)):
        return result
    reason = (
        result.reason or f"the search closed at {result.lower_bound:.9g}, which its certificate falls short of"
    )
    bound = min(proved, result.lower_bound)
    return replace(result, status=Status.FEASIBLE, lower_bound=bound, reason=reason)


def _empty(instance: Instance, rules: Rules, begun: float, certify: bool) -> Result:
    """Without contours the head stays at home."""
    plan = Plan(((),))
    seconds = time.perf_counter() - begun
    result = conclude(instance, rules, plan, method="links", seconds=seconds, lower_bound=0.0)
    return replace(result, certificate=empty_certificate(instance, rules, plan)) if certify else result


def _infeasible(
    instance: Instance, rules: Rules, graph: LinkGraph, tree: list[Pair], begun: float, certify: bool
) -> Result:
    """Say, and prove, that links join the contours into more groups than there may be pierces."""
    place = graph.place_of.tolist()
    leaders = groups(instance, tuple(Link(place[p], 0, place[q], 0) for p, q in tree))
    parts = [[each for each, leader in enumerate(leaders) if leader == one] for one in sorted(set(leaders))]
    first, *others = (repr(instance.contours[part[0]].id) for part in parts)
    apart = f"no clear link leads from contour {first}, or what is linked to it, to {', '.join(others)}"
    reason = f"{len(parts)} pierces are needed, most {rules.pierces}: {apart:.300}"
    seconds = time.perf_counter() - begun
    result = conclude(instance, rules, None, method="links", seconds=seconds, infeasible=True, reason=reason)
    return (
        replace(result, certificate=infeasibility_certificate(instance, rules, graph, parts))
        if certify
        else result
    )


def _allowed(instance: Instance, rules: Rules, plan: Plan, start: Plan | None) -> Plan:
    """Return the plan, or ``start`` where precedence allows that alone."""
    if not instance.precedence or start is None or not check(instance, rules, plan):
        return plan
    return plan if check(instance, rules, start) else start
