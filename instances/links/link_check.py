"""Whether a plan's links keep to the rules, and what rules with links ask of an instance."""

from collections import Counter

from cutgap.instances.instance import Instance
from cutgap.instances.links.clearance import blocked, require_shapes
from cutgap.instances.links.strokes import groups, link_ends, odd_nodes, strokes
from cutgap.instances.links.trajectory import walk
from cutgap.instances.plan import Plan
from cutgap.instances.rules import Rules
from cutgap.instances.violation import Violation


def require_links(instance: Instance, rules: Rules) -> None:
    """Raise ``ValueError`` when rules that allow links do not suit the instance or each other."""
    name = f"instance {instance.name!r}"
    if len(instance.heads) != 1 or instance.heads[0].home is None:
        raise ValueError(
            f"{name}: links need one head with a home, got {len(instance.heads)} heads; give its home"
        )
    if rules.objective not in ("travel", "makespan"):
        raise ValueError(f"rules, links: go with the objectives travel and makespan, not {rules.objective}")
    others = [
        *rules.process,
        *(["via points"] if rules.via_points else []),
        *(["free entries"] if rules.free_entries else []),
        *(["temperature cap"] if rules.temperature_cap is not None else []),
    ]
    if others:
        raise ValueError(f"rules, links: do not go with {', '.join(others)}")
    require_shapes(instance)


def link_violations(instance: Instance, rules: Rules, plan: Plan) -> list[Violation]:
    """Return what a plan's links and pierces break."""
    if not rules.links:
        if not plan.links:
            return []
        return [Violation("no links", f"the plan has {len(plan.links)} links", len(plan.links), "links")]
    return [
        *even_nodes(instance, plan),
        *clear_links(instance, plan),
        *each_link_once(instance, plan),
        *few_pierces(rules, plan),
        *link_precedence(instance, plan),
    ]


def even_nodes(instance: Instance, plan: Plan) -> list[Violation]:
    """(1) or (2) of ``strokes`` holds for each stroke."""
    broken = []
    for stroke in (stroke for tour in strokes(instance, plan) for stroke in tour):
        odd = set(odd_nodes(instance, stroke.links)) - {stroke.start, stroke.end}
        if odd:
            place = f"stroke from node {stroke.start}: odd numbers of links meet at {len(odd)} other nodes"
            broken.append(Violation("even nodes", place, len(odd), "nodes"))
    return broken


def clear_links(instance: Instance, plan: Plan) -> list[Violation]:
    """No link leads through material."""
    if not plan.links:
        return []
    starts, ends = zip(*(link_ends(instance, link) for link in plan.links), strict=True)
    names = [(instance.contours[link.contour].id, instance.contours[link.to_contour].id) for link in plan.links]
    return [
        Violation("clear links", f"link from {one!r} to {other!r} leads through a part", 1, "links")
        for (one, other), bad in zip(names, blocked(instance, starts, ends), strict=True)
        if bad
    ]


def each_link_once(instance: Instance, plan: Plan) -> list[Violation]:
    """No two links join the same two nodes: one that is passed twice says so."""
    counts = Counter(tuple(sorted(link_ends(instance, link))) for link in plan.links)
    return [
        Violation("each link once", f"nodes {a} and {b} are linked {count} times", count - 1, "links")
        for (a, b), count in counts.items()
        if count > 1
    ]


def few_pierces(rules: Rules, plan: Plan) -> list[Violation]:
    """There are no more pierces than asked for."""
    pierces = sum(map(len, plan.tours))
    if rules.pierces is None or pierces <= rules.pierces:
        return []
    place = f"{pierces} pierces, most {rules.pierces}"
    return [Violation("pierces", place, pierces - rules.pierces, "pierces")]


def link_precedence(instance: Instance, plan: Plan) -> list[Violation]:
    """The first contour of each pair is cut out before the second is.

    That is, its last piece is cut earlier; without links this is the order of the visits.
    """
    if not instance.precedence or even_nodes(instance, plan):
        return []
    done: dict[int, int] = {}
    step = 0
    for stroke in (stroke for tour in strokes(instance, plan) for stroke in tour):
        for arc in walk(instance, stroke):
            step += 1
            if arc.contour is not None:
                done[arc.contour] = step
    return [
        Violation("precedence", f"{instance.contours[a].id!r} before {instance.contours[b].id!r}", 1, "pairs")
        for a, b in instance.precedence
        if a in done and b in done and done[a] > done[b]
    ]


def cut_counts(instance: Instance, plan: Plan) -> Counter[int]:
    """Return how often each contour is cut: once for each visit to its group."""
    leaders = groups(instance, plan.links)
    visits = Counter(leaders[visit.contour] for tour in plan.tours for visit in tour)
    return Counter({contour: visits[leader] for contour, leader in enumerate(leaders)})
