r"""Heat by positions: what each start point has caught from what was cut before, for one head.

    Sets       positions b < t in 1 .. n; cells c of the lags between two positions, low_c <= lag <= high_c
    Data       T(L, t) the kernel, K, and L_vj the distance from entry point v to the curve of contour j
               (``instances.heat``); T_vjc = least T(L_vj, t) over t in cell c
    Variables  go[t,u,v]        0 .. 1: from u at position t to v at position t + 1, t = 1 .. n - 1
               lag[b,t,c]       0, 1: the lag from the end of position b to the start of position t is in c
               met[b,t,v,j,c]   0 .. 1: position t is at v, position b cuts j, lag in c;  b < t - 1, j != C(v)
               peak             ambient .. : the highest temperature of a start point, deg C
    Short      at[t,v] = sum_w go[t,v,w],   at[n,v] = sum_u go[n-1,u,v]
               D[b,t]  = sum_uv (l_uv / v) go[b,u,v] + sum_(b < s < t) sum_uv (w_C(u) + l_uv / v) go[s,u,v]

    (walk-begin v)       sum_w go[1,v,w] - first[v] = 0
    (walk-on t v)        sum_u go[t-1,u,v] - sum_w go[t,v,w] = 0                              t = 2 .. n - 1
    (walk-leg u v)       sum_t go[t,u,v] - x[u,v] = 0
    (lag-least b t)      D[b,t] - sum_c low_c lag[b,t,c] >= 0
    (lag-most b t)       -D[b,t] + sum_c high_c lag[b,t,c] >= 0
    (met-point b t v)    sum_jc met[b,t,v,j,c] - at[t,v] = 0
    (met-contour b t j)  sum_vc met[b,t,v,j,c] - sum_(u in V(j)) at[b,u] = 0
    (met-cell b t c)     sum_vj met[b,t,v,j,c] - lag[b,t,c] = 0
    (warm t)             peak - sum_uv T(L_v,C(u), l_uv / v) go[t-1,u,v] - sum_bvjc T_vjc met[b,t,v,j,c]
                         >= ambient                                                           t = 2 .. n
    (cap)                -peak >= -(cap + e)                      e = what ``check`` forgives

The lag of two visits in a row is their rapid, so what the one before gives is exact. go is 0 where that is
above the cap alone, and so is met. The rows are linear, without big-M. An infinite T, of a start on the curve
just cut and at once, stands at ``INFINITE``, which is less.

What is a relaxation of what. Let x and lag be whole. By (walk-begin) position 1 is where x begins; if position
t is at one point, (walk-leg) leaves it only the leg of x out of that point, along which (walk-on) goes on. So
go is the plan, at its positions, D its lags, lag a cell that holds each, and met, whose three sums are unit
vectors, is their product. Hence peak - ambient may be any number that is at least

    (1)  max_t  T(rapid before t) + sum over b < t - 1 of the least T over the cell of its lag   <=   max_t R_t

- The model is a relaxation: each plan within the cap is one of its points, at its own travel, with a peak no
  higher than its own. So its optimum, of travel under the cap or of the peak, bounds that of the summed rise.
- It is exact in the limit. Let w be the largest difference of T within a cell: (1) is at most (n - 2) w below
  max_t R_t, hence the bound on the peak at most that below the least peak. The bound on travel is the optimum
  once (n - 2) w is less than the excess over the cap of each plan that breaks it and is shorter. w tends to 0
  with the cells wherever T is continuous: everywhere but where a lag of 0 at distance 0 is possible.
- With n = 2 there is no met, and the model is exact.
- With the largest T over a cell in place of the least (``above``) it is a restriction: its plans keep the cap.
- lag in 0 .. 1 instead of 0 or 1 relaxes all this once more.

Source: Yang, Liu, Ju (2012) for the rise; Picard, Queyranne (1978) for the walk through positions.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import cvxpy as cp
import numpy as np
from scipy.sparse import csr_array, eye_array, kron

from cutgap.formulations.compact.family import Family, family
from cutgap.formulations.compact.network import DEPOT, Network, selection
from cutgap.formulations.compact.variables import HeadVariables
from cutgap.formulations.heat.plates import rise_limit
from cutgap.instances import Instance, Rules
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.heat import curve_distances, diffusivity, require_heat, rise

MOST_MEETINGS = 200_000
"""Largest number of variables met."""

LAG_CELLS = 8
"""Cells of the lags between two positions, unless the caller says otherwise."""

INFINITE = 1e6
"""What an infinite rise counts, K."""

ROUNDING = 1e-9
"""Cells reach so much further than lags, relatively, that rounding leaves no plan out."""


def between(network: Network) -> Ints:
    """Return the rapids between contours, as numbers of legs."""
    of = network.contour_of
    return np.flatnonzero((of[network.tails] != DEPOT) & (of[network.heads] != DEPOT) & ~network.closing)


class Walk:
    """The head's walk through positions.

    Attributes
    ----------
    legs, tails, heads
        Shape (legs,): the rapids between contours, and their nodes.
    rapids
        Their durations, s.
    warmth
        What their ends catch from the contours that they leave, K; 0 where that is above the cap.
    go
        Shape ((n - 1) legs,), by position, then leg.
    """

    def __init__(self, head: HeadVariables, limit: float) -> None:
        network = head.network
        self.head, self.instance, self.contour_of = head, network.instance, network.contour_of
        self.legs = between(network)
        self.tails, self.heads = network.tails[self.legs], network.heads[self.legs]
        self.rapids: Floats = network.lengths[self.legs] / self.instance.machine.v_jump
        near = curve_distances(self.instance)[self.heads, self.contour_of[self.tails]]
        warmth = np.minimum(rise(self.instance, near, self.rapids), INFINITE)
        may = warmth <= limit
        # What is 0 is not priced: huge numbers in rows cost digits.
        self.warmth: Floats = np.where(may, warmth, 0.0)
        most = np.tile(may.astype(np.float64), self.steps)
        self.go = cp.Variable(len(most), name="go", bounds=[0, most])

    @property
    def steps(self) -> int:
        """Number of steps from a position to the next, n - 1."""
        return len(self.instance.contours) - 1

    @property
    def points(self) -> int:
        """Number of entry points."""
        return int(self.instance.first_node[-1])

    def arrives(self) -> csr_array:
        """Return what comes to each position from 2 and point, shape ((n - 1) points, (n - 1) legs)."""
        return kron(eye_array(self.steps), selection(self.heads, self.points)).tocsr()

    def leaves(self) -> csr_array:
        """Return what leaves each position up to n - 1 and point, shape ((n - 1) points, (n - 1) legs)."""
        return kron(eye_array(self.steps), selection(self.tails, self.points)).tocsr()

    def lags(self, pairs: Ints) -> csr_array:
        """Return D for pairs of positions, shape (pairs, (n - 1) legs), s."""
        position = np.arange(1, self.steps + 1)
        first, last = pairs[:, :1], pairs[:, 1:]
        work = self.instance.service_times[self.contour_of[self.tails]]
        rapids = kron((position >= first) & (position < last), self.rapids[None, :])
        return csr_array(rapids + kron((position > first) & (position < last), work[None, :]))


def walk_begin(walk: Walk) -> list[Family]:
    """The walk begins where the tour does."""
    leaves = walk.leaves()[: walk.points] @ walk.go
    return [family("walk-begin", (), range(walk.points), leaves - walk.head.first == 0)]


def walk_on(walk: Walk) -> list[Family]:
    """What comes to a point at a position leaves it at that position."""
    names = [(t, v) for t in range(2, walk.steps + 1) for v in range(walk.points)]
    if not names:
        return []
    kept = walk.arrives()[: -walk.points] - walk.leaves()[walk.points :]
    return [family("walk-on", (), names, kept @ walk.go == 0)]


def walk_leg(walk: Walk) -> list[Family]:
    """Each leg of the tour is taken from one position."""
    taken = kron(np.ones((1, walk.steps)), eye_array(len(walk.legs))).tocsr() @ walk.go
    names = list(zip(walk.tails.tolist(), walk.heads.tolist(), strict=True))
    return [family("walk-leg", (), names, taken - walk.head.x[walk.legs] == 0)]


@dataclass(frozen=True, eq=False)
class Meetings:
    """Who may warm whom at which lags, for positions that are not in a row.

    Attributes
    ----------
    pairs
        Shape (pairs, 2): the positions b and t.
    edges
        Shape (pairs, cells + 1): low_c, then the last high_c, s.
    points, contours
        Shape (couples,): v and j.
    warmth
        Shape (pairs, couples, cells): T_vjc, K; 0 where that is above the cap.
    lag, met
        Shapes (pairs cells,) and (pairs couples cells,).
    """

    walk: Walk
    pairs: Ints
    edges: Floats
    points: Ints
    contours: Ints
    warmth: Floats
    lag: cp.Variable
    met: cp.Variable

    @cached_property
    def names(self) -> list[tuple[int, int]]:
        """The pairs (b, t)."""
        return [(int(b), int(t)) for b, t in self.pairs]

    def summed(self, couples: csr_array | Floats, cells: csr_array | Floats) -> cp.Expression:
        """Return sums of met within each pair of positions, by sums over couples and cells."""
        return kron(eye_array(len(self.pairs)), kron(couples, cells)).tocsr() @ self.met


def meetings_of(walk: Walk, cells: int, limit: float, *, integer: bool, above: bool) -> Meetings:
    """Build lag and met, with the most heat of each cell if ``above``, else the least."""
    instance, count = walk.instance, walk.steps + 1
    pairs = np.array([(b, t) for b, t in combinations(range(1, count + 1), 2) if t - b > 1], dtype=np.int64)
    points, contours = np.nonzero(walk.contour_of[: walk.points, None] != np.arange(count))
    size = len(pairs) * len(points) * cells
    if size > MOST_MEETINGS:
        raise ValueError(
            f"instance {instance.name!r}, compact model: heat by positions needs {size} variables with {cells} "
            f"cells of lags, the limit is {MOST_MEETINGS}; take fewer lag_cells, or the method heat"
        )
    edges = _edges(walk, pairs, cells)
    distances = curve_distances(instance)[points, contours]
    warmth = _envelope(instance, distances[:, None], edges[:, None, :], above=above)
    may = warmth <= limit
    shape = len(pairs) * cells
    lag = cp.Variable(shape, "lag", boolean=True) if integer else cp.Variable(shape, "lag", bounds=[0, 1])
    met = cp.Variable(size, name="met", bounds=[0, may.ravel().astype(np.float64)])
    return Meetings(walk, pairs, edges, points, contours, np.where(may, warmth, 0.0), lag, met)


def _edges(walk: Walk, pairs: Ints, cells: int) -> Floats:
    """Return the edges of cells, finer where lags are short and the kernel changes fast."""
    work, rapids, gaps = np.sort(walk.instance.service_times), np.sort(walk.rapids), pairs[:, 1] - pairs[:, 0]
    least = np.array([work[: gap - 1].sum() + gap * rapids[0] for gap in gaps])
    most = np.array([work[len(work) - gap + 1 :].sum() + gap * rapids[-1] for gap in gaps])
    slack = ROUNDING * np.maximum(1.0, most)
    roots = np.sqrt([np.maximum(0.0, least - slack), most + slack])
    return np.asarray(np.linspace(roots[0], roots[1], cells + 1, axis=1) ** 2, dtype=np.float64)


def _envelope(instance: Instance, distances: Floats, edges: Floats, *, above: bool) -> Floats:
    """Return the least T over each cell, or the most; T rises up to L^2 / (2 a) and falls after it."""
    low, high = edges[..., :-1], edges[..., 1:]
    if above:
        low = high = np.clip(distances**2 / (2.0 * diffusivity(instance)), low, high)
    least = np.minimum(rise(instance, distances, low), rise(instance, distances, high))
    return np.minimum(least, INFINITE)


def lag_cell(meetings: Meetings) -> list[Family]:
    """The lag is in the cell that is chosen for it."""
    lags = meetings.walk.lags(meetings.pairs) @ meetings.walk.go
    least, most = (_blocks(each) @ meetings.lag for each in (meetings.edges[:, :-1], meetings.edges[:, 1:]))
    return [
        family("lag-least", (), meetings.names, lags - least >= 0),
        family("lag-most", (), meetings.names, most - lags >= 0),
    ]


def met_point(meetings: Meetings) -> list[Family]:
    """Who is warmed at a position is the point where the head is."""
    walk = meetings.walk
    cells = np.ones((1, meetings.edges.shape[1] - 1))
    summed = meetings.summed(selection(meetings.points, walk.points), cells)
    rows = ((meetings.pairs[:, 1:] - 2) * walk.points + np.arange(walk.points)).ravel()
    names = [(*pair, v) for pair in meetings.names for v in range(walk.points)]
    return [family("met-point", (), names, summed - walk.arrives()[rows] @ walk.go == 0)]


def met_contour(meetings: Meetings) -> list[Family]:
    """What warms from a position is the contour that is cut there."""
    walk = meetings.walk
    count = walk.steps + 1
    summed = meetings.summed(selection(meetings.contours, count), np.ones((1, meetings.edges.shape[1] - 1)))
    cut = kron(eye_array(walk.steps), selection(walk.contour_of[walk.tails], count)).tocsr()
    rows = ((meetings.pairs[:, :1] - 1) * count + np.arange(count)).ravel()
    names = [(*pair, j) for pair in meetings.names for j in range(count)]
    return [family("met-contour", (), names, summed - cut[rows] @ walk.go == 0)]


def met_cell(meetings: Meetings) -> list[Family]:
    """At which lag it warms is the cell that is chosen."""
    cells = meetings.edges.shape[1] - 1
    summed = meetings.summed(np.ones((1, len(meetings.points))), eye_array(cells).tocsr())
    names = [(*pair, c) for pair in meetings.names for c in range(cells)]
    return [family("met-cell", (), names, summed - meetings.lag == 0)]


def warm(walk: Walk, meetings: Meetings | None, peak: cp.Variable, ambient_c: float) -> list[Family]:
    """No position is warmer than the peak."""
    caught = kron(eye_array(walk.steps), walk.warmth[None, :]).tocsr() @ walk.go
    if meetings is not None:
        parts = meetings.warmth.reshape(len(meetings.pairs), -1)
        caught += selection(meetings.pairs[:, 1] - 2, walk.steps) @ _blocks(parts) @ meetings.met
    return [family("warm", (), range(2, walk.steps + 2), peak - caught >= ambient_c)]


def cap(peak: cp.Variable, highest_c: float) -> list[Family]:
    """The peak is within the cap."""
    return [family("cap", (), [()], -cp.hstack([peak]) >= -highest_c)]


def heat(
    head: HeadVariables, rules: Rules, peak: cp.Variable, cells: int, *, integer: bool, above: bool
) -> Iterator[Family]:
    """Yield all families of one head."""
    instance = head.network.instance
    limit, ambient_c = rise_limit(instance, rules), require_heat(instance).ambient_c
    if np.isfinite(limit):
        yield from cap(peak, ambient_c + limit)
    # Without a way between contours there is nothing to be warmed, and from two contours on no plan.
    if not len(between(head.network)):
        return
    walk, meetings = Walk(head, limit), None
    for rows in (walk_begin, walk_on, walk_leg):
        yield from rows(walk)
    if head.way.contours > 2:
        meetings = meetings_of(walk, cells, limit, integer=integer, above=above)
        for tied in (lag_cell, met_point, met_contour, met_cell):
            yield from tied(meetings)
    yield from warm(walk, meetings, peak, ambient_c)


def _blocks(rows: Floats) -> csr_array:
    """Return the matrix whose row r holds ``rows[r]`` in the r-th block of columns, 0 elsewhere."""
    count, width = rows.shape
    places = np.repeat(np.arange(count), width)
    return csr_array((rows.ravel(), (places, np.arange(count * width))), shape=(count, count * width))
