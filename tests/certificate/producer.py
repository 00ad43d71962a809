"""A small, slow writer of proofs: dual values of dense LPs over all rows, rounded to integers."""

from itertools import combinations, permutations
from typing import Any

import numpy as np
from scipy.optimize import linprog

from cutgap.formulations.certificate import Bounds, Problem, Relaxation, Row, leaf_value

MULTIPLIER_SCALE = 2**24


def coefficients(relaxation: Relaxation, row: Row) -> list[int]:
    """The row written out, one coefficient a variable."""
    numbers = [0] * relaxation.nodes
    for node, number in row.nodes:
        numbers[node] += number
    dense = [
        numbers[tail] + numbers[head] for tail, head in zip(relaxation.tails, relaxation.heads, strict=True)
    ]
    for coefficient, variables in row.corrections:
        for variable in variables:
            dense[variable] += coefficient
    return dense


def subsets(items: Any, least: int = 1) -> list[list[int]]:
    members = list(items)
    return [list(s) for size in range(least, len(members) + 1) for s in combinations(members, size)]


def tour_rows(count: int, via: bool) -> list[list[Any]]:
    rows: list[list[Any]] = [["degree", v] for v in range(count)]
    rows += [["cut", [s]] for s in subsets(range(count), 2) if 2 * len(s) <= count]
    return rows + [["via"]] * via


def generalized_rows(relaxation: Any) -> list[list[Any]]:
    """Every row but combs; where a set and its outside hold whole contours, only the row that says so."""
    contours, nodes = relaxation.contours, range(relaxation.count)
    rows: list[list[Any]] = [["contour", h] for h in range(len(contours))]
    rows += [["degree", v] for v in nodes]
    for inside in subsets(nodes, 2):
        if 2 * len(inside) <= len(nodes):
            outside = [v for v in nodes if v not in inside]
            rows += [
                ["border", inside, h, k] for h in asked(contours, inside) for k in asked(contours, outside)
            ]
    return rows


def asked(contours: list[Any], part: list[int]) -> list[int | None]:
    """What a row may ask of a part: a whole contour, else each contour that has a node there."""
    if any(set(contour) <= set(part) for contour in contours):
        return [None]
    return [h for h, contour in enumerate(contours) if set(contour) & set(part)]


def two_heads_rows(problem: Problem, rules: Any) -> list[list[Any]]:
    """Every row of the relaxation but combs of teeth."""
    count, heads = len(problem.ids), (0, 1)
    rows: list[list[Any]] = [["degree", a, i] for a in heads for i in range(count)]
    rows += [["home", a] for a in heads]
    rows += [["connect", a, i, [s]] for a in heads for s in subsets(range(count), 2) for i in s]
    rows += [["visit", a, i, *e] for a in heads for e in combinations(range(count), 2) for i in e]
    rows += [["comb", [s]] for s in subsets(range(count))]
    if rules.empty_heads or count < 2:
        rows += [["used", a, i] for a in heads for i in range(count)]
    if rules.objective == "makespan":
        rows += [["makespan", a] for a in heads]
    if rules.objective == "weighted":
        rows += [["imbalance", s] for s in (1, -1)]
    if rules.balance is not None:
        rows += [["balance", s] for s in (1, -1)]
    if rules.non_overlap is not None:
        for i, j in permutations(range(count), 2):
            apart = problem.xs[j] - problem.xs[i]
            if apart > 0 or abs(apart) < rules.non_overlap:
                rows.append(["order", i, j])
    if rules.via_points:
        rows += [["via", a, i] for a in heads for i in range(count)]
    return rows


def variable_names(relaxation: Relaxation, count: int) -> dict[int, list[Any]]:
    """Name of each whole variable, for ``count`` nodes (one tour) or contours (two heads)."""
    if hasattr(relaxation, "families"):
        names: list[list[Any]] = [["z", i] for i in range(count)]
        names += [["x", a, u, v] for a in (0, 1) for u, v in combinations(range(-1, count), 2)]
        names += [["e", 0], ["e", 1]] if relaxation.e is not None else []
    else:
        names = [["y", v] for v in range(count)] if hasattr(relaxation, "contours") else []
        names += [["x", u, v] for u, v in combinations(range(count), 2)]
    return {relaxation.variable(name): name for name in names}


class Prover:
    """Branch and bound with every row in the LP; elastic, so that a node without solution has duals too."""

    def __init__(self, relaxation: Relaxation, names: list[list[Any]], count: int) -> None:
        self.relaxation, self.names = relaxation, names
        self.rows = [relaxation.row(name) for name in names]
        self.matrix = np.array([coefficients(relaxation, row) for row in self.rows], dtype=float)
        self.equal = np.array([row.equality for row in self.rows])
        self.right = np.array([row.rhs for row in self.rows], dtype=float)
        self.variables = variable_names(relaxation, count)
        self.whole = sorted(self.variables)

    def duals(self, bounds: Bounds) -> tuple[list[tuple[int, int]], np.ndarray]:
        """Integer multipliers by row, and the LP's solution."""
        scale = self.relaxation.multiplier_scale
        costs = np.array(self.relaxation.costs, dtype=float) / scale
        penalty = 100.0 * max(1.0, abs(costs).max(), abs(self.matrix).max())
        m = len(self.rows)
        upper, lower = np.eye(m), -np.eye(m)[:, self.equal]
        dense = np.hstack([self.matrix, upper, lower])
        limits = [
            (low, None if j in self.relaxation.endless else high)
            for j, (low, high) in enumerate(zip(bounds.lower, bounds.upper, strict=True))
        ] + [(0, None)] * (dense.shape[1] - len(costs))
        cost = np.concatenate([costs, np.full(dense.shape[1] - len(costs), penalty)])
        solved = linprog(
            cost,
            A_ub=-dense[~self.equal],
            b_ub=-self.right[~self.equal],
            A_eq=dense[self.equal],
            b_eq=self.right[self.equal],
            bounds=limits,
        )
        assert solved.status == 0, solved.message
        y = np.empty(m)
        y[self.equal] = solved.eqlin.marginals
        y[~self.equal] = np.maximum(0.0, -solved.ineqlin.marginals)
        # Rounded down, so that prices of makespan and imbalance never exceed their cost.
        whole = [int(np.floor(value * scale)) for value in y]
        return [(i, value) for i, value in enumerate(whole) if value != 0], solved.x[: len(costs)]

    def prove(self, target: int, fix: bool = True) -> list[dict[str, Any]]:
        """Return the nodes of a tree that proves the target; fails when that is too much."""
        nodes: list[dict[str, Any]] = []
        start = self.relaxation.start
        self._visit(Bounds(list(start.lower), list(start.upper)), target, nodes, fix)
        return nodes

    def _visit(self, bounds: Bounds, target: int, nodes: list[dict[str, Any]], fix: bool) -> int:
        index = len(nodes)
        nodes.append({})
        if any(bounds.lower[j] > bounds.upper[j] for j in self.whole):
            nodes[index] = {"leaf": []}
            return index
        duals, x = self.duals(bounds)
        value, reduced = leaf_value(self.relaxation, bounds, [(self.rows[i], y) for i, y in duals])
        pairs = [[i, y] for i, y in duals]
        if value >= target:
            nodes[index] = {"leaf": pairs}
            return index
        if fix:
            for j in self.whole:
                if reduced[j] > 0 and value + reduced[j] >= target:
                    bounds.upper[j] = bounds.lower[j]
                elif reduced[j] < 0 and value - reduced[j] >= target:
                    bounds.lower[j] = bounds.upper[j]
            nodes[index] = {"fix": pairs, "then": self._visit(bounds, target, nodes, False)}
            return index
        free = [j for j in self.whole if bounds.lower[j] < bounds.upper[j]]
        assert free, "the target is too high"
        assert len(nodes) < 500, "the proof is too long"
        j = max(free, key=lambda each: abs(x[each] - round(x[each])))
        at = min(int(np.floor(x[j] + 1e-6)), bounds.upper[j] - 1)
        down, up = (Bounds(list(bounds.lower), list(bounds.upper)) for _ in (0, 1))
        down.upper[j], up.lower[j] = at, at + 1
        nodes[index] = {
            "branch": self.variables[j],
            "at": at,
            "down": self._visit(down, target, nodes, False),
            "up": self._visit(up, target, nodes, False),
        }
        return index
