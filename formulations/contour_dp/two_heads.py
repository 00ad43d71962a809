r"""Two heads as one walk: first the left head's visits, then the *switch*, then the right head's.

    Points     v      entry point i of a contour, once for each head that may cut the contour there
               o      the switch: a contour of its own with one point
    Data       l_vw   rapid length; h_0, h_1 homes                                         [mm]
               s_v    work of the contour of v                                             [s]
               a, p   price of one mm of rapid and of one s of work, for either head

    start at v   a l(h_0, v) + p s_v  for the left head, 0 for o, never for the right head
    v -> w       a l_vw + p s_w  for one head;  left v -> o: a l(v, h_0);  o -> right w: a l(h_1, w) + p s_w
    end at v     a l(v, h_1)  for the right head, 0 for o, never for the left head

So the cost of a walk is a (L_0 + L_1) + p (work), whatever the division. With a = 1, p = 0 it is the travel,
with a = 1 / (2 v_jump), p = 1/2 half the sum of both times, which no makespan is below.

Contours of which one head has all points come before or after the switch. A head rests when the switch comes
first or last.
"""

from dataclasses import dataclass

import numpy as np

from cutgap.formulations.contour_dp.division import LEFT, RIGHT, Division, Region
from cutgap.formulations.contour_dp.walks import Bools, Walks, closed_arcs
from cutgap.instances import Instance, Plan, Visit
from cutgap.instances.arrays import Floats, Ints


@dataclass(frozen=True, slots=True)
class Price:
    """a and p of the module: of one mm of rapid, and of one s of work."""

    travel: float
    work: float


def switch_points(division: Division, region: Region) -> tuple[Ints, Bools]:
    """Return the node of each point and whether it is the right head's, contour by contour, the switch last.

    The switch has node -1.
    """
    left, right = division.points(region)
    nodes = np.concatenate((np.flatnonzero(left), np.flatnonzero(right)))
    is_right = np.arange(len(nodes)) >= np.count_nonzero(left)
    order = np.lexsort((is_right, division.contour_of[nodes]))
    return np.append(nodes[order], -1), np.append(is_right[order], False)


def switch_walks(instance: Instance, division: Division, region: Region, price: Price) -> Walks:
    """Return the walk problem of a region in which each contour has a point."""
    nodes, is_right = switch_points(division, region)
    contours = division.contour_of[nodes[:-1]]
    count = len(instance.contours)
    costs, start, end = _costs(instance, nodes, is_right, price, contours)
    if not division.may_rest:
        start[-1] = end[-1] = np.inf
    before = np.zeros((count + 1, count + 1), dtype=np.bool_)
    lefts, rights = np.append(region.side == LEFT, False), np.append(region.side == RIGHT, False)
    before[lefts, count] = before[count, rights] = True
    before[np.ix_(lefts, rights)] = True
    visits = [Visit(int(c), int(v - instance.first_node[c])) for v, c in zip(nodes, contours, strict=False)]
    sizes = [*np.bincount(contours, minlength=count).tolist(), 1]
    return Walks(
        visits=(*visits, Visit(-1)),
        first=np.concatenate(([0], np.cumsum(sizes))).astype(np.int64),
        contours=np.append(np.arange(count), -1),
        costs=costs,
        start=start,
        end=end,
        closed=closed_arcs(before, None),
        before=before,
        parts=None,
        crossed=None,
    )


def _costs(
    instance: Instance, nodes: Ints, is_right: Bools, price: Price, contours: Ints
) -> tuple[Floats, Floats, Floats]:
    """Return costs between points, at the start and at the end."""
    homes = [node for head in (0, 1) if (node := instance.home_node(head)) is not None]
    lengths, inner = instance.rapids, nodes[:-1]
    size, rights = len(nodes), is_right[:-1]
    work = np.append(instance.service_times[contours], 0.0)
    costs = np.full((size, size), np.inf)
    costs[:-1, :-1] = np.where(rights[:, None] == rights, lengths[np.ix_(inner, inner)], np.inf)
    costs[:-1, -1] = np.where(rights, np.inf, lengths[inner, homes[0]])
    costs[-1, :-1] = np.where(rights, lengths[homes[1], inner], np.inf)
    start = np.append(np.where(rights, np.inf, lengths[homes[0], inner]), 0.0)
    end = np.append(np.where(rights, lengths[inner, homes[1]], np.inf), 0.0)
    return (
        price.travel * costs + price.work * work,
        price.travel * start + price.work * work,
        price.travel * end,
    )


def plan_of_switch_walk(walks: Walks, walk: Ints) -> Plan:
    """Return the plan of two heads of a walk."""
    turn = int(np.flatnonzero(walk == len(walks.visits) - 1)[0])
    tours = walk[:turn], walk[turn + 1 :]
    return Plan(tuple(tuple(walks.visits[point] for point in tour) for tour in tours))
