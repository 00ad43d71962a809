"""Kernels of tours over contours with entry points: cheapest entries for an order, and for one contour more.

A tour is an order of contours; each contour may be entered at any of its points. For a fixed order

    (1) forward(v)  = min over u in the contour before of  forward(u) + leg(u, v);   0 at the start
    (2) backward(u) = min over v in the contour after of  leg(u, v) + backward(v);  closing(u, start) at last
    (3) value       = min over u in the last contour of  forward(u) + closing(u, start)
    (4) with contour c between contours a and b:
        min over w in c of  min_{u in a} (forward(u) + leg(u, w)) + min_{v in b} (leg(w, v) + backward(v))

so that (4) prices an insertion with all entries chosen anew, at the cost of two legs. The start is one node:
the home, or the entry at the first place, which is chosen anew when the others are known.

A leg costs its length, and ``price`` more when it is barred: when the set of contours that bars it holds one
that is cut by then. Bit ``n`` of these sets, after the contours 0..n-1, stands for "always".
"""

from typing import NamedTuple

import numba
import numpy as np
import numpy.typing as npt

from cutgap.instances.arrays import Floats, Ints

Words = npt.NDArray[np.uint64]
Bools = npt.NDArray[np.bool_]

FAST = {"nnan", "nsz"}
"""No sum here is ever not a number: without that case the loops over entries run on vectors."""

SAME = 1e-12
"""Changes of figures of (1) or (2) that differ by this share of them are the same, and differ by rounding."""


class Task(NamedTuple):
    """What the kernels read; n contours are clusters 0..n-1, and cluster n is the home, if there is one.

    Attributes
    ----------
    costs, arrivals
        Cost of each leg, shape (nodes, nodes), and its transpose.
    closing
        Cost of the leg from the last place to the first, by which the tour closes, shape (nodes, nodes).
    least
        Cheapest leg from cluster to cluster, shape (clusters, clusters).
    first
        First node of each cluster, then the number of nodes.
    before
        Whether a contour must be cut before another, shape (n, n), transitive.
    part
        Part of each contour, shape (n,): those of one part stay together.
    barred
        Sets that bar the legs, shape (nodes, nodes, words), symmetric; shape (0, 0, 0) bars none.
    near
        Other contours of each contour, nearest first, shape (n, n - 1).
    anchored
        Whether the home is the fixed start.
    cyclic
        Whether any contour may as well be the first, at the same value.
    """

    costs: Floats
    arrivals: Floats
    closing: Floats
    least: Floats
    first: Ints
    before: Bools
    part: Ints
    barred: Words
    near: Ints
    anchored: bool
    cyclic: bool


class Path(NamedTuple):
    """A tour under work: clusters and nodes by place, and tables for them.

    ``forward`` and ``backward`` are (1) and (2) by node, ``reach`` and ``rest`` their least figures by cluster.
    By cluster too, ``cut`` holds the contours that are cut when it is left, and ``later`` the same with the
    contour that is to be inserted: it bars the legs that come after it. ``bounds`` is by place.
    """

    clusters: Ints
    nodes: Ints
    forward: Floats
    backward: Floats
    reach: Floats
    rest: Floats
    cut: Words
    later: Words
    bounds: Floats


@numba.njit(cache=True, fastmath=FAST)
def pull(lengths: Floats, first: Ints, here: Floats, a: int, b: int, there: Floats) -> float:
    """Set ``there[v]`` to the least ``here[u] + lengths[v, u]``, u in a and v in b; return the least."""
    begin, end = first[a], first[a + 1]
    come, overall = here[begin:end], np.inf
    for v in range(first[b], first[b + 1]):
        row, least = lengths[v, begin:end], np.inf
        for u in range(end - begin):
            least = min(least, come[u] + row[u])
        there[v] = least
        overall = min(overall, least)
    return overall


@numba.njit(cache=True, fastmath=FAST)
def pull_barred(
    lengths: Floats,
    first: Ints,
    here: Floats,
    a: int,
    b: int,
    there: Floats,
    barred: Words,
    cut: Words,
    price: float,
) -> float:
    """Do the same where sets may bar the legs; they are symmetric, so both ways are alike."""
    begin, end = first[a], first[a + 1]
    come, overall = here[begin:end], np.inf
    for v in range(first[b], first[b + 1]):
        row, sets, least = lengths[v, begin:end], barred[v, begin:end], np.inf
        for u in range(end - begin):
            least = min(least, come[u] + row[u] + (price if is_barred(sets[u], cut) else 0.0))
        there[v] = least
        overall = min(overall, least)
    return overall


@numba.njit(cache=True)
def is_barred(sets: Words, cut: Words) -> bool:
    """Whether a contour of the set is cut."""
    for word in range(len(sets)):  # noqa: SIM110, any() is slow here
        if sets[word] & cut[word]:
            return True
    return False


@numba.njit(cache=True)
def leg(task: Task, u: int, v: int, cut: Words, price: float) -> float:
    """Return the cost of one leg."""
    if len(task.barred) and is_barred(task.barred[u, v], cut):
        return task.costs[u, v] + price
    return task.costs[u, v]


@numba.njit(cache=True)
def add_contour(sets: Words, row: int, contour: int) -> None:
    """Add a contour to the set in a row."""
    sets[row, contour // 64] |= np.uint64(1) << np.uint64(contour % 64)


@numba.njit(cache=True)
def note_cut(task: Task, path: Path, size: int, inserted: int) -> None:
    """Set which contours are cut when each place is left, without and with one to be inserted (n: none).

    Bit n stands in all of these sets.
    """
    n, words = len(task.part), path.cut.shape[1]
    for place in range(size):
        k = path.clusters[place]
        for word in range(words):
            path.cut[k, word] = path.cut[path.clusters[place - 1], word] if place > 0 else np.uint64(0)
        if place == 0:
            add_contour(path.cut, k, n)
        if k < n:
            add_contour(path.cut, k, k)
        for word in range(words):
            path.later[k, word] = path.cut[k, word]
        add_contour(path.later, k, inserted)


@numba.njit(cache=True)
def begin_forward(task: Task, path: Path) -> None:
    """Set (1) at the first place."""
    k = path.clusters[0]
    path.forward[task.first[k] : task.first[k + 1]] = np.inf
    path.forward[path.nodes[0]] = 0.0
    path.reach[k] = 0.0


@numba.njit(cache=True)
def end_backward(task: Task, path: Path, size: int) -> None:
    """Set (2) at the last place."""
    k, rest = path.clusters[size - 1], np.inf
    for u in range(task.first[k], task.first[k + 1]):
        path.backward[u] = task.closing[u, path.nodes[0]]
        rest = min(rest, path.backward[u])
    path.rest[k] = rest


@numba.njit(cache=True)
def fill_forward(task: Task, path: Path, since: int, size: int, price: float) -> None:
    """Fill (1) from place ``since`` >= 1 on."""
    lengths, first, barred = task.arrivals, task.first, task.barred
    clusters, forward, reach, cut = path.clusters, path.forward, path.reach, path.cut
    for place in range(since, size):
        a, b = clusters[place - 1], clusters[place]
        if len(barred):
            reach[b] = pull_barred(lengths, first, forward, a, b, forward, barred, cut[a], price)
        else:
            reach[b] = pull(lengths, first, forward, a, b, forward)


@numba.njit(cache=True)
def fill_backward(task: Task, path: Path, since: int, price: float) -> None:
    """Fill (2) from place ``since``, which is not the last one, down to place 1; ``later`` says what is cut."""
    lengths, first, barred = task.costs, task.first, task.barred
    clusters, backward, rest, later = path.clusters, path.backward, path.rest, path.later
    for place in range(since, 0, -1):
        a, b = clusters[place + 1], clusters[place]
        if len(barred):
            rest[b] = pull_barred(lengths, first, backward, a, b, backward, barred, later[b], price)
        else:
            rest[b] = pull(lengths, first, backward, a, b, backward)


@numba.njit(cache=True)
def _repeat(
    lengths: Floats, first: Ints, table: Floats, least: Floats, clusters: Ints, place: int, step: int, end: int
) -> None:
    """Fill a table again from ``place`` on, by ``step``, until its change is the same at all entries.

    From there on the change is the same at all entries to the end, and is added without looking at legs.
    """
    old, change = np.empty(len(table)), 0.0
    while place != end:
        a, b = clusters[place - step], clusters[place]
        begin, finish = first[b], first[b + 1]
        old[: finish - begin] = table[begin:finish]
        least[b] = pull(lengths, first, table, a, b, table)
        change, same = table[begin] - old[0], True
        for k in range(1, finish - begin):
            if abs(table[begin + k] - old[k] - change) > SAME * table[begin + k]:
                same = False
                break
        place += step
        if same:
            break
    while place != end:
        b = clusters[place]
        least[b] += change
        for v in range(first[b], first[b + 1]):
            table[v] += change
        place += step


@numba.njit(cache=True)
def refresh(task: Task, path: Path, place: int, size: int) -> None:
    """Bring (1) and (2) up to date after an insertion at ``place`` >= 1, where no legs are barred."""
    first, clusters = task.first, path.clusters
    c, a = clusters[place], clusters[place - 1]
    path.reach[c] = pull(task.arrivals, first, path.forward, a, c, path.forward)
    if place + 1 < size:
        _repeat(task.arrivals, first, path.forward, path.reach, clusters, place + 1, 1, size)
        path.rest[c] = pull(task.costs, first, path.backward, clusters[place + 1], c, path.backward)
    else:
        end_backward(task, path, size)
    if place > 1:
        _repeat(task.costs, first, path.backward, path.rest, clusters, place - 1, -1, 0)


@numba.njit(cache=True, fastmath=FAST)
def insertion(task: Task, path: Path, size: int, c: int, gap: int, price: float, most: float) -> float:
    """Return (4) for contour ``c`` after place ``gap`` >= 0, or more than ``most`` when it is no less."""
    first, clusters, barred = task.first, path.clusters, task.barred
    costs, arrivals, forward, backward = task.costs, task.arrivals, path.forward, path.backward
    a, last = clusters[gap], gap == size - 1
    b = clusters[0 if last else gap + 1]
    begin, end, start, finish = first[a], first[a + 1], first[b], first[b + 1]
    guarded, cut, later, least = len(barred) > 0, path.cut[a], path.later[a], np.inf
    for w in range(first[c], first[c + 1]):
        there = back = np.inf
        for u in range(begin, end):
            extra = price if guarded and is_barred(barred[w, u], cut) else 0.0
            there = min(there, forward[u] + arrivals[w, u] + extra)
        if there >= min(most, least):
            continue
        if last:
            back = task.closing[w, path.nodes[0]]
        else:
            for v in range(start, finish):
                extra = price if guarded and is_barred(barred[w, v], later) else 0.0
                back = min(back, costs[w, v] + backward[v] + extra)
        least = min(least, there + back)
    return least


@numba.njit(cache=True)
def insertion_in_front(task: Task, path: Path, size: int, c: int) -> tuple[float, int]:
    """Return the value with contour ``c`` as the new start, and its entry; barred legs are not priced."""
    begin, end = task.first[path.clusters[size - 1]], task.first[path.clusters[size - 1] + 1]
    least, entry = np.inf, -1
    for w in range(task.first[c], task.first[c + 1]):
        onward = task.costs[w, path.nodes[0]]
        for u in range(begin, end):
            value = path.forward[u] + task.closing[u, w] + onward
            if value < least:
                least, entry = value, w
    return least, entry
