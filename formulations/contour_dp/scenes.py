"""Scenes of the dynamic programme: relaxed walks, prices, memories, and the states that are left."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cutgap.formulations.contour_dp.memory import Members
from cutgap.formulations.contour_dp.walks import Walks
from cutgap.instances import Instance
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.scene import Leg, Pass, Scene


@dataclass(frozen=True, eq=False)
class Passed:
    """A pass over one walk problem; ``walk`` is ``None`` where none is left below the limit."""

    text: str
    walks: Walks
    bound: float
    walk: Ints | None
    prices: Floats
    members: Members
    states: tuple[int, ...]


PassMaker = Callable[[], Passed]


def states_of(table: Floats) -> tuple[int, ...]:
    """Return how many states of each position are not dropped; shape (n, states)."""
    return tuple(int(count) for count in np.isfinite(table).sum(axis=1))


def scene_of(instance: Instance, passed: Passed, best: tuple[tuple[int, ...], ...] | None) -> Scene:
    """Return the scene of a pass, by the contours and nodes of the instance."""
    walks, count = passed.walks, len(instance.contours)
    contours = walks.contours.tolist()
    prices, visits = np.zeros(count), np.zeros(count, dtype=np.int64)
    memories: list[tuple[int, ...]] = [()] * count
    prices[contours] = passed.prices
    for contour, members in zip(contours, passed.members, strict=True):
        memories[contour] = tuple(contours[member] for member in members)
    visits[[visit.contour for visit in walks.prefix]] = 1
    legs: tuple[Leg, ...] = ()
    if passed.walk is not None:
        np.add.at(visits, walks.contours[walks.contour_of[passed.walk]], 1)
        legs = _legs(instance, walks, passed.walk)
    counts = () if passed.walk is None else tuple(visits.tolist())
    dp = Pass(tuple(prices.tolist()), counts, tuple(memories), passed.states)
    return Scene(passed.text, bound=passed.bound, legs=legs, best=best, dp=dp)


def _legs(instance: Instance, walks: Walks, walk: Ints) -> tuple[Leg, ...]:
    """Return the legs of a walk, from home to home or around, with how often each is made."""
    stops = [
        instance.node(visit.contour, visit.entry)
        for visit in (*walks.prefix, *map(walks.visits.__getitem__, walk))
    ]
    home = instance.home_node(0)
    around = [*stops, stops[0]] if home is None else [home, *stops, home]
    times = Counter((min(pair), max(pair)) for pair in pairwise(around) if pair[0] != pair[1])
    return tuple(Leg(start, end, float(number)) for (start, end), number in times.items())
