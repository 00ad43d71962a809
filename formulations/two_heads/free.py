r"""Two heads with the partition free: branch and cut on one model (see ``branch_and_cut.two_heads``).

It takes every rule of ``Rules``: overlap or a least gap, a balance limit, via points, heads that may rest, and
any weight. Where the threshold search (``split``) applies, that is much faster.
"""

import time
from dataclasses import replace
from typing import Any

import numpy as np

from cutgap.formulations.branch_and_cut.engine import BranchAndCut, Outcome
from cutgap.formulations.branch_and_cut.model import Fixing
from cutgap.formulations.branch_and_cut.two_heads import TwoHeadsModel
from cutgap.formulations.certify import SCALE, Certificate, Rows, certificate_of, flat_tree, two_heads_family
from cutgap.formulations.scope import require_two_heads
from cutgap.formulations.sides import Sides
from cutgap.formulations.two_heads.divisions import Divisions
from cutgap.instances import Instance, Plan, Result, Rules, Status, conclude
from cutgap.instances.arrays import Floats
from cutgap.instances.progress import Progress, Watch, nobody
from cutgap.instances.result import OPTIMALITY_TOLERANCE

MULTIPLIER_SCALE = 2**40
"""Multipliers of times are numbers up to 1, so they need a fine scale."""


def solve_free(
    instance: Instance,
    rules: Rules,
    *,
    time_limit: float | None = None,
    start: Plan | None = None,
    certify: bool = False,
    watch: Watch = nobody,
) -> Result:
    """Solve the two-head problem under any rules by branch and cut.

    Parameters
    ----------
    time_limit
        Seconds after which the best plan and the bound proved so far are returned; Ctrl-C does the same.
    start
        A plan to start from; one that breaks rules is ignored.
    certify
        Whether to add a verified certificate of the bound.

    Raises
    ------
    ValueError
        When the instance is outside of this method: not two heads with homes, several entry points,
        precedence, asymmetric lengths.
    """
    started = time.perf_counter()
    require_two_heads(instance, rules, "free")
    homeless = next((head.id for head in instance.heads if head.home is None), None)
    if homeless is not None:
        raise ValueError(f"instance {instance.name!r}, method free: head {homeless!r} needs a home")
    if not instance.contours:
        result = conclude(instance, rules, Plan(((), ())), method="free", seconds=0.0, lower_bound=0.0)
        return replace(result, certificate=_trivial(instance, rules)) if certify else result
    via = rules.via_points
    sides = (
        Sides(instance, 0, via_points=via, inherits=False),
        Sides(instance, 1, via_points=via, inherits=False),
    )
    divisions = Divisions(instance, rules, sides)
    unit = divisions.in_mm(1.0)
    incumbent = _incumbent(instance, rules, divisions, start)

    def report(progress: Progress) -> None:
        watch(progress.seen_as(lambda value: value / unit))

    search = BranchAndCut(
        TwoHeadsModel(instance, rules, divisions.around),
        incumbent=incumbent,
        tolerance=OPTIMALITY_TOLERANCE / 2,
        deadline=np.inf if time_limit is None else started + time_limit,
        watch=report,
    )
    outcome = search.run()
    proved = bool(np.isfinite(outcome.lower_bound))
    result = conclude(
        instance,
        rules,
        outcome.solution,
        method="free",
        seconds=time.perf_counter() - started,
        lower_bound=outcome.lower_bound / unit if proved else None,
        infeasible=outcome.complete and outcome.solution is None and not proved,
        reason=None if outcome.complete else "stopped early",
    )
    return replace(result, certificate=_certificate(instance, rules, outcome, result)) if certify else result


def _certificate(instance: Instance, rules: Rules, outcome: Outcome, result: Result) -> Certificate | None:
    """Return a verified certificate of a search's outcome."""
    infeasible = result.status is Status.INFEASIBLE
    if outcome.root is None or not (infeasible or np.isfinite(outcome.lower_bound)):
        return None
    root, holes = outcome.root, len(instance.contours)
    target = None if infeasible else outcome.lower_bound

    def variable(fixing: Fixing) -> list[Any]:
        if fixing.variable < holes:
            return ["z", fixing.variable]
        if fixing.variable < holes + 2:
            return ["e", fixing.variable - holes]
        return edge_name(fixing.variable - holes - 3, holes)

    def claim(margin: float) -> tuple[int | None, dict[str, Any]]:
        rows = Rows(two_heads_family(instance, rules, MULTIPLIER_SCALE))
        nodes = flat_tree(root, () if infeasible else outcome.fixes, rows, variable, target)
        bound = None if target is None else max(0, int(np.floor((target - margin) * SCALE)))
        return bound, {"kind": "two-heads", "rows": rows.names, "nodes": nodes}

    return certificate_of(instance, rules, result.plan, MULTIPLIER_SCALE, claim)


def _trivial(instance: Instance, rules: Rules) -> Certificate | None:
    """Return the certificate of a part without holes: nothing costs less than 0."""
    proof = {"kind": "two-heads", "rows": [], "nodes": [{"leaf": []}]}
    return certificate_of(instance, rules, Plan(((), ())), MULTIPLIER_SCALE, lambda _: (0, proof))


def edge_name(edge: int, holes: int) -> list[Any]:
    """Return an edge variable's name in a certificate; there a home is node -1."""
    u, v = np.triu_indices(holes + 1, 1)
    head, place = divmod(edge, len(u))
    one, two = int(u[place]), int(v[place])
    return ["x", head, -1, one] if two == holes else ["x", head, one, two]


def _incumbent(
    instance: Instance, rules: Rules, divisions: Divisions, start: Plan | None
) -> tuple[float, Plan] | None:
    """Return the better of the given plan, if allowed, and one that halves the work from left to right."""
    found = []
    if start is not None:
        result = conclude(instance, rules, start, method="free", seconds=0.0)
        if result.value is not None and not result.violations:
            found.append((divisions.in_mm(result.value), start))
    order = np.argsort(instance.points[: len(instance.contours), 0], kind="stable")
    done = np.cumsum(divisions.work[order])
    share: Floats = np.zeros(len(order))
    share[order[: max(1, int(np.searchsorted(done, done[-1] / 2)))]] = 1.0
    planned = divisions.around(share)
    if planned is not None:
        found.append(planned)
    return min(found, key=lambda each: each[0], default=None)
