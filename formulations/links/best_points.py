r"""The best link points of a plan whose topology is fixed (SOCP), and what no choice of points can beat.

Topology: which nodes are linked, where strokes start and end, on which edge of its curve each of these nodes
lies. Nodes are shared: links that meet at a point go on meeting there.

Sets       V          entry points that links or rapids of the plan end at; the home is a node that stays
           E          its links, w_e = passes * price of a cut, and its rapids, w_e = price of a rapid;
                      prices 1 for travel, 1 / v_cut and 1 / v_jump for makespan               [1 or s/mm]
Data       a_v, b_v   ends of the edge of node v (a_v = b_v for the home)                      [mm]
Variables  t_v        in 0 .. 1: p_v = a_v + t_v (b_v - a_v); heights are those of the given points
           u_e        multiplier of e = (v, v')                                                [1 or s/mm]

    (P)  min sum_e w_e |p_v' - p_v|
    (D)  max sum_v min(s_v . a_v, s_v . b_v)      s.t.  |u_e| <= w_e,  s_v = sum of u_e into v - sum out of v

(P) = (D), as for tours through regions (``relaxations.touring``); any u scaled into the balls proves a bound.
Pierces and outlines are a constant on top. The bound is for this topology alone, not for other plans.

Where links become blocked, their ends stay where they were, and the other points move.
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise

import cvxpy as cp
import numpy as np

from cutgap.formulations.relaxations.bound import float_below
from cutgap.formulations.scope import require_euclidean_links
from cutgap.instances import Instance, Plan, Rules, check, evaluate
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.links.clearance import Bools, blocked
from cutgap.instances.links.strokes import link_ends, strokes

PRECISION = 1e-11
"""Tolerances asked of the solver; what it reached shows in the distance of value and bound."""
SNAP = 1e-8
"""A point nearer to a corner than this part of its edge counts as the corner."""
STAY = 1e-8
"""Price of moving a point, relative to the heaviest weight; what it costs shows in the bound."""
SCALE = 10**15
"""Multipliers count as integers over this, times their weight."""
HAIR = 1e-14
"""Relative shrinking of multipliers that keeps them in their balls for certain."""
SLOPE = 1e-6
"""Relative slope that counts as downhill."""
LEAST_GAIN = 1e-10
"""Relative gain below which ``polish`` stops."""


@dataclass(frozen=True, slots=True)
class LinkPoints:
    """Improved link points.

    Attributes
    ----------
    instance
        With the moved entry points; numbers stay, so the plan is the same.
    value
        Of the plan on that instance, in ``rules.unit``.
    lower_bound
        No points on the same edges make the plan worth less; exact but for rounding down.
    multipliers
        u, shape (edges, 3).
    """

    instance: Instance
    plan: Plan
    value: float
    lower_bound: float
    multipliers: Floats


@dataclass(frozen=True, eq=False)
class Topology:
    """Data of (P).

    Attributes
    ----------
    nodes
        Shape (V,): numbers of the nodes, the home last.
    starts, ends
        Shape (V, 3), mm: a and b.
    shares
        Shape (V,): t of the points that are given.
    edges
        Shape (E, 2): places in ``nodes``.
    weights
        Shape (E,): w.
    constant
        What pierces and outlines add to the value.
    """

    nodes: Ints
    starts: Floats
    ends: Floats
    shares: Floats
    edges: Ints
    weights: Floats
    constant: Fraction

    def points(self, shares: Floats) -> Floats:
        """Return p, shape (V, 3)."""
        return self.starts + shares[:, None] * (self.ends - self.starts)


def best_link_points(instance: Instance, rules: Rules, plan: Plan) -> LinkPoints:
    """Return the best points on the edges that a plan's points lie on; of a corner's edges, the first.

    Raises
    ------
    ValueError
        When the plan breaks a rule, or the rules or the metric do not suit.
    """
    _require(instance, rules, plan)
    return _improve(instance, rules, plan, edges_of(instance, plan))


def polish(instance: Instance, rules: Rules, plan: Plan, *, most_rounds: int = 20) -> LinkPoints:
    """Alternate best points with moving corner points over to the neighbouring edge, while it pays.

    The bound is that of the last topology. Raises as ``best_link_points`` does.
    """
    _require(instance, rules, plan)
    edges = edges_of(instance, plan)
    found = _improve(instance, rules, plan, edges)
    for _ in range(most_rounds):
        others = _turned_edges(found.instance, rules, plan, edges)
        if others == edges:
            break
        after = _improve(found.instance, rules, plan, others)
        if after.value > found.value - LEAST_GAIN * max(1.0, found.value):
            break
        found, edges = after, others
    return found


def _require(instance: Instance, rules: Rules, plan: Plan) -> None:
    require_euclidean_links(instance, rules, "link points")
    broken = check(instance, rules, plan)
    if broken:
        raise ValueError(f"instance {instance.name!r}, link points: the plan breaks {broken[0].constraint}")


def _improve(instance: Instance, rules: Rules, plan: Plan, edges: dict[int, int]) -> LinkPoints:
    """Solve (P) and go as far towards its points as the rules allow."""
    topology = topology_of(instance, rules, plan, edges)
    before = evaluate(instance, plan).objective(rules)
    if not len(topology.edges):
        return LinkPoints(instance, plan, before, before, np.zeros((0, 3)))
    stays = np.zeros(len(topology.nodes), dtype=np.bool_)
    shares, multipliers = solve(topology, stays)
    bound = float_below(exact_bound(topology, multipliers) + topology.constant)
    while True:
        moved = moved_instance(instance, topology, shares)
        value = evaluate(moved, plan).objective(rules)
        if value >= before:
            return LinkPoints(instance, plan, before, min(bound, before), multipliers)
        if not check(moved, rules, plan):
            return LinkPoints(moved, plan, value, min(bound, value), multipliers)
        ends = topology.edges[: len(plan.links)]
        bad = ends[blocked(moved, *topology.nodes[ends].T)].ravel()
        # What breaks another rule, or is at fault for no move of its own, ends it.
        if not (~stays[bad]).any():
            bad = np.arange(len(stays))
        stays[bad] = True
        shares = solve(topology, stays)[0]


def topology_of(instance: Instance, rules: Rules, plan: Plan, edges: dict[int, int]) -> Topology:
    """Return the data of (P); ``edges`` says on which edge of its curve each node lies."""
    machine = instance.machine
    cut, jump = (1.0, 1.0) if rules.objective == "travel" else (1 / machine.v_cut, 1 / machine.v_jump)
    (made,), home = strokes(instance, plan), instance.home_node(0)
    assert home is not None  # rules with links ask for it
    ways = [*(each for stroke in made for each in (stroke.start, stroke.end))]
    rapids = list(pairwise([home, *ways, home]))[::2] if made else []
    pairs = [link_ends(instance, link) for link in plan.links] + rapids
    weights = np.array([link.passes * cut for link in plan.links] + [jump] * len(rapids))
    nodes = np.unique(np.array([*np.ravel(pairs), home], dtype=np.int64))
    starts, ends, shares = instance.points[nodes].copy(), instance.points[nodes].copy(), np.zeros(len(nodes))
    for place, node in enumerate(nodes[:-1].tolist()):
        point, curve = instance.points[node, :2], _curve(instance, node)
        a, b = curve[edges[node]], curve[(edges[node] + 1) % len(curve)]
        starts[place, :2], ends[place, :2] = a, b
        shares[place] = _share(point, a, b)
    constant = Fraction(0)
    if rules.objective == "makespan":
        perimeters = sum((Fraction(each) for each in instance.perimeters.tolist()), Fraction(0))
        constant = perimeters / Fraction(machine.v_cut) + len(made) * Fraction(machine.t_aux)
    places = np.searchsorted(nodes, np.array(pairs, dtype=np.int64).reshape(-1, 2))
    return Topology(nodes, starts, ends, shares, places, weights, constant)


def solve(topology: Topology, stays: Bools) -> tuple[Floats, Floats]:
    """Return t and u of (P), by Clarabel; some points may have to stay."""
    edges, count = topology.edges, len(topology.nodes)
    # A unit of the size of the sheet, so that the solver's tolerances are relative.
    unit = float(np.ptp(np.concatenate((topology.starts, topology.ends)), axis=0).max()) or 1.0
    origin, steps = topology.starts[-1], (topology.ends - topology.starts) / unit
    share, apart = cp.Variable(count), cp.Variable((len(edges), 3))
    places = (topology.starts - origin) / unit + cp.multiply(cp.reshape(share, (count, 1), order="C"), steps)
    ends = apart == places[edges[:, 1]] - places[edges[:, 0]]
    heaviest = float(topology.weights.max())
    cost = (topology.weights / heaviest) @ cp.norm(apart, axis=1)
    # Of points that are equally good the nearest ones: others may lie behind a part for nothing.
    cost += STAY * np.linalg.norm(steps, axis=1) @ cp.abs(share - topology.shares)
    least, most = (np.where(stays, topology.shares, end) for end in (0.0, 1.0))
    problem = cp.Problem(cp.Minimize(cost), [ends, share >= least, share <= most])
    precision = {name: PRECISION for name in ("tol_gap_abs", "tol_gap_rel", "tol_feas")}
    with warnings.catch_warnings():
        # How accurate a point is shows in its value and its bound.
        warnings.filterwarnings("ignore", message="Solution may be inaccurate", category=UserWarning)
        try:
            problem.solve(solver=cp.CLARABEL, max_threads=1, **precision)
        except cp.SolverError:
            return topology.shares, np.zeros((len(edges), 3))
    if share.value is None:
        return topology.shares, np.zeros((len(edges), 3))
    found = np.where(share.value < SNAP, 0.0, np.where(share.value > 1.0 - SNAP, 1.0, share.value))
    found = np.where(stays, topology.shares, found)
    return found, -heaviest * np.asarray(ends.dual_value)


def exact_bound(topology: Topology, u: Floats) -> Fraction:
    """Return the value of (D) in exact arithmetic, for any ``u`` of shape (edges, 3), scaled into its balls."""
    lengths = np.linalg.norm(u, axis=1) / topology.weights
    u = u * ((1.0 - HAIR) / np.maximum(1.0, lengths))[:, None]
    total = Fraction(0)
    into = [[Fraction(0)] * 3 for _ in topology.nodes]
    for (tail, head), weight, row in zip(
        topology.edges.tolist(), topology.weights.tolist(), u.tolist(), strict=True
    ):
        vector = [Fraction(int(each / weight * SCALE), SCALE) for each in row]
        # The hair keeps |u| <= w in spite of rounding; should it not, the edge counts for nothing.
        if sum(each**2 for each in vector) > 1:
            continue
        for axis, each in enumerate(vector):
            into[head][axis] += Fraction(weight) * each
            into[tail][axis] -= Fraction(weight) * each
    for s, a, b in zip(into, topology.starts.tolist(), topology.ends.tolist(), strict=True):
        total += min(_product(s, a), _product(s, b))
    return total


def _product(vector: Sequence[Fraction], point: Sequence[float]) -> Fraction:
    return sum((each * Fraction(x) for each, x in zip(vector, point, strict=True)), Fraction(0))


def moved_instance(instance: Instance, topology: Topology, shares: Floats) -> Instance:
    """Return the instance with the nodes of a topology at other places of their edges."""
    places, rows = topology.points(shares), instance.points.copy()
    moving = np.flatnonzero(shares != topology.shares)
    rows[topology.nodes[moving], :2] = places[moving, :2]
    first = instance.first_node.tolist()
    contours = tuple(
        replace(contour, entry_points=rows[begin:end])
        for contour, (begin, end) in zip(instance.contours, pairwise(first), strict=True)
    )
    return replace(instance, contours=contours)


def edges_of(instance: Instance, plan: Plan) -> dict[int, int]:
    """Return the edge of its curve that each entry point of the plan lies on."""
    made = [stroke for tour in strokes(instance, plan) for stroke in tour]
    nodes = {end for stroke in made for end in (stroke.start, stroke.end)}
    nodes |= {end for link in plan.links for end in link_ends(instance, link)}
    found = {}
    for node in sorted(nodes):
        point, curve = instance.points[node, :2], _curve(instance, node)
        ends = np.roll(curve, -1, axis=0)
        feet = [a + _share(point, a, b) * (b - a) for a, b in zip(curve, ends, strict=True)]
        found[node] = int(np.argmin(np.linalg.norm(np.array(feet) - point, axis=1)))
    return found


def _turned_edges(instance: Instance, rules: Rules, plan: Plan, edges: dict[int, int]) -> dict[int, int]:
    """Return the edges with those of corner points replaced by their neighbours where that way is downhill."""
    topology = topology_of(instance, rules, plan, edges)
    places, found = topology.points(topology.shares), dict(edges)
    for place, node in enumerate(topology.nodes[:-1].tolist()):
        share, curve = topology.shares[place], _curve(instance, node)
        if SNAP < share < 1.0 - SNAP:
            continue
        onward = 1 if share > 0.5 else -1
        edge = (edges[node] + onward) % len(curve)
        # Onward the corner is the start of the neighbouring edge, else its end.
        a, b = curve[edge], curve[(edge + 1) % len(curve)]
        way = onward * (b - a) / np.linalg.norm(b - a)
        if _slope(topology, places, place, np.append(way, 0.0)) < -SLOPE * topology.weights.max():
            found[node] = edge
    return found


def _slope(topology: Topology, places: Floats, place: int, way: Floats) -> float:
    """Return the directional derivative of (P) when one point moves along a unit vector."""
    slope = 0.0
    for (tail, head), weight in zip(topology.edges.tolist(), topology.weights.tolist(), strict=True):
        if place in (tail, head):
            apart = places[place] - places[tail + head - place]
            length = float(np.linalg.norm(apart))
            slope += weight * (float(apart @ way) / length if length > 0 else 1.0)
    return slope


def _share(point: Floats, a: Floats, b: Floats) -> float:
    """Return t of the place on the segment a b that is next to a point."""
    step = b - a
    square = float(step @ step)
    return min(max(float(step @ (point - a)) / square, 0.0), 1.0) if square > 0 else 0.0


def _curve(instance: Instance, node: int) -> Floats:
    curve = instance.contours[int(np.searchsorted(instance.first_node, node, side="right")) - 1].geometry
    assert curve is not None
    return curve
