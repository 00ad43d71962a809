"""Proofs of a lower bound: a branching tree whose leaves carry multipliers, or a minimum 1-tree.

A tree is a flat list of nodes, node 0 the root. Each node has bounds of the variables, the root those of the
relaxation, and is one of

    {"leaf": [[row, multiplier], ...]}                    value (weak duality) at least the target
    {"fix": [[row, multiplier], ...], "then": k}          reduced-cost fixing, then node k
    {"branch": variable, "at": t, "down": j, "up": k}     variable <= t in node j, variable >= t + 1 in node k

Why it is valid: let some whole solution cost less than the target. It lies within the bounds of the root, and
of one child of each branching that holds it. Fixing does not lose it: with r_j > 0 a solution with x_j > l_j
costs at least value + r_j, as (1) of ``relaxation`` counts x_j at l_j (likewise r_j < 0 and u_j). So it lies in
some leaf, whose value it is not below: a contradiction. A node whose bounds cross holds no solution; below a
fixing whose value reaches the target there is nothing to be proved, so its bounds are crossed.
"""

from collections.abc import Callable, Sequence
from typing import Any

from cutgap.formulations.certificate.reading import Refused, entries, fields, integer, require, show
from cutgap.formulations.certificate.relaxation import Bounds, Relaxation, Row, leaf_value

MAX_STEPS = 2_000_000_000
"""Elementary steps of one verification; about 10 million a second."""
MAX_NUMBERS = 100_000_000
"""Numbers that the rows of one relaxation may hold."""


class Budget:
    """Steps that are left; keeps the time for a certificate of unknown origin bounded."""

    def __init__(self, steps: int = MAX_STEPS) -> None:
        self.steps = steps

    def spend(self, steps: int) -> None:
        """Take steps off, before they are made."""
        self.steps -= steps
        require(self.steps >= 0, "the proof takes too many steps to check")


class Trail:
    """Bounds that are tightened on the way down a tree and restored on the way up."""

    def __init__(self, start: Bounds) -> None:
        self.bounds = Bounds(list(start.lower), list(start.upper))
        self.changes: list[tuple[int, int, int]] = []
        self.crossed = 0

    def set(self, variable: int, low: int, high: int) -> None:
        """Give a variable new bounds."""
        old_low, old_high = self._exchange(variable, low, high)
        self.changes.append((variable, old_low, old_high))

    def undo(self, length: int) -> None:
        """Go back to the state with ``length`` changes."""
        while len(self.changes) > length:
            self._exchange(*self.changes.pop())

    def _exchange(self, variable: int, low: int, high: int) -> tuple[int, int]:
        old = self.bounds.lower[variable], self.bounds.upper[variable]
        self.crossed += (low > high) - (old[0] > old[1])
        self.bounds.lower[variable], self.bounds.upper[variable] = low, high
        return old


def check_tree(relaxation: Relaxation, row_names: Any, nodes: Any, target: int, budget: Budget) -> None:
    """Refuse unless the tree proves that cost * multiplier scale >= target for all whole solutions."""
    rows = build_rows(relaxation, row_names, budget)
    tree = entries(nodes, "nodes")
    require(tree != [], "nodes: expected at least one")
    trail = Trail(relaxation.start)
    reached = [False] * len(tree)
    stack: list[tuple[int, int, tuple[int, int, int] | None]] = [(0, 0, None)]
    while stack:
        index, length, change = stack.pop()
        require(not reached[index], f"node {index} is reached twice")
        reached[index] = True
        trail.undo(length)
        if change is not None:
            trail.set(*change)
        budget.spend(10)
        try:
            children = _step(relaxation, rows, tree[index], trail, target, budget)
        except Refused as error:
            raise Refused(f"node {index}: {error}") from None
        for child, bounds in children:
            require(
                index < child < len(tree), f"node {index}: its child {show(child)} must come later in the list"
            )
            stack.append((child, len(trail.changes), bounds))
    require(all(reached), f"node {reached.index(False) if not all(reached) else 0} is never reached")


def build_rows(relaxation: Relaxation, names: Any, budget: Budget) -> list[Row]:
    """Return the rows that a proof names."""
    rows: list[Row] = []
    numbers = 0
    for index, name in enumerate(entries(names, "rows")):
        try:
            row = relaxation.row(name)
        except Refused as error:
            raise Refused(f"row {index}: {error}") from None
        numbers += row.size
        require(numbers <= MAX_NUMBERS, f"row {index}: the rows hold more than {MAX_NUMBERS} numbers")
        budget.spend(row.size + 1)
        rows.append(row)
    return rows


OneTreeRows = Callable[[int, list[int]], list[int]]
"""Integer lengths from one node to others."""
Children = list[tuple[int, tuple[int, int, int] | None]]


def _step(
    relaxation: Relaxation, rows: Sequence[Row], node: Any, trail: Trail, target: int, budget: Budget
) -> Children:
    """Check one node within the trail's bounds; return its children, each with new bounds of one variable."""
    require(isinstance(node, dict), "expected an object")
    if "branch" in node:
        table = fields(node, "branch", "branch at down up")
        variable, at = relaxation.variable(table["branch"]), integer(table["at"], "at")
        low, high = trail.bounds.lower[variable], trail.bounds.upper[variable]
        down, up = integer(table["down"], "down"), integer(table["up"], "up")
        return [(down, (variable, low, min(high, at))), (up, (variable, max(low, at + 1), high))]
    kind = "leaf" if "leaf" in node else "fix"
    table = fields(node, "node", "leaf" if kind == "leaf" else "fix then")
    multipliers = _multipliers(table[kind], rows)
    if trail.crossed > 0 and kind == "leaf":
        return []
    budget.spend(4 * len(relaxation.costs) + sum(row.size for row, _ in multipliers))
    value, reduced = leaf_value(relaxation, trail.bounds, multipliers)
    if kind == "leaf":
        require(value >= target, f"the leaf is worth {show(value)}, less than {show(target)}")
        return []
    _fix(trail, value, reduced, target)
    return [(integer(table["then"], "then"), None)]


def _multipliers(value: Any, rows: Sequence[Row]) -> list[tuple[Row, int]]:
    pairs = []
    for entry in entries(value, "multipliers"):
        row, multiplier = entries(entry, "multipliers", count=2)
        require(integer(row, "row", least=0) < len(rows), f"there is no row {show(row)}")
        pairs.append((rows[row], integer(multiplier, "multiplier")))
    return pairs


def _fix(trail: Trail, value: int, reduced: list[int], target: int) -> None:
    """Reduced-cost fixing: a variable that costs the target when it leaves its bound stays there.

    A variable without upper bound has equal numbers for its bounds, so that it is left alone. When all
    solutions cost the target, crossed bounds say that none below it is left.
    """
    if value >= target:
        trail.set(0, 1, 0)
        return
    for variable, r in enumerate(reduced):
        low, high = trail.bounds.lower[variable], trail.bounds.upper[variable]
        if r != 0 and low < high and value + abs(r) >= target:
            trail.set(variable, *((low, low) if r > 0 else (high, high)))


def one_tree_value(rows: OneTreeRows, potentials: list[int], firsts: list[int], multiplier_scale: int) -> int:
    """Return a lower bound on K * (length of a tour), from a minimum 1-tree.

    A tour is two edges at node 0 (one of them to a node of ``firsts``, if there are any) and a spanning tree
    of the rest, and has degree 2 everywhere. So K * length is at least 2 * sum of pi + the least value of a
    1-tree for the edge costs K l_uv - pi_u - pi_v, whatever the potentials pi.

    Source: Held and Karp (1970). Prim's algorithm, O(n^2).
    """
    count = len(potentials)

    def costs(u: int, others: list[int]) -> list[int]:
        mine = potentials[u]
        lengths = rows(u, others)
        return [
            multiplier_scale * length - mine - potentials[v] for length, v in zip(lengths, others, strict=True)
        ]

    at_zero = dict(enumerate(costs(0, list(range(1, count))), 1))
    first = min(firsts or at_zero, key=at_zero.__getitem__)
    value = 2 * sum(potentials) + at_zero.pop(first) + min(at_zero.values())
    outside, nearest = list(range(2, count)), costs(1, list(range(2, count)))
    while outside:
        place = min(range(len(outside)), key=nearest.__getitem__)
        value += nearest[place]
        joined = outside.pop(place)
        nearest.pop(place)
        nearest = list(map(min, nearest, costs(joined, outside)))
    return value
