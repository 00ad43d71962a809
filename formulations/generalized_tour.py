"""One head and contours with any number of entry points: the best order and the best points, proved.

With one head the makespan is its travel over v_jump plus a constant and there is no imbalance, so all
objectives are the shortest tour's. The home is one more contour. See ``branch_and_cut.generalized_tour``.

Precedence and process rules are left out of the model: they only forbid plans, or add to their value, so its
bound holds with them. A plan of the entry search stands in where the shortest tour breaks or pays for them.
"""

import time
from dataclasses import replace
from typing import Any

import numpy as np

from cutgap.formulations.branch_and_cut.engine import Outcome
from cutgap.formulations.branch_and_cut.generalized_cuts import GeneralizedCut
from cutgap.formulations.branch_and_cut.generalized_search import shortest_generalized_tour
from cutgap.formulations.branch_and_cut.model import Fixing
from cutgap.formulations.certify import SCALE, TOUR_MULTIPLIER_SCALE, Family, Rows, certificate_of, flat_tree
from cutgap.formulations.scope import require_symmetric
from cutgap.instances import Instance, Plan, Result, Rules, Visit, check, conclude
from cutgap.instances.arrays import Ints
from cutgap.instances.check import require_coordinates
from cutgap.instances.entry_tours import entry_task, search_entries
from cutgap.instances.progress import Progress, Watch, nobody

LARGEST_STEPS = 2.0**30
"""Whole lengths above this, in mm, do not count as whole: sums of them may lose their last digits."""

SEARCH_ROUNDS = 100
"""Rounds per contour of the search for a plan where the shortest tour breaks rules."""

ROUNDING = 1e-4
"""Share of a step by which a bound may be too high."""


def solve_generalized_tour(
    instance: Instance,
    rules: Rules,
    *,
    time_limit: float | None = None,
    start: Plan | None = None,
    certify: bool = False,
    watch: Watch = nobody,
) -> Result:
    """Solve an instance with one head; the options are those of ``solve``.

    Raises
    ------
    ValueError
        When there are several heads, via points from a home or asymmetric lengths.
    """
    begun = time.perf_counter()
    _require(instance, rules)
    first, speed = _first_nodes(instance), instance.machine.v_jump
    service = float(instance.service_times.sum())

    def objective(length: float) -> float:
        return length / speed + service if rules.objective == "makespan" else length

    def report(state: Progress) -> None:
        seen = state.seen_as(lambda length: objective(max(0.0, length)))
        watch(_without_plan(seen) if instance.precedence or rules.process else seen)

    outcome = Outcome(0.0, 0.0, np.arange(len(first) - 1), True, 0)  # at most one place to be
    if len(first) > 2:
        known = None if start is None or check(instance, rules, start) else _nodes(instance, start)
        step = _step(instance)
        outcome = shortest_generalized_tour(
            instance.rapids,
            first,
            start=known,
            step=step,
            deadline=np.inf if time_limit is None else begun + time_limit,
            watch=report,
        )
        outcome = replace(outcome, lower_bound=_rounded_up(max(0.0, outcome.lower_bound), step))
    result = conclude(
        instance,
        rules,
        _allowed(instance, rules, _plan(instance, np.asarray(outcome.solution)), start),
        method="gtsp",
        seconds=time.perf_counter() - begun,
        lower_bound=objective(outcome.lower_bound),
        reason=None if outcome.complete else "stopped early",
    )
    return replace(result, certificate=_certificate(instance, rules, outcome, result)) if certify else result


def _without_plan(progress: Progress) -> Progress:
    """Return the event without the tour, which rules on order may forbid."""
    make = progress.scene
    scene = None if make is None else lambda: replace(make(), best=None)
    return replace(progress, value=None, scene=scene)


def _require(instance: Instance, rules: Rules) -> None:
    name = f"instance {instance.name!r}, method gtsp"
    if len(instance.heads) != 1:
        raise ValueError(f"{name}: needs one head, got {len(instance.heads)}")
    require_coordinates(instance, rules)
    require_symmetric(instance, "gtsp")
    if rules.via_points and instance.home_node(0) is not None:
        raise ValueError(f"{name}: does not take via points of a head with a home")


def _allowed(instance: Instance, rules: Rules, plan: Plan, start: Plan | None) -> Plan:
    """Return the plan; under rules on order the best of it, of ``start`` and of a quick search's."""
    if not instance.precedence and not rules.process:
        return plan
    rounds = SEARCH_ROUNDS * len(instance.contours)
    found = search_entries(entry_task(instance, rules), rounds=rounds, rng=np.random.default_rng(0))
    results = [
        conclude(instance, rules, each, method="gtsp", seconds=0.0)
        for each in (plan, Plan((found.visits,)), start)
        if each is not None
    ]
    return min(results, key=lambda result: (len(result.violations), result.value)).plan or plan


def _first_nodes(instance: Instance) -> Ints:
    """Return the first node of each contour, the home as the last one, then the number of nodes."""
    home = instance.home_node(0)
    return instance.first_node if home is None else np.append(instance.first_node, home + 1)


def _nodes(instance: Instance, plan: Plan) -> Ints:
    home = instance.home_node(0)
    nodes = [instance.node(*visit[:2]) for visit in plan.tours[0]]
    return np.array(nodes if home is None else [home, *nodes], dtype=np.int64)


def _plan(instance: Instance, nodes: Ints) -> Plan:
    """Return the plan of a tour, from the home on, or else from a leftmost point."""
    if not instance.contours:
        return Plan(((),))
    home = instance.home_node(0)
    turn = np.argmin(instance.points[nodes, 0] if home is None else nodes != home)
    stops = [node for node in np.roll(nodes, -turn).tolist() if node != home]
    contours = np.searchsorted(instance.first_node, stops, side="right") - 1
    pairs = zip(contours.tolist(), (stops - instance.first_node[contours]).tolist(), strict=True)
    return Plan((tuple(Visit(*pair) for pair in pairs),))


def _step(instance: Instance) -> float:
    """Return the greatest common divisor of whole lengths in a matrix; 0 when they are no whole numbers."""
    first = _first_nodes(instance)
    contour_of = np.repeat(np.arange(len(first) - 1), np.diff(first))
    lengths = instance.rapids[contour_of[:, None] != contour_of]
    if instance.matrix is None or (lengths != np.floor(lengths)).any() or (lengths > LARGEST_STEPS).any():
        return 0.0
    return float(np.gcd.reduce(lengths.astype(np.int64)))


def _rounded_up(bound: float, step: float) -> float:
    """Return the bound as the multiple of ``step`` that tours must reach."""
    return bound if step == 0.0 else float(np.ceil(bound / step - ROUNDING)) * step


def _certificate(instance: Instance, rules: Rules, outcome: Outcome, result: Result) -> dict[str, Any] | None:
    step = _step(instance)

    def claim(margin: float) -> tuple[int | None, dict[str, Any]]:
        proof: dict[str, Any] = {"kind": "gtsp", "length": 0}
        if outcome.root is not None:
            length = outcome.lower_bound if step else max(0.0, outcome.lower_bound - margin)
            proof["length"] = int(length) * SCALE if step else int(length * SCALE)
            proof |= _tree(outcome, instance.node_count, length)
        work = 0.0
        if rules.objective == "makespan":
            work = float(instance.service_times.sum()) * instance.machine.v_jump - margin
        return proof["length"] + max(0, int(work * SCALE)), proof

    plan = None if result.violations else result.plan
    return certificate_of(instance, rules, plan, TOUR_MULTIPLIER_SCALE, claim)


def _tree(outcome: Outcome, nodes: int, target: float) -> dict[str, Any]:
    """Return ``rows`` and ``nodes`` of the proof."""
    assert outcome.root is not None
    rows = Rows(_family)

    def variable(fixing: Fixing) -> list[Any]:
        if fixing.variable < nodes:
            return ["y", fixing.variable]
        return ["x", *divmod(fixing.variable - nodes, nodes)]

    tree = flat_tree(outcome.root, outcome.fixes, rows, variable, target)
    return {"rows": rows.names, "nodes": tree}


def _family(name: Any) -> Family:
    """Name the rows of the model."""
    factor = float(SCALE * TOUR_MULTIPLIER_SCALE)
    if not isinstance(name, GeneralizedCut):
        return list(name), factor
    sets = [sorted(members) for members in name.sets]
    if len(sets) == 1:
        return ["border", sets[0], *name.pairs[0]], factor
    return ["comb", sets, [list(pair) for pair in name.pairs]], factor
