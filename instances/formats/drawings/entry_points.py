"""Where a contour may be pierced: its corners, and points on its curves at equal arc lengths.

Sections run from corner to corner (``outlines``); s is arc length along the polyline.

    auto    every corner, and s = 1/4, 1/2, 3/4 of every curved section; 0, 1/4, 1/2, 3/4 of a contour
            without corners
    N       N <= corners: the corners nearest to N points at equal arc lengths, from the first corner on
            N > corners:  every corner, and N - corners points more, each put where the spacing is largest,
            equally spaced within their section; without corners N points at equal arc lengths

Each entry point is a vertex of the polyline: one that is there within ``SNAP``, or a new one on the chord.
The reference (Li et al., 2019) takes the joints of the basic elements and the 1/2, 1/4, 1/6 points of some.
"""

import heapq

import numpy as np

from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.formats.drawings.outlines import Outline

SNAP = 1e-3
"""Distance in mm within which an entry point becomes the vertex that is there."""


def with_entry_points(outline: Outline, count: int | None) -> tuple[Floats, Floats]:
    """Return the polyline, shape (k, 2), and the entry points among its vertices, shape (m, 2), mm.

    Parameters
    ----------
    count
        N, or ``None`` for auto.
    """
    closed = np.vstack((outline.points, outline.points[:1]))
    along = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))))
    sections = _sections(outline, along)
    if count is None:
        at = _automatic(outline, sections)
    elif count <= len(outline.corners):
        at = _spread(along[list(outline.corners)], along[-1], count)
    else:
        at = _filled(outline, sections, count)
    return _inserted(closed, along, np.unique(at % along[-1]))


def _sections(outline: Outline, along: Floats) -> Floats:
    """Return start and end of each section as arc lengths; ends may lie beyond the closing point."""
    starts = along[list(outline.corners)] if outline.corners else np.zeros(1)
    return np.column_stack((starts, np.append(starts[1:], starts[0] + along[-1])))


def _automatic(outline: Outline, sections: Floats) -> Floats:
    shares = np.arange(4) / 4
    # A straight section has its corner only; share 0 is the corner, or the start of a contour without.
    return np.concatenate(
        [
            start + (end - start) * (shares if curved or not outline.corners else shares[:1])
            for (start, end), curved in zip(sections, outline.curved, strict=True)
        ]
    )


def _spread(corners: Floats, whole: float, count: int) -> Floats:
    """Return corners near to equally spaced places; two places may share one."""
    targets = corners[0] + np.arange(count) * whole / count
    around = np.append(corners, corners[0] + whole)
    return around[np.unique(_nearest(around, targets) % len(corners))]


def _filled(outline: Outline, sections: Floats, count: int) -> Floats:
    """Return all corners and more points, one after the other into the section of the largest spacing."""
    lengths = sections[:, 1] - sections[:, 0]
    pieces = [1] * len(lengths)
    spacing = [(-length, number) for number, length in enumerate(lengths.tolist())]
    heapq.heapify(spacing)
    for _ in range(count - max(1, len(outline.corners))):
        number = spacing[0][1]
        pieces[number] += 1
        heapq.heapreplace(spacing, (-lengths[number] / pieces[number], number))
    return np.concatenate(
        [
            start + (end - start) * np.arange(parts) / parts
            for (start, end), parts in zip(sections, pieces, strict=True)
        ]
    )


def _inserted(closed: Floats, along: Floats, at: Floats) -> tuple[Floats, Floats]:
    """Return the polyline with vertices at the given arc lengths, and these vertices in order."""
    count = len(closed) - 1
    nearest = _nearest(along, at)
    is_there = np.abs(along[nearest] - at) <= SNAP
    is_entry = np.zeros(count, dtype=np.bool_)
    is_entry[nearest[is_there] % count] = True
    new = at[~is_there]
    places = np.column_stack([np.interp(new, along, closed[:, axis]) for axis in (0, 1)])
    before = np.searchsorted(along, new)
    points = np.insert(closed[:-1], before, places, axis=0)
    return points, points[np.insert(is_entry, before, True)]


def _nearest(ascending: Floats, values: Floats) -> Ints:
    """Return for each value the index of the entry next to it."""
    return np.searchsorted((ascending[1:] + ascending[:-1]) / 2, values)
