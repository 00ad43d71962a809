"""Kernels of the search over orders of contours with entry points: ruin and recreate (door: ``entry_tours``).

A round takes out some contours that lie close together, as short runs of the tour (Christiaens and Vanden
Berghe, 2020), and puts them back one by one where they cost least, with all entries chosen anew each time (see
``entry_steps``; Smith and Imeson, 2017, choose the entries of the inserted contour only). A worse tour is kept
by the rule of simulated annealing. A contour goes only between those that must be cut before it and those that
must be cut after it, and beside its part. Barred legs have a price, which rises while tours have some of them
and falls while they have none.
"""

from typing import Any, NamedTuple

import numba
import numpy as np

from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.entry_choice import settle
from cutgap.instances.entry_steps import (
    Path,
    Task,
    begin_forward,
    end_backward,
    fill_backward,
    fill_forward,
    insertion,
    insertion_in_front,
    note_cut,
    refresh,
)

LONGEST_RUN = 8
"""Most neighbouring contours that are taken out at once."""

MOST_TAKEN = 40
"""Most contours that are taken out in a round, but for the rest of their parts; mostly far fewer are."""

SKIPPED = 0.02
"""Share of places that are overlooked when a contour is put back, for variety."""

MOVED_STARTS = 0.1
"""Share of rounds of a closed tour that begin at another entry: only the others are chosen together."""

HOT, COLD = 1.0, 0.1
"""First and last temperature of a search, in mean legs."""

PATIENCE = 50
"""Rounds with the same answer after which the price of barred legs changes."""

# Places in ``figures``.
COST, BARRED, BEST_COST, BEST_BARRED, PRICE, STREAK = 0, 1, 2, 3, 4, 5


class Search(NamedTuple):
    """Tours of a search, by clusters and by nodes; its figures (cost, barred legs, price); room for a ruin."""

    clusters: Ints
    nodes: Ints
    best_clusters: Ints
    best_nodes: Ints
    figures: Floats
    taken: Ints


def new_search(contours: int, size: int) -> Search:
    """Return an empty search over tours of ``size`` places."""
    a, b, c, d = (np.zeros(size, dtype=np.int64) for _ in range(4))
    return Search(a, b, c, d, np.zeros(6), np.zeros(contours, dtype=np.int64))


@numba.njit(cache=True)
def _rotate(path: Path, size: int, by: int) -> None:
    """Begin a cyclic tour at another place."""
    for row in (path.clusters, path.nodes):
        row[:size] = np.concatenate((row[by:size], row[:by]))


@numba.njit(cache=True)
def _widen(task: Task, clusters: Ints, begin: int, end: int, low: int, high: int) -> tuple[int, int]:
    """Widen a run to whole parts; with ``high`` = 0 it stays."""
    part = task.part
    while low < begin < high and part[clusters[begin - 1]] == part[clusters[begin]]:
        begin -= 1
    while end < high and part[clusters[end - 1]] == part[clusters[end]]:
        end += 1
    return begin, end


@numba.njit(cache=True)
def _ruin(task: Task, path: Path, size: int, taken: Ints, rng: Any) -> int:
    """Take contours out of the tour, listed in ``taken`` from near to far; return their number."""
    n = len(task.part)
    clusters = path.clusters
    place = np.full(n + 1, -1)
    for i in range(size):
        place[clusters[i]] = i
    most = min(MOST_TAKEN, n if task.anchored else n - 1)
    wanted = 1 + int(rng.random() ** 2 * most)
    longest = 1 + int(rng.random() * min(LONGEST_RUN, wanted))
    whole = rng.random() < 0.5
    low = 1 if task.anchored else 0
    seed = int(rng.random() * n)
    count = 0
    for rank in range(-1, n - 1):
        at = place[seed if rank < 0 else task.near[seed, rank]]
        if count >= wanted:
            break
        if at < 0:
            continue
        run = min(1 + int(rng.random() * longest), wanted - count)
        begin = max(low, at - int(rng.random() * run))
        begin, end = _widen(task, clusters, begin, min(size, begin + run), low, size if whole else 0)
        for i in range(begin, end):
            if place[clusters[i]] >= 0 and count < n - 1 + low:
                place[clusters[i]] = -1
                taken[count] = clusters[i]
                count += 1
    left = 0
    for i in range(size):
        if clusters[i] == n or place[clusters[i]] >= 0:
            clusters[left], path.nodes[left] = clusters[i], path.nodes[i]
            left += 1
    return count


@numba.njit(cache=True)
def _reorder(taken: Ints, count: int, rng: Any) -> None:
    """Choose in which order contours are put back: mostly at random, else far ones or near ones first."""
    choice = rng.random()
    if choice < 0.5:
        for i in range(count - 1, 0, -1):
            j = int(rng.random() * (i + 1))
            taken[i], taken[j] = taken[j], taken[i]
    elif choice < 0.75:
        taken[:count] = taken[:count][::-1].copy()


@numba.njit(cache=True)
def _allowed_gaps(task: Task, path: Path, size: int, c: int) -> tuple[int, int, bool]:
    """Return the first and the last place after which contour ``c`` may go, and whether its part is begun."""
    clusters, part, before = path.clusters, task.part, task.before
    low, high, begun = 0 if task.anchored or task.cyclic else -1, size - 1, False
    for i in range(1 if task.anchored else 0, size):
        if part[clusters[i]] == part[c]:
            if not begun:
                low = i - 1
            high, begun = i, True
    for i in range(1 if task.anchored else 0, size):
        if before[clusters[i], c]:
            low = max(low, i)
        elif before[c, clusters[i]]:
            high = min(high, i - 1)
            break
    # Where any contour may be the first, after the last place is as good as before the first.
    return max(low, 0) if task.cyclic else low, high, begun


@numba.njit(cache=True)
def _bound_gaps(task: Task, path: Path, size: int, c: int, low: int, high: int, begun: bool, rng: Any) -> int:
    """Set a bound on (4) for each place: infinite where ``c`` may not go; return the place of the least one."""
    clusters, part, bounds, shortest = path.clusters, task.part, path.bounds, low
    bounds[low] = np.inf
    for gap in range(low, high + 1):
        a, last = clusters[gap], gap == size - 1
        b = a if last else clusters[gap + 1]
        bounds[gap] = np.inf
        inside_a_part = not begun and not last and a < len(part) and part[a] == part[b]
        if inside_a_part or (bounds[shortest] < np.inf and rng.random() < SKIPPED):
            continue
        bounds[gap] = path.reach[a] + task.least[a, c]
        if not last:
            bounds[gap] += task.least[c, b] + path.rest[b]
        if bounds[gap] < bounds[shortest]:
            shortest = gap
    return shortest


@numba.njit(cache=True)
def _best_gap(task: Task, path: Path, size: int, c: int, price: float, rng: Any) -> tuple[int, int]:
    """Return the place after which contour ``c`` costs least, and an entry.

    The place -1 is before the first; only then the entry matters, as the new start.
    """
    low, high, begun = _allowed_gaps(task, path, size, c)
    front, low = low < 0, max(low, 0)
    shortest = _bound_gaps(task, path, size, c, low, high, begun, rng)
    chosen, least = -1, np.inf
    for attempt in range(low - 1, high + 1):
        gap = shortest if attempt < low else attempt
        if path.bounds[gap] < least:
            value = insertion(task, path, size, c, gap, price, least)
            if value < least:
                chosen, least = gap, value
    if front:
        value, entry = insertion_in_front(task, path, size, c)
        if value < least:
            return -1, entry
    return chosen, task.first[c]


@numba.njit(cache=True)
def recreate(task: Task, path: Path, size: int, taken: Ints, count: int, price: float, rng: Any) -> None:
    """Put ``count`` contours back; table (1) is filled then."""
    guarded, place = len(task.barred) > 0, 0
    for i in range(count + 1):
        c = taken[i] if i < count else len(task.part)
        if guarded:
            note_cut(task, path, size, c)
        if guarded or place == 0:
            begin_forward(task, path)
            fill_forward(task, path, 1, size, price)
            end_backward(task, path, size)
            fill_backward(task, path, size - 2, price)
        else:
            refresh(task, path, place, size)
        if i == count:
            break
        gap, entry = _best_gap(task, path, size, c, price, rng)
        place = gap + 1
        for j in range(size, place, -1):
            path.clusters[j], path.nodes[j] = path.clusters[j - 1], path.nodes[j - 1]
        path.clusters[place], path.nodes[place] = c, entry
        size += 1


@numba.njit(cache=True)
def keep(search: Search, path: Path, size: int, cost: float, barred: int, better: bool) -> None:
    """Make the tour under work the current one, and the best one when it is better."""
    search.clusters[:], search.nodes[:] = path.clusters[:size], path.nodes[:size]
    search.figures[COST], search.figures[BARRED] = cost, barred
    if better:
        search.best_clusters[:], search.best_nodes[:] = path.clusters[:size], path.nodes[:size]
        search.figures[BEST_COST], search.figures[BEST_BARRED] = cost, barred


@numba.njit(cache=True)
def _change_price(figures: Floats, barred: int) -> None:
    """Raise the price after many tours with barred legs, lower it after many without."""
    sign = 1.0 if barred else -1.0
    streak = figures[STREAK]
    figures[STREAK] = streak + sign if streak * sign > 0 else sign
    if abs(figures[STREAK]) >= PATIENCE:
        figures[STREAK] = 0.0
        figures[PRICE] *= 1.5 if barred else 0.75


def begin(task: Task, path: Path, search: Search, order: Ints, price: float, rng: Any) -> None:
    """Make the first tour: contours put in one by one, in the given order."""
    n, size = len(task.part), len(search.clusters)
    path.clusters[0] = n if task.anchored else order[0]
    path.nodes[0] = task.first[path.clusters[0]]
    search.figures[PRICE], search.figures[STREAK] = price, 0.0
    others = order if task.anchored else order[1:].copy()
    recreate(task, path, 1, others, len(others), price, rng)
    keep(search, path, size, *settle(task, path, size, price), True)


@numba.njit(cache=True)
def iterate(task: Task, path: Path, search: Search, since: int, until: int, rounds: int, rng: Any) -> None:
    """Do rounds ``since`` to ``until`` of a search of ``rounds``; random numbers go on from the last call."""
    size, figures = len(search.clusters), search.figures
    for turn in range(since, until):
        price = figures[PRICE]
        path.clusters[:size], path.nodes[:size] = search.clusters, search.nodes
        if task.cyclic:
            _rotate(path, size, int(rng.random() * size))
        count = _ruin(task, path, size, search.taken, rng)
        _reorder(search.taken, count, rng)
        if not task.anchored and rng.random() < MOVED_STARTS:
            first, k = task.first, path.clusters[0]
            path.nodes[0] = first[k] + int(rng.random() * (first[k + 1] - first[k]))
        recreate(task, path, size - count, search.taken, count, price, rng)
        cost, barred = settle(task, path, size, price)
        heat = HOT * (COLD / HOT) ** (turn / rounds) * figures[BEST_COST] / size
        limit = figures[COST] + price * figures[BARRED] - heat * np.log(1.0 - rng.random())
        better = barred < figures[BEST_BARRED] or (barred == figures[BEST_BARRED] and cost < figures[BEST_COST])
        if better or cost + price * barred <= limit:
            keep(search, path, size, cost, barred, better)
        if len(task.barred):
            _change_price(figures, int(figures[BARRED]))
