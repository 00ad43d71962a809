r"""Contours joined by links, strokes joined by rapids: the problem written down whole, in cvxpy.

    Sets       i, k in C          contours, n in all; V(i) entry points (nodes) of i, C(u) the contour of a node
               E                  links: pairs of nodes u < v of different contours, clear of material
               rapids             (home, v), (u, home), and (u, v) with C(u) != C(v)
    Data       c_e, c_uv          travel: length of a link, of a rapid                                   [mm]
                                  makespan: the same divided by v_cut, by v_jump                         [s]
               t, W               makespan: t_aux and sum(perimeter) / v_cut                             [s]
    Variables  y_e, w_e in 0, 1   the link is passed; it is passed again
               x_uv in 0, 1       the head goes by a rapid from u to v
               g_u in 0, 1, ...   half the number of passes and rapids that end at u
               a_ik in 0, 1       contour i is cut in the stroke that starts at contour k
               f_ij in 0 .. n     contours that are reached by the way from i to j (-1: the home)

    s_u = sum_v x_vu (a stroke starts at u),  e_u = sum_v x_uv (it ends there)

    min  sum c_e (y_e + w_e) + sum c_uv x_uv  for travel; for makespan a variable of which
    (makespan)         makespan - sum c_e (y_e + w_e) - sum c_uv x_uv - t sum_u s_u >= W
    (even u)           sum over e at u of (y_e + w_e) + s_u + e_u - 2 g_u = 0
    (again u v)        y_e - w_e >= 0
    (leave), (return)  sum_v x_home,v = 1,  sum_u x_u,home = 1
    (leader k)         sum of s_u over V(k) - a_kk = 0
    (member i)         sum_k a_ik = 1
    (follows i k)      a_kk - a_ik >= 0                                                  i != k
    (together u v k)   a_C(v),k - a_C(u),k - y_e >= -1, and with v, u in place of u, v
    (reach j)          sum_i f_ij - sum_i f_ji = 1
    (carry i j)        n (sum of x from i to j + sum of y between i and j) - f_ij >= 0
    (pierces)          -sum_u s_u >= -limit                                              with a limit

One stroke a group, exactly: by (together) linked contours have one leader, and a contour at which a stroke
starts leads itself, so a group has one start at most; (leader), (member) and (follows) make it one at least. By
(even) starts and ends of a group are even in number, so it has an end, and in all there are as many ends as
starts: it has one. So the rapids are cycles through the groups and the home, and (reach) leaves one cycle.

Without (leader) to (together) a group may have several strokes: a relaxation. Precedence is refused, as it asks
in which order the pieces of a stroke are cut. Bounds hold for the entry points that are given.

Source: an even connected multigraph, as in the rural postman problem; (reach) as Gavish, Graves (1978).
"""

import time
from dataclasses import dataclass

import cvxpy as cp
import numpy as np
from scipy.sparse import csr_array

from cutgap.formulations.compact.family import Family, family
from cutgap.formulations.compact.network import Network, contours_of_nodes, networks_of
from cutgap.formulations.compact.programme import Programme
from cutgap.formulations.compact.relaxing import Size, reason_of, size_of
from cutgap.formulations.compact.solvers import AGREEMENT, Outcome, require_solver, run
from cutgap.instances import Instance, Link, Plan, Result, Rules, Visit, conclude, evaluate
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.check import require_coordinates
from cutgap.instances.links.clearance import blocked
from cutgap.instances.links.strokes import groups

METHOD = "links model"

MOST_NODES = 400
"""Largest number of entry points: links and rapids grow with its square."""


@dataclass(frozen=True, eq=False)
class LinkVariables:
    """The variables, and what links are.

    Attributes
    ----------
    ends
        Shape (links, 2): the nodes that each link joins.
    at_nodes
        Which links end at each entry point, shape (entry points, links).
    """

    network: Network
    ends: Ints
    at_nodes: csr_array
    passed: cp.Variable
    again: cp.Variable
    rapid: cp.Variable
    half: cp.Variable
    leads: cp.Variable
    flow: cp.Variable

    @property
    def contours(self) -> int:
        """Number of contours, n."""
        return self.network.pairs.contours

    @property
    def names(self) -> list[tuple[int, int]]:
        """The links by their nodes."""
        return [(u, v) for u, v in self.ends.tolist()]

    @property
    def starts(self) -> cp.Expression:
        """Vector s of strokes that start at each entry point."""
        return self.network.into @ self.rapid


@dataclass(frozen=True)
class LinksModel:
    """The problem as one programme; build it with ``links_model``."""

    instance: Instance
    rules: Rules

    def programme(self, *, integer: bool = False) -> Programme:
        """Return the model in cvxpy, or its relaxation."""
        return assemble(self.rules, variables(self.instance, self.rules, integer=integer))

    def size(self) -> Size:
        """Return the size of the relaxation."""
        return size_of(self.programme()) if self.instance.contours else Size(0, 0, 0)

    def relax(self, solver: str = "HIGHS", *, time_limit: float | None = None) -> Outcome:
        """Solve the relaxation; ``safe_bound`` of the outcome bounds every plan, by the solver's word.

        Raises
        ------
        ValueError
            When the solver is not installed, or is not known to take a time limit.
        """
        require_solver(solver, integer=False)
        if not self.instance.contours:
            return Outcome("optimal", 0.0, 0.0)
        return run(self.programme().problem(), solver, time_limit, integer=False)

    def solve(self, solver: str = "HIGHS", *, time_limit: float | None = None) -> Result:
        """Solve the model; the bound is the solver's claim, without a certificate.

        The plan is decoded, evaluated and checked. Where the solver claims an optimum that is worth what its
        plan is, the plan's value is the bound.

        Raises
        ------
        ValueError
            As ``relax`` does.
        """
        begun = time.perf_counter()
        require_solver(solver, integer=True)
        if not self.instance.contours:
            return conclude(self.instance, self.rules, Plan(((),)), method=METHOD, seconds=0.0, lower_bound=0.0)
        given = variables(self.instance, self.rules, integer=True)
        outcome = run(assemble(self.rules, given).problem(), solver, time_limit, integer=True)
        plan = plan_of(self.instance, given) if outcome.value is not None else None
        infeasible = outcome.state == "infeasible"
        return conclude(
            self.instance,
            self.rules,
            plan,
            method=METHOD,
            seconds=time.perf_counter() - begun,
            lower_bound=None if infeasible else self._bound(plan, outcome),
            infeasible=infeasible,
            reason=None if outcome.state == "optimal" else reason_of(outcome, solver),
        )

    def _bound(self, plan: Plan | None, outcome: Outcome) -> float | None:
        if plan is None or outcome.value is None:
            return outcome.safe_bound(0.0)
        value = evaluate(self.instance, plan).objective(self.rules)
        if outcome.state == "optimal" and abs(value - outcome.value) <= AGREEMENT * max(1.0, abs(value)):
            return value
        bound = outcome.safe_bound(0.0)
        return None if bound is None else min(bound, value)


def links_model(instance: Instance, rules: Rules) -> LinksModel:
    """Return the model of a problem with links.

    Raises
    ------
    ValueError
        When the rules take no links or do not go with them, the instance has precedence pairs, more than
        ``MOST_NODES`` entry points, or curves that links cannot be judged by.
    """
    name = f"instance {instance.name!r}, {METHOD}"
    if not rules.links:
        raise ValueError(f"{name}: needs rules with links")
    require_coordinates(instance, rules)
    if instance.precedence:
        raise ValueError(f"{name}: does not take precedence pairs")
    nodes = int(instance.first_node[-1])
    if nodes > MOST_NODES:
        raise ValueError(f"{name}: {nodes} entry points are too many, the most is {MOST_NODES}")
    return LinksModel(instance, rules)


def variables(instance: Instance, rules: Rules, *, integer: bool) -> LinkVariables:
    """Build the variables; without ``integer`` they are those of the relaxation."""
    (network,) = networks_of(instance, rules)
    of = contours_of_nodes(instance)
    nodes, contours = int(instance.first_node[-1]), len(instance.contours)
    u, v = np.nonzero(np.triu(of[:nodes, None] != of[:nodes]))
    clear = ~blocked(instance, u, v)
    ends = np.column_stack((u, v))[clear].astype(np.int64)
    count = len(ends)
    at_nodes = csr_array((np.ones(2 * count), (ends.T.ravel(), np.tile(np.arange(count), 2))), (nodes, count))
    # Not as ``boolean``, which cvxpy does not take without any links.
    outward = network.pairs.end.start
    return LinkVariables(
        network,
        ends,
        at_nodes,
        passed=cp.Variable(count, name="y", integer=integer, bounds=[0, 1]),
        again=cp.Variable(count, name="w", integer=integer, bounds=[0, 1]),
        rapid=cp.Variable(len(network.tails), name="x", integer=integer, bounds=[0, 1]),
        half=cp.Variable(nodes, name="g", integer=integer, bounds=[0, np.inf]),
        leads=cp.Variable((contours, contours), name="a", integer=integer, bounds=[0, 1]),
        flow=cp.Variable(outward, name="f", bounds=[0, contours]),
    )


# See ``compact.programme.assemble``: the warning comes from cvxpy's sums of any model.
@np.errstate(invalid="ignore")
def assemble(rules: Rules, given: LinkVariables) -> Programme:
    """Put variables, families and objective together."""
    families = [*even(given), *again(given), *leave_and_return(given)]
    families += [*leader(given), *member(given), *follows(given), *together(given)]
    families += [*reach(given), *carry(given)]
    if rules.pierces is not None:
        families += pierces(given, rules.pierces)
    if rules.objective == "travel":
        machine_free = lengths(given)
        return Programme((), tuple(families), machine_free[0] + machine_free[1])
    latest = cp.Variable(name="makespan", nonneg=True)
    return Programme((), (*families, *makespan(latest, given)), latest)


def lengths(given: LinkVariables) -> tuple[cp.Expression, cp.Expression]:
    """Return the length of all passes and of all rapids, mm."""
    points = given.network.instance.points
    links = np.linalg.norm(points[given.ends[:, 0]] - points[given.ends[:, 1]], axis=1)
    return links @ (given.passed + given.again), given.network.lengths @ given.rapid


def makespan(latest: cp.Variable, given: LinkVariables) -> list[Family]:
    """The makespan is no less than the time of the head."""
    instance = given.network.instance
    machine, (cut, jumped) = instance.machine, lengths(given)
    lit = machine.t_aux * cp.sum(given.starts)
    moving = cut / machine.v_cut + jumped / machine.v_jump + lit
    least = float(instance.perimeters.sum()) / machine.v_cut
    return [family("makespan", (), [()], cp.reshape(latest - moving, (1,), order="C") >= least)]


def even(given: LinkVariables) -> list[Family]:
    """An even number of passes and rapids ends at each entry point."""
    network = given.network
    rapids = (network.into + network.out_of) @ given.rapid
    passes = given.at_nodes @ (given.passed + given.again)
    return [family("even", (), range(given.half.size), passes + rapids - 2 * given.half == 0)]


def again(given: LinkVariables) -> list[Family]:
    """What is passed again is passed."""
    return [family("again", (), given.names, given.passed - given.again >= 0)]


def leave_and_return(given: LinkVariables) -> list[Family]:
    """The head leaves its home once and returns once."""
    pairs, ways = given.network.pairs, given.network.to_pairs @ given.rapid
    return [
        family(name, (), [()], cp.reshape(cp.sum(ways[which]), (1,), order="C") == 1)
        for name, which in (("leave", pairs.begin), ("return", pairs.end))
    ]


def leader(given: LinkVariables) -> list[Family]:
    """A stroke starts at the contours that lead themselves."""
    of, n = given.network.contour_of, given.contours
    nodes = given.half.size
    of_contours = csr_array((np.ones(nodes), (of[:nodes], np.arange(nodes))), (n, nodes))
    return [family("leader", (), range(n), of_contours @ given.starts - given.leads[range(n), range(n)] == 0)]


def member(given: LinkVariables) -> list[Family]:
    """Each contour has one leader."""
    return [family("member", (), range(given.contours), cp.sum(given.leads, axis=1) == 1)]


def follows(given: LinkVariables) -> list[Family]:
    """Whoever leads another leads itself."""
    i, k = np.nonzero(~np.eye(given.contours, dtype=np.bool_))
    names = list(zip(i.tolist(), k.tolist(), strict=True))
    return [family("follows", (), names, given.leads[k, k] - given.leads[i, k] >= 0)] if names else []


def together(given: LinkVariables) -> list[Family]:
    """Contours that a link joins have the same leader."""
    n, of = given.contours, given.network.contour_of
    links, k = np.divmod(np.arange(len(given.ends) * n), n)
    found = []
    for ends in (given.ends, given.ends[:, ::-1]) if len(links) else ():
        u, v = ends[links].T
        left = given.leads[of[v], k] - given.leads[of[u], k] - given.passed[links]
        names = list(zip(u.tolist(), v.tolist(), k.tolist(), strict=True))
        found.append(family("together", (), names, left >= -1))
    return found


def reach(given: LinkVariables) -> list[Family]:
    """Of what flows from the home each contour keeps one unit."""
    pairs = given.network.pairs
    kept = (pairs.into - pairs.out_of)[:, : pairs.end.start]
    return [family("reach", (), range(given.contours), kept @ given.flow == 1)]


def carry(given: LinkVariables) -> list[Family]:
    """It flows along rapids, and along links both ways."""
    network, n = given.network, given.contours
    pairs, outward = network.pairs, slice(0, network.pairs.end.start)
    one, other = network.contour_of[given.ends].T.tolist()
    both = [[pairs.index[i, j] for i, j in zip(*ways, strict=True)] for ways in ((one, other), (other, one))]
    count = len(given.ends)
    places = np.concatenate(both).astype(np.int64), np.tile(np.arange(count), 2)
    between = csr_array((np.ones(2 * count), places), (outward.stop, count))
    ways = network.to_pairs[outward] @ given.rapid + between @ given.passed
    return [family("carry", (), pairs.names[outward], n * ways - given.flow >= 0)]


def pierces(given: LinkVariables, limit: int) -> list[Family]:
    """No more strokes than asked for."""
    return [family("pierces", (), [()], cp.reshape(-cp.sum(given.starts), (1,), order="C") >= -limit)]


def plan_of(instance: Instance, given: LinkVariables) -> Plan | None:
    """Return the plan of a solved programme; ``None`` when its rapids are no way through all groups."""
    passed, again_, rapid = (_whole(each) for each in (given.passed, given.again, given.rapid))
    of, network = given.network.contour_of, given.network

    def visit(node: int) -> Visit:
        return Visit(int(of[node]), node - int(instance.first_node[of[node]]))

    ends = given.ends.tolist()
    chosen = np.flatnonzero(passed)
    links = tuple(Link(*visit(ends[e][0])[:2], *visit(ends[e][1])[:2], 1 + int(again_[e])) for e in chosen)
    leaders = [*groups(instance, links), -1]  # the home, of contour -1, is a group of its own
    legs = np.flatnonzero(rapid)
    start_after = {leaders[of[network.tails[leg]]]: int(network.heads[leg]) for leg in legs}
    tour: list[Visit] = []
    group = -1
    while group in start_after and len(tour) <= len(instance.contours):
        start = start_after.pop(group)
        group = leaders[of[start]]
        if group == -1:
            return Plan((tuple(tour),), links)
        tour.append(visit(start))
    return None


def _whole(variable: cp.Variable) -> Floats:
    return np.rint(np.asarray(variable.value))
