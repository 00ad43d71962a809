"""Whether a plan is allowed: one violation per broken constraint, from instance, rules and plan alone."""

from cutgap.instances.evaluate import Evaluation, evaluate
from cutgap.instances.free_entries import entries_in_regions, pinned
from cutgap.instances.heat import require_heat
from cutgap.instances.instance import Instance
from cutgap.instances.links.link_check import cut_counts, link_violations, require_links
from cutgap.instances.plan import Plan
from cutgap.instances.process import require_entries_on_curves, require_geometry
from cutgap.instances.process_check import process_violations
from cutgap.instances.rules import Rules
from cutgap.instances.simulate import start_times
from cutgap.instances.violation import Violation

TOLERANCE = 1e-9
"""Relative slack for limits on computed figures (a balance limit in s)."""


def check(instance: Instance, rules: Rules, plan: Plan) -> list[Violation]:
    """Return every violation of the rules; an empty list means that the plan is allowed.

    Raises
    ------
    ValueError
        When the plan names what does not exist, or the rules need coordinates that are not there.
    """
    require_coordinates(instance, rules)
    evaluation = evaluate(instance, plan)
    entries = entries_in_regions(instance, rules, plan)
    instance, plan = pinned(instance, plan)
    return [
        *each_contour_once(instance, plan),
        *non_overlap(rules, evaluation),
        *balance(rules, evaluation),
        *via_points(instance, rules, plan),
        *no_empty_heads(instance, rules, plan),
        *precedence(instance, plan),
        *entries,
        *temperature(instance, rules, evaluation),
        *process_violations(instance, rules, plan),
        *link_violations(instance, rules, plan),
    ]


def require_coordinates(instance: Instance, rules: Rules) -> None:
    """Raise ``ValueError`` when the rules speak of coordinates or curves that are not there."""
    if rules.neighbours_only:
        require_geometry(instance, "neighbours only")
    if rules.clear_rapids:
        require_geometry(instance, "clear rapids")
        require_entries_on_curves(instance, "clear rapids")
    if rules.free_entries and instance.matrix is not None:
        raise ValueError(f"instance {instance.name!r} has a matrix, which holds no lengths to free entries")
    if rules.speaks_of_heat:
        require_heat(instance)
        require_entries_on_curves(instance, "temperature")
    if rules.links:
        require_links(instance, rules)
    if instance.located:
        return
    if rules.backward_price > 0:
        raise ValueError(f"instance {instance.name!r} has a matrix but no coordinates: backward price needs x")
    if rules.via_points or (rules.non_overlap is not None and len(instance.heads) > 1):
        raise ValueError(
            f"instance {instance.name!r} has a matrix but no coordinates: "
            "via points and non-overlap need them; allow overlap and drop via points"
        )


def each_contour_once(instance: Instance, plan: Plan) -> list[Violation]:
    """Each contour is cut once, by one head."""
    counts = cut_counts(instance, plan)
    return [
        Violation(
            "each contour once",
            f"contour {contour.id!r} is cut {counts[index]} times",
            counts[index] - 1,
            "times",
        )
        for index, contour in enumerate(instance.contours)
        if counts[index] != 1
    ]


def non_overlap(rules: Rules, evaluation: Evaluation) -> list[Violation]:
    """The partition gap is at least the asked one; coordinates are exact, so there is no slack."""
    gap = evaluation.partition_gap_mm
    if rules.non_overlap is None or gap is None or gap >= rules.non_overlap:
        return []
    place = f"partition gap {gap:g} mm, least {rules.non_overlap:g} mm"
    return [Violation("non-overlap", place, rules.non_overlap - gap, "mm")]


def balance(rules: Rules, evaluation: Evaluation) -> list[Violation]:
    """The imbalance is within its limit."""
    if rules.balance is None:
        return []
    excess = evaluation.imbalance_s - rules.balance
    if excess <= TOLERANCE * max(1.0, evaluation.makespan_s):
        return []
    place = f"imbalance {evaluation.imbalance_s:g} s, most {rules.balance:g} s"
    return [Violation("balance", place, excess, "s")]


def temperature(instance: Instance, rules: Rules, evaluation: Evaluation) -> list[Violation]:
    """No start point is warmer than the cap, up to a slack on the rise above ambient."""
    peak, material = evaluation.peak_temperature_c, instance.material
    if rules.temperature_cap is None or peak is None or material is None:
        return []
    excess = peak - rules.temperature_cap
    # By the cap's own rise: an infinite peak would allow itself an infinite slack.
    if excess <= TOLERANCE * max(1.0, abs(rules.temperature_cap - material.ambient_c)):
        return []
    place = f"peak {peak:g} deg C, most {rules.temperature_cap:g} deg C"
    return [Violation("temperature cap", place, excess, "K")]


def via_points(instance: Instance, rules: Rules, plan: Plan) -> list[Violation]:
    """Each head cuts a leftmost contour of its range first."""
    if not rules.via_points:
        return []
    broken = []
    for head, tour in zip(instance.heads, plan.tours, strict=True):
        xs = [float(instance.points[instance.node(*visit[:2]), 0]) for visit in tour]
        if xs and xs[0] > min(xs):
            first = instance.contours[tour[0].contour].id
            place = f"head {head.id!r} starts with contour {first!r}, not the leftmost"
            broken.append(Violation("via points", place, xs[0] - min(xs), "mm"))
    return broken


def no_empty_heads(instance: Instance, rules: Rules, plan: Plan) -> list[Violation]:
    """Each head has work, unless the rules or too few contours let it rest."""
    if rules.empty_heads or len(instance.contours) < len(instance.heads):
        return []
    return [
        Violation("no empty heads", f"head {head.id!r} has no work", 1, "contours")
        for head, tour in zip(instance.heads, plan.tours, strict=True)
        if not tour
    ]


def precedence(instance: Instance, plan: Plan) -> list[Violation]:
    """The first contour of each pair is done when the second starts, on whichever heads.

    On one head the order decides: contours that take no time at one place all start at once.
    """
    if not instance.precedence or plan.links:
        return []  # with links the end of a contour decides (``link_check``)
    starts = start_times(instance, plan)
    turns = {visit.contour: (head, i) for head, tour in enumerate(plan.tours) for i, visit in enumerate(tour)}
    broken = []
    for before, after in instance.precedence:
        if before not in starts or after not in starts:
            continue
        late = starts[before] + float(instance.service_times[before]) - starts[after]
        (head, turn), (other_head, other_turn) = turns[before], turns[after]
        broken_by_time = late > TOLERANCE * max(1.0, starts[before])
        if turn > other_turn if head == other_head else broken_by_time:
            names = f"{instance.contours[before].id!r} before {instance.contours[after].id!r}"
            broken.append(Violation("precedence", names, late, "s"))
    return broken
