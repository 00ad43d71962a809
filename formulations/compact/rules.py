"""Rules on order: precedence, and the process rules of Li et al. (2019) that are no matter of cost.

    (one-go h part)          -(sum of y[h,i,j], i in the part, j in another) - sum of y[h,i,-1], i in it  >= -1
    (precedence h i j)       p[h,j] - p[h,i] - n z[h,i] - n z[h,j] >= 1 - 2 n;     one head: p[j] - p[i] >= 1
    (clear h u v k)          p[h,k] - p[h,C(u)] - n x[h,u,v] - n z[h,k] >= 1 - 2 n;
                             one head: p[k] - p[C(u)] - n x[u,v] >= 1 - n;      k crossed on the way from u to v

p is a position in the head's order (``tours.order``). Neighbours only leaves rapids out (``network``), as do
clear rapids those that cross the contour which they leave; one that crosses the contour at its end is clear.

Source: Li et al. (2019), constraints (5), (6) and (8).
"""

import cvxpy as cp
import numpy as np

from cutgap.formulations.compact.family import Family, family
from cutgap.formulations.compact.network import DEPOT, crossed
from cutgap.formulations.compact.variables import HeadVariables, Way
from cutgap.instances import Instance
from cutgap.instances.process import part_of


def one_go(instance: Instance, way: Way) -> list[Family]:
    """A head leaves a part once, for another part or for good; a single contour is left once anyhow."""
    part = part_of(instance)
    several = [number for number in range(int(part.max()) + 1) if (part == number).sum() > 1]
    if not several:
        return []
    # The depot is no part, so its number is that of none.
    numbers = np.append(part, DEPOT)
    tails, heads = numbers[way.pairs.tails], numbers[way.pairs.heads]
    leaving = np.array([(tails == number) & (heads != number) for number in several], dtype=np.float64)
    return [family("one-go", (way.head,), several, -(leaving @ way.y) >= -1)]


def precedence(instance: Instance, way: Way) -> list[Family]:
    """Of a pair on one head the first is cut earlier."""
    pairs = sorted(set(instance.precedence))
    i, j = np.transpose(pairs)
    later = way.position[j] - way.position[i]
    return [family("precedence", (way.head,), pairs, _when_cut(way, later, [way.z[i], way.z[j]]))]


def clear(head: HeadVariables) -> list[Family]:
    """What a rapid crosses is cut after the contour that the rapid leaves."""
    way, (names, legs, k, i) = head.way, crossed(head.network)
    if not names:
        return []
    later = way.position[k] - way.position[i] - way.contours * (head.x[legs] - 1)
    return [family("clear", (way.head,), names, _when_cut(way, later, [way.z[k]]))]


def _when_cut(way: Way, later: cp.Expression, cut: list[cp.Expression]) -> cp.Constraint:
    """Return ``later >= 1``, given up by n for each contour of ``cut`` that another head cuts."""
    if way.alone:
        return later >= 1
    return later + way.contours * sum(1 - z for z in cut) >= 1
