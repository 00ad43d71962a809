r"""One head's plans as walks over entry points: the arrays that the dynamic programme works on.

    Contours   0..n-1, each with consecutive points; a walk visits each contour once, at one of its points
    Data       c_vw   cost of the rapid from point v to point w, infinite where it is forbidden        [mm]
               s_v    cost of beginning at v, t_v cost of ending there                                 [mm]
               closed_ab   whether b may not come right after a
               before_ab   whether a must come some time before b (transitively)
               X_vw   contours that the rapid crosses: forbidden once one of them is cut

    min  s_(v_1) + sum_i c_(v_i, v_(i+1)) + t_(v_n)

A head with a home gives one such problem. A closed tour without a home gives one for each point at which it
may begin: that point is left out as a contour, and s, t are the rapids from and to it. When nothing depends
on where a closed tour begins, the contour with the fewest points serves as the beginning.

Source: Held and Karp (1962); Li et al. (2019) for the process rules.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cutgap.instances import Instance, Rules, Visit
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.process import WORD, Words, adjacent_parts, crossings, part_of, rapid_costs

Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Walks:
    """The data above.

    Attributes
    ----------
    visits
        The visit that each point stands for.
    first
        Point 0 of each contour, then the number of points; shape (n + 1,).
    contours
        Number in the instance of each contour.
    costs, start, end
        c, s and t; shapes (points, points) and (points,).
    closed, before
        Shape (n, n).
    parts
        Part of each contour when parts are cut in one go, else ``None``.
    crossed
        X as sets in words of 64 bits over the contours here, when rapids must be clear, else ``None``.
    prefix
        The visits made before the walk begins: none, or the beginning of a closed tour.
    """

    visits: tuple[Visit, ...]
    first: Ints
    contours: Ints
    costs: Floats
    start: Floats
    end: Floats
    closed: Bools
    before: Bools
    parts: Ints | None
    crossed: Words | None
    prefix: tuple[Visit, ...] = ()

    @property
    def count(self) -> int:
        """Number of contours."""
        return len(self.contours)

    @property
    def contour_of(self) -> Ints:
        """Contour of each point, shape (points,)."""
        return np.repeat(np.arange(self.count), np.diff(self.first))

    @property
    def earliest(self) -> Ints:
        """Least number of contours before each contour."""
        return self.before.sum(axis=0).astype(np.int64)

    @property
    def latest(self) -> Ints:
        """Largest number of contours before each contour."""
        return self.count - 1 - self.before.sum(axis=1).astype(np.int64)


def walk_problems(instance: Instance, rules: Rules) -> list[Walks]:
    """Return the walk problems of an instance with one head; the best of their optima is its optimum."""
    everything = np.arange(len(instance.contours))
    home = instance.home_node(0)
    if home is not None:
        return [_walks(instance, rules, everything, home, ())]
    before = precedes(instance, rules)
    if before.any() or rules.process:
        firsts = np.flatnonzero(~before.any(axis=0)).tolist()
    else:
        firsts = [int(np.argmin(np.diff(instance.first_node)))]
    return [
        _walks(
            instance,
            rules,
            np.delete(everything, contour),
            instance.node(contour, entry),
            (Visit(contour, entry),),
        )
        for contour in firsts
        for entry in range(len(instance.contours[contour].entry_points))
    ]


def precedes(instance: Instance, rules: Rules) -> Bools:
    """Return whether contour a comes before contour b by the precedence or what follows from it.

    Where parts are cut in one go, a pair of contours of two parts orders all contours of these parts; a contour
    that then comes before itself says that there is no plan.
    """
    count = len(instance.contours)
    before: Bools = np.zeros((count, count), dtype=np.bool_)
    for a, b in instance.precedence:
        before[a, b] = True
    if rules.parts_in_one_go:
        parts = part_of(instance)
        mates = parts[:, None] == parts
        across = (before & ~mates).astype(np.int64)
        before |= (mates @ across @ mates) > 0
    for middle in range(count):
        before |= np.outer(before[:, middle], before[middle])
    return before


def _walks(instance: Instance, rules: Rules, contours: Ints, base: int, prefix: tuple[Visit, ...]) -> Walks:
    """Return the walks through ``contours`` from a node and back to it."""
    sizes = np.diff(instance.first_node)[contours]
    nodes = np.concatenate(
        [instance.first_node[c] + np.arange(size) for c, size in zip(contours, sizes, strict=True)]
    )
    visits = tuple(
        Visit(int(c), entry) for c, size in zip(contours, sizes, strict=True) for entry in range(size)
    )
    of_point = np.repeat(np.arange(len(contours)), sizes)
    costs, lengths = rapid_costs(instance, rules), instance.rapids
    inner = costs[np.ix_(nodes, nodes)].copy()
    start, end = costs[base, nodes].copy(), lengths[nodes, base].copy()
    parts = part_of(instance)
    before = precedes(instance, rules)[np.ix_(contours, contours)]
    closed = closed_arcs(before, parts[contours] if rules.parts_in_one_go else None)
    if rules.neighbours_only:
        near = adjacent_parts(instance) | np.eye(len(adjacent_parts(instance)), dtype=bool)
        closed |= ~near[np.ix_(parts[contours], parts[contours])]
    if prefix:
        start[~_may_follow(instance, rules, prefix[0].contour, contours)[of_point]] = np.inf
    crossed = None
    if rules.clear_rapids:
        table = crossings(instance)
        begun = [visit.contour for visit in prefix]
        crossed = _renumbered(table[np.ix_(nodes, nodes)], contours)
        inner[_meets_own(crossed, of_point)] = np.inf
        for contour in begun:
            inner[_has(table[np.ix_(nodes, nodes)], contour)] = np.inf
            start[_has(table[base][nodes], contour)] = np.inf
    return Walks(
        visits=visits,
        first=np.concatenate(([0], np.cumsum(sizes))).astype(np.int64),
        contours=contours,
        costs=inner,
        start=start,
        end=end,
        closed=closed,
        before=before,
        parts=parts[contours] if rules.parts_in_one_go else None,
        crossed=crossed,
        prefix=prefix,
    )


def closed_arcs(before: Bools, parts: Ints | None) -> Bools:
    """Return whether contour b may not come right after contour a.

    It may not when it comes before a, when a third contour comes between them, or when parts are cut in one go
    and the step from one part to another leaves a contour of the first that comes after a, or of the second
    that comes before b.
    """
    between = before.astype(np.int64) @ before.astype(np.int64) > 0
    closed: Bools = before.T | between | np.eye(len(before), dtype=np.bool_)
    if parts is not None:
        mates = parts[:, None] == parts
        unfinished, begun = (before & mates).any(axis=1), (before & mates).any(axis=0)
        closed |= ~mates & (unfinished[:, None] | begun[None, :])
    return closed


def _may_follow(instance: Instance, rules: Rules, begun: int, contours: Ints) -> Bools:
    """Return whether each contour may come right after the first one of a closed tour."""
    parts = part_of(instance)
    same = parts[contours] == parts[begun]
    allowed: Bools = np.ones(len(contours), dtype=np.bool_)
    if rules.parts_in_one_go and same.any():
        allowed &= same
    if rules.neighbours_only:
        allowed &= same | adjacent_parts(instance)[parts[begun], parts[contours]]
    return allowed


def _has(words: Words, contour: int) -> Bools:
    return (words[..., contour // WORD] >> np.uint64(contour % WORD)) & np.uint64(1) > 0


def _meets_own(crossed: Words, of_point: Ints) -> Bools:
    """Return which rapids cross the contour that they leave, shape (points, points)."""
    own = np.left_shift(np.uint64(1), (of_point % WORD).astype(np.uint64))
    return (crossed[np.arange(len(of_point)), :, of_point // WORD] & own[:, None]) > 0


def _renumbered(words: Words, contours: Ints) -> Words:
    """Return the sets with contour ``contours[i]`` as number i."""
    renumbered: Words = np.zeros((*words.shape[:-1], (len(contours) + WORD - 1) // WORD), dtype=np.uint64)
    for new, old in enumerate(contours.tolist()):
        renumbered[..., new // WORD] |= np.where(_has(words, old), np.uint64(1 << new % WORD), np.uint64(0))
    return renumbered
