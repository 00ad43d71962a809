"""One stroke over a doubled spanning tree: the published way to cut a nest with one ignition.

    (1) Prim over contours: begin with the first; time and again join, by the shortest clear link between entry
        points, a contour that is not joined yet to those that are.
    (2) Each link is passed twice, so that all degrees are even.
    (3) The stroke starts, and ends, at the joined point that is nearest to the home.

A link that leads through material is replaced by the shortest that does not. What no clear link reaches gets
strokes of its own, the nearest start first, and what must be cut first before that; with ``pierces`` = 1
``check`` then says so. The way through a stroke, "bridge first, then edge", is ``links.trajectory``.

Source: Chen, Li, Chu. Points inside edges are for the instance's entry points to hold.
"""

import heapq
from collections.abc import Iterator

import numpy as np
from scipy.spatial.distance import cdist

from cutgap.heuristics.sides import Clock
from cutgap.instances import Instance, Link, Plan, Rules, Visit, evaluate
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.check import require_coordinates
from cutgap.instances.links.clearance import blocked, require_shapes
from cutgap.instances.links.strokes import groups
from cutgap.instances.nesting import enclosures
from cutgap.instances.progress import Progress, Watch, nobody

TESTED_AT_ONCE = 16
"""How many of the shortest links between two contours are tested for clearance first; then four times more."""


def euler_bridging(
    instance: Instance,
    rules: Rules,
    *,
    rng: np.random.Generator,
    watch: Watch = nobody,
    time_limit: float | None = None,
) -> Plan:
    """Plan one head with as few strokes as clear links allow, over doubled links.

    It is made in one go, without chance: ``rng`` and ``time_limit`` are not used.

    Raises
    ------
    ValueError
        When the rules do not allow links, or do not suit the instance (see ``link_check.require_links``).
    """
    if not rules.links:
        raise ValueError("euler-bridging: the rules allow no links; ask for links")
    require_coordinates(instance, rules)
    clock = Clock(None)
    links = spanning_forest(instance)
    plan = Plan((nearest_starts(instance, links),), links)
    watch(Progress(clock.seconds, value=evaluate(instance, plan).objective(rules)))
    return plan


def spanning_forest(instance: Instance) -> tuple[Link, ...]:
    """Return the links of (1), each passed twice, in the order in which Prim takes them.

    Of several shortest links the first by the numbers of its contours and entry points is taken. Where no
    clear link leads on, it begins anew with the first contour that is not joined.
    """
    grower = _Grower(instance)
    waiting = list(range(len(instance.contours)))
    links = []
    while waiting:
        found = grower.next_link()
        if found is None:
            grower.join(waiting[0])
        else:
            links.append(found)
            grower.join(found.to_contour)
        waiting = [contour for contour in waiting if not grower.joined[contour]]
    return tuple(links)


class _Grower:
    """Prim's queue: links by length, where a pair of contours first stands with the gap between their boxes.

    Clearance is tested only when a link's turn has come.
    """

    def __init__(self, instance: Instance) -> None:
        self.instance, self.rooms = instance, rooms(instance)
        self.joined = np.zeros(len(instance.contours), dtype=np.bool_)
        corners = [instance.points[slice(*instance.first_node[c : c + 2])] for c in range(len(self.joined))]
        self.low = np.array([points.min(axis=0) for points in corners]).reshape(-1, 3)
        self.high = np.array([points.max(axis=0) for points in corners]).reshape(-1, 3)
        self.queue: list[tuple[float, int, int, int, int]] = []

    def join(self, contour: int) -> None:
        """Count a contour as joined, and queue what it may be linked to."""
        self.joined[contour] = True
        gaps = np.maximum(0.0, np.maximum(self.low - self.high[contour], self.low[contour] - self.high))
        for other in np.flatnonzero(~self.joined & (self.rooms == self.rooms[contour])).tolist():
            bound = float(np.linalg.norm(gaps[other]))
            heapq.heappush(self.queue, (bound, contour, other, -1, -1))

    def next_link(self) -> Link | None:
        """Return the shortest clear link that leads on, or ``None``."""
        while self.queue:
            _, contour, other, node, to_node = heapq.heappop(self.queue)
            if self.joined[other]:
                continue
            if node >= 0:
                first = self.instance.first_node
                return Link(contour, node - int(first[contour]), other, to_node - int(first[other]))
            found = next(clear_links(self.instance, contour, other), None)
            if found is not None:
                heapq.heappush(self.queue, (found[0], contour, other, *found[1:]))
        return None


def rooms(instance: Instance) -> Ints:
    """Return in which piece of waste the links of each contour lie, shape (contours,).

    That is -1 around the parts, and the number of the hole within one: no link leads from one to the other.
    """
    around = enclosures(require_shapes(instance)) if instance.contours else []
    return np.array(
        [contour if len(each) % 2 else (each[0] if each else -1) for contour, each in enumerate(around)],
        dtype=np.int64,
    )


def clear_links(instance: Instance, contour: int, other: int) -> Iterator[tuple[float, int, int]]:
    """Yield the clear links between two contours by length: mm, node of the one, node of the other."""
    ones, others = (np.arange(*instance.first_node[c : c + 2]) for c in (contour, other))
    lengths: Floats = cdist(instance.points[ones], instance.points[others]).ravel()
    done, count = 0, TESTED_AT_ONCE
    while done < len(lengths):
        count = min(count, len(lengths))
        near = np.flatnonzero(lengths <= np.partition(lengths, count - 1)[count - 1])  # with all equal ones
        order = near[np.argsort(lengths[near], kind="stable")][done:]
        starts, ends = ones[order // len(others)], others[order % len(others)]
        for place in np.flatnonzero(~blocked(instance, starts, ends)).tolist():
            yield float(lengths[order[place]]), int(starts[place]), int(ends[place])
        done, count = len(near), 4 * count


def nearest_starts(instance: Instance, links: tuple[Link, ...]) -> tuple[Visit, ...]:
    """Return (3) for each stroke, from where the one before has ended.

    A stroke waits for those that cut what must be cut before one of its contours.
    """
    leaders = np.array(groups(instance, links), dtype=np.int64)
    first, at = instance.first_node, instance.home_node(0)
    assert at is not None  # rules with links ask for it
    owners = np.repeat(np.arange(len(leaders)), np.diff(first))
    waits = {(int(leaders[b]), int(leaders[a])) for a, b in instance.precedence if leaders[a] != leaders[b]}
    left, visits = set(leaders.tolist()), []
    while left:
        held = {group for group, before in waits if before in left}
        ready = (left - held) or left
        nodes = np.flatnonzero(np.isin(leaders[owners], list(ready)))
        at = int(nodes[np.argmin(instance.rapid_lengths([at], nodes)[0])])
        contour = int(owners[at])
        visits.append(Visit(contour, at - int(first[contour])))
        left.remove(int(leaders[contour]))
    return tuple(visits)
