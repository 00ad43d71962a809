r"""Partition by task balancing, with the genetic algorithm on each side (Wang et al., 2025, section 2.1).

    (3) l_k = l_{k-1} + h_k v_jump / v_cut + t_aux v_jump    work of the first k contours by x  [mm]
    (4) F_k = l_k - l_N / 2                                  initial offset: first k with F_k > 0

The source contradicts itself on the offset k: its text gives the left head P_1 .. P_k, its nine-hole figure
finds k = 5 and gives the left head 1 .. 4. **The text is followed here**: contour k goes to the left head.
The shifts by one that come next make the two readings start one step apart, no more.

Sides are re-planned with the offset one up (the left head has too little work) or one down, until the
imbalance is below 0.5 s or the next offset has been seen: then it changed sign between two neighbours. The
plan with the smallest imbalance seen is the answer. Offsets that the rules forbid (gap too small, a head
without work) are stepped over. The source always fixes the via points; here the rules say whether.

No offset is planned twice. The source prints imbalances of 0.1 to 0.5 s, far below the 5 s by which one contour
changes them: it probably plans the same offset anew until chance balances the heads, and does not say so.
"""

from dataclasses import dataclass, field

import numpy as np

from cutgap.heuristics.genetic import GeneticParameters, genetic_tour
from cutgap.heuristics.sides import (
    Clock,
    SideTour,
    allowed_splits,
    contour_xs,
    plan_of,
    require_two_sides,
    score,
    side_tour,
)
from cutgap.instances import Instance, Plan, Rules
from cutgap.instances.arrays import Ints, finite_number
from cutgap.instances.progress import Progress, Watch, nobody

Sides = tuple[SideTour, SideTour]


@dataclass(frozen=True, slots=True)
class TaskBalancingParameters:
    """The genetic algorithm's parameters, and the imbalance in s that counts as balanced (source: 0.5)."""

    genetic: GeneticParameters = field(default_factory=GeneticParameters)
    balanced_s: float = 0.5

    def __post_init__(self) -> None:
        value = finite_number(self.balanced_s, "task balancing, balanced_s", least=0.0)
        object.__setattr__(self, "balanced_s", value)


def task_balancing(
    instance: Instance,
    rules: Rules,
    *,
    rng: np.random.Generator,
    watch: Watch = nobody,
    time_limit: float | None = None,
    parameters: TaskBalancingParameters | None = None,
) -> Plan:
    """Plan two heads by task balancing; at least one split is planned, whatever the time limit.

    Raises
    ------
    ValueError
        Unless there are two heads, coordinates, one entry point per contour and no precedence.
    """
    require_two_sides(instance, "task-balancing")
    parameters = parameters or TaskBalancingParameters()
    clock = Clock(time_limit)
    order = np.argsort(contour_xs(instance), kind="stable")
    splits = allowed_splits(instance, rules, order)
    offset = initial_offset(instance, order)
    at = min(range(len(splits)), key=lambda i: abs(splits[i] - offset))
    best: Sides | None = None
    seen: set[int] = set()
    try:
        while 0 <= at < len(splits) and at not in seen and not (seen and clock.over):
            seen.add(at)
            sides = plan_split(instance, rules, order, splits[at], rng, parameters.genetic)
            if best is None or imbalance(sides) < imbalance(best):
                best = sides
                watch(Progress(clock.seconds, value=score(instance, rules, best)[1]))
            if imbalance(sides) < parameters.balanced_s:
                break
            at += 1 if sides[0].time_s < sides[1].time_s else -1
    except KeyboardInterrupt:
        if best is None:
            raise
    assert best is not None  # the first offset lies among the splits, of which there is at least one
    return plan_of(best)


def initial_offset(instance: Instance, order: Ints) -> int:
    """Return the first k with F_k > 0, by (3) and (4); 0 without contours."""
    machine = instance.machine
    steps = instance.perimeters[order] * machine.v_jump / machine.v_cut + machine.t_aux * machine.v_jump
    work = np.cumsum(steps)
    if len(work) == 0:
        return 0
    beyond = np.flatnonzero(work - work[-1] / 2 > 0)
    # Without any work (no auxiliary time, no perimeters) no F_k is positive: count contours instead.
    return int(beyond[0]) + 1 if len(beyond) else (len(work) + 1) // 2


def plan_split(
    instance: Instance,
    rules: Rules,
    order: Ints,
    split: int,
    rng: np.random.Generator,
    parameters: GeneticParameters,
) -> Sides:
    """Plan both sides of a split by the genetic algorithm."""
    left, right = (
        side_tour(
            instance,
            head,
            genetic_tour(instance, rules, head, [int(c) for c in side], rng=rng, parameters=parameters),
        )
        for head, side in enumerate((order[:split], order[split:]))
    )
    return left, right


def imbalance(sides: Sides) -> float:
    """Return |T_1 - T_2|, s."""
    return abs(sides[0].time_s - sides[1].time_s)
