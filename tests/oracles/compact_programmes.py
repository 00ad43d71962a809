"""The relaxations of compact models as dense linear programmes, from docs/formulations.md alone."""

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, permutations

import numpy as np
from scipy.optimize import linprog

from cutgap.instances import Instance, Rules
from oracles.compact_rows import CompactRows, Name, times, total

FORMULATIONS = (
    "assignment",
    "mtz",
    "lifted-mtz",
    "single-commodity",
    "two-commodity",
    "multi-commodity",
    "time-indexed",
    "dfj",
)


@dataclass(frozen=True)
class Solved:
    """The optimum of a relaxation, ``None`` when it has no point, and the multipliers of its rows."""

    value: float | None
    multipliers: dict[Name, float]


class CompactProgramme(CompactRows):
    """``min cost`` subject to the rows of a problem and of a tour formulation."""

    def __init__(self, instance: Instance, rules: Rules, formulation: str) -> None:
        super().__init__(instance, rules)
        for h in self.heads:
            getattr(self, "add_" + formulation.replace("-", "_"))(h)

    def add_assignment(self, h: int) -> None:
        pass

    def add_lifted_mtz(self, h: int) -> None:
        n = self.n
        if n < 2:
            return
        for i, j in permutations(range(n), 2):
            ways = total(times(-n, self.y(h, i, j)), times(2 - n, self.y(h, j, i)))
            self.row(("lifted-position", h, i, j), total(self.p(h, j), times(-1, self.p(h, i)), ways), 1 - n)
        for i in range(n):
            begins, ends = self.y(h, -1, i), self.y(h, i, -1)
            left = total(self.p(h, i), begins)
            if self.alone:
                left = total(left, times(2 - n, ends))
                last = total(times(-1, self.p(h, i)), times(2 - n, begins), ends)
                self.row(("lifted-last", h, i), last, 1 - n)
            self.row(("lifted-first", h, i), left, 2)

    def add_single_commodity(self, h: int) -> None:
        n = self.n
        for j in range(n):
            kept = [self.variable("f", h, i, j, most=n) for i in self.places(j)]
            kept += [times(-1, self.variable("f", h, j, i, most=n)) for i in self.others(j)]
            self.row(("flow-keep", h, j), total(*kept, times(-1, self.z(h, j))))
            for i in self.places(j):
                most = times(n if i == -1 else n - 1, self.y(h, i, j))
                self.row(("flow-most", h, i, j), total(most, Counter({("f", h, i, j): -1})))

    def add_two_commodity(self, h: int) -> None:
        n = self.n
        for i, j in permutations(range(-1, n), 2):
            load = self.variable("f", h, i, j, most=0 if self.alone and j == -1 else n)
            space = self.variable("g", h, i, j, most=0 if self.alone and i == -1 else n)
            self.row(("load-and-space", h, i, j), total(load, space, times(-n, self.y(h, i, j))))
        for j in range(n):
            for family, kind, sign in (("load-keep", "f", 1), ("space-keep", "g", -1)):
                kept = Counter({(kind, h, i, j): sign for i in self.places(j)})
                kept.update({(kind, h, j, i): -sign for i in self.places(j)})
                self.row((family, h, j), total(kept, times(-1, self.z(h, j))))

    def add_multi_commodity(self, h: int) -> None:
        for k in range(self.n):
            for j in range(self.n):
                into = [self.variable("f", h, k, i, j, most=1) for i in self.places(j)]
                out = [times(-1, self.variable("f", h, k, j, i, most=1)) for i in self.others(j)]
                if j == k:
                    self.row(("to-sink", h, k), total(*into, *out, times(-1, self.z(h, k))))
                else:
                    self.row(("through", h, k, j), total(*into, *out))
                for i in self.places(j):
                    within = total(self.y(h, i, j), Counter({("f", h, k, i, j): -1}))
                    self.row(("flow-within", h, k, i, j), within)

    def add_time_indexed(self, h: int) -> None:
        n = self.n
        arcs = [(0, -1, j) for j in range(n)]
        arcs += [(t, i, j) for t in range(1, n) for i, j in permutations(range(n), 2)]
        arcs += [(t, i, -1) for t in range(n if self.alone else 1, n + 1) for i in range(n)]
        for arc in arcs:
            self.variable("w", h, *arc, most=1)
        for t in range(1, n + 1):
            for i in range(n):
                into = Counter({("w", h, *arc): 1 for arc in arcs if arc[0] == t - 1 and arc[2] == i})
                out = Counter({("w", h, *arc): -1 for arc in arcs if arc[0] == t and arc[1] == i})
                self.row(("step", h, t, i), total(into, out))
        for i, j in permutations(range(-1, n), 2):
            each = Counter({("w", h, *arc): 1 for arc in arcs if arc[1:] == (i, j)})
            self.row(("timed", h, i, j), total(each, times(-1, self.y(h, i, j))))

    def add_dfj(self, h: int) -> None:
        for size in range(2, self.n + 1):
            for members in combinations(range(self.n), size):
                outside = [i for i in range(-1, self.n) if i not in members]
                entering = total(*(self.y(h, i, j) for i in outside for j in members))
                if self.alone:
                    self.row(("enter", h, members), entering, 1)
                    continue
                for k in members:
                    self.row(("enter", h, members, k), total(entering, times(-1, self.z(h, k))))

    # The programme as arrays

    @cached_property
    def dense(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Rows, right sides, which are equations, costs."""
        column = {name: at for at, name in enumerate(self.ranges)}
        matrix = np.zeros((len(self.rows), len(column)))
        for at, (left, _, _) in enumerate(self.rows.values()):
            for name, number in left.items():
                matrix[at, column[name]] += number
        right = np.array([right for _, _, right in self.rows.values()], dtype=float)
        equal = np.array([equation for _, equation, _ in self.rows.values()], dtype=bool)
        cost = np.zeros(len(column))
        for name, number in self.cost.items():
            cost[column[name]] = number
        return matrix, right, equal, cost

    @cached_property
    def solved(self) -> Solved:
        matrix, right, equal, cost = self.dense
        found = linprog(
            cost, -matrix[~equal], -right[~equal], matrix[equal], right[equal], list(self.ranges.values())
        )
        if found.status == 2:
            return Solved(None, {})
        assert found.status == 0, found.message
        duals = np.empty(len(right))
        duals[equal], duals[~equal] = found.eqlin.marginals, np.maximum(0.0, -found.ineqlin.marginals)
        return Solved(float(found.fun), dict(zip(self.rows, duals.tolist(), strict=True)))

    def worth(self, multipliers: dict[Name, float]) -> float:
        """What multipliers prove by weak duality; -inf where a variable without upper bound spoils it."""
        matrix, right, _, cost = self.dense
        given = np.array([multipliers.get(name, 0.0) for name in self.rows])
        reduced = cost - given @ matrix
        low, high = np.array(list(self.ranges.values())).T
        with np.errstate(invalid="ignore"):
            ends = np.where(reduced >= 0, reduced * low, np.where(reduced < -1e-9, reduced * high, 0.0))
        return float(given @ right + ends.sum())
