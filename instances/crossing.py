"""Whether the middle part of a rapid meets a closed polyline, decided without rounding.

The middle part leads from v' = v + t (w - v) to w' = w - t (w - v), t = 10^-6. It meets the edge p q when
neither p and q are on one side of the line v w, nor v' and w' on one side of the line p q; on one line, when
they overlap.

Sides come from floats where their error bound says that the sign is certain, else from fractions.
"""

from fractions import Fraction

import numba
import numpy as np
import numpy.typing as npt

from cutgap.instances.arrays import Floats

END_SHARE = Fraction(1, 10**6)
"""t."""

SHARE = float(END_SHARE)
ERROR = 2.0**-49
"""Relative to the products in it, a side's error is below 8 units of rounding, 2^-53 each; twice that."""

DOUBT = 2
"""Neither a sign nor a verdict."""

Words = npt.NDArray[np.uint64]
Edge = tuple[int, int, int]
"""A rapid and the first corner of an edge."""


def mark_meetings(points: Floats, curve: Floats, table: Words, bit: np.uint64) -> None:
    """Set a bit of a table of rapids for those whose middle part meets a closed polyline.

    Parameters
    ----------
    points
        Shape (points, 2), mm. No rapid between equal points meets anything.
    curve
        Shape (corners, 2), mm, first corner not repeated.
    table
        Shape (points, points).
    """
    for v, w, p in _mark_by_floats(points, curve, table, bit):
        if _meets_exactly(points[v], points[w], curve[p], curve[(p + 1) % len(curve)]):
            table[v, w] |= bit
            table[w, v] |= bit


@numba.njit(cache=True)
def _mark_by_floats(points: Floats, curve: Floats, table: Words, bit: np.uint64) -> list[Edge]:
    """Set the bit of the rapids that meet a polyline for certain; return rapids and edges in doubt."""
    doubts = [(0, 0, 0) for _ in range(0)]
    low_x, low_y = curve[:, 0].min(), curve[:, 1].min()
    high_x, high_y = curve[:, 0].max(), curve[:, 1].max()
    for v in range(len(points) - 1):
        vx, vy = points[v]
        for w in range(v + 1, len(points)):
            wx, wy = points[w]
            apart_x = max(vx, wx) < low_x or min(vx, wx) > high_x
            if apart_x or max(vy, wy) < low_y or min(vy, wy) > high_y or (vx == wx and vy == wy):
                continue
            known = len(doubts)
            for p in range(len(curve)):
                px, py = curve[p]
                qx, qy = curve[(p + 1) % len(curve)]
                verdict = _meets(vx, vy, wx, wy, px, py, qx, qy)
                if verdict == 1:
                    table[v, w] |= bit
                    table[w, v] |= bit
                    del doubts[known:]
                    break
                if verdict == DOUBT:
                    doubts.append((v, w, p))
    return doubts


@numba.njit(cache=True)
def _meets(vx: float, vy: float, wx: float, wy: float, px: float, py: float, qx: float, qy: float) -> int:
    """Return 1, 0 or ``DOUBT``."""
    p_side = _sign(*_side(vx, vy, wx, wy, px, py))
    q_side = _sign(*_side(vx, vy, wx, wy, qx, qy))
    if p_side * q_side == 1:
        return 0
    v_area, v_size = _side(px, py, qx, qy, vx, vy)
    w_area, w_size = _side(px, py, qx, qy, wx, wy)
    v_side = _sign(v_area + SHARE * (w_area - v_area), v_size + SHARE * w_size)
    w_side = _sign(w_area + SHARE * (v_area - w_area), w_size + SHARE * v_size)
    if v_side * w_side == 1:
        return 0
    if DOUBT in (p_side, q_side, v_side, w_side):
        return DOUBT
    if p_side != 0 or q_side != 0:
        return 1
    # On one line, so along the longer axis of the rapid.
    if abs(wx - vx) >= abs(wy - vy):
        return _overlap(vx, wx, px, qx)
    return _overlap(vy, wy, py, qy)


@numba.njit(cache=True)
def _side(ax: float, ay: float, bx: float, by: float, cx: float, cy: float) -> tuple[float, float]:
    """Return twice the area of the triangle a b c, positive with c left of a b, and the size of its terms."""
    left, right = (bx - ax) * (cy - ay), (by - ay) * (cx - ax)
    return left - right, abs(left) + abs(right)


@numba.njit(cache=True)
def _sign(value: float, size: float) -> int:
    if abs(value) > ERROR * size:
        return 1 if value > 0 else -1
    return 0 if size == 0.0 else DOUBT


@numba.njit(cache=True)
def _overlap(v: float, w: float, p: float, q: float) -> int:
    step = SHARE * (w - v)
    lapped = min(max(v + step, w - step), max(p, q)) - max(min(v + step, w - step), min(p, q))
    if abs(lapped) <= ERROR * max(abs(v), abs(w), abs(p), abs(q)):
        return DOUBT
    return 1 if lapped > 0 else 0


def _meets_exactly(v: Floats, w: Floats, p: Floats, q: Floats) -> bool:
    a, b, c, d = ([Fraction(float(x)) for x in point[:2]] for point in (v, w, p, q))
    start, end = ([x + END_SHARE * (y - x) for x, y in zip(*ends, strict=True)] for ends in ((a, b), (b, a)))

    def side(one: list[Fraction], other: list[Fraction], point: list[Fraction]) -> Fraction:
        return (other[0] - one[0]) * (point[1] - one[1]) - (other[1] - one[1]) * (point[0] - one[0])

    c_side, d_side = side(a, b, c), side(a, b, d)
    if c_side * d_side > 0 or side(c, d, start) * side(c, d, end) > 0:
        return False
    if c_side != 0 or d_side != 0:
        return True
    return all(
        min(max(start[x], end[x]), max(c[x], d[x])) >= max(min(start[x], end[x]), min(c[x], d[x]))
        for x in (0, 1)
    )
