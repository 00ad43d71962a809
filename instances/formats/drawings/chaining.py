"""Strands of a drawing become closed loops: which end continues at which.

    (1) Strands that follow each other in the file, end to end, and come back to where they began are a loop,
        since most programs write a contour as a whole. Ends lie together here when they are at most
        tolerance / 1000 apart.
    (2) Of all other strands, ends that are at most ``tolerance`` apart meet in pairs, each end once: nearest
        first (less than tolerance / 1000 counts as none), and among equals with the sharpest bend.
    (3) Going straight back is the last choice in both, so that an edge drawn twice belongs to two loops.
    (4) A way that comes through a point again is cut there, so that loops touch but do not pass through
        themselves at a joint.

Nothing depends on the direction in which strands are drawn, and by (2) little on their order.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from cutgap.instances.arrays import Floats
from cutgap.instances.formats.drawings.curves import Strand

TOGETHER = 1e-3
"""Share of the tolerance within which ends lie together."""
FOLD = 1e-6
"""Angle in rad between two ends below which going from one to the other is going straight back."""

Way = list[int]
"""Strands one after the other, each by the end where it is entered; strand k has the ends 2 k and 2 k + 1."""


@dataclass(frozen=True, slots=True)
class Chain:
    """Strands run one after the other; closed ones are loops."""

    strands: tuple[Strand, ...]
    closed: bool


@dataclass(frozen=True, slots=True)
class _Ends:
    """Places of all ends, and the directions that lead from them into their strands, shape (2 strands, 2)."""

    places: Floats
    inward: Floats

    @classmethod
    def of(cls, strands: list[Strand]) -> "_Ends":
        places = np.concatenate([strand.ends for strand in strands])
        pairs = [(s.elements[0].directions[0], -s.elements[-1].directions[1]) for s in strands]
        return cls(places, np.concatenate([np.stack(pair) for pair in pairs]))

    def meet(self, one: int, other: int, near: float) -> bool:
        """Whether two ends are at most ``near`` apart and going on from one to the other is no fold."""
        gap = np.hypot(*(self.places[one] - self.places[other]))
        return bool(gap <= near) and float(self.inward[one] @ self.inward[other]) < np.cos(FOLD)


def chain(strands: list[Strand], tolerance: float) -> list[Chain]:
    """Return closed loops and what stays open, in the order of their first strands.

    Parameters
    ----------
    strands
        In the order of the file; ends in mm.
    tolerance
        Largest gap between ends that meet, mm, above 0.
    """
    alone = [k for k, strand in enumerate(strands) if _closes_itself(strand, tolerance)]
    found: list[tuple[Way, bool]] = [([2 * k], True) for k in alone]
    rest = sorted(set(range(len(strands))) - set(alone))
    if rest:
        ends = _Ends.of([strands[k] for k in rest])
        found += [
            ([2 * rest[end // 2] + end % 2 for end in way], closed) for way, closed in _ways(ends, tolerance)
        ]
    chains = []
    for way, closed in sorted(found, key=lambda each: min(each[0])):
        run = [strands[end // 2] if end % 2 == 0 else strands[end // 2].reverse() for end in way]
        chains.append(Chain(tuple(run), closed))
    return chains


def _closes_itself(strand: Strand, tolerance: float) -> bool:
    return float(np.hypot(*np.subtract(*strand.ends))) <= tolerance < strand.extent


def _ways(ends: _Ends, tolerance: float) -> Iterator[tuple[Way, bool]]:
    """Yield all ways, with whether they are closed."""
    together = KDTree(ends.places).query_pairs(TOGETHER * tolerance, output_type="ndarray")
    in_file = list(_loops_in_file(ends, TOGETHER * tolerance))
    done = {end // 2 for way in in_file for end in way}
    left = [end for end in range(len(ends.places)) if end // 2 not in done]
    partner = _matched(ends, np.array(left, dtype=np.int64), tolerance)
    met = np.array([*together.tolist(), *([a, b] for a, b in partner.items())], dtype=np.int64).reshape(-1, 2)
    graph = coo_array((np.ones(len(met)), met.T), shape=(len(ends.places), len(ends.places)))
    joint = connected_components(graph, directed=False)[1].tolist()
    for way in (*in_file, *_followed(left, partner)):
        yield from _cut_at_touches(way, joint)


def _loops_in_file(ends: _Ends, near: float) -> Iterator[Way]:
    """Yield the loops of (1)."""
    way: Way = []
    for strand in range(len(ends.places) // 2):
        both = (2 * strand, 2 * strand + 1)
        tails = [end ^ 1 for end in way[-1:]] + (way if len(way) == 1 else [])
        joined = next(((tail, end) for tail in tails for end in both if ends.meet(tail, end, near)), None)
        if joined is None:
            way = [both[0]]
            continue
        # The direction of a first strand is known once the second one joins it.
        way = [*way[:-1], joined[0] ^ 1, joined[1]]
        if ends.meet(way[0], way[-1] ^ 1, near):
            yield way
            way = []


def _matched(ends: _Ends, left: np.ndarray, tolerance: float) -> dict[int, int]:
    """Return the partner of each end that has one, by (2)."""
    pairs = KDTree(ends.places[left]).query_pairs(tolerance, output_type="ndarray") if len(left) else left
    first, second = left[np.sort(pairs.reshape(-1, 2), axis=1)].T
    keep = first // 2 != second // 2
    first, second = first[keep], second[keep]
    gaps = np.linalg.norm(ends.places[first] - ends.places[second], axis=1)
    angle = np.arccos(np.clip((ends.inward[first] * ends.inward[second]).sum(axis=1), -1.0, 1.0))
    # The last key is the first one; numbers at the end, so that ties are always broken alike.
    keys = (second, first, np.round(angle, 6), angle < FOLD, np.floor(gaps / (TOGETHER * tolerance)))
    partner: dict[int, int] = {}
    for place in np.lexsort(keys).tolist():
        a, b = int(first[place]), int(second[place])
        if a not in partner and b not in partner:
            partner[a], partner[b] = b, a
    return partner


def _followed(left: list[int], partner: dict[int, int]) -> Iterator[Way]:
    """Yield the ways along partners; open ones begin at ends without a partner."""
    seen: set[int] = set()
    for start in (*(end for end in left if end not in partner), *left):
        way: Way = []
        end: int | None = start
        while end is not None and end // 2 not in seen:
            seen.add(end // 2)
            way.append(end)
            end = partner.get(end ^ 1)
        if way:
            yield way


def _cut_at_touches(way: Way, joint: list[int]) -> Iterator[tuple[Way, bool]]:
    """Cut a loop off wherever the way comes back to a joint; what is left, if anything, is open."""
    run: Way = []
    places = {joint[way[0]]: 0}
    for end in way:
        run.append(end)
        place = joint[end ^ 1]
        if place in places:
            begin = places[place]
            for cut in run[begin:-1]:
                del places[joint[cut ^ 1]]
            yield run[begin:], True
            del run[begin:]
        else:
            places[place] = len(run)
    if run:
        yield run, False
