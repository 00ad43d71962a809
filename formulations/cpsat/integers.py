"""The data of the CP-SAT model: whole numbers, rounded down, at a scale that suits the instance's size."""

import math
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

import numpy as np

from cutgap.instances import Instance, Rules
from cutgap.instances.arrays import Floats
from cutgap.instances.check import TOLERANCE
from cutgap.instances.process import adjacent_parts, contours_in, crossings, part_of, rapid_costs

LARGEST = 10**12
"""The scale is the largest power of ten at which the sum of all work and long rapids stays below this."""

DENOMINATOR = 1000
"""Largest denominator of p / q."""

Tours = tuple[tuple[int, ...], ...]
"""Per head its entry points in order."""


@dataclass(frozen=True, slots=True)
class Integers:
    """The model's data, in its notation; lengths are in mm / scale.

    Attributes
    ----------
    contour_of
        Contour of each entry point.
    rapids, costs
        l and c between entry points.
    out, back
        Per head the lengths from its home to each entry point, and back; ``None`` without a home.
    barred
        Rapids between entry points that the rules forbid.
    crossed
        Contours other than those at its ends that a rapid crosses, where clear rapids are asked for.
    parts
        Part of each contour, where parts in one go are asked for.
    most
        No tour takes longer than this.
    tolerance
        What ``check`` forgives a limit on times, at most.
    """

    scale: float
    contour_of: list[int]
    rapids: list[list[int]]
    costs: list[list[int]]
    out: tuple[list[int] | None, ...]
    back: tuple[list[int] | None, ...]
    work: list[int]
    xs: list[float]
    may_rest: bool
    gap: float | None
    via_points: bool
    makespan: bool
    price: tuple[int, int]
    slack: int
    balance: float | None
    precedence: tuple[tuple[int, int], ...]
    parts: list[int] | None
    barred: frozenset[tuple[int, int]]
    crossed: dict[tuple[int, int], list[int]]
    backward: bool
    most: int
    tolerance: int

    @property
    def heads(self) -> int:
        """Number of heads."""
        return len(self.out)

    @property
    def ordered(self) -> bool:
        """Whether rules ask which contour of a head comes first."""
        return bool(self.precedence or self.crossed)

    @property
    def start_matters(self) -> bool:
        """Whether it matters where a closed tour starts."""
        any_process = self.ordered or self.barred or self.backward or self.parts is not None
        return bool(any_process or self.via_points)

    @property
    def may_break_by_rounding(self) -> bool:
        """Whether a plan of the model may break a rule by a hair, and ``tight`` can prevent it."""
        if self.heads == 1:
            return False
        limit = self.limit(tight=True)
        return limit >= 0 if limit is not None else self.ordered

    def limit(self, *, tight: bool) -> int | None:
        """Return the limit of (balance), or what is left of it when no plan may break the true one."""
        if self.balance is None:
            return None
        if tight:
            return math.floor(self.balance) - self.slack
        return math.ceil(self.balance) + self.tolerance + self.slack


def integers_of(instance: Instance, rules: Rules) -> Integers:
    """Round an instance's data down at a scale that suits its size."""
    places, speed = int(instance.first_node[-1]), instance.machine.v_jump
    homes = [instance.home_node(head) for head in range(len(instance.heads))]
    work, costs = instance.service_times * speed, rapid_costs(instance, rules)
    most = float(work.sum()) + _long_rapids(instance, costs)
    scale = 10.0 ** math.floor(math.log10(LARGEST / most)) if most > 0 else 1.0
    rapids = instance.rapids * scale
    lost = float((rapids % 1.0).max(initial=0.0))
    barred, crossed = _process_arcs(instance, rules)
    return Integers(
        scale=scale,
        contour_of=np.repeat(np.arange(len(instance.contours)), np.diff(instance.first_node)).tolist(),
        rapids=_floors(rapids[:places, :places]),
        costs=_floors(costs[:places, :places] * scale),
        out=tuple(None if home is None else _floors(rapids[home, :places]) for home in homes),
        back=tuple(None if home is None else _floors(rapids[:places, home]) for home in homes),
        work=_floors(work * scale),
        xs=instance.points[:places, 0].tolist(),
        may_rest=rules.empty_heads or len(instance.contours) < len(instance.heads),
        gap=rules.non_overlap,
        via_points=rules.via_points,
        makespan=rules.objective == "makespan",
        price=_price(Fraction(rules.weight) / Fraction(speed)),
        slack=math.ceil(float((scale * work % 1.0).sum()) + (len(work) + len(homes)) * lost),
        balance=None if rules.balance is None else rules.balance * speed * scale,
        precedence=instance.precedence,
        parts=part_of(instance).tolist() if rules.parts_in_one_go else None,
        barred=barred,
        crossed=crossed,
        backward=rules.backward_price > 0,
        most=math.ceil(most * scale),
        tolerance=math.ceil(TOLERANCE * scale * max(speed, most)),
    )


def _long_rapids(instance: Instance, costs: Floats) -> float:
    """Return what the rapids of a plan cost at most, mm: the longest from each contour and each home."""
    longest = costs.max(axis=1)
    first = instance.first_node
    from_contours = sum(float(longest[a:b].max()) for a, b in pairwise(first))
    return from_contours + float(longest[first[-1] :].sum())


def _process_arcs(
    instance: Instance, rules: Rules
) -> tuple[frozenset[tuple[int, int]], dict[tuple[int, int], list[int]]]:
    """Return the rapids that no plan may use, and what the others cross, as ``Integers`` says."""
    barred: set[tuple[int, int]] = set()
    crossed: dict[tuple[int, int], list[int]] = {}
    parts = part_of(instance)
    adjacent = adjacent_parts(instance) if rules.neighbours_only else None
    table = crossings(instance) if rules.clear_rapids else None
    contours = np.repeat(np.arange(len(instance.contours)), np.diff(instance.first_node)).tolist()
    for v, here in enumerate(contours):
        for w, there in enumerate(contours):
            a, b = parts[here], parts[there]
            if here == there:
                continue
            if adjacent is not None and a != b and not adjacent[a, b]:
                barred.add((v, w))
            met = contours_in(table[v, w]) if table is not None else []
            if here in met:
                barred.add((v, w))
            elif (v, w) not in barred and set(met) - {there}:
                crossed[v, w] = [k for k in met if k != there]
    return frozenset(barred), crossed


def _price(price: Fraction) -> tuple[int, int]:
    """Return the price of imbalance as a fraction of small numbers, rounded down."""
    near = price.limit_denominator(DENOMINATOR)
    if near > price:
        near = Fraction(math.floor(price * DENOMINATOR), DENOMINATOR)
    return near.as_integer_ratio()


def _floors(table: Floats) -> list:
    whole: list = np.floor(table).astype(int).tolist()
    return whole
