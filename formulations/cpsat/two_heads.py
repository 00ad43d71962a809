r"""Two heads in one CP-SAT model: who cuts what and both tours at once, on integers.

    Sets       i, j in 0..N-1 holes, a in {0, 1} heads, node N of head a its home, if it has one
    Data       c_ij   floor of ``scale`` times the rapid length from i to j                 [mm / scale]
               w_i    floor of ``scale`` times v_jump times the service time of hole i      [mm / scale]
               x_i    place of hole i                                                       [mm]
               p / q  at most weight / v_jump, in integers                                  [-]
               K      what all roundings of one plan come to at most                        [mm / scale]
    Variables  z_i    hole i is cut by head 0; z^0_i = z_i, z^1_i = not z_i                 [-]
               y^a_ij head a goes from i to j                                               [-]
               r_a    head a stays without work                                             [-]
               s^a_i  head a, without a home, cuts hole i alone                             [-]
               m, d   makespan and imbalance times v_jump, from 0 up                        [mm / scale]
               T_a    = sum c_ij y^a_ij + sum w_i z^a_i

    min  m   or   q sum c_ij y^a_ij + p d
    (circuit a)      the arcs y^a form one circuit; hole i is off it when not z^a_i or s^a_i, the home when r_a
    (rest a)         r_a  =>  not z^a_i,   and not r_a unless heads may rest
    (closed a)       without a home: s^a_i  =>  z^a_i and not z^a_j for j other than i
    (makespan a)     m >= T_a
    (imbalance s)    d >= s (T_0 - T_1) - K             s = +1, -1
    (balance s)      s (T_0 - T_1) <= limit
    (order i j)      z_j  =>  z_i                       whenever x_i - x_j < least gap
    (via a i)        z^a_i  =>  y^a_Nj for some j with x_j <= x_i

All data are rounded down, so the value of each plan here is at most its true one, times ``scale``: a lower
bound here bounds the true problem. T_0 - T_1 moves by at most K, so (imbalance) gives K away and (balance)
takes the limit rounded up, plus K. A plan then may break the true limit by a hair; ``tight`` asks for the limit
less K instead, which only plans are taken from.

A circuit may be empty. A head without a home may start its closed tour anywhere, so (via) costs it nothing.

Source: the 2TSP of Wang et al. (2025); self loops for optional nodes as CP-SAT documents them.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

import numpy as np
from ortools.sat.python import cp_model

from cutgap.instances import Instance, Rules
from cutgap.instances.arrays import Floats, difference
from cutgap.instances.check import TOLERANCE

LARGEST = 10**12
"""The scale is the largest power of ten at which the sum of all work and long rapids stays below this."""

DENOMINATOR = 1000
"""Largest denominator of p / q."""

Orders = tuple[tuple[int, ...], tuple[int, ...]]
Literal = cp_model.LiteralT


@dataclass(frozen=True, slots=True)
class Integers:
    """The model's data; a head's lengths include its home, if any, as the last node."""

    scale: float
    holes: int
    lengths: tuple[list[list[int]], list[list[int]]]
    work: list[int]
    xs: list[float]
    has_home: tuple[bool, bool]
    may_rest: bool
    gap: float | None
    via_points: bool
    makespan: bool
    price: tuple[int, int]
    slack: int
    balance: float | None

    def limit(self, *, tight: bool) -> int | None:
        """Return the limit of (balance), or what is left of it when no plan may break the true one."""
        if self.balance is None:
            return None
        tolerated = TOLERANCE * max(self.scale, float(sum(self.work)))
        if tight:
            return math.floor(self.balance) - self.slack
        return math.ceil(self.balance + tolerated) + self.slack


def integers_of(instance: Instance, rules: Rules) -> Integers:
    """Round an instance's data down at a scale that suits its size."""
    holes, speed = len(instance.contours), instance.machine.v_jump
    tables = (_lengths(instance, 0), _lengths(instance, 1))
    work = instance.service_times * speed
    most = float(work.sum()) + sum(float(table.max(axis=1).sum()) for table in tables if table.size)
    scale = 10.0 ** math.floor(math.log10(LARGEST / most)) if most > 0 else 1.0
    price = Fraction(rules.weight) / Fraction(speed)
    near = price.limit_denominator(DENOMINATOR)
    if near > price:
        near = Fraction(math.floor(price * DENOMINATOR), DENOMINATOR)
    lost = max((float((scale * table % 1.0).max()) for table in tables if table.size), default=0.0)
    first = tables[0]
    located = rules.via_points or rules.non_overlap is not None
    return Integers(
        scale=scale,
        holes=holes,
        lengths=(_floors(first * scale), _floors(tables[1] * scale)),
        work=np.floor(work * scale).astype(int).tolist(),
        xs=instance.points[:holes, 0].tolist() if located else [],
        has_home=(instance.home_node(0) is not None, instance.home_node(1) is not None),
        may_rest=rules.empty_heads or holes < 2,
        gap=rules.non_overlap,
        via_points=rules.via_points,
        makespan=rules.objective == "makespan",
        price=near.as_integer_ratio(),
        slack=math.ceil(float((scale * work % 1.0).sum()) + (holes + 2) * lost),
        balance=None if rules.balance is None else rules.balance * speed * scale,
    )


def _lengths(instance: Instance, head: int) -> Floats:
    home = instance.home_node(head)
    nodes = [instance.node(hole) for hole in range(len(instance.contours))]
    nodes += [] if home is None else [home]
    return instance.rapids[np.ix_(nodes, nodes)]


def _floors(table: Floats) -> list[list[int]]:
    rows: list[list[int]] = np.floor(table).astype(int).tolist()
    return rows


class TwoHeads:
    """The model above; ``arcs`` holds each head's arcs (from, to, literal) between holes and home."""

    def __init__(self, data: Integers, *, tight: bool = False) -> None:
        self.data, self.model = data, cp_model.CpModel()
        self.z = [self.model.new_bool_var(f"z{i}") for i in range(data.holes)]
        self.arcs: list[list[tuple[int, int, cp_model.IntVar]]] = []
        self.alone: list[list[cp_model.IntVar]] = [[], []]
        for head in (0, 1):
            if data.has_home[head]:
                self._circuit(head)
            else:
                self._closed_circuit(head)
        self._order()
        if data.via_points:
            self._via_points()
        self._times(data.limit(tight=tight))

    def _mine(self, head: int, hole: int) -> Literal:
        return self.z[hole] if head == 0 else self.z[hole].negated()

    def _hole_arcs(self, head: int, nodes: int) -> list[tuple[int, int, cp_model.IntVar]]:
        pairs = ((i, j) for i in range(nodes) for j in range(nodes) if i != j)
        return [(i, j, self.model.new_bool_var(f"y{head},{i},{j}")) for i, j in pairs]

    def _off_circuit(self, head: int) -> Iterator[tuple[int, int, Literal]]:
        return ((i, i, self._mine(1 - head, i)) for i in range(self.data.holes))

    def _circuit(self, head: int) -> None:
        """(circuit), (rest)."""
        home = self.data.holes
        arcs = self._hole_arcs(head, home + 1)
        self.arcs.append(arcs)
        loops: list[tuple[int, int, Literal]] = list(self._off_circuit(head))
        if self.data.may_rest:
            rest = self.model.new_bool_var(f"r{head}")
            loops.append((home, home, rest))
            for hole in range(home):
                self.model.add_implication(rest, self._mine(1 - head, hole))
        self.model.add_circuit([*arcs, *loops])

    def _closed_circuit(self, head: int) -> None:
        """(circuit), (rest), (closed)."""
        holes = self.data.holes
        arcs = self._hole_arcs(head, holes)
        self.arcs.append(arcs)
        self.alone[head] = [self.model.new_bool_var(f"s{head},{i}") for i in range(holes)]
        loops = []
        for hole, alone in enumerate(self.alone[head]):
            # A node has one loop, so the two reasons to be off the circuit are joined.
            off = self.model.new_bool_var(f"off{head},{hole}")
            loops.append((hole, hole, off))
            self.model.add_exactly_one(off.negated(), alone, self._mine(1 - head, hole))
            for other in range(holes):
                if other != hole:
                    self.model.add_implication(alone, self._mine(1 - head, other))
        self.model.add_circuit([*arcs, *loops])
        if not self.data.may_rest:
            self.model.add_bool_or([self._mine(head, hole) for hole in range(holes)])

    def _order(self) -> None:
        """(order)."""
        gap, xs = self.data.gap, self.data.xs
        if gap is None:
            return
        for i, left in enumerate(xs):
            for j, right in enumerate(xs):
                if i != j and difference(right, left) < gap:
                    self.model.add_implication(self.z[j], self.z[i])

    def _via_points(self) -> None:
        """(via)."""
        xs, home = self.data.xs, self.data.holes
        for head in (0, 1):
            starts = [(j, literal) for i, j, literal in self.arcs[head] if i == home]
            for hole, x in enumerate(xs if self.data.has_home[head] else ()):
                first = [literal for j, literal in starts if xs[j] <= x]
                self.model.add_bool_or([*first, self._mine(1 - head, hole)])

    def _times(self, limit: int | None) -> None:
        """Objective, (makespan), (imbalance), (balance)."""
        data, travel, times = self.data, [], []
        for head in (0, 1):
            lengths = data.lengths[head]
            travel.append(sum(lengths[i][j] * literal for i, j, literal in self.arcs[head]))
            mine = self.z if head == 0 else [1 - z for z in self.z]
            times.append(travel[head] + sum(w * z for w, z in zip(data.work, mine, strict=True)))
        most = sum(data.work) + sum(max(row) for table in data.lengths for row in table)
        difference = times[0] - times[1]
        if limit is not None:
            self.model.add_linear_constraint(difference, -limit, limit)
        if data.makespan:
            makespan = self.model.new_int_var(0, most, "m")
            for each in times:
                self.model.add(makespan >= each)
            self.model.minimize(makespan)
            return
        numerator, denominator = data.price
        imbalance = self.model.new_int_var(0, most, "d")
        self.model.add(imbalance >= difference - data.slack)
        self.model.add(imbalance >= -difference - data.slack)
        self.model.minimize(denominator * (travel[0] + travel[1]) + numerator * imbalance)

    def hint(self, orders: Sequence[Sequence[int]]) -> None:
        """Tell the solver of a plan."""
        for hole, z in enumerate(self.z):
            self.model.add_hint(z, int(hole in orders[0]))
        for order, arcs, has_home in zip(orders, self.arcs, self.data.has_home, strict=True):
            stops = [self.data.holes, *order, self.data.holes] if has_home else [*order, *order[:1]]
            used = set(pairwise(stops)) if order else set()
            for i, j, literal in arcs:
                self.model.add_hint(literal, int((i, j) in used))

    def orders(self, solution: cp_model.CpSolverSolutionCallback) -> Orders:
        """Return the tours of a solution."""
        return self._order_of(0, solution), self._order_of(1, solution)

    def _order_of(self, head: int, solution: cp_model.CpSolverSolutionCallback) -> tuple[int, ...]:
        following = {i: j for i, j, literal in self.arcs[head] if solution.boolean_value(literal)}
        if not following:
            single = [i for i, s in enumerate(self.alone[head]) if solution.boolean_value(s)]
            return tuple(single)
        # With home, from there; a closed tour from its leftmost hole.
        xs, home = self.data.xs, self.data.holes
        start = home if self.data.has_home[head] else min(following, key=lambda i: xs[i] if xs else i)
        order = [start]
        while following[order[-1]] != start:
            order.append(following[order[-1]])
        return tuple(order[1:] if start == home else order)
