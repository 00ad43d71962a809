"""The method ``links``: the cheapest plan with links, for given entry points, proved.

Precedence is left out of the model: it only forbids plans, so the bound holds with it. Where the cheapest
plan breaks it, a plan to start from stands in.
"""

import time
from dataclasses import replace

import numpy as np

from cutgap.formulations.branch_and_cut.engine import BranchAndCut, Outcome
from cutgap.formulations.branch_and_cut.tour import TOLERANCE
from cutgap.formulations.links.graph import LinkGraph
from cutgap.formulations.links.model import LinkModel
from cutgap.formulations.links.plans import cost, first_plans, passes_of, plan_of
from cutgap.formulations.scope import require_symmetric
from cutgap.instances import Instance, Plan, Result, Rules, check, conclude
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
        outcome = Outcome(0.0, 0.0, {}, True, 0)
    else:
        graph = LinkGraph(instance, rules)
        tree = graph.tree()
        if rules.pierces is not None and len(instance.contours) - len(tree) > rules.pierces:
            reason = _too_few_pierces(instance, graph, tree, rules.pierces)
            seconds = time.perf_counter() - begun
            return conclude(
                instance, rules, None, method="links", seconds=seconds, infeasible=True, reason=reason
            )
        known = list(first_plans(graph, tree))
        if start is not None and not check(instance, rules, start):
            known.append(passes_of(instance, start))
        best = min(known, key=lambda passes: cost(graph, passes))
        search = BranchAndCut(
            LinkModel(graph, best),
            incumbent=(cost(graph, best), best),
            tolerance=TOLERANCE,
            deadline=np.inf if time_limit is None else begun + time_limit,
            watch=report,
        )
        outcome = search.run()
    plan = plan_of(instance, outcome.solution or {})
    return conclude(
        instance,
        rules,
        _allowed(instance, rules, plan, start),
        method="links",
        seconds=time.perf_counter() - begun,
        lower_bound=objective(max(0.0, outcome.lower_bound)),
        reason=None if outcome.complete else "stopped early",
    )


def _allowed(instance: Instance, rules: Rules, plan: Plan, start: Plan | None) -> Plan:
    """Return the plan, or ``start`` where precedence allows that alone."""
    if not instance.precedence or start is None or not check(instance, rules, plan):
        return plan
    return plan if check(instance, rules, start) else start


def _too_few_pierces(instance: Instance, graph: LinkGraph, tree: list[tuple[int, int]], most: int) -> str:
    """Say which contours no link reaches."""
    place = graph.place_of
    links = tuple(Link(int(place[p]), 0, int(place[q]), 0) for p, q in tree)
    leaders = groups(instance, links)
    names = [instance.contours[each].id for each in sorted(set(leaders))]
    others = ", ".join(map(repr, names[1:]))
    apart = f"no clear link leads from contour {names[0]!r}, or what is linked to it, to {others}"
    return f"{len(names)} pierces are needed, most {most}: {apart:.300}"
