"""Shortest tours of one of two heads through some contours at some entry points, bounded step by step."""

from dataclasses import replace

import numpy as np

from cutgap.formulations.contour_dp.solve import ContourSearch
from cutgap.formulations.contour_dp.walks import Bools
from cutgap.instances import Instance, Rules, Visit
from cutgap.instances.arrays import Ints
from cutgap.instances.progress import nobody


class Side:
    """One head with a home, which visits each contour of some entry points.

    Attributes
    ----------
    service_s
        Work of the contours, s.
    """

    def __init__(self, instance: Instance, head: int, nodes: Ints, begun: float, limit: float | None) -> None:
        of_node = np.searchsorted(instance.first_node, nodes, side="right") - 1
        self.contours = np.unique(of_node)
        self.entries = [nodes[of_node == c] - instance.first_node[c] for c in self.contours]
        self.service_s = float(instance.service_times[self.contours].sum())
        self.search: ContourSearch | None = None
        if len(nodes):
            part = self._part(instance, head, nodes)
            self.search = ContourSearch(part, Rules("travel"), None, begun, limit, nobody)

    def _part(self, instance: Instance, head: int, nodes: Ints) -> Instance:
        contours = tuple(
            replace(instance.contours[c], entry_points=instance.contours[c].entry_points[entries])
            for c, entries in zip(self.contours, self.entries, strict=True)
        )
        kept = [*nodes.tolist(), instance.home_node(head)]
        matrix = None if instance.matrix is None else instance.matrix[np.ix_(kept, kept)]
        return replace(instance, contours=contours, heads=(instance.heads[head],), precedence=(), matrix=matrix)

    @property
    def lower(self) -> float:
        """No tour is shorter, mm."""
        return 0.0 if self.search is None else max(0.0, self.search.bound)

    @property
    def upper(self) -> float:
        """Length of the best tour found, mm."""
        return 0.0 if self.search is None else self.search.incumbent.cost

    @property
    def closed(self) -> bool:
        """Whether the best tour found is a shortest one."""
        return self.search is None or self.search.closed

    @property
    def tour(self) -> tuple[Visit, ...]:
        """The best tour found."""
        if self.search is None or self.search.plan is None:
            return ()
        (visits,) = self.search.plan.tours
        return tuple(Visit(int(self.contours[c]), int(self.entries[c][entry])) for c, entry, _ in visits)

    def advance(self) -> bool:
        """Raise the bound or find a shorter tour; False when neither works any more."""
        return self.search is not None and self.search.advance()


class Sides:
    """The sides of an instance with two heads, each made once."""

    def __init__(self, instance: Instance, begun: float, limit: float | None) -> None:
        self.instance, self.begun, self.limit = instance, begun, limit
        self.known: dict[tuple[int, bytes], Side] = {}

    def side(self, head: int, points: Bools) -> Side:
        """Return the side of a head that visits each contour with a point."""
        key = head, np.packbits(points).tobytes()
        if key not in self.known:
            nodes = np.flatnonzero(points)
            self.known[key] = Side(self.instance, head, nodes, self.begun, self.limit)
        return self.known[key]
