"""The tour of one head by iterated local search, via point included.

The via point is modelled by a gate: an extra node between home and first contour. The edge home - gate is
forced by a very negative length, the gate's edge to a leftmost contour is as long as from home, and its
edges to other contours are forbidden by a very large length. So several contours of equal least x stay a
choice.
"""

from collections.abc import Sequence

import numpy as np

from cutgap.heuristics.sides import SideTour, contour_xs, side_tour
from cutgap.instances import Instance, Rules
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.tours import improve_tour, nearest_neighbour_tour

HOME, GATE = 0, 1


def search_side(
    instance: Instance,
    rules: Rules,
    head: int,
    contours: Sequence[int],
    *,
    kicks: int,
    rng: np.random.Generator,
) -> SideTour:
    """Return a head's tour over the contours; their given order is where the search starts."""
    order = np.asarray(contours, dtype=np.int64)
    if len(order) == 0:
        return side_tour(instance, head, ())
    home = instance.home_node(head)
    leftmost = leftmost_contours(instance, order) if rules.via_points else np.zeros(len(order), dtype=bool)
    nodes = instance.first_node[order]
    seed = int(rng.integers(2**63))
    if home is None:
        tour = improve_tour(instance.rapids[np.ix_(nodes, nodes)], np.arange(len(order)), kicks, seed)
        found = np.roll(tour, -int(np.argmax(leftmost[tour])))
    elif rules.via_points:
        start = np.concatenate(([HOME, GATE], 2 + np.roll(np.arange(len(order)), -int(np.argmax(leftmost)))))
        lengths = gated_lengths(instance.rapids[np.ix_([home, *nodes], [home, *nodes])], leftmost)
        found = after_gate(improve_tour(lengths, start, kicks, seed))
    else:
        lengths = instance.rapids[np.ix_([home, *nodes], [home, *nodes])]
        tour = improve_tour(lengths, np.arange(len(order) + 1), kicks, seed)
        found = np.roll(tour, -int(np.argmax(tour == HOME)))[1:] - 1
    return side_tour(instance, head, order[found])


def leftmost_contours(instance: Instance, contours: Ints) -> np.ndarray:
    """Return which of the contours have the least x."""
    xs = contour_xs(instance)[contours]
    return xs == xs.min()


def gated_lengths(lengths: Floats, leftmost: np.ndarray) -> Floats:
    """Return lengths over home, gate, contours from those over home, contours."""
    n = len(lengths) + 1
    far = 1.0 + n * float(lengths.max())
    gated = np.full((n, n), far)
    rest = np.r_[HOME, 2:n]
    gated[np.ix_(rest, rest)] = lengths
    gated[GATE, 2:][leftmost] = lengths[HOME, 1:][leftmost]
    gated[HOME, GATE] = -far
    if np.array_equal(lengths, lengths.T):
        gated[:, GATE] = gated[GATE]
        gated[GATE, HOME] = gated[HOME, GATE] = -far
    return gated


def after_gate(tour: Ints) -> Ints:
    """Return the contours in order from the gate on; a symmetric tour may have come back to front."""
    tour = np.roll(tour, -int(np.argmax(tour == HOME)))
    if tour[1] != GATE:
        tour = np.concatenate((tour[:1], tour[:0:-1]))
    return tour[2:] - 2


def cheapest_insertion(instance: Instance, head: int, tour: Sequence[int], contour: int) -> tuple[float, int]:
    """Return the least extra travel in mm for one more contour, and the index at which it goes in."""
    home = instance.home_node(head)
    node = int(instance.first_node[contour])
    nodes = instance.first_node[np.asarray(tour, dtype=np.int64)]
    if home is None and len(nodes) == 0:
        return 0.0, 0
    if home is None:
        before, after = np.roll(nodes, 1), nodes
    else:
        before, after = np.concatenate(([home], nodes)), np.concatenate((nodes, [home]))
    rapids = instance.rapids
    extra = rapids[before, node] + rapids[node, after] - rapids[before, after]
    index = int(np.argmin(extra))
    return float(extra[index]), index


def adapt_tour(instance: Instance, head: int, tour: Sequence[int], contours: Ints) -> list[int]:
    """Return a start over ``contours`` from a tour over similar ones, by removals and cheapest insertions."""
    wanted = set(contours.tolist())
    adapted = [c for c in tour if c in wanted]
    if not adapted and len(contours):
        nodes = instance.first_node[contours]
        return [int(c) for c in contours[nearest_neighbour_tour(instance.rapids[np.ix_(nodes, nodes)])]]
    for contour in sorted(wanted.difference(adapted)):
        adapted.insert(cheapest_insertion(instance, head, adapted, contour)[1], contour)
    return adapted
