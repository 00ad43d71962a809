r"""Kernel: shortest closed tour through regions in a fixed order, by a primal-dual interior-point method.

    (1) p_k = c_k + B_k x_k,  |x_k| <= 1 (ellipsoid) or G_k x_k <= h_k (hull)
    (2) value = sum_k |d_k|,  d_k = p_{k+1} - p_k                            (indices mod n)
    (3) bound = sum_k min over region k of s_k . p,  s_k = u_{k-1} - u_k,  |u_k| <= 1

With the cone Q = {(a, b) : |b| <= a} the limits and their multipliers are

    (4) leg    s = (t_k, d_k) in Q,  z = (1, -u_k) in Q
    (5) ball   s = (1, x_k) in Q,    z = (v_0, v) in Q
    (6) sides  s = h - G x >= 0,     z >= 0
    (7) B_k' (u_{k-1} - u_k) - v_k + G_k' z_k = 0

and a step solves dz = m s^-1 - z - W^-2 ds with Nesterov and Todd's scaling W for each of them. Without dt_k
and dz this is a cyclic block tridiagonal system for the dx_k, so a step takes time O(n). Iterates stay inside
all cones: (2) and (3) hold at each step, however well it is solved. Source: Andersen, Roos, Terlaky (2003).
"""

import numba
import numpy as np

from cutgap.formulations.regions.cones import (
    State,
    add_limits,
    complementarity,
    first_side,
    move_limits,
    reach,
    scale_legs,
    set_sides,
)
from cutgap.formulations.regions.cyclic_system import solve_cyclic
from cutgap.formulations.regions.shapes import Shapes, support
from cutgap.instances.arrays import Floats, Ints

MOST_STEPS = 60
REACH = 0.95
"""Share of the way to the border of the cones that a step may take."""


@numba.njit(cache=True, error_model="numpy")
def bound_of(shapes: Shapes, order: Ints, u: Floats) -> float:
    """Return (3) for multipliers inside the unit ball."""
    n, axes = u.shape
    s = np.empty(axes)
    total = 0.0
    for k in range(n):
        for e in range(axes):
            s[e] = u[k - 1, e] - u[k, e]
        total += support(shapes, order[k], s)
    return total


@numba.njit(cache=True, error_model="numpy")
def shortest(
    shapes: Shapes, order: Ints, cutoff: float, rough: float, fine: float, p: Floats, u: Floats
) -> tuple[float, float]:
    """Find the shortest tour through the regions ``order``; return bound and value.

    It stops when the bound reaches the cutoff; when the value is below the cutoff and within ``rough`` of the
    bound; when both are within ``fine`` (relative to the value); or when steps no longer gain.

    Parameters
    ----------
    p, u
        Shape (n, E): the touch points and multipliers are written there.
    """
    n, axes = p.shape
    size = shapes.bases.shape[2]
    first = first_side(shapes, order)
    sides = int(first[n])
    state = _zeros(n, axes, size, sides)
    move = _zeros(n, axes, size, sides)
    value = _place(shapes, order, state)
    least, bound, stalled = 1e-14 * value, 0.0, 0
    _copy(state.p, p)
    _copy(state.u, u)
    if n < 2:
        return 0.0, value
    _begin(shapes, order, first, state, value / n + 1e-300)
    blocks = np.zeros((3, n, size, size))
    legs, tilts = np.zeros((n, axes, axes)), np.zeros((n, axes))
    centring = 0.1
    for _ in range(MOST_STEPS):
        m = centring * complementarity(shapes, order, first, state) / (n + sides)
        scale_legs(m, state, move, legs, tilts)
        blocks.fill(0.0)
        move.x.fill(0.0)
        add_limits(shapes, order, first, m, state, blocks[0], move.x)
        _add_legs(shapes, order, move, legs, blocks)
        solve_cyclic(blocks[0], blocks[1], blocks[2], move.x)
        _move_legs(shapes, order, state, move, legs, tilts)
        move_limits(shapes, order, first, m, state, move)
        step = _advance(shapes, order, first, state, move)
        centring = 0.1 if step > 0.9 else 0.3
        new_value = _place(shapes, order, state)
        set_sides(shapes, order, first, state)
        new_bound = bound_of(shapes, order, state.u)
        stalled += 1
        if new_bound > bound:
            stalled = 0 if new_bound - bound > 0.01 * (value - bound) else stalled
            bound = new_bound
            _copy(state.u, u)
        if new_value < value:
            stalled = 0 if value - new_value > 0.01 * (value - bound) else stalled
            value = new_value
            _copy(state.p, p)
        gap = value - bound
        if bound >= cutoff or gap <= fine * value or value <= least or stalled > 8:
            break
        if value < cutoff and gap <= rough * value:
            break
    return bound, value


@numba.njit(cache=True, error_model="numpy")
def _zeros(n: int, axes: int, size: int, sides: int) -> State:
    return State(
        np.zeros((n, axes)),
        np.zeros((n, axes)),
        np.zeros(n),
        np.zeros((n, axes)),
        np.zeros((n, size)),
        np.zeros((n, size)),
        np.zeros(sides),
        np.zeros(sides),
    )


@numba.njit(cache=True, error_model="numpy")
def _place(shapes: Shapes, order: Ints, state: State) -> float:
    """Set p and d by (1) and (2); return the value."""
    n, axes = state.p.shape
    for k in range(n):
        r = order[k]
        for e in range(axes):
            state.p[k, e] = shapes.centres[r, e]
            for d in range(shapes.sizes[r]):
                state.p[k, e] += shapes.bases[r, e, d] * state.x[k, d]
    total = 0.0
    for k in range(n):
        after = k + 1 if k + 1 < n else 0
        square = 0.0
        for e in range(axes):
            state.d[k, e] = state.p[after, e] - state.p[k, e]
            square += state.d[k, e] ** 2
        total += np.sqrt(square)
    return total


@numba.njit(cache=True, error_model="numpy")
def _begin(shapes: Shapes, order: Ints, first: Ints, state: State, mean: float) -> None:
    """Set t and z so that all complementarities are about the mean length of a leg."""
    set_sides(shapes, order, first, state)
    for k in range(len(state.t)):
        square = mean * mean
        for e in range(state.d.shape[1]):
            square += state.d[k, e] ** 2
        state.t[k] = np.sqrt(square)
    for i in range(len(state.s)):
        state.z[i] = mean / state.s[i]


@numba.njit(cache=True, error_model="numpy")
def _add_legs(shapes: Shapes, order: Ints, move: State, legs: Floats, blocks: Floats) -> None:
    """Add what the legs put into the blocks (k, k), (k, k + 1), (n - 1, k) and the right side ``move.x``."""
    n, axes = move.p.shape
    size = move.x.shape[1]
    moved, back = np.empty((axes, size)), np.empty((axes, size))
    for k in range(n):
        after = k + 1 if k + 1 < n else 0
        here, there = shapes.bases[order[k]], shapes.bases[order[after]]
        _product(legs[k], there, moved)
        _product(legs[k], here, back)
        for d in range(size):
            for e in range(axes):
                move.x[k, d] += here[e, d] * move.u[k, e]
                move.x[after, d] -= there[e, d] * move.u[k, e]
            for f in range(size):
                across = 0.0
                for e in range(axes):
                    blocks[0, k, d, f] += here[e, d] * back[e, f]
                    blocks[0, after, d, f] += there[e, d] * moved[e, f]
                    across -= here[e, d] * moved[e, f]
                if after == 0:
                    blocks[2, 0, d, f] += across
                elif after == n - 1:
                    blocks[2, k, f, d] += across
                else:
                    blocks[1, k, d, f] += across


@numba.njit(cache=True, error_model="numpy")
def _product(a: Floats, b: Floats, out: Floats) -> None:
    """Set ``out`` to a b."""
    for e in range(a.shape[0]):
        for d in range(b.shape[1]):
            out[e, d] = 0.0
            for f in range(a.shape[1]):
                out[e, d] += a[e, f] * b[f, d]


@numba.njit(cache=True, error_model="numpy")
def _move_legs(shapes: Shapes, order: Ints, state: State, move: State, legs: Floats, tilts: Floats) -> None:
    """Set the moves of p, d, t and u that go with those of x."""
    n, axes = state.p.shape
    for k in range(n):
        for e in range(axes):
            move.p[k, e] = 0.0
            for d in range(shapes.sizes[order[k]]):
                move.p[k, e] += shapes.bases[order[k], e, d] * move.x[k, d]
    for k in range(n):
        after = k + 1 if k + 1 < n else 0
        for e in range(axes):
            move.d[k, e] = move.p[after, e] - move.p[k, e]
            move.t[k] += tilts[k, e] * move.d[k, e]
            move.u[k, e] -= state.u[k, e]
        for e in range(axes):
            for f in range(axes):
                move.u[k, e] += legs[k, e, f] * move.d[k, f]


# Loops instead of slices, which take seconds to compile.


@numba.njit(cache=True, error_model="numpy")
def _copy(source: Floats, target: Floats) -> None:
    for k in range(target.shape[0]):
        for e in range(target.shape[1]):
            target[k, e] = source[k, e]


@numba.njit(cache=True, error_model="numpy")
def _add(target: Floats, share: float, move: Floats) -> None:
    for k in range(target.shape[0]):
        for e in range(target.shape[1]):
            target[k, e] += share * move[k, e]


@numba.njit(cache=True, error_model="numpy")
def _advance(shapes: Shapes, order: Ints, first: Ints, state: State, move: State) -> float:
    """Move inside the cones, primal and dual each as far as they go; return the shorter of both steps."""
    n = len(order)

    primal, dual = 1.0 / REACH, 1.0 / REACH
    for k in range(n):
        primal = min(primal, reach(state.t[k], move.t[k], state.d[k], move.d[k]))
        dual = min(dual, reach(1.0, 0.0, state.u[k], move.u[k]))
        for i in range(first[k], first[k + 1]):
            if shapes.is_hull[order[k]]:
                if move.s[i] < 0.0:
                    primal = min(primal, -state.s[i] / move.s[i])
                if move.z[i] < 0.0:
                    dual = min(dual, -state.z[i] / move.z[i])
            else:
                primal = min(primal, reach(1.0, 0.0, state.x[k], move.x[k]))
                dual = min(dual, reach(state.z[i], move.z[i], state.v[k], move.v[k]))
    primal, dual = REACH * primal, REACH * dual
    for k in range(n):
        state.t[k] += primal * move.t[k]
    for i in range(len(state.z)):
        state.z[i] += dual * move.z[i]
    _add(state.x, primal, move.x)
    _add(state.u, dual, move.u)
    _add(state.v, dual, move.v)
    return min(primal, dual)
