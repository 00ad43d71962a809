"""Tours by the positions of contours: MTZ, and MTZ lifted.

Variable p[h,i] in 1 .. n: the position of contour i in the order of head h; n is the number of contours.

    (position h i j)          p[h,j] - p[h,i] - n y[h,i,j] >= 1 - n
    (lifted-position h i j)   p[h,j] - p[h,i] - n y[h,i,j] - (n - 2) y[h,j,i] >= 1 - n
    (lifted-first h i)        p[h,i] + y[h,-1,i] >= 2;   one head: p[i] + y[-1,i] - (n - 2) y[i,-1] >= 2
    (lifted-last h i)         one head: -p[i] - (n - 2) y[-1,i] + y[i,-1] >= 1 - n

(position): p grows along the way, so the way has no cycle. (lifted-position) says in addition that p grows by
no more than one. The last two hold from two contours on: a contour that is not the first has position 2 or
more, the last of a single head has position n, and one that is not the last has n - 1 or less.

Strength: lifted-mtz >= mtz >= assignment, and both are weak: a cycle of the relaxation needs only sum y <= its
length * (1 - 1 / n).

Source: Miller, Tucker, Zemlin (1960); lifted by Desrochers, Laporte (1991).
"""

from cutgap.formulations.compact.family import Family, family
from cutgap.formulations.compact.variables import Way


def assignment(way: Way) -> list[Family]:
    """Nothing: each contour is entered and left, cycles stay. A relaxation only."""
    return []


def position(way: Way) -> list[Family]:
    """Positions grow along the way; this is the formulation ``mtz``."""
    pairs, n = way.pairs, way.contours
    if n < 2:
        return []
    i, j = pairs.tails[pairs.inner], pairs.heads[pairs.inner]
    left = way.position[j] - way.position[i] - n * way.y[pairs.inner]
    return [family("position", (way.head,), pairs.names[pairs.inner], left >= 1 - n)]


def lifted_mtz(way: Way) -> list[Family]:
    """Positions grow by one along the way, and tell the first and the last contour."""
    if way.contours < 2:
        return []
    return lifted_position(way) + lifted_first(way) + (lifted_last(way) if way.alone else [])


def lifted_position(way: Way) -> list[Family]:
    """Positions grow by one along the way."""
    pairs, n = way.pairs, way.contours
    i, j = pairs.tails[pairs.inner], pairs.heads[pairs.inner]
    back = way.y[pairs.reversed[pairs.inner]]
    left = way.position[j] - way.position[i] - n * way.y[pairs.inner] - (n - 2) * back
    return [family("lifted-position", (way.head,), pairs.names[pairs.inner], left >= 1 - n)]


def lifted_first(way: Way) -> list[Family]:
    """The position is 1 for the first contour only, and n for the last of a single head."""
    pairs, n = way.pairs, way.contours
    left = way.position + way.y[pairs.begin]
    if way.alone:
        left = left - (n - 2) * way.y[pairs.end]
    return [family("lifted-first", (way.head,), range(n), left >= 2)]


def lifted_last(way: Way) -> list[Family]:
    """On a single head the position is n for the last contour only, and 1 for the first."""
    pairs, n = way.pairs, way.contours
    left = -way.position - (n - 2) * way.y[pairs.begin] + way.y[pairs.end]
    return [family("lifted-last", (way.head,), range(n), left >= 1 - n)]
