"""Kernels: which regions a closed polyline touches, and how far it misses the others.

A region's own coordinates of a point y are x = B^+ (y - c), with rest (I - B B^+) (y - c). Along a leg both are
linear, so the leg is inside the region on an interval: where |x| <= 1 or G x <= h, and the rest is 0.
"""

import numba
import numpy as np

from cutgap.formulations.regions.shapes import Shapes, support
from cutgap.instances.arrays import Floats


@numba.njit(cache=True, error_model="numpy")
def inside(shapes: Shapes, inverses: Floats, k: int, a: Floats, b: Floats, slack: float) -> tuple[float, float]:
    """Return from where to where, as shares of the way from a to b, region k is touched; (1, 0) nowhere.

    Parameters
    ----------
    inverses
        Shape (regions, D, E): B^+ of each region.
    slack
        How far, in the region's own coordinates (in mm for the rest), a point may be outside.
    """
    axes, size = len(a), shapes.sizes[k]
    start, step = np.zeros(max(size, 1)), np.zeros(max(size, 1))
    for d in range(size):
        for e in range(axes):
            start[d] += inverses[k, d, e] * (a[e] - shapes.centres[k, e])
            step[d] += inverses[k, d, e] * (b[e] - a[e])
    low, high = 0.0, 1.0
    if size < axes:
        square, mixed, rest = 0.0, 0.0, 0.0
        for e in range(axes):
            off, move = a[e] - shapes.centres[k, e], b[e] - a[e]
            for d in range(size):
                off -= shapes.bases[k, e, d] * start[d]
                move -= shapes.bases[k, e, d] * step[d]
            square += move * move
            mixed += off * move
            rest += off * off
        low, high = _within(square, mixed, rest - (slack + 1e-9) ** 2, low, high)
    if shapes.is_hull[k]:
        return _between_sides(shapes, k, start, step, slack, low, high)
    if size > 0:
        rest = float(np.dot(start, start)) - (1.0 + slack) ** 2
        low, high = _within(float(np.dot(step, step)), float(np.dot(start, step)), rest, low, high)
    return low, high


@numba.njit(cache=True, error_model="numpy")
def _between_sides(
    shapes: Shapes, k: int, start: Floats, step: Floats, slack: float, low: float, high: float
) -> tuple[float, float]:
    """Return the part of an interval where start + t step is inside all sides of a hull."""
    for row in range(shapes.first_row[k], shapes.first_row[k + 1]):
        height, slope = shapes.limits[row] + slack, 0.0
        for d in range(shapes.sizes[k]):
            height -= shapes.rows[row, d] * start[d]
            slope -= shapes.rows[row, d] * step[d]
        if slope < 0.0:
            high = min(high, height / -slope)
        elif slope > 0.0:
            low = max(low, -height / slope)
        elif height < 0.0:
            return 1.0, 0.0
    return low, high


@numba.njit(cache=True, error_model="numpy")
def _within(square: float, mixed: float, rest: float, low: float, high: float) -> tuple[float, float]:
    """Return the part of an interval where square t^2 + 2 mixed t + rest <= 0, which grows from its middle."""
    if square <= 0.0:
        return (low, high) if rest <= 0.0 else (1.0, 0.0)
    inner = mixed * mixed - square * rest
    if inner < 0.0:
        return 1.0, 0.0
    root = np.sqrt(inner)
    return max(low, (-mixed - root) / square), min(high, (-mixed + root) / square)


@numba.njit(cache=True, error_model="numpy")
def misses(shapes: Shapes, inverses: Floats, p: Floats, slack: float, gaps: Floats) -> None:
    """Set how far the closed polyline p misses each region, mm: 0 where it touches, else at least 1e-12."""
    n, axes = p.shape
    towards = np.empty(axes)
    for k in range(len(gaps)):
        nearest = np.inf
        for leg in range(n):
            a, b = p[leg], p[leg + 1 if leg + 1 < n else 0]
            low, high = inside(shapes, inverses, k, a, b, slack)
            if low <= high:
                nearest = 0.0
                break
            square, along = 0.0, 0.0
            for e in range(axes):
                square += (b[e] - a[e]) ** 2
                along += (b[e] - a[e]) * (shapes.centres[k, e] - a[e])
            share = min(1.0, max(0.0, along / square)) if square > 0.0 else 0.0
            norm, height = 0.0, 0.0
            for e in range(axes):
                towards[e] = shapes.centres[k, e] - a[e] - share * (b[e] - a[e])
                norm += towards[e] ** 2
                height += towards[e] * (a[e] + share * (b[e] - a[e]))
            miss = (support(shapes, k, towards) - height) / np.sqrt(norm) if norm > 0.0 else 0.0
            nearest = min(nearest, max(miss, 1e-12))
        gaps[k] = nearest


@numba.njit(cache=True, error_model="numpy")
def touch(
    shapes: Shapes, inverses: Floats, k: int, p: Floats, slack: float, since: float
) -> tuple[float, float]:
    """Return the first stretch of the closed polyline inside region k that ends at ``since`` or later.

    Places are leg + share of it; (-1, -1) when there is no such stretch.
    """
    n = len(p)
    for leg in range(max(0, int(since)), n):
        low, high = inside(shapes, inverses, k, p[leg], p[leg + 1 if leg + 1 < n else 0], slack)
        if low <= high and leg + high >= since:
            return max(since, leg + low), leg + high
    return -1.0, -1.0
