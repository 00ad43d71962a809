r"""A closed tour through convex regions in any order, as one mixed-integer conic model, and its relaxation.

    Sets       v in V       regions R_v, at least 3
               e = {u, v}   edges between regions; (e, v) is their end at v, E(v) the edges at v
    Variables  y_e          1 if the tour takes the edge                           [-]
               z_ev         y_e times the point at which v is touched              [mm]
               d_e          step along the edge                                    [mm]
    Short      p_v = 1/2 sum over E(v) of z_ev, the touch point of v

    min sum_e |d_e|   s.t.
    (1) degree    sum over E(v) of y_e = 2                     each v
    (2) subtour   sum over e in delta(S) of y_e >= 2           each proper set S of at least 2 regions
    (3) step      d_e = z_eu - z_ev                            each e = {u, v}, u < v
    (4) inside    z_ev in y_e R_v                              each end
    (5) one point p_v - z_ev in (1 - y_e) R_v                  each end
    (6) y_e in {0, 1}; the relaxation takes 0 <= y_e <= 1

With whole y, (4) makes z_ev = 0 on edges that are not taken, and (5) makes z_ev = p_v on the two that are: so
p_v is one point of R_v and |d_e| a rapid. t R is the region scaled by t (its perspective): for an ellipsoid
{ t c + sum_i u_i a_i : |u| <= t }, for a hull { sum_j w_j v_j : w >= 0, sum w = t }.

Strength. Without (5) the bound is that of the tour problem whose lengths are the distances between regions. So
is the bound of the model with a direction for each edge and, instead of (5), "where a region is entered it is
left": turned round, a solution of its relaxation without this is one again, and the mean of the two keeps it.

Weak duality. For any vectors |w_e| <= 1 and g_ev, with h_v(g) = max of g.x over R_v,

    |d_e| >= w_e.d_e   and, by (5),   0 >= g_ev.(p_v - z_ev) - h_v(g_ev) (1 - y_e)

Add these up and sort by z_ev, for which (4) says a.z_ev >= y_e min of a.x over R_v:

    (7) a_ev = +-w_e + 1/2 (sum over E(v) of g_fv) - g_ev,   + at the end u < v of e, - at v
    (8) c_e  = sum over both ends of  min { a_ev.x : x in R_v } + h_v(g_ev)
    (9) length >= (shortest tour for the lengths c_e) - sum over all ends of h_v(g_ev)

For the tour problem in (9) there is the bound of 1-trees (Held and Karp). When w and g are the multipliers of
the relaxation, and pi_v is that of (1) plus those of (2) over the sets that hold v and not region 0, this bound
is the relaxation's value.

Sources: Marcucci, Umenberger, Parrilo, Tedrake (2024), "Shortest paths in graphs of convex sets"; Marcucci
(2025), "A unified and scalable method for optimization over graphs of convex sets", for tours and (5).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

import cvxpy as cp
import numpy as np

from cutgap.formulations.branch_and_cut.separation import Support, separate_subtours
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.region import Ellipsoid, Hull, Region

MOST_REGIONS = 30
"""Regions of the relaxation; their ends grow with the square, and with them the time."""
FLAT = 1e-7
"""What counts as zero in the solution of a model: share of an edge, or length in parts of the extent."""


@dataclass(frozen=True, slots=True)
class Prices:
    """Multipliers that prove a bound by (7) to (9).

    Attributes
    ----------
    steps
        w_e, shape (edges, 3), no dimension; edges in the order of ``edge_ends``.
    shifts
        g_ev, shape (2 * edges, 3), no dimension: the ends at the smaller region, then those at the larger one.
    potentials
        pi_v, shape (regions,), mm.
    """

    steps: Floats
    shifts: Floats
    potentials: Floats


@dataclass(frozen=True, slots=True)
class Relaxed:
    """The relaxation's solution: its value in mm as the solver has it, which is no proof, and its prices."""

    value: float
    taken: Floats
    touch: Floats
    prices: Prices


def edge_ends(regions: int) -> tuple[Ints, Ints]:
    """Return the smaller and the larger region of each edge."""
    tails, heads = np.triu_indices(regions, 1)
    return tails.astype(np.int64), heads.astype(np.int64)


class Cone:
    """Rows |vectors| <= bounds, as they are or by tangents  direction.vector <= bound, |direction| <= 1.

    Attributes
    ----------
    vectors, bounds
        Expressions of shape (rows, k) and (rows,).
    rows, directions
        The tangents so far: to which row each belongs, and its direction. At first those along the axes.
    """

    def __init__(self, vectors: cp.Expression, bounds: cp.Expression) -> None:
        self.vectors, self.bounds = vectors, bounds
        rows, axes = vectors.shape
        along = np.concatenate((np.eye(axes), -np.eye(axes)))
        self.rows: list[Ints] = [np.repeat(np.arange(rows), 2 * axes)]
        self.directions: list[Floats] = [np.tile(along, (rows, 1))]

    def exact(self) -> cp.Constraint:
        """Return the cone."""
        return cp.norm(self.vectors, 2, axis=1) <= self.bounds

    def add(self, rows: Ints, directions: Floats) -> None:
        """Add tangents, shortened to length 1 where they are longer."""
        norms = np.linalg.norm(directions, axis=1, keepdims=True)
        self.rows.append(rows)
        self.directions.append(directions / np.maximum(1.0, norms))

    def cut_off(self, at_least: float = FLAT) -> bool:
        """Add tangents at the solution, in rows that it breaks by more than this; False when there are none."""
        vectors = self.vectors.value
        norms = np.linalg.norm(vectors, axis=1)
        outside = np.flatnonzero((norms > FLAT) & (norms > self.bounds.value + at_least))
        self.add(outside, vectors[outside] / norms[outside, None])
        return len(outside) > 0

    def tangents(self) -> list[cp.Constraint]:
        """Return the tangents so far."""
        rows, directions = np.concatenate(self.rows), np.concatenate(self.directions)
        along = cp.multiply(directions, self.vectors[rows]) @ np.ones(directions.shape[1])
        return [along <= self.bounds[rows]]


class PerspectiveModel:
    """The variables, in units of ``size`` mm from ``origin``, and the constraints by family.

    Parameters
    ----------
    regions
        3 to ``MOST_REGIONS`` of them.
    whole
        Whether edges are taken or not, rather than in part.
    """

    def __init__(self, regions: Sequence[Region], *, whole: bool) -> None:
        self.count = len(regions)
        if not 3 <= self.count <= MOST_REGIONS:
            raise ValueError(
                f"perspective model: takes 3 to {MOST_REGIONS} regions (the home is one), got {self.count}"
            )
        self.origin, self.size = _frame(regions)
        self.regions = [_scaled(region, self.origin, self.size) for region in regions]
        self.tails, self.heads = edge_ends(self.count)
        edges = len(self.tails)
        self.owner = np.concatenate((self.tails, self.heads))
        self.at = (np.arange(self.count)[:, None] == self.owner).astype(float)
        self.taken = cp.Variable(edges, boolean=whole, name="y")
        self.ends = cp.Variable((2 * edges, 3), name="z")
        self.steps = cp.Variable((edges, 3), name="d")
        self.lengths = cp.Variable(edges, name="length")
        self.touch = 0.5 * self.at @ self.ends
        self.cone_of_steps = Cone(self.steps, self.lengths)
        self.cones_of: list[list[Cone]] = [[] for _ in regions]
        self.sets: list[frozenset[int]] = []
        self.subtours: list[cp.Constraint] = []
        taken_at_ends = cp.hstack([self.taken, self.taken])
        self.degree = self.at @ taken_at_ends == 2
        self.step = self.steps == self.ends[:edges] - self.ends[edges:]
        self.inside = self._in_regions(self.ends, taken_at_ends)
        self.one_point = self._in_regions(self.at.T @ self.touch - self.ends, 1 - taken_at_ends)
        self.linear = [self.degree, self.step, self.taken >= 0, self.taken <= 1]

    @property
    def cones(self) -> list[Cone]:
        """All cones."""
        return [self.cone_of_steps, *chain.from_iterable(self.cones_of)]

    def _in_regions(self, points: cp.Expression, scales: cp.Expression) -> list[list[cp.Constraint]]:
        """Return (4) or (5) for each region, but for its cone: its ends' points lie in ``scales`` times it."""
        families = []
        for number, region in enumerate(self.regions):
            ends = np.flatnonzero(self.owner == number)
            linear, cone = scaled_region(region, points[ends], scales[ends])
            families.append(linear)
            self.cones_of[number] += cone
        return families

    def add_subtour(self, members: frozenset[int]) -> None:
        """Add (2) for a set of regions."""
        inside = self.at[sorted(members)].sum(axis=0).reshape(2, -1)
        self.sets.append(members)
        self.subtours.append(cp.sum(self.taken[inside[0] != inside[1]]) >= 2)

    def add_broken_subtours(self) -> bool:
        """Add (2) for sets where the solution breaks it; False when there are none."""
        taken = np.clip(self.taken.value, 0.0, 1.0)
        used = taken > FLAT
        support = Support(self.count, self.tails[used], self.heads[used], taken[used])
        broken = separate_subtours(support)
        for cut in broken:
            self.add_subtour(cut.sets[0])
        return bool(broken)

    def edge(self, u: int, v: int) -> int:
        """Return the number of the edge between two regions."""
        return int(np.flatnonzero((self.tails == min(u, v)) & (self.heads == max(u, v)))[0])

    def order(self) -> list[int] | None:
        """Return the regions in the order of the tour that the solution takes; ``None`` when it is no tour."""
        chosen = self.taken.value > 0.5
        neighbours: list[list[int]] = [[] for _ in self.regions]
        for u, v in zip(self.tails[chosen].tolist(), self.heads[chosen].tolist(), strict=True):
            neighbours[u].append(v)
            neighbours[v].append(u)
        if any(len(each) != 2 for each in neighbours):
            return None
        order = [0]
        while (following := next((v for v in neighbours[order[-1]] if v not in order), None)) is not None:
            order.append(following)
        return order if len(order) == self.count else None

    def problem(self, *, conic: bool) -> cp.Problem:
        """Return the problem with the subtour constraints so far and cones or their tangents so far."""
        families = [self.linear, self.subtours, *self.inside, *self.one_point]
        families += [[cone.exact()] if conic else cone.tangents() for cone in self.cones]
        return cp.Problem(cp.Minimize(cp.sum(self.lengths)), list(chain.from_iterable(families)))


def scaled_region(
    region: Region, points: cp.Expression, scales: cp.Expression
) -> tuple[list[cp.Constraint], list[Cone]]:
    """Return that each row of ``points`` is in ``scales`` times the region; the first constraint places it."""
    count = points.shape[0]
    if isinstance(region, Hull):
        shares = cp.Variable((count, len(region.vertices)))
        whole = shares @ np.ones(len(region.vertices)) == scales
        return [points == shares @ region.vertices, shares >= 0, whole], []
    weights = cp.Variable((count, len(region.axes)))
    return [points == cp.outer(scales, region.centre) + weights @ region.axes], [Cone(weights, scales)]


def relax_perspective(regions: Sequence[Region]) -> Relaxed:
    """Solve the relaxation, with subtour constraints in rounds until none is broken.

    Parameters
    ----------
    regions
        3 to ``MOST_REGIONS`` of them; a home is the region of one point.

    Raises
    ------
    ValueError
        When there are too few or too many regions.
    """
    model = PerspectiveModel(regions, whole=False)
    solve_relaxation(model)
    return relaxed_solution(model)


def solve_relaxation(model: PerspectiveModel) -> None:
    """Solve the relaxation; the subtour constraints that it needs stay in the model."""
    model.problem(conic=True).solve(solver=cp.CLARABEL)
    while model.add_broken_subtours():
        model.problem(conic=True).solve(solver=cp.CLARABEL)


def relaxed_solution(model: PerspectiveModel) -> Relaxed:
    """Return solution and multipliers of a solved relaxation; those of equations have cvxpy's sign."""
    shifts = np.zeros((len(model.owner), 3))
    for region, (placed, *_) in enumerate(model.one_point):
        shifts[model.owner == region] = placed.dual_value
    potentials = -np.array(model.degree.dual_value)
    for members, constraint in zip(model.sets, model.subtours, strict=True):
        # A set and its complement have one cut; pi asks for the one without region 0.
        inside = members if 0 not in members else frozenset(range(model.count)) - members
        potentials[sorted(inside)] += float(constraint.dual_value)
    # Seen from elsewhere, c_e is larger by what its two regions' shifts say of the way there.
    potentials = potentials * model.size + 0.5 * (model.at @ shifts) @ model.origin
    prices = Prices(-np.array(model.step.dual_value), shifts, potentials)
    touch = model.origin + model.size * model.touch.value
    return Relaxed(float(model.lengths.value.sum()) * model.size, np.array(model.taken.value), touch, prices)


def priced_lengths(regions: Sequence[Region], prices: Prices) -> tuple[Floats, float]:
    """Return c_e of (8), shape (edges,), and the constant of (9), in mm, in floating point."""
    tails, heads = edge_ends(len(regions))
    owner = np.concatenate((tails, heads))
    at = (np.arange(len(regions))[:, None] == owner).astype(float)
    steps = prices.steps / np.maximum(1.0, np.linalg.norm(prices.steps, axis=1, keepdims=True))
    tilts = np.concatenate((steps, -steps)) + 0.5 * at.T @ (at @ prices.shifts) - prices.shifts
    least, most = np.zeros(len(owner)), np.zeros(len(owner))
    for number, region in enumerate(regions):
        ends = owner == number
        least[ends] = region.support_minimum(tilts[ends])
        most[ends] = -region.support_minimum(-prices.shifts[ends])
    costs = (least + most).reshape(2, -1).sum(axis=0)
    return costs, float(most.sum())


def _frame(regions: Sequence[Region]) -> tuple[Floats, float]:
    """Return the middle of the regions and their extent, mm."""
    directions = np.concatenate((np.eye(3), -np.eye(3)))
    reach = np.array([region.support_minimum(directions) for region in regions]).min(axis=0)
    low, high = reach[:3], -reach[3:]
    return (low + high) / 2, float(max(1e-9, (high - low).max()))


def _scaled(region: Region, origin: Floats, size: float) -> Region:
    if isinstance(region, Ellipsoid):
        return Ellipsoid((region.centre - origin) / size, region.axes / size)
    return Hull((region.vertices - origin) / size)
