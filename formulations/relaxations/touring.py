r"""Shortest closed tour through convex regions in a fixed order (SOCP); a home is the region of one point.

Data       R_k        region k = 0..n-1 (indices mod n): an ellipsoid { c_k + A_k' x : |x| <= 1 }
                      or the hull { V_k' x : x >= 0, sum x = 1 } of points                          [mm]
Variables  p_k        touch point                                                                   [mm]
           u_k        multiplier of leg k -> k+1                                                    [-]

    (P)  min sum_k |p_{k+1} - p_k|              s.t.  p_k in R_k
    (D)  max sum_k min over R_k of s_k . p      s.t.  |u_k| <= 1,  s_k = u_{k-1} - u_k

The minimum is s.c - |A s| over an ellipsoid, min_j s.v_j over a hull. (P) = (D) by Slater's condition, and any
u in the unit balls proves a bound, however it was found. Source: Coutinho, do Nascimento, Pessoa, Subramanian
(2016), for discs.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import accumulate

import clarabel
import numpy as np
from scipy import sparse

from cutgap.formulations.certificate.proof import Budget
from cutgap.formulations.certificate.regions import Regions
from cutgap.instances.arrays import Floats
from cutgap.instances.region import Ellipsoid, Region

PRECISION = 1e-11
"""Tolerances asked of the solver; what it reached shows in the gap of value and bound."""
SCALE = 10**15
"""Multipliers count as integers over this."""
HAIR = 1e-14
"""Relative shrinking of coordinates and multipliers that keeps them inside their balls for certain."""


@dataclass(frozen=True, slots=True)
class Tour:
    """A tour in the given order and what proves how short it can be.

    Attributes
    ----------
    points
        Shape (n, 3), mm: touch points, in their regions.
    multipliers
        Shape (n, 3): u of each leg.
    value
        Length of the tour through the points, mm.
    lower_bound
        Value of (D) in exact arithmetic, mm: no tour in this order is shorter.
    """

    points: Floats
    multipliers: Floats
    value: float
    lower_bound: Fraction

    @property
    def gap(self) -> float:
        """(value - lower_bound) / value."""
        return 0.0 if self.value == 0 else max(0.0, (self.value - float(self.lower_bound)) / self.value)


def shortest_in_order(regions: Sequence[Region]) -> Tour:
    """Return the shortest closed tour through regions in their order, by Clarabel.

    Raises
    ------
    ValueError
        When there is no region.
    """
    if not regions:
        raise ValueError("regions: expected at least one, got none")
    maps = [each.axes.T if isinstance(each, Ellipsoid) else each.vertices.T for each in regions]
    origins = np.array([each.centre if isinstance(each, Ellipsoid) else np.zeros(3) for each in regions])
    rows, right, cones = _model(regions, maps, origins)
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = PRECISION
    count, size = len(regions), rows.shape[1]
    costs = np.concatenate((np.ones(count), np.zeros(size - count)))
    solver = clarabel.DefaultSolver(sparse.csc_matrix((size, size)), costs, rows, right, cones, settings)
    solution = solver.solve()
    ends = [count, *accumulate((each.shape[1] for each in maps), initial=count)][1:]
    points = [
        origin + basis @ _inside(region, np.array(solution.x[start:end]))
        for region, basis, origin, start, end in zip(regions, maps, origins, ends, ends[1:], strict=False)
    ]
    places = np.array(points)
    u = -np.array(solution.z[: 4 * count]).reshape(count, 4)[:, 1:]
    value = float(np.linalg.norm(places - np.roll(places, 1, axis=0), axis=1).sum())
    return Tour(places, u, value, exact_bound(regions, u))


def _model(
    regions: Sequence[Region], maps: Sequence[Floats], origins: Floats
) -> tuple[sparse.csc_matrix, Floats, list[object]]:
    """Return rows, right side and cones of (P): right - rows (t, x) in the cones, legs first."""
    count = len(regions)
    starts = list(accumulate((each.shape[1] for each in maps), initial=count))
    size = starts[-1]
    blocks, right, cones = [], [], []
    for k in range(count):
        after = (k + 1) % count
        block = sparse.lil_matrix((4, size))
        block[0, k] = -1.0
        if after != k:
            block[1:, starts[k] : starts[k + 1]] = maps[k]
            block[1:, starts[after] : starts[after + 1]] = -maps[after]
        blocks.append(block)
        right.append(np.concatenate(([0.0], origins[after] - origins[k])))
        cones.append(clarabel.SecondOrderConeT(4))
    for k, region in enumerate(regions):
        own = sparse.eye(size, format="csr")[starts[k] : starts[k + 1]]
        width = own.shape[0]
        if isinstance(region, Ellipsoid):
            blocks.append(sparse.vstack((sparse.csr_matrix((1, size)), -own)))
            right.append(np.concatenate(([1.0], np.zeros(width))))
            cones.append(clarabel.SecondOrderConeT(width + 1))
        else:
            blocks += [sparse.csr_matrix(own.sum(axis=0)), -own]
            right += [np.ones(1), np.zeros(width)]
            cones += [clarabel.ZeroConeT(1), clarabel.NonnegativeConeT(width)]
    return sparse.csc_matrix(sparse.vstack(blocks)), np.concatenate(right), cones


def _inside(region: Region, x: Floats) -> Floats:
    """Return coordinates moved by a hair, so that they are those of a point of the region."""
    if isinstance(region, Ellipsoid):
        return x * (1.0 - HAIR) / max(1.0, float(np.linalg.norm(x)))
    weights = np.maximum(x, 0.0)
    return weights / weights.sum() if weights.sum() > 0 else np.full(len(x), 1.0 / len(x))


def dual_bound(regions: Sequence[Region], u: Floats) -> float:
    """Return the value of (D), a lower bound in mm on every such tour, in floating point.

    Holds for any ``u`` of shape (n, 3): rows are first scaled into the unit ball, so a solver's tolerance
    cannot make the bound invalid.
    """
    u = u / np.maximum(1.0, np.linalg.norm(u, axis=1, keepdims=True))
    s = np.roll(u, 1, axis=0) - u
    return float(sum(region.support_minimum(s[k : k + 1])[0] for k, region in enumerate(regions)))


def exact_bound(regions: Sequence[Region], u: Floats) -> Fraction:
    """Return the value of (D) for ``u``, shape (n, 3), rounded down in exact arithmetic; likewise for any u."""
    u = u * (1.0 - HAIR) / np.maximum(1.0, np.linalg.norm(u, axis=1, keepdims=True))
    integers = [int(each * SCALE) for each in u.ravel().tolist()]
    shapes = Regions([_fractions(region) for region in regions])
    return shapes.bound(range(len(regions)), [SCALE, *integers], Budget())


def _fractions(region: Region) -> tuple[list[tuple[Fraction, ...]], list[tuple[Fraction, ...]]]:
    """Return a region's points and axes as the fractions of their decimal texts."""
    if isinstance(region, Ellipsoid):
        return _decimals(region.centre[None]), _decimals(region.axes)
    return _decimals(region.vertices), []


def _decimals(rows: Floats) -> list[tuple[Fraction, ...]]:
    return [tuple(Fraction(repr(each)) for each in row) for row in rows.tolist()]
