"""Strands of a drawing become closed loops: which end continues at which.

Two ends may meet when they are at most ``tolerance`` apart. All pairs that may are taken one after the other,
each end once, in the order

    (1) nearest first, distances below tolerance / 1000 counting as none;
    (2) pairs that do not turn straight back, so that an edge drawn twice belongs to two loops;
    (3) neighbours in the file, since most programs write a contour as a whole;
    (4) the sharpest bend.

Whatever (3) and (4) choose, a way that comes through a point again is cut there, so loops touch but do not pass
through themselves at a joint. Nothing depends on the direction in which strands are drawn.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.formats.drawings.curves import Strand

FOLD = 1e-6
"""Angle in rad between two ends below which going from one to the other is turning back."""


@dataclass(frozen=True, slots=True)
class Chain:
    """Strands run one after the other; closed ones are loops."""

    strands: tuple[Strand, ...]
    closed: bool


@dataclass(frozen=True, slots=True)
class _Step:
    """A strand run from its end number ``entered`` to the other one; ends are 2 k and 2 k + 1 for strand k."""

    entered: int

    @property
    def left(self) -> int:
        return self.entered ^ 1


def chain(strands: list[Strand], tolerance: float) -> list[Chain]:
    """Return closed loops and what stays open, in the order of their first strands.

    Parameters
    ----------
    strands
        In the order of the file; ends in mm.
    tolerance
        Largest gap between ends that meet, mm, above 0.
    """
    alone: list[int] = []
    rest: list[int] = []
    for number, strand in enumerate(strands):
        gap = float(np.hypot(*np.subtract(*strand.ends)))
        (alone if gap <= tolerance < strand.extent else rest).append(number)
    found = [(number, Chain((strands[number],), True)) for number in alone]
    if rest:
        ends = np.concatenate([strands[number].ends for number in rest])
        out = np.concatenate([_outward(strands[number]) for number in rest])
        partner, joint = _matched(ends, out, np.array(rest), tolerance)
        for steps, closed in _ways(partner, joint):
            numbers = [rest[step.entered // 2] for step in steps]
            run = [
                strands[number] if step.entered % 2 == 0 else strands[number].reverse()
                for number, step in zip(numbers, steps, strict=True)
            ]
            found.append((min(numbers), Chain(tuple(run), closed)))
    return [each for _, each in sorted(found, key=lambda numbered: numbered[0])]


def _outward(strand: Strand) -> Floats:
    """Return unit vectors that lead from each end into the strand, shape (2, 2)."""
    return np.stack((strand.elements[0].directions[0], -strand.elements[-1].directions[1]))


def _matched(ends: Floats, out: Floats, order: Ints, tolerance: float) -> tuple[list[int], list[int]]:
    """Return the partner of each end (-1 without), and the number of its joint (ends that lie together)."""
    pairs = KDTree(ends).query_pairs(tolerance, output_type="ndarray")
    pairs = np.sort(pairs[pairs[:, 0] // 2 != pairs[:, 1] // 2], axis=1)
    first, second = pairs.T
    distance = np.floor(1000 * np.linalg.norm(ends[first] - ends[second], axis=1) / tolerance)
    angle = np.arccos(np.clip((out[first] * out[second]).sum(axis=1), -1.0, 1.0))
    apart = np.abs(order[first // 2] - order[second // 2]) != 1
    # The last key is the first one: (1) to (4), then numbers, so that ties are always broken alike.
    ranked = np.lexsort((second, first, np.round(angle, 6), apart, angle < FOLD, distance))
    partner = [-1] * len(ends)
    for a, b in pairs[ranked].tolist():
        if partner[a] < 0 and partner[b] < 0:
            partner[a], partner[b] = b, a
    met = [pair for pair, step in zip(pairs.tolist(), distance.tolist(), strict=True) if step == 0]
    met += [[a, b] for a, b in enumerate(partner) if b > a]
    rows, columns = np.array(met, dtype=np.int64).reshape(-1, 2).T
    graph = coo_array((np.ones(len(met)), (rows, columns)), shape=(len(ends), len(ends)))
    return partner, connected_components(graph, directed=False)[1].tolist()


def _ways(partner: list[int], joint: list[int]) -> Iterable[tuple[list[_Step], bool]]:
    """Yield the loops and the open rests of all ways; open ones begin at ends without a partner."""
    seen: set[int] = set()
    loose = [end for end, other in enumerate(partner) if other < 0]
    for start in (*loose, *range(0, len(partner), 2)):
        steps: list[_Step] = []
        end = start
        while end >= 0 and end // 2 not in seen:
            seen.add(end // 2)
            steps.append(_Step(end))
            end = partner[steps[-1].left]
        if steps:
            yield from _cut_at_touches(steps, joint)


def _cut_at_touches(steps: list[_Step], joint: list[int]) -> Iterable[tuple[list[_Step], bool]]:
    """Cut a loop off wherever the way comes back to a joint; what is left, if anything, is open."""
    way: list[_Step] = []
    places = {joint[steps[0].entered]: 0}
    for step in steps:
        way.append(step)
        place = joint[step.left]
        if place in places:
            begin = places[place]
            for cut in way[begin:-1]:
                del places[joint[cut.left]]
            yield way[begin:], True
            del way[begin:]
        else:
            places[place] = len(way)
    if way:
        yield way, False
