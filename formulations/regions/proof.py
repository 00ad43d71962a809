"""From the tree of a search to its certificate: each leaf gets multipliers with as few digits as do."""

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import numpy as np

from cutgap.formulations.certificate import problem_of
from cutgap.formulations.certificate.proof import Budget
from cutgap.formulations.certificate.regions import regions_of
from cutgap.formulations.regions.interior_point import shortest
from cutgap.formulations.regions.search import Node, RegionSearch
from cutgap.instances import Instance
from cutgap.instances.arrays import Ints
from cutgap.instances.formats.json_format import format_instance

PRECISIONS = ((1e-2, 10**2), (1e-3, 10**3), (1e-4, 10**5), (1e-6, 10**7), (1e-8, 10**9), (1e-11, 10**13))
"""Relative precision of a leaf's multipliers, and the scale of their integers."""
MOST_NUMBERS = 5_000_000
"""Of all leaves; a checker reads 40 million characters, and a number takes about six."""


class TreeTooLargeError(Exception):
    """The certificate would be longer than a checker reads."""


class Writer:
    """Writes the tree of a search as a proof that no tour is shorter than a length."""

    def __init__(self, search: RegionSearch, instance: Instance) -> None:
        self.search = search
        self.problem = problem_of(format_instance(instance))
        self.regions = regions_of(self.problem)

    def proof(self, length: Fraction) -> dict[str, Any]:
        """Return the proof that tours are at least ``length`` mm long.

        Raises
        ------
        TreeTooLargeError
            When it has too many leaves.
        """
        root = self.search.root
        assert root is not None
        axes, numbers = self.search.shapes.centres.shape[1], 0
        for order, region in self._preorder(root, float(length)):
            numbers += len(order) * axes if region < 0 else 0
            if numbers > MOST_NUMBERS:
                raise TreeTooLargeError
        nodes = [
            region if region >= 0 else self.leaf(order, length)
            for order, region in self._preorder(root, float(length))
        ]
        return {"kind": "regions", "root": root.order.tolist(), "nodes": nodes}

    def _preorder(self, root: Node, length: float) -> Iterator[tuple[Ints, int]]:
        """Yield each node's order and the region that its children insert, -1 for a leaf."""
        waiting: list[tuple[Ints, Node | None]] = [(root.order, root)]
        while waiting:
            order, node = waiting.pop()
            if node is None or node.region < 0 or node.bound >= length * (1.0 + 1e-9) + 1e-6:
                yield order, -1
                continue
            yield order, node.region
            places = self.search.orders.places(order, node.region)
            children = list(zip(places, node.children, strict=True))
            waiting += [
                (np.insert(order, place + 1, node.region), child) for place, child in reversed(children)
            ]

    def leaf(self, order: Ints, length: Fraction) -> list[int]:
        """Return the shortest multipliers tried that prove the length; the last ones in any case."""
        shapes, names = self.search.shapes, order.tolist()
        u = np.empty((len(order), shapes.centres.shape[1]))
        leaf = [1] + [0] * u.size
        if length <= 0:
            return leaf
        for precision, scale in PRECISIONS:
            shortest(shapes, order, np.inf, precision, precision, np.empty_like(u), u)
            leaf = [scale, *map(int, np.trunc(u * (1.0 - 4e-16) * scale).ravel())]
            if self.regions.bound(names, leaf, Budget()) >= length:
                break
        return leaf
