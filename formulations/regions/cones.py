"""Kernels: the cones of ``interior_point``, their scalings, and what they add to a step.

With w of Nesterov and Todd's scaling, W^-2 = (2 (Jw)(Jw)' - J) / eta for J = diag(1, -1, ...).
"""

from typing import NamedTuple

import numba
import numpy as np

from cutgap.formulations.regions.shapes import Shapes
from cutgap.instances.arrays import Floats, Ints


class State(NamedTuple):
    """An iterate: p, d, t, u of the legs, x of the regions, s and z of the sides (z_0 of balls), v of balls."""

    p: Floats
    d: Floats
    t: Floats
    u: Floats
    x: Floats
    v: Floats
    s: Floats
    z: Floats


@numba.njit(cache=True, error_model="numpy")
def first_side(shapes: Shapes, order: Ints) -> Ints:
    """Return the first of the limits of each region: the sides of a hull, one of a ball, none of a point."""
    first = np.zeros(len(order) + 1, np.int64)
    for k in range(len(order)):
        r = order[k]
        count = shapes.first_row[r + 1] - shapes.first_row[r]
        first[k + 1] = first[k] + (count if shapes.is_hull[r] else min(1, shapes.sizes[r]))
    return first


@numba.njit(cache=True, error_model="numpy")
def set_sides(shapes: Shapes, order: Ints, first: Ints, state: State) -> None:
    """Set s: h - G x of hulls, 1 - |x|^2 of balls."""
    for k in range(len(order)):
        r = order[k]
        for i in range(first[k], first[k + 1]):
            if shapes.is_hull[r]:
                row = shapes.first_row[r] + i - first[k]
                state.s[i] = shapes.limits[row]
                for d in range(shapes.sizes[r]):
                    state.s[i] -= shapes.rows[row, d] * state.x[k, d]
            else:
                state.s[i] = 1.0
                for d in range(shapes.sizes[r]):
                    state.s[i] -= state.x[k, d] ** 2


@numba.njit(cache=True, error_model="numpy")
def complementarity(shapes: Shapes, order: Ints, first: Ints, state: State) -> float:
    """Return the sum of all s.z."""
    n, axes = state.p.shape
    total = 0.0
    for k in range(n):
        total += state.t[k]
        for e in range(axes):
            total -= state.u[k, e] * state.d[k, e]
        r = order[k]
        for i in range(first[k], first[k + 1]):
            if shapes.is_hull[r]:
                total += state.s[i] * state.z[i]
            else:
                total += state.z[i]
                for d in range(shapes.sizes[r]):
                    total += state.v[k, d] * state.x[k, d]
    return total


@numba.njit(cache=True, error_model="numpy")
def scale_legs(m: float, state: State, move: State, legs: Floats, tilts: Floats) -> None:
    """Set K and y of u + du = K dd + y (y into ``move.u``), and dt = tilt . dd + r (r into ``move.t``).

    The first row of W^-2, where dz = 0, gives dt. The rest is K = (I - w w' / (w_0^2 - 1/2)) / eta.
    """
    n, axes = state.d.shape
    w = np.empty(axes)
    for k in range(n):
        inner, outer, dot = 0.0, 0.0, state.t[k]
        for e in range(axes):
            inner += state.d[k, e] ** 2
            outer += state.u[k, e] ** 2
            dot -= state.u[k, e] * state.d[k, e]
        norm, slope = np.sqrt(inner), np.sqrt(outer)
        s_square = (state.t[k] - norm) * (state.t[k] + norm)
        s_root, z_root = np.sqrt(s_square), np.sqrt((1.0 - slope) * (1.0 + slope))
        eta = s_root / z_root
        half = 0.5 / np.sqrt(0.5 * (1.0 + dot / (s_root * z_root)))
        w0 = half * (state.t[k] / s_root + 1.0 / z_root)
        for e in range(axes):
            w[e] = half * (state.d[k, e] / s_root + state.u[k, e] / z_root)
        corner = (2.0 * w0 * w0 - 1.0) / eta
        move.t[k] = (m * state.t[k] / s_square - 1.0) / corner
        for e in range(axes):
            tilts[k, e] = 2.0 * w0 * w[e] / (eta * corner)
            move.u[k, e] = m * state.d[k, e] / s_square - tilts[k, e] * corner * move.t[k]
        for e in range(axes):
            for f in range(axes):
                legs[k, e, f] = ((1.0 if e == f else 0.0) - w[e] * w[f] / (w0 * w0 - 0.5)) / eta


@numba.njit(cache=True, error_model="numpy")
def _scale_ball(state: State, k: int, i: int, size: int, w: Floats) -> tuple[float, float]:
    """Set w of the scaling of a ball; return w_0 and eta."""
    inner, dot = 0.0, state.z[i]
    for d in range(size):
        inner += state.v[k, d] ** 2
        dot += state.v[k, d] * state.x[k, d]
    norm = np.sqrt(inner)
    s_root, z_root = np.sqrt(state.s[i]), np.sqrt((state.z[i] - norm) * (state.z[i] + norm))
    half = 0.5 / np.sqrt(0.5 * (1.0 + dot / (s_root * z_root)))
    for d in range(size):
        w[d] = half * (state.x[k, d] / s_root - state.v[k, d] / z_root)
    return half * (1.0 / s_root + state.z[i] / z_root), s_root / z_root


@numba.njit(cache=True, error_model="numpy")
def add_limits(
    shapes: Shapes, order: Ints, first: Ints, m: float, state: State, diagonal: Floats, right: Floats
) -> None:
    """Add what the limits put into the blocks (k, k) and the right side."""
    size = state.x.shape[1]
    w = np.empty(size)
    for k in range(len(order)):
        r = order[k]
        own = shapes.sizes[r]
        for d in range(own, size):
            diagonal[k, d, d] = 1.0
        for i in range(first[k], first[k + 1]):
            if shapes.is_hull[r]:
                row = shapes.first_row[r] + i - first[k]
                pull, weight = m / state.s[i], state.z[i] / state.s[i]
                for d in range(own):
                    right[k, d] -= pull * shapes.rows[row, d]
                    for f in range(own):
                        diagonal[k, d, f] += weight * shapes.rows[row, d] * shapes.rows[row, f]
            else:
                _, eta = _scale_ball(state, k, i, own, w)
                for d in range(own):
                    right[k, d] -= m * state.x[k, d] / state.s[i]
                    diagonal[k, d, d] += 1.0 / eta
                    for f in range(own):
                        diagonal[k, d, f] += 2.0 * w[d] * w[f] / eta


@numba.njit(cache=True, error_model="numpy")
def move_limits(shapes: Shapes, order: Ints, first: Ints, m: float, state: State, move: State) -> None:
    """Set the moves of z and v, and of the s of sides, that go with those of x."""
    w = np.empty(state.x.shape[1])
    for k in range(len(order)):
        r = order[k]
        own = shapes.sizes[r]
        for i in range(first[k], first[k + 1]):
            along = 0.0
            if shapes.is_hull[r]:
                for d in range(own):
                    along += shapes.rows[shapes.first_row[r] + i - first[k], d] * move.x[k, d]
                move.s[i] = -along
                move.z[i] = (m + state.z[i] * along) / state.s[i] - state.z[i]
            else:
                w0, eta = _scale_ball(state, k, i, own, w)
                for d in range(own):
                    along += w[d] * move.x[k, d]
                move.z[i] = 2.0 * w0 * along / eta + m / state.s[i] - state.z[i]
                for d in range(own):
                    change = (2.0 * w[d] * along + move.x[k, d]) / eta + m * state.x[k, d] / state.s[i]
                    move.v[k, d] = -change - state.v[k, d]


@numba.njit(cache=True, error_model="numpy")
def reach(s0: float, ds0: float, s: Floats, ds: Floats) -> float:
    """Return how far (s0, s) may move along (ds0, ds) inside the cone Q (at most 1e9)."""
    norm, mixed, square = 0.0, s0 * ds0, ds0 * ds0
    for e in range(len(s)):
        norm += s[e] * s[e]
        mixed -= s[e] * ds[e]
        square -= ds[e] * ds[e]
    norm = np.sqrt(norm)
    slack = (s0 - norm) * (s0 + norm)
    inside = mixed * mixed - square * slack
    if (mixed >= 0.0 and square >= 0.0) or inside < 0.0:
        return 1e9
    root = np.sqrt(inside)
    # The two forms of the least positive root, each where it does not cancel.
    return min(1e9, slack / (root - mixed) if mixed < 0.0 else (root + mixed) / -square)
