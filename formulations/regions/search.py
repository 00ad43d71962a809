r"""Shortest closed tour through convex regions in any order: branch and bound over partial sequences.

A node is a cyclic order of some regions. Its relaxation is the shortest tour through them: each tour through
all regions that has them in this order is at least as long. When it touches the others too, it is the best of
the node. Else one of them is inserted, at each place in turn: these are the children.

Source: Coutinho, do Nascimento, Pessoa, Subramanian (2016).
"""

import heapq
import time
from dataclasses import dataclass, field

import numba
import numpy as np

from cutgap.formulations.regions.interior_point import shortest
from cutgap.formulations.regions.orders import Orders
from cutgap.formulations.regions.shapes import Shapes
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.progress import Progress, Watch, nobody

TOLERANCE = 5e-10
"""A node is dropped when its bound is this near to the best tour, relative to it or 1 mm, the larger."""
FINE, ROUGH, GLANCE = 1e-10, 1e-6, 1e-3
"""Relative precision of bounds near the best tour, of those of nodes, and of children that stay open."""
REPORT_NODES = 100


@numba.njit(cache=True, error_model="numpy")
def insertions(
    shapes: Shapes, order: Ints, region: int, places: Ints, cutoff: float, bounds: Floats, values: Floats
) -> None:
    """Set bounds and values of the tours with a region inserted behind places of an order."""
    n, axes = len(order), shapes.centres.shape[1]
    longer = np.empty(n + 1, np.int64)
    p, u = np.empty((n + 1, axes)), np.empty((n + 1, axes))
    for i in range(len(places)):
        place = places[i]
        for k in range(n):
            longer[k if k <= place else k + 1] = order[k]
        longer[place + 1] = region
        bounds[i], values[i] = shortest(shapes, longer, cutoff, GLANCE, FINE, p, u)


@dataclass(order=True, slots=True)
class Node:
    """An order with its bound; the least bound goes first, then the longest order.

    ``region`` is what its children insert, in order of the places; one that was dropped at once is ``None``.
    """

    bound: float
    rank: tuple[int, int]
    order: Ints = field(compare=False)
    region: int = field(compare=False, default=-1)
    children: "tuple[Node | None, ...]" = field(compare=False, default=())


class RegionSearch:
    """One search.

    Parameters
    ----------
    orders
        The regions and what orders they may have.
    deadline
        ``time.perf_counter()`` at which to stop.

    Attributes
    ----------
    value, best, points
        Length of the best tour, the order of all regions, and its touch points, shape (regions, E).
    """

    def __init__(self, orders: Orders, *, deadline: float = np.inf, watch: Watch = nobody) -> None:
        self.orders = orders
        self.shapes = orders.shapes
        self.deadline = deadline
        self.watch = watch
        self.started = time.perf_counter()
        self.value = np.inf
        self.best: Ints = np.zeros(0, dtype=np.int64)
        self.points: Floats = np.zeros((0, orders.shapes.centres.shape[1]))
        self.nodes = 0
        self.root: Node | None = None
        self.open: list[Node] = []
        self.current: Node | None = None  # taken off the heap and being worked on
        self.closed_bound = np.inf

    @property
    def cutoff(self) -> float:
        """The bound at which a node is dropped."""
        return self.value - TOLERANCE * max(1.0, self.value) if np.isfinite(self.value) else np.inf

    @property
    def lower_bound(self) -> float:
        """What is proved so far: the least bound among open and closed nodes."""
        if self.root is None:
            return 0.0
        nodes = [node.bound for node in (self.current, *self.open[:1]) if node is not None]
        return float(min([self.closed_bound, self.cutoff, *nodes]))

    def tour(self, order: Ints, precision: float = ROUGH) -> tuple[float, float, Floats, Floats]:
        """Return bound, value, touch points and multipliers of the shortest tour in an order."""
        p = np.empty((len(order), self.shapes.centres.shape[1]))
        u = np.empty_like(p)
        bound, value = shortest(self.shapes, order, self.cutoff, precision, FINE, p, u)
        return bound, value, p, u

    def offer(self, order: Ints) -> bool:
        """Keep the shortest tour through an order of all regions if it is the best so far."""
        p = np.empty((len(order), self.shapes.centres.shape[1]))
        _, value = shortest(self.shapes, order, np.inf, FINE, FINE, p, np.empty_like(p))
        if value >= self.value:
            return False
        self.value, self.best, self.points = value, order, p
        self.report()
        return True

    def report(self) -> None:
        """Tell the watcher."""
        seconds = time.perf_counter() - self.started
        self.watch(
            Progress(seconds, self.value, self.lower_bound, f"{self.nodes} nodes, {len(self.open)} open")
        )

    def first_order(self) -> Ints:
        """Return an order of which each plan has one: of three regions, of two where direction matters.

        Each next one makes the tour longest.
        """
        most = min(2 if self.orders.is_ordered else 3, self.orders.count)
        order = np.array([0 if self.orders.home is None else self.orders.home], dtype=np.int64)
        while len(order) < most:
            lengths = [self._longer(order, region) for region in range(self.orders.count)]
            order = np.append(order, int(np.argmax(lengths)))
            if len(order) == 2 and self.orders.home is None and not self.orders.is_ordered:
                # The first one was any: replace it by the farthest from the second.
                lengths = [self._longer(order[1:], region) for region in range(self.orders.count)]
                order = np.array([order[1], int(np.argmax(lengths))])
        return order

    def _longer(self, order: Ints, region: int) -> float:
        return -1.0 if region in order else self.tour(np.append(order, region), GLANCE)[1]

    @property
    def is_closed(self) -> bool:
        """Whether nothing below the cutoff is open."""
        return self.root is not None and not (self.open and self.open[0].bound < self.cutoff)

    def run(self, most_nodes: float = np.inf) -> bool:
        """Search until nothing below the cutoff is open, or for so many nodes in all.

        False when the deadline or Ctrl-C came first.
        """
        try:
            if self.root is None:
                self.root = Node(0.0, (0, 0), self.first_order())
                self.open = [self.root]
            while not self.is_closed and self.nodes < most_nodes:
                if time.perf_counter() > self.deadline:
                    return False
                self.current = heapq.heappop(self.open)
                self._process(self.current)
                self.current = None
                self.nodes += 1
                if self.nodes % REPORT_NODES == 0:
                    self.report()
        except KeyboardInterrupt:
            return False
        return True

    def _process(self, node: Node) -> None:
        """Close a node or push its children."""
        bound, _, p, _ = self.tour(node.order)
        node.bound = max(node.bound, bound)
        if node.bound >= self.cutoff:
            return
        gaps = self.orders.misses(node.order, p)
        region = int(np.argmax(gaps))
        if gaps[region] == 0.0:
            full = self.orders.all_in_order(node.order, p)
            region = full if isinstance(full, int) else self._close(node, full)
            if region < 0:
                return
        self._branch(node, region)

    def _close(self, node: Node, full: Ints) -> int:
        """Offer a node's tour, which touches all regions; return one to insert if it is not the node's best.

        Rounding may let a tour touch what it only comes near to.
        """
        self.offer(full)
        bound, _, p, _ = self.tour(node.order, FINE)
        node.bound = max(node.bound, bound)
        if node.bound >= self.cutoff:
            return -1
        rest = np.setdiff1d(np.arange(self.orders.count), node.order)
        if len(rest) == 0:
            self.closed_bound = min(self.closed_bound, node.bound)
            return -1
        return int(rest[np.argmax(self.orders.misses(node.order, p, 0.0)[rest])])

    def _branch(self, node: Node, region: int) -> None:
        """Push the children that insert a region."""
        places = np.array(self.orders.places(node.order, region), dtype=np.int64)
        bounds, values = np.empty(len(places)), np.empty(len(places))
        insertions(self.shapes, node.order, region, places, self.cutoff, bounds, values)
        children: list[Node | None] = []
        for place, bound in zip(places.tolist(), bounds.tolist(), strict=True):
            if bound >= self.cutoff:
                children.append(None)
                continue
            order = np.insert(node.order, place + 1, region)
            child = Node(max(bound, node.bound), (-len(order), self.nodes), order)
            children.append(child)
            heapq.heappush(self.open, child)
        node.region, node.children = region, tuple(children)
