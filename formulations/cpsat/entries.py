r"""One or two heads and entry points in one CP-SAT model: who cuts what, where and in which order, on integers.

    Sets       v, w    entry points; i = i(v), j = i(w), k contours; a heads
    Data       l_vw    floor of ``scale`` times the rapid length from v to w                 [mm / scale]
               c_vw    the same of the length and the price of going back                    [mm / scale]
               w_i     floor of ``scale`` times v_jump times the service time of contour i   [mm / scale]
               x_v     place of entry point v                                                [mm]
               p / q   at most weight / v_jump, in integers                                  [-]
               K       what all roundings of one plan come to at most                        [mm / scale]
               R_vw    contours that the rapid from v to w crosses, without i and j
    Variables  e^a_v   head a cuts contour i(v) at v                                         [-]
               z^a_i   head a cuts contour i; z^0_i = z_i, z^1_i = not z_i; one head: true   [-]
               y^a_vw  head a goes from v to w                                               [-]
               f^a_v, g^a_v   head a starts with v, ends with v                              [-]
               n^a_ij  head a goes from contour i to contour j                               [-]
               h^a_vw  head a, without a home, closes its tour from v to w                   [-]
               r_a     head a stays without work                                             [-]
               b_ij    i comes before j, when one head cuts both; b_ji = not b_ij            [-]
               o_i     place of i in an order that agrees with b, in 0..N-1                  [-]
               u_ik    the rapid that follows i crosses k                                    [-]
               t_i     when contour i is done, times v_jump (two heads)                      [mm / scale]
               m, d    makespan and imbalance times v_jump, from 0 up                        [mm / scale]
               L_a     = sum l_vw y^a_vw + ways from and to the home, or the closing leg;  C_a with c for l
               T_a     = L_a + sum w_i z^a_i

    min  m   or   q sum_a C_a + p d
    (once a i)        exactly one of not z^a_i and e^a_v for v of i
    (circuit a)       the arcs y^a, f^a from a depot and g^a to it form one circuit, which is off v when not
                      e^a_v and off the depot when r_a
    (contours a)      n^a_ij = sum of the y^a_vw from i to j, and so for f^a, g^a: they form one circuit too,
                      which is off i when not z^a_i. Implied, but its cuts close most of the gap
    (rest a)          r_a  =>  not e^a_v,   and not r_a unless heads may rest
    (closing a)       without a home: sum_w h^a_vw = g^a_v,  sum_v h^a_vw = f^a_w
    (start a)         without a home, where it does not matter: f^a_v  =>  not z^a_j for j before i
    (makespan a)      m >= T_a
    (imbalance s)     d >= s (T_0 - T_1) - K             s = +1, -1
    (balance s)       s (T_0 - T_1) <= limit
    (apart v w)       not e^1_v or not e^0_w             whenever x_v - x_w < least gap
    (via a v)         e^a_v  =>  f^a_w for some w with x_w <= x_v
    (barred)          no y^a_vw between parts that are no neighbours, nor where the rapid crosses i itself
    (part a)          at most one of the y^a and f^a that enter a part from outside
    (order)           y^a_vw  =>  b_ij,   b_ij  =>  o_i < o_j
    (precedence i j)  z^a_i and z^a_j  =>  b_ij;   z^a_i and not z^a_j  =>  t_i <= t_j - w_j + K + tolerance
    (crossing)        y^a_vw  =>  u_ik for k in R_vw
    (clear i k)       u_ik, z^a_i and z^a_k  =>  b_ik;   u_ik, z^a_i and not z^a_k  =>  t_k >= t_i - K
    (time a)          y^a_vw  =>  t_j = t_i + l_vw + w_j;   f^a_v  =>  t_i = way from home + w_i

All data are rounded down, so the value of each plan here is at most its true one, times ``scale``: a lower
bound here bounds the true problem. T_0 - T_1 and differences of t move by at most K, so (imbalance) gives K
away and the limits on times are taken wider by K. A plan then may break the true limit by a hair; ``tight``
takes them narrower by K instead, and only plans are taken from it.

Source: the 2TSP of Wang et al. (2025), the entry points and process rules of Li et al. (2019); self loops for
optional nodes as CP-SAT documents them.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from itertools import combinations, pairwise

from ortools.sat.python import cp_model
from ortools.sat.python.cp_model_helper import LinearExpr, Literal

from cutgap.formulations.cpsat.integers import Integers, Tours
from cutgap.instances.arrays import difference


class EntryModel:
    """The model above; ``arcs``, ``firsts``, ``lasts`` and ``chosen`` hold y, f, g and e of each head."""

    def __init__(self, data: Integers, *, tight: bool = False) -> None:
        self.data, self.tight, self.model = data, tight, cp_model.CpModel()
        self.places, self.contours = range(len(data.contour_of)), range(len(data.work))
        heads, self.true = range(data.heads), self.model.new_constant(1)
        self.z = [self._new(f"z{i}") for i in self.contours] if data.heads == 2 else []
        self.chosen = [[self._new(f"e{a},{v}") for v in self.places] for a in heads]
        self.firsts = [[self._new(f"f{a},{v}") for v in self.places] for a in heads]
        self.lasts = [[self._new(f"g{a},{v}") for v in self.places] for a in heads]
        self.arcs = [{(v, w): self._new(f"y{a},{v},{w}") for v, w in self._rapids()} for a in heads]
        for head in heads:
            self._once(head)
            self._circuit(head)
            if data.via_points:
                self._via_points(head)
            if data.parts is not None:
                self._parts(head, data.parts)
        if data.gap is not None and data.heads == 2:
            self._apart(data.gap)
        if data.ordered:
            self._order()
        self._objective()

    def _new(self, name: str) -> cp_model.IntVar:
        return self.model.new_bool_var(name)

    def _rapids(self) -> Iterator[tuple[int, int]]:
        """(barred)."""
        of = self.data.contour_of
        pairs = ((v, w) for v in self.places for w in self.places if of[v] != of[w])
        return (pair for pair in pairs if pair not in self.data.barred)

    def _cuts(self, head: int, contour: int) -> Literal:
        """Return z^a_i."""
        if not self.z:
            return self.true
        return self.z[contour] if head == 0 else self.z[contour].negated()

    def _once(self, head: int) -> None:
        """(once)."""
        for contour in self.contours:
            chosen = [e for v, e in enumerate(self.chosen[head]) if self.data.contour_of[v] == contour]
            elsewhere = [self._cuts(1 - head, contour)] if self.z else []
            self.model.add_exactly_one([*chosen, *elsewhere])

    def _circuit(self, head: int) -> None:
        """(circuit), (contours), (rest)."""
        depot, of = len(self.places), self.data.contour_of
        arcs: list[tuple[int, int, Literal]] = [(v, w, y) for (v, w), y in self.arcs[head].items()]
        arcs += [(depot, v, f) for v, f in enumerate(self.firsts[head])]
        arcs += [(v, depot, g) for v, g in enumerate(self.lasts[head])]
        off = [(v, v, e.negated()) for v, e in enumerate(self.chosen[head])]
        rest = self._new(f"r{head}")
        if not self.data.may_rest:
            self.model.add(rest == 0)
        for e in self.chosen[head]:
            self.model.add_implication(rest, e.negated())
        self.model.add_circuit([*arcs, *off, (depot, depot, rest)])
        if len(self.contours) < len(self.places):
            ends = [*of, len(self.contours)]
            between = defaultdict(list)
            for v, w, literal in arcs:
                between[ends[v], ends[w]].append(literal)
            self._contour_circuit(head, between, rest)

    def _contour_circuit(
        self, head: int, between: dict[tuple[int, int], list[Literal]], rest: cp_model.IntVar
    ) -> None:
        """(contours)."""
        depot, arcs = len(self.contours), []
        for (i, j), literals in between.items():
            goes = self._new(f"n{head},{i},{j}")
            self.model.add(LinearExpr.sum(literals) == goes)
            arcs.append((i, j, goes))
        off = [(i, i, self._cuts(head, i).negated()) for i in self.contours]
        self.model.add_circuit([*arcs, *off, (depot, depot, rest)])

    def _ways(self, head: int) -> LinearExpr:
        """Length of the ways from home and back, or of the leg that closes the tour: (closing), (start)."""
        out, back = self.data.out[head], self.data.back[head]
        firsts, lasts = self.firsts[head], self.lasts[head]
        if out is not None and back is not None:
            return LinearExpr.weighted_sum([*firsts, *lasts], [*out, *back])
        of = self.data.contour_of
        pairs = [(v, w) for v in self.places for w in self.places if v == w or of[v] != of[w]]
        legs = {(v, w): self._new(f"h{head},{v},{w}") for v, w in pairs}
        for v in self.places:
            self.model.add(sum(leg for (last, _), leg in legs.items() if last == v) == lasts[v])
            self.model.add(sum(leg for (_, first), leg in legs.items() if first == v) == firsts[v])
            if not self.data.start_matters:
                for contour in range(of[v]):
                    self.model.add_implication(firsts[v], self._cuts(head, contour).negated())
        return _length(legs, self.data.rapids)

    def _via_points(self, head: int) -> None:
        """(via)."""
        xs = self.data.xs
        for e, x in zip(self.chosen[head], xs, strict=True):
            starts = [f for f, other in zip(self.firsts[head], xs, strict=True) if other <= x]
            self.model.add_bool_or([*starts, e.negated()])

    def _parts(self, head: int, parts: list[int]) -> None:
        """(part)."""
        part_of = [parts[contour] for contour in self.data.contour_of]
        entering = defaultdict(list)
        for v, f in enumerate(self.firsts[head]):
            entering[part_of[v]].append(f)
        for (v, w), y in self.arcs[head].items():
            if part_of[v] != part_of[w]:
                entering[part_of[w]].append(y)
        for literals in entering.values():
            self.model.add_at_most_one(literals)

    def _apart(self, gap: float) -> None:
        """(apart)."""
        left, right = self.chosen
        for v, x in enumerate(self.data.xs):
            for w, other in enumerate(self.data.xs):
                if difference(other, x) < gap:
                    self.model.add_implication(right[v], left[w].negated())

    def _order(self) -> None:
        """(order), (precedence), (crossing), (clear), (time)."""
        model, of = self.model, self.data.contour_of
        last = len(self.contours) - 1
        turns = [model.new_int_var(0, last, f"o{i}") for i in self.contours]
        self.before: dict[tuple[int, int], Literal] = {}
        for i, j in combinations(self.contours, 2):
            literal = self._new(f"b{i},{j}")
            self.before[i, j], self.before[j, i] = literal, literal.negated()
            model.add(turns[i] < turns[j]).only_enforce_if(literal)
            model.add(turns[j] < turns[i]).only_enforce_if(literal.negated())
        for arcs in self.arcs:
            for (v, w), y in arcs.items():
                model.add_implication(y, self.before[of[v], of[w]])
        done = self._times() if self.z else []
        margin = self.data.slack
        for i, j in self.data.precedence:
            least = self.data.work[j] + (margin if self.tight else -margin - self.data.tolerance)
            self._after([], i, j, done, least)
        # Times are compared as they are: the last bits of their sums are covered by one unit more.
        least = margin + 1 if self.tight else -margin - 1
        for (i, k), crosses in self._crosses().items():
            self._after([crosses], i, k, done, least)

    def _crosses(self) -> dict[tuple[int, int], Literal]:
        """(crossing): return u."""
        found: dict[tuple[int, int], Literal] = {}
        for (v, w), contours in self.data.crossed.items():
            i = self.data.contour_of[v]
            for k in contours:
                if (i, k) not in found:
                    found[i, k] = self._new(f"u{i},{k}")
                for arcs in self.arcs:
                    self.model.add_implication(arcs[v, w], found[i, k])
        return found

    def _after(self, when: list[Literal], i: int, j: int, done: list[cp_model.IntVar], least: int) -> None:
        """When all literals hold: j comes after i on one head; on two it is done ``least`` later than i."""
        for head in range(self.data.heads):
            mine = self._cuts(head, i)
            same = [*when, mine, self._cuts(head, j)]
            self.model.add_bool_or([*(literal.negated() for literal in same), self.before[i, j]])
            if done:
                both = [*when, mine, self._cuts(1 - head, j)]
                self.model.add(done[j] - done[i] >= least).only_enforce_if(both)

    def _times(self) -> list[cp_model.IntVar]:
        """(time): return t."""
        data, of = self.data, self.data.contour_of
        done = [self.model.new_int_var(0, data.most, f"t{i}") for i in self.contours]
        for head, arcs in enumerate(self.arcs):
            for (v, w), y in arcs.items():
                takes = data.rapids[v][w] + data.work[of[w]]
                self.model.add(done[of[w]] - done[of[v]] == takes).only_enforce_if(y)
            out = data.out[head]
            for v, f in enumerate(self.firsts[head]):
                takes = (0 if out is None else out[v]) + data.work[of[v]]
                self.model.add(done[of[v]] == takes).only_enforce_if(f)
        return done

    def _objective(self) -> None:
        """Objective, (makespan), (imbalance), (balance)."""
        data, costs, times = self.data, [], []
        services = [data.work[i] for i in data.contour_of]
        for head, arcs in enumerate(self.arcs):
            ways = self._ways(head)
            costs.append(ways + _length(arcs, data.costs))
            times.append(
                ways + _length(arcs, data.rapids) + LinearExpr.weighted_sum(self.chosen[head], services)
            )
        numerator, denominator = data.price
        if data.makespan:
            makespan = self.model.new_int_var(0, data.most, "m")
            for each in times:
                self.model.add(makespan >= each)
            self.model.minimize(makespan)
        elif data.heads == 1:
            self.model.minimize(denominator * costs[0])
        else:
            imbalance = self.model.new_int_var(0, data.most, "d")
            for late, early in (times, times[::-1]):
                self.model.add(imbalance >= late - early - data.slack)
            self.model.minimize(denominator * sum(costs) + numerator * imbalance)
        limit = data.limit(tight=self.tight)
        if limit is not None and data.heads == 2:
            self.model.add_linear_constraint(times[0] - times[1], -limit, limit)

    def hint(self, tours: Sequence[Sequence[int]]) -> None:
        """Tell the solver of a plan."""
        for tour, chosen, arcs in zip(tours, self.chosen, self.arcs, strict=True):
            used = set(pairwise(tour))
            for v, e in enumerate(chosen):
                self.model.add_hint(e, int(v in tour))
            for pair, y in arcs.items():
                self.model.add_hint(y, int(pair in used))

    def tours(self, solution: cp_model.CpSolverSolutionCallback) -> Tours:
        """Return the tours of a solution."""
        return tuple(self._tour(head, solution) for head in range(self.data.heads))

    def _tour(self, head: int, solution: cp_model.CpSolverSolutionCallback) -> tuple[int, ...]:
        following = {v: w for (v, w), y in self.arcs[head].items() if solution.boolean_value(y)}
        tour = [v for v, f in enumerate(self.firsts[head]) if solution.boolean_value(f)]
        while tour and tour[-1] in following:
            tour.append(following[tour[-1]])
        return tuple(tour)


def _length(arcs: dict[tuple[int, int], cp_model.IntVar], table: list[list[int]]) -> LinearExpr:
    return LinearExpr.weighted_sum(list(arcs.values()), [table[v][w] for v, w in arcs])
