"""Good tours of one head through contours with entry points, under precedence and process rules, fast.

``EntrySearch`` improves a tour by ruin and recreate (kernels in ``entry_moves``); ``best_entries`` is the exact
choice of entries for a given order (kernels in ``entry_choice``). Heuristics and exact methods take both from
here.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.entry_choice import choose_entries
from cutgap.instances.entry_moves import BEST_BARRED, BEST_COST, begin, iterate, new_search
from cutgap.instances.entry_steps import Bools, Path, Task, Words
from cutgap.instances.instance import Instance
from cutgap.instances.plan import Visit
from cutgap.instances.process import adjacent_parts, crossings, part_of, rapid_costs
from cutgap.instances.rules import Rules


def entry_task(instance: Instance, rules: Rules) -> Task:
    """Return what the kernels read of an instance with one head and at least one contour.

    Parts that the precedence forbids to cut in one go are not kept together: ``check`` then says so.

    Raises
    ------
    ValueError
        With more heads or no contour, via points, or process rules without geometry.
    """
    if len(instance.heads) != 1:
        raise ValueError(f"instance {instance.name!r}: expected one head, got {len(instance.heads)}")
    n = len(instance.contours)
    if n == 0:
        raise ValueError(f"instance {instance.name!r}: expected at least one contour, got none")
    if rules.via_points:
        raise ValueError("via points: not together with entry points to choose from; drop them")
    costs = np.array(rapid_costs(instance, rules))
    anchored = instance.heads[0].home is not None
    first = np.concatenate((instance.first_node, [instance.node_count] * anchored)).astype(np.int64)
    parts = part_of(instance) if rules.parts_in_one_go else np.arange(n)
    before = orders_within_parts(n, instance.precedence, parts)
    if before.diagonal().any():
        parts = np.arange(n)
        before = orders_within_parts(n, instance.precedence, parts)
    least = least_legs(costs, first)
    ordered = bool(instance.precedence) or bool(rules.process)
    return Task(
        costs,
        np.ascontiguousarray(costs.T),
        costs if rules.backward_price == 0.0 else np.array(instance.rapids),
        least,
        first,
        before,
        parts,
        barred_legs(instance, rules),
        near_contours(least[:n, :n]),
        anchored,
        not anchored and not ordered,
    )


def plain_task(lengths: Floats, first: Ints) -> Task:
    """Return the task of closed tours through one node of each cluster, under no rules.

    Parameters
    ----------
    lengths
        Shape (nodes, nodes), mm, not negative; entries within a cluster are not used.
    first
        First node of each cluster, then the number of nodes; shape (clusters + 1,).
    """
    # Copied, since kernels are compiled anew for arrays that are read-only.
    costs, count = np.array(lengths, dtype=np.float64, order="C"), len(first) - 1
    least = least_legs(costs, first)
    return Task(
        costs,
        np.ascontiguousarray(costs.T),
        costs,
        least,
        first.astype(np.int64),
        np.zeros((count, count), dtype=np.bool_),
        np.arange(count),
        np.zeros((0, 0, 0), dtype=np.uint64),
        near_contours(least),
        False,
        True,
    )


def orders_within_parts(n: int, precedence: Sequence[tuple[int, int]], parts: Ints) -> Bools:
    """Return whether a contour must be cut before another when parts are cut in one go, shape (n, n).

    A true diagonal says that this is impossible.
    """
    own = np.zeros((n, n), dtype=np.bool_)
    among = np.zeros((n, n), dtype=np.bool_)
    for a, b in precedence:
        (own if parts[a] == parts[b] else among)[a, b] = True
    same = parts[:, None] == parts[None, :]
    # One pair between two parts orders all their contours.
    among = _matmul(_matmul(same, among), same)
    return _closure(own) | _closure(among)


def _matmul(a: Bools, b: Bools) -> Bools:
    return (a.astype(np.float32) @ b.astype(np.float32)) > 0


def _closure(pairs: Bools) -> Bools:
    """Return the transitive closure, by squaring."""
    while True:
        longer = pairs | _matmul(pairs, pairs)
        if (longer == pairs).all():
            return pairs
        pairs = longer


def barred_legs(instance: Instance, rules: Rules) -> Words:
    """Return the sets of contours that bar each leg once one of them is cut; bit n is for "always"."""
    if not (rules.neighbours_only or rules.clear_rapids):
        return np.zeros((0, 0, 0), dtype=np.uint64)
    n, places = len(instance.contours), int(instance.first_node[-1])
    barred = np.zeros((instance.node_count, instance.node_count, n // 64 + 1), dtype=np.uint64)
    if rules.clear_rapids:
        table = crossings(instance)
        barred[:places, :places, : table.shape[2]] = table
    if rules.neighbours_only:
        parts = part_of(instance)[np.repeat(np.arange(n), np.diff(instance.first_node))]
        apart = ~adjacent_parts(instance)[parts[:, None], parts[None, :]] & (parts[:, None] != parts[None, :])
        barred[:places, :places, n // 64] |= np.where(apart, np.uint64(1 << n % 64), np.uint64(0))
    return barred


def least_legs(costs: Floats, first: Ints) -> Floats:
    """Return the cheapest leg from cluster to cluster, shape (clusters, clusters)."""
    rows = np.minimum.reduceat(costs, first[:-1], axis=0)
    return np.ascontiguousarray(np.minimum.reduceat(rows, first[:-1], axis=1))


def near_contours(least: Floats) -> Ints:
    """Return for each contour the others, nearest first by the cheapest leg either way, shape (n, n - 1)."""
    least = np.minimum(least, least.T)
    np.fill_diagonal(least, -1.0)
    return np.ascontiguousarray(np.argsort(least, axis=1, kind="stable")[:, 1:])


def _new_path(task: Task) -> Path:
    size, nodes, words = len(task.first) - 1, len(task.costs), task.barred.shape[2]
    return Path(
        clusters=np.zeros(size, dtype=np.int64),
        nodes=np.zeros(size, dtype=np.int64),
        forward=np.zeros(nodes),
        backward=np.zeros(nodes),
        reach=np.zeros(size),
        rest=np.zeros(size),
        cut=np.zeros((size, words), dtype=np.uint64),
        later=np.zeros((size, words), dtype=np.uint64),
        bounds=np.zeros(size),
    )


@dataclass(frozen=True, slots=True)
class EntryTour:
    """A tour: visits in order, cost in mm (backward price included), number of legs that process rules bar."""

    visits: tuple[Visit, ...]
    cost: float
    barred: int


def best_entries(task: Task, order: Sequence[int] | Ints) -> EntryTour:
    """Return the tour of least cost, among those of fewest barred legs, with the contours in a given order.

    Parameters
    ----------
    order
        Each contour once. Precedence and parts are taken as they are.

    Raises
    ------
    ValueError
        When the order is no permutation of the contours.
    """
    n, order = len(task.part), np.asarray(order, dtype=np.int64)
    if order.shape != (n,) or not np.array_equal(np.sort(order), np.arange(n)):
        raise ValueError(f"order: expected each of {n} contours once")
    if task.cyclic:
        order = np.roll(order, -int(np.argmin(np.diff(task.first)[order])))
    path = _new_path(task)
    path.clusters[:] = np.concatenate(([n], order)) if task.anchored else order
    barred = choose_entries(task, path, 1.0 + 2.0 * len(path.clusters) * float(task.costs.max()))
    return _tour(task, path.clusters, path.nodes, barred)


def _tour(task: Task, clusters: Ints, nodes: Ints, barred: int) -> EntryTour:
    cost = float(task.costs[nodes[:-1], nodes[1:]].sum() + task.closing[nodes[-1], nodes[0]])
    stops = zip(clusters.tolist(), nodes.tolist(), strict=True)
    visits = [Visit(k, v - int(task.first[k])) for k, v in stops if k < len(task.part)]
    return EntryTour(tuple(visits), cost, barred)


def shortest_in_order(task: Task, order: Sequence[int] | Ints) -> tuple[float, Ints]:
    """Return the length and the nodes of the shortest tour through contours in a given order."""
    found = best_entries(task, order)
    return found.cost, np.array(
        [task.first[visit.contour] + visit.entry for visit in found.visits], dtype=np.int64
    )


class EntrySearch:
    """A search for a good tour that can be run piece by piece; the pieces do not change what it finds.

    Parameters
    ----------
    task
        See ``entry_task``.
    rounds
        Length of the search, over which it cools down. One takes 10 to 100 microseconds on nests.
    rng
        Draws the seed; the same seed gives the same tours.
    """

    def __init__(self, task: Task, rounds: int, *, rng: np.random.Generator) -> None:
        n, size = len(task.part), len(task.first) - 1
        self.task, self.rounds, self.done = task, rounds, 0
        self._rng = np.random.default_rng(int(rng.integers(2**63)))
        self._path = _new_path(task)
        self._search = new_search(n, size)
        price = float(task.costs.max()) / 4
        begin(task, self._path, self._search, self._rng.permutation(n), price, self._rng)

    @property
    def over(self) -> bool:
        """Whether all rounds are done."""
        return self.done >= self.rounds

    def run(self, rounds: int) -> None:
        """Do more rounds, at most those that are left."""
        until = min(self.rounds, self.done + rounds)
        iterate(self.task, self._path, self._search, self.done, until, self.rounds, self._rng)
        self.done = until

    @property
    def cost(self) -> float:
        """Cost of the best tour so far, mm."""
        return float(self._search.figures[BEST_COST])

    @property
    def barred(self) -> int:
        """Barred legs of the best tour so far: fewer are better than any cost."""
        return int(self._search.figures[BEST_BARRED])

    @property
    def best(self) -> EntryTour:
        """The best tour so far."""
        clusters = self._search.best_clusters
        return best_entries(self.task, clusters[clusters < len(self.task.part)])


def search_entries(task: Task, *, rounds: int, rng: np.random.Generator) -> EntryTour:
    """Return a good tour, mostly an optimal one up to 40 contours with some hundred rounds per contour."""
    search = EntrySearch(task, rounds, rng=rng)
    search.run(rounds)
    return search.best
