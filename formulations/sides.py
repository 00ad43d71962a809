"""Shortest tours of one head over many sets of contours, each known between two bounds that tighten on demand.

Sets are bit masks of contour indices. In a metric a tour of a set, cut short to a subset, gets no longer; so
the lower bound of a set passes to its supersets, unless via points forbid the shortcut (see ``inherits``).
"""

import time
from dataclasses import dataclass

import numpy as np

from cutgap.formulations.branch_and_cut.engine import Outcome
from cutgap.formulations.branch_and_cut.tour import best_tour, shortest_tour
from cutgap.formulations.relaxations.one_tree import held_karp_bound
from cutgap.instances import Instance
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.progress import Watch, nobody
from cutgap.instances.result import OPTIMALITY_TOLERANCE
from cutgap.instances.tours import tour_length

SHORT_SEARCH, LONG_SEARCH = 1, 10
"""Kicks of local search per node: for a set's first tour, and before branch and cut."""


@dataclass(slots=True)
class Side:
    """One head's tours of one set of contours: ``lower <= shortest <= upper`` in mm."""

    contours: tuple[int, ...]
    nodes: int  # with the home, if there is one
    service_s: float
    lower: float = 0.0
    upper: float = np.inf
    order: tuple[int, ...] = ()
    inherited_from: int = 0  # how many known bounds were looked at
    one_tree: tuple[float, Floats] | None = None  # Held-Karp bound and its potentials
    search: Outcome | None = None  # the last branch and cut

    @property
    def relaxed(self) -> bool:
        """Whether the first, cheap bound was taken."""
        return self.one_tree is not None

    @property
    def own_lower(self) -> float:
        """Lower bound that this set's own proofs show."""
        bounds = [0.0 if self.one_tree is None else self.one_tree[0]]
        return max(bounds if self.search is None else [*bounds, self.search.lower_bound])

    @property
    def is_exact(self) -> bool:
        """Whether the bounds meet."""
        slack = OPTIMALITY_TOLERANCE / 4 * max(1.0, self.upper)
        return bool(np.isfinite(self.upper)) and self.upper - self.lower <= slack


class Sides:
    """All sets that one head has been asked about.

    Parameters
    ----------
    inherits
        Whether a set's lower bound holds for its supersets.
    """

    def __init__(self, instance: Instance, head: int, *, via_points: bool, inherits: bool) -> None:
        self.instance = instance
        self.home = instance.home_node(head)
        self.via_points = via_points and self.home is not None  # a closed tour can start at its leftmost point
        self.inherits = inherits
        self._sides: dict[int, Side] = {}
        self._known: list[tuple[int, float]] = []

    def side(self, members: int) -> Side:
        """Return what is known about a set; its lower bound includes what subsets proved meanwhile."""
        side = self._sides.get(members)
        if side is None:
            contours = tuple(c for c in range(len(self.instance.contours)) if members >> c & 1)
            side = Side(
                contours,
                len(contours) + (self.home is not None),
                float(self.instance.service_times[list(contours)].sum()),
            )
            if not contours:
                side.upper = 0.0
            self._sides[members] = side
        if self.inherits:
            for known, lower in self._known[side.inherited_from :]:
                if lower > side.lower and known & members == known:
                    side.lower = min(lower, side.upper)
            side.inherited_from = len(self._known)
        return side

    def peek(self, members: int) -> tuple[float, float, float]:
        """Return what is known about a set and change nothing: bounds on its tour (mm), service time (s)."""
        known = self._sides.get(members)
        if known is not None:
            return known.lower, known.upper, known.service_s
        contours = [c for c in range(len(self.instance.contours)) if members >> c & 1]
        implied = [low for each, low in self._known if each & members == each] if self.inherits else []
        upper = np.inf if contours else 0.0
        return max(implied, default=0.0), upper, float(self.instance.service_times[contours].sum())

    def tighten(self, members: int, cutoff: float, deadline: float, watch: Watch = nobody) -> bool:
        """Raise a set's lower bound by the next stronger method; False when the deadline passed first.

        First the Held-Karp bound, then branch and cut, which need not go beyond the cutoff (mm) and starts
        from a longer local search; the watch is told of it in mm, its nodes numbered as in ``lengths``.
        """
        side = self.side(members)
        lengths, via = self.lengths(side.contours), self.via(side.contours)
        complete = True
        if side.one_tree is None:
            target = min(cutoff, side.upper)
            side.one_tree = held_karp_bound(lengths, tuple(via.tolist()), target=target)
            lower = side.one_tree[0]
        else:
            self._keep(side, *best_tour(lengths, via, lengths, LONG_SEARCH * len(lengths)))
            start = side.upper, self._tour(side)
            outcome = shortest_tour(lengths, via, start=start, cutoff=cutoff, deadline=deadline, watch=watch)
            lower, complete, side.search = outcome.lower_bound, outcome.complete, outcome
            if outcome.solution is not None:
                self._keep(side, tour_length(lengths, outcome.solution), outcome.solution)
        side.lower = min(max(side.lower, lower), side.upper)
        if self.inherits:
            self._known.append((members, side.lower))
        return complete and time.perf_counter() <= deadline

    def proved(self) -> list[tuple[int, Side]]:
        """Return the sets with bounds of their own, those left out whose bound a subset's one implies."""
        own = [(members, side) for members, side in self._sides.items() if side.relaxed and side.contours]
        if not self.inherits:
            return own
        return [
            (members, side)
            for members, side in own
            if not any(
                other != members and other & members == other and each.own_lower >= side.own_lower
                for other, each in own
            )
        ]

    def tour(self, members: int) -> Side:
        """Return a set with a tour, by a short local search if none is known."""
        side = self.side(members)
        if not np.isfinite(side.upper):
            lengths = self.lengths(side.contours)
            self._keep(side, *best_tour(lengths, self.via(side.contours), lengths, SHORT_SEARCH * len(lengths)))
        return side

    def removal_gains(self, order: tuple[int, ...]) -> Floats:
        """Return by how much a tour gets shorter when each of its contours is left out, mm."""
        nodes = self.nodes(order)
        before, after = np.roll(nodes, 1), np.roll(nodes, -1)
        rapids = self.instance.rapids
        gains = rapids[before, nodes] + rapids[nodes, after] - rapids[before, after]
        return gains[len(nodes) - len(order) :]

    def insertion_cost(self, order: tuple[int, ...], contour: int) -> float:
        """Return by how much a tour gets longer when a contour is put at its best place, mm."""
        nodes, new = self.nodes(order), self.instance.node(contour)
        after, rapids = np.roll(nodes, -1), self.instance.rapids
        if len(nodes) == 0:
            return 0.0
        return float((rapids[nodes, new] + rapids[new, after] - rapids[nodes, after]).min())

    def nodes(self, contours: tuple[int, ...]) -> Ints:
        """Return the node of the home (if any, first) and of each contour."""
        nodes = [self.instance.node(contour) for contour in contours]
        return np.array(nodes if self.home is None else [self.home, *nodes], dtype=np.int64)

    def lengths(self, contours: tuple[int, ...]) -> Floats:
        """Return rapid lengths between the home (if any, first) and the contours."""
        nodes = self.nodes(contours)
        return self.instance.rapids[np.ix_(nodes, nodes)]

    def via(self, contours: tuple[int, ...]) -> Ints:
        """Return the positions in ``lengths`` of the leftmost contours, if one must come first."""
        if not self.via_points:
            return np.empty(0, dtype=np.int64)
        xs = self.instance.points[[self.instance.node(contour) for contour in contours], 0]
        leftmost = np.flatnonzero(xs == xs.min()) + 1
        # When all are leftmost, any may come first.
        return leftmost if len(leftmost) < len(xs) else np.empty(0, dtype=np.int64)

    def _keep(self, side: Side, value: float, tour: Ints) -> None:
        """Remember a tour (positions in ``lengths``) if it is the shortest so far."""
        if value >= side.upper:
            return
        side.upper = value
        if self.home is not None:
            side.order = tuple(side.contours[position - 1] for position in tour[1:])
            return
        order = [side.contours[position] for position in tour]
        leftmost = min(order, key=lambda contour: self.instance.points[self.instance.node(contour), 0])
        first = order.index(leftmost)
        side.order = tuple(order[first:] + order[:first])

    def _tour(self, side: Side) -> Ints:
        """Return the best tour as positions in ``lengths``."""
        position = {contour: i for i, contour in enumerate(side.contours)}
        if self.home is None:
            return np.array([position[contour] for contour in side.order])
        return np.array([0, *(position[contour] + 1 for contour in side.order)])
