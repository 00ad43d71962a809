"""The rows of docs/formulations.md, left minus right, in plain loops over values of the variables.

Written from the page alone; ``rows`` of a model are compared with it at random points.
"""

from itertools import combinations, permutations

from oracles.problem import Problem, plain_problem

from cutgap.instances import Instance, Rules

HOME = -1


class Page:
    """Values of x and c by (head, node, node), and what follows from them."""

    def __init__(self, instance: Instance, rules: Rules, x: dict, c: dict) -> None:
        self.instance, self.rules, self.x, self.c = instance, rules, x, c
        self.problem: Problem = plain_problem(instance)
        self.heads = range(len(self.problem.homes))
        self.n = len(self.problem.entries)
        self.contours = range(self.n)
        self.of = [i for i, points in enumerate(self.problem.entries) for _ in points]
        self.nodes = range(len(self.of))
        self.xs = [point[0] for points in self.problem.entries for point in points]
        self.alone = len(self.heads) == 1
        self.pairs = list(permutations(self.contours, 2))
        self.ends = self.pairs + [(HOME, j) for j in self.contours] + [(i, HOME) for i in self.contours]

    def contour(self, node: int) -> int:
        return self.of[node] if node < len(self.of) else HOME

    def y(self, h: int, i: int, j: int) -> float:
        total = sum(v for (g, a, b), v in self.x.items() if (g, self.contour(a), self.contour(b)) == (h, i, j))
        if i == HOME:
            total += sum(v for (g, _, b), v in self.c.items() if (g, self.of[b]) == (h, j))
        if j == HOME:
            total += sum(v for (g, a, _), v in self.c.items() if (g, self.of[a]) == (h, i))
        return total

    def z(self, h: int, i: int) -> float:
        return sum(self.y(h, j, i) for j in (*self.contours, HOME) if j != i)

    def q(self, h: int, u: int) -> float:
        return sum(v for legs in (self.x, self.c) for (g, _, b), v in legs.items() if (g, b) == (h, u))

    def leaving(self, h: int, u: int) -> float:
        return sum(v for legs in (self.x, self.c) for (g, a, _), v in legs.items() if (g, a) == (h, u))

    def first(self, h: int, u: int) -> float:
        from_home = sum(v for (g, a, b), v in self.x.items() if (g, b) == (h, u) and self.contour(a) == HOME)
        return from_home + sum(v for (g, _, b), v in self.c.items() if (g, b) == (h, u))

    def time(self, h: int) -> float:
        lengths = self.problem.lengths
        travel = sum(lengths[a][b] * v for legs in (self.x, self.c) for (g, a, b), v in legs.items() if g == h)
        return travel / self.problem.v_jump + sum(self.problem.work([i]) * self.z(h, i) for i in self.contours)

    def problem_rows(self, makespan: float, imbalance: float) -> dict:
        rows = {("cut-once", i): sum(self.z(h, i) for h in self.heads) - 1 for i in self.contours}
        for h in self.heads:
            for u in self.nodes:
                rows["continuity", h, u] = self.q(h, u) - self.leaving(h, u)
            begun = sum(self.y(h, HOME, j) for j in self.contours)
            rests = self.rules.empty_heads or self.n < len(self.heads)
            rows["leave-once", h] = 1 - begun if rests else begun - 1
            if self.rules.objective == "makespan":
                rows["makespan", h] = makespan - self.time(h)
            other = 1 - h
            if self.rules.objective == "weighted" and not self.alone:
                rows["imbalance", h, other] = imbalance - self.time(h) + self.time(other)
            if self.rules.balance is not None and not self.alone:
                rows["balance", h, other] = self.time(other) - self.time(h) + self.rules.balance
        return rows | self._pair_rows() | self._part_rows()

    def _pair_rows(self) -> dict:
        rows = {}
        for u in self.nodes:
            for v in self.nodes:
                if self.of[u] == self.of[v]:
                    continue
                gap = self.rules.non_overlap
                if gap is not None and not self.alone and self.xs[v] - self.xs[u] < gap:
                    rows["apart", u, v] = 1 - self.q(0, u) - self.q(1, v)
                if self.rules.via_points and self.xs[v] < self.xs[u]:
                    for h in self.heads:
                        rows["via", h, u, v] = 1 - self.first(h, u) - self.q(h, v)
        return rows

    def _part_rows(self) -> dict:
        if not self.rules.parts_in_one_go:
            return {}
        names: list = []
        for i, contour in enumerate(self.instance.contours):
            name = ("alone", i) if contour.part is None else contour.part
            if name not in names:
                names.append(name)
        parts = [
            [i for i, contour in enumerate(self.instance.contours) if name in (contour.part, ("alone", i))]
            for name in names
        ]
        rows = {}
        for h in self.heads:
            for number, part in enumerate(parts):
                if len(part) > 1:
                    out = sum(self.y(h, i, j) for i in part for j in self.contours if j not in part)
                    rows["one-go", h, number] = 1 - out - sum(self.y(h, i, HOME) for i in part)
        return rows

    def order_rows(self, p: list, crossed: dict) -> dict:
        """``crossed``: (u, v) -> contours that the rapid crosses, those at its ends left out."""
        n, rows = self.n, {}
        for h in self.heads:
            for i, j in set(self.instance.precedence):
                left = p[h][j] - p[h][i]
                rows["precedence", h, i, j] = (
                    left - 1 if self.alone else left - n * (self.z(h, i) + self.z(h, j)) - 1 + 2 * n
                )
            for (u, v), contours in crossed.items():
                for k in contours:
                    if (h, u, v) not in self.x:
                        continue
                    left = p[h][k] - p[h][self.of[u]] - n * self.x[h, u, v]
                    rows["clear", h, u, v, k] = (
                        left - 1 + n if self.alone else left - n * self.z(h, k) - 1 + 2 * n
                    )
        return rows

    def clock_rows(self, s: list, most: float, crossed: dict) -> dict:
        work, speed = [self.problem.work([i]) for i in self.contours], self.problem.v_jump
        lengths, rows = self.problem.lengths, {}
        for i, j in self.pairs:
            goes = sum(self.y(h, i, j) for h in self.heads)
            taken = sum(
                (work[i] + lengths[a][b] / speed) * v
                for (_, a, b), v in self.x.items()
                if (self.contour(a), self.contour(b)) == (i, j)
            )
            rows["clock", i, j, "least"] = s[j] - s[i] - taken - most * goes + most
            rows["clock", i, j, "most"] = s[i] - s[j] + taken - most * goes + most
        for j in self.contours:
            way = sum(
                lengths[a][b] / speed * v
                for (_, a, b), v in self.x.items()
                if (self.contour(a), self.contour(b)) == (HOME, j)
            )
            begins = sum(self.y(h, HOME, j) for h in self.heads)
            rows["clock-first", j, "least"] = s[j] - way
            rows["clock-first", j, "most"] = -s[j] + way - most * begins + most
        for i, j in set(self.instance.precedence):
            rows["late", i, j] = s[j] - s[i] - work[i]
        for h, u, v in self.x:
            for k in crossed.get((u, v), ()):
                i = self.of[u]
                high = most + work[i]
                rows["late-clear", h, u, v, k] = s[k] - s[i] - high * self.x[h, u, v] - work[i] + work[k] + high
        return rows

    def tour_rows(self, formulation: str, values: dict) -> dict:
        """``values``: p, f, g, w of each head, by the indices of the page."""
        rows = {}
        for h in self.heads:
            one_head = {name: each[h] for name, each in values.items()}
            rows |= getattr(self, "_" + formulation.replace("-", "_"))(h, **one_head)
        return rows

    def _mtz(self, h: int, p: list) -> dict:
        n = self.n
        return {("position", h, i, j): p[j] - p[i] - n * self.y(h, i, j) - 1 + n for i, j in self.pairs}

    def _lifted_mtz(self, h: int, p: list) -> dict:
        n = self.n
        rows = {
            ("lifted-position", h, i, j): p[j] - p[i] - n * self.y(h, i, j) - (n - 2) * self.y(h, j, i) - 1 + n
            for i, j in self.pairs
        }
        for i in self.contours if n >= 2 else ():
            begins, ends = self.y(h, HOME, i), self.y(h, i, HOME)
            rows["lifted-first", h, i] = p[i] + begins - 2 - ((n - 2) * ends if self.alone else 0)
            if self.alone:
                rows["lifted-last", h, i] = -p[i] - (n - 2) * begins + ends - 1 + n
        return rows

    def _single_commodity(self, h: int, f: dict) -> dict:
        n, rows = self.n, {}
        for j in self.contours:
            rows["flow-keep", h, j] = _in(f, j) - _out(f, j) - self.z(h, j)
            rows["flow-most", h, HOME, j] = n * self.y(h, HOME, j) - f[HOME, j]
        for i, j in self.pairs:
            rows["flow-most", h, i, j] = (n - 1) * self.y(h, i, j) - f[i, j]
        return rows

    def _two_commodity(self, h: int, f: dict, g: dict) -> dict:
        rows = {}
        for j in self.contours:
            rows["load-keep", h, j] = _in(f, j) - _out(f, j) - self.z(h, j)
            rows["space-keep", h, j] = _out(g, j) - _in(g, j) - self.z(h, j)
        for i, j in self.ends:
            rows["load-and-space", h, i, j] = f[i, j] + g[i, j] - self.n * self.y(h, i, j)
        return rows

    def _multi_commodity(self, h: int, f: dict) -> dict:
        rows = {}
        for k in self.contours:
            mine = {(i, j): v for (sink, i, j), v in f.items() if sink == k}
            rows["to-sink", h, k] = _in(mine, k) - _out(mine, k) - self.z(h, k)
            for j in self.contours:
                if j != k:
                    rows["through", h, k, j] = _in(mine, j) - _out(mine, j)
            for i, j in mine:
                rows["flow-within", h, k, i, j] = self.y(h, i, j) - mine[i, j]
        return rows

    def _time_indexed(self, h: int, w: dict) -> dict:
        rows = {}
        for t in range(1, self.n + 1):
            for i in self.contours:
                arrives = sum(v for (s, _, j), v in w.items() if (s, j) == (t - 1, i))
                rows["step", h, t, i] = arrives - sum(v for (s, j, _), v in w.items() if (s, j) == (t, i))
        for i, j in self.ends:
            rows["timed", h, i, j] = sum(v for (_, a, b), v in w.items() if (a, b) == (i, j)) - self.y(h, i, j)
        return rows

    def _dfj(self, h: int) -> dict:
        rows = {}
        for size in range(2, self.n + 1):
            for inside in combinations(self.contours, size):
                outside = [i for i in (*self.contours, HOME) if i not in inside]
                entering = sum(self.y(h, i, j) for i in outside for j in inside)
                if self.alone:
                    rows["enter", h, inside] = entering - 1
                else:
                    rows |= {("enter", h, inside, k): entering - self.z(h, k) for k in inside}
        return rows


def _in(f: dict, j: int) -> float:
    return sum(v for (_, b), v in f.items() if b == j)


def _out(f: dict, j: int) -> float:
    return sum(v for (a, _), v in f.items() if a == j)
