"""What links and rapids cost, which links are clear, and the cheapest links between contours.

Costs are in mm of rapid: a length, and for the makespan the time of a link or a pierce times v_jump.

    c_e = |pq|, or |pq| v_jump / v_cut for the makespan                      link between nodes p, q
    c_r = d_pq, or d_pq + t_aux v_jump / 2 for each end at a contour         rapid
"""

import heapq

import numpy as np
from scipy.cluster.hierarchy import DisjointSet
from scipy.spatial.distance import cdist

from cutgap.instances import Instance, Rules
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.links.clearance import Bools, blocked

Pair = tuple[int, int]
Multigraph = dict[tuple[int, int, int], int]
"""How often each link and rapid is passed, by its kind (see ``cuts``) and its nodes."""


class LinkGraph:
    """Nodes are those of the instance, the home last; places are the contours and, last, the home.

    Attributes
    ----------
    links, rapids
        Costs between nodes, shape (nodes, nodes), infinite where there is no such edge; blocked links become
        infinite as they are found out.
    place_of
        Place of each node.
    """

    def __init__(self, instance: Instance, rules: Rules) -> None:
        machine = instance.machine
        timed = rules.objective == "makespan"
        self.instance, self.pierces = instance, rules.pierces
        self.euclidean = machine.metric == "euclidean"
        self.nodes, self.places = instance.node_count, len(instance.contours) + 1
        self.home_node, self.home = self.nodes - 1, self.places - 1
        self.first = np.append(instance.first_node, self.nodes)
        self.place_of: Ints = np.repeat(np.arange(self.places), np.diff(self.first))
        within = self.place_of[:, None] == self.place_of
        self.links: Floats = cdist(instance.points, instance.points)
        self.links *= machine.v_jump / machine.v_cut if timed else 1.0
        self.lengths = self.links.copy()
        self.links[within] = np.inf
        self.links[self.home_node] = self.links[:, self.home_node] = np.inf
        pierce = np.full(self.nodes, machine.t_aux * machine.v_jump / 2 if timed else 0.0)
        pierce[self.home_node] = 0.0
        self.rapids: Floats = instance.rapids + pierce[:, None] + pierce
        self.rapids[within] = np.inf
        if rules.pierces == 1:  # no rapid leads from contour to contour
            self.rapids[: self.home_node, : self.home_node] = np.inf
        self._clear, self.blocked = np.zeros((2, self.nodes, self.nodes), dtype=np.bool_)
        starts = self.first[:-1]
        self.least: Floats = np.minimum.reduceat(
            np.minimum.reduceat(self.links, starts, axis=0), starts, axis=1
        )
        """Cost of the cheapest link between two places that is not known to be blocked."""

    def members(self, place: int) -> slice:
        """Return the nodes of a place."""
        return slice(int(self.first[place]), int(self.first[place + 1]))

    def clear(self, tails: Ints, heads: Ints) -> Bools:
        """Return which links are clear, shape (links,), and remember it."""
        known = ~np.isfinite(self.links[tails, heads]) | self._clear[tails, heads]
        new = np.flatnonzero(~known)
        bad = new[blocked(self.instance, tails[new], heads[new])]
        self._clear[tails[new], heads[new]] = self._clear[heads[new], tails[new]] = True
        if len(bad):
            self.links[tails[bad], heads[bad]] = self.links[heads[bad], tails[bad]] = np.inf
            self.blocked[tails[bad], heads[bad]] = self.blocked[heads[bad], tails[bad]] = True
            for place, other in {*zip(self.place_of[tails[bad]], self.place_of[heads[bad]], strict=True)}:
                least = self.links[self.members(place), self.members(other)].min()
                self.least[place, other] = self.least[other, place] = least
        return np.isfinite(self.links[tails, heads])

    def rapids_needed(self, tails: Ints, heads: Ints) -> Bools:
        """Return which rapids no clear link replaces at no more cost, shape (rapids,); the others go."""
        cheaper = self.euclidean & (self.links[tails, heads] <= self.rapids[tails, heads])
        cheaper[cheaper] = self.clear(tails[cheaper], heads[cheaper])
        self.rapids[tails[cheaper], heads[cheaper]] = self.rapids[heads[cheaper], tails[cheaper]] = np.inf
        return ~cheaper

    def cheapest(self, place: int, other: int) -> Pair:
        """Return the cheapest link between two places that is not known to be blocked."""
        block = self.links[self.members(place), self.members(other)]
        p, q = np.unravel_index(int(block.argmin()), block.shape)
        return int(self.first[place] + p), int(self.first[other] + q)

    def nearest_rapid(self, place: int) -> Pair:
        """Return the cheapest rapid between the home and a contour."""
        members = self.members(place)
        return members.start + int(self.rapids[members, self.home_node].argmin()), self.home_node

    def tree(self) -> list[Pair]:
        """Return the cheapest clear links that join contours as far as links can (Kruskal)."""
        joints = DisjointSet(range(self.places))
        heap = [(float(self.least[i, j]), i, j) for i in range(self.home) for j in range(i)]
        heapq.heapify(heap)
        found: list[Pair] = []
        while heap:
            _, i, j = heapq.heappop(heap)
            if joints.connected(i, j) or not np.isfinite(self.least[i, j]):
                continue
            p, q = self.cheapest(i, j)
            if self.clear(np.array([p]), np.array([q]))[0]:
                joints.merge(i, j)
                found.append((min(p, q), max(p, q)))
            else:
                heapq.heappush(heap, (float(self.least[i, j]), i, j))
        return found
