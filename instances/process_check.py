"""Whether a plan keeps the process rules (see ``process``): one violation per broken rule and rapid or part."""

from itertools import pairwise

from cutgap.instances.instance import Instance
from cutgap.instances.plan import Plan
from cutgap.instances.process import adjacent_parts, contours_in, crossings, part_of
from cutgap.instances.rules import Rules
from cutgap.instances.simulate import start_times
from cutgap.instances.violation import Violation


def process_violations(instance: Instance, rules: Rules, plan: Plan) -> list[Violation]:
    """Return every violation of the process rules."""
    found: list[Violation] = []
    if rules.parts_in_one_go:
        found += parts_in_one_go(instance, plan)
    if rules.neighbours_only:
        found += neighbours_only(instance, plan)
    if rules.clear_rapids:
        found += clear_rapids(instance, plan)
    return found


def parts_in_one_go(instance: Instance, plan: Plan) -> list[Violation]:
    """A head cuts the contours of a part one after the other."""
    parts, found = part_of(instance), []
    for head, tour in zip(instance.heads, plan.tours, strict=True):
        order = [int(parts[visit.contour]) for visit in tour]
        begun = [part for turn, part in enumerate(order) if turn == 0 or order[turn - 1] != part]
        for part in sorted({part for part in begun if begun.count(part) > 1}):
            place = f"head {head.id!r} begins {_part_name(instance, part)} {begun.count(part)} times"
            found.append(Violation("parts in one go", place, begun.count(part) - 1, "times"))
    return found


def neighbours_only(instance: Instance, plan: Plan) -> list[Violation]:
    """A head goes from a part to one of its neighbours."""
    parts, adjacent, found = part_of(instance), adjacent_parts(instance), []
    for tour in plan.tours:
        for before, after in pairwise(int(parts[visit.contour]) for visit in tour):
            if before != after and not adjacent[before, after]:
                names = f"{_part_name(instance, before)} to {_part_name(instance, after)}"
                found.append(Violation("neighbours only", names, 1, "rapids"))
    return found


def clear_rapids(instance: Instance, plan: Plan) -> list[Violation]:
    """No rapid between contours crosses a contour that is cut when the rapid begins, by whichever head."""
    starts, turns = start_times(instance, plan), _turns(plan)
    table, found = crossings(instance), []
    for head, tour in enumerate(plan.tours):
        for turn, (one, other) in enumerate(pairwise(tour)):
            begins = starts[one.contour] + float(instance.service_times[one.contour])
            crossed = contours_in(table[instance.node(*one[:2]), instance.node(*other[:2])])
            cut = [
                instance.contours[k].id
                for k in crossed
                if k in turns and _is_cut(instance, k, head, turn, begins, starts, turns)
            ]
            if cut:
                names = [instance.contours[visit.contour].id for visit in (one, other)]
                place = f"{names[0]!r} to {names[1]!r} crosses {', '.join(map(repr, cut)):.120}"
                found.append(Violation("clear rapids", place, len(cut), "contours"))
    return found


def _turns(plan: Plan) -> dict[int, tuple[int, int]]:
    """Return head and place in its tour of each contour."""
    return {
        visit.contour: (head, turn) for head, tour in enumerate(plan.tours) for turn, visit in enumerate(tour)
    }


def _is_cut(
    instance: Instance,
    contour: int,
    head: int,
    turn: int,
    time: float,
    starts: dict[int, float],
    turns: dict[int, tuple[int, int]],
) -> bool:
    """Whether a contour is cut when a head leaves visit ``turn`` at ``time``; on one head the order decides."""
    its_head, its_turn = turns[contour]
    if its_head == head:
        return its_turn <= turn
    return starts[contour] + float(instance.service_times[contour]) <= time


def _part_name(instance: Instance, part: int) -> str:
    first = instance.contours[part_of(instance).tolist().index(part)]
    return f"contour {first.id!r}" if first.part is None else f"part {first.part!r}"
