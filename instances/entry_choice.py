"""The best entry points for contours in a given order: a shortest path through layers, exact.

    (1) D_1(v) = rapid from the home to v, for the entry points v of the first contour
    (2) D_k(w) = min over v of contour k - 1 of  D_{k-1}(v) + cost(v, w)
    (3) value  = min over v of the last contour of  D_n(v) + rapid from v to the home

Without a home the tour is closed: (1) to (3) run for each entry point u of the first contour, with D_1(u) = 0
and u in the place of the home in (3). The costs are those of ``process.rapid_costs``. Under clear rapids (2)
leaves out rapids that cross a contour of 1 .. k - 1: the order is given, so what is cut is known. All in mm.
"""

from collections.abc import Sequence

import numba
import numpy as np

from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.instance import Instance
from cutgap.instances.plan import Visit
from cutgap.instances.process import WORD, Words, crossings, rapid_costs
from cutgap.instances.rules import Rules


def best_entries(
    instance: Instance, rules: Rules, order: Sequence[int] | Ints, head: int = 0
) -> tuple[Visit, ...] | None:
    """Return the cheapest tour of a head that cuts these contours in this order.

    Cheapest is least travel plus backward price, clear of contours of this tour if the rules ask for clear
    rapids. The other process rules depend on the order alone; via points are not heeded.

    Returns
    -------
    tuple[Visit, ...] | None
        ``None`` when no choice of entry points keeps all rapids clear.

    Raises
    ------
    ValueError
        When the order names a contour twice or one that does not exist, or a contour lacks the geometry that
        clear rapids need.
    """
    contours = np.asarray(order, dtype=np.int64)
    if len(np.unique(contours)) < len(contours):
        raise ValueError(f"order: names a contour more than once, got {contours.tolist()!s:.80}")
    if len(contours) == 0:
        return ()
    for contour in contours[(contours < 0) | (contours >= len(instance.contours))]:
        raise ValueError(f"order: no contour {contour} among {len(instance.contours)}")
    home = instance.home_node(head)
    value, nodes = shortest_layers(
        rapid_costs(instance, rules),
        instance.rapids,
        contours,
        instance.first_node,
        -1 if home is None else home,
        blocking_crossings(instance, rules),
    )
    if not np.isfinite(value):
        return None
    starts = instance.first_node[contours]
    return tuple(Visit(*visit) for visit in np.column_stack((contours, nodes - starts)).tolist())


def blocking_crossings(instance: Instance, rules: Rules) -> Words:
    """Return ``process.crossings``, or sets of no words when the rules do not ask for clear rapids."""
    if rules.clear_rapids:
        return crossings(instance)
    places = int(instance.first_node[-1])
    return np.zeros((places, places, 0), dtype=np.uint64)


@numba.njit(cache=True)
def crosses(crossed: Words, cut: Words) -> bool:
    """Whether two sets of contours have a contour in common."""
    common = np.uint64(0)
    for word in range(len(crossed)):
        common |= crossed[word] & cut[word]
    return common != 0


@numba.njit(cache=True)
def shortest_layers(
    costs: Floats, lengths: Floats, order: Ints, first_node: Ints, home: int, crossed: Words
) -> tuple[float, Ints]:
    """Return value (3), infinite when no choice is clear, and the node at which each contour is entered.

    Parameters
    ----------
    costs, lengths
        Shape (nodes, nodes): of rapids between contours; of those from the home and back, or closing.
    order
        At least one contour.
    home
        Node of the home, or -1.
    crossed
        Shape (points, points, words): contours that each rapid must not cross once they are cut.
    """
    distance, before = np.empty(first_node[-1]), np.empty(first_node[-1], np.int64)
    nodes, best = np.empty(len(order), np.int64), np.inf
    first, first_end = first_node[order[0]], first_node[order[0] + 1]
    for start in range(first, first_end if home < 0 else first + 1):
        for v in range(first, first_end):
            distance[v] = lengths[home, v] if home >= 0 else 0.0 if v == start else np.inf
        _relax(costs, order, first_node, crossed, distance, before)
        end = home if home >= 0 else start
        last = -1
        for v in range(first_node[order[-1]], first_node[order[-1] + 1]):
            if distance[v] + lengths[v, end] < best:
                best, last = distance[v] + lengths[v, end], v
        if last >= 0:
            for k in range(len(order) - 1, -1, -1):
                nodes[k] = last
                last = before[last]
    return best, nodes


@numba.njit(cache=True)
def _relax(
    costs: Floats, order: Ints, first_node: Ints, crossed: Words, distance: Floats, before: Ints
) -> None:
    """Apply (2) layer by layer: fill ``distance`` from the second contour on, and whence it comes."""
    cut = np.zeros(crossed.shape[2], np.uint64)
    for k in range(1, len(order)):
        a, b = order[k - 1], order[k]
        if len(cut):
            cut[a // WORD] |= np.uint64(1) << np.uint64(a % WORD)
        for w in range(first_node[b], first_node[b + 1]):
            distance[w], before[w] = np.inf, -1
            for v in range(first_node[a], first_node[a + 1]):
                through = distance[v] + costs[v, w]
                if through < distance[w] and not crosses(crossed[v, w], cut):
                    distance[w], before[w] = through, v
