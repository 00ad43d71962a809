"""Good tours through regions to begin with: insertion, then ruin and recreate, by the tools of the search.

A tour is held by the regions that bend it; the others it touches on its way. Some neighbouring ones are taken
out, then what is missed is inserted at its best place, the farthest first, until all are touched.
"""

import time

import numpy as np

from cutgap.formulations.regions.search import TOLERANCE, RegionSearch, insertions
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.tours import improve_tour

NEAR_PLACES = 5
"""Places that are tried for an insertion, chosen by the detour over the region's centre."""
SLACKEST = 1e-6
"""Regions with a smaller multiplier do not bend the tour."""
MOST_OUT = 6
KICKS = 1000
WORSE = 0.002
"""By how much, relatively, a tour may be longer than the best to be changed further."""


def find_tours(search: RegionSearch, rounds: int, deadline: float, rng: np.random.Generator) -> None:
    """Offer tours to a search: a first one, then ``rounds`` changed ones, until ``deadline`` (perf_counter)."""
    if len(search.best) == 0:
        _complete(search, search.first_order())
    order = _reordered(search, _bent(search, search.best, search.tour(search.best)[3]), rng)
    value = search.value
    for _ in range(rounds):
        if time.perf_counter() > deadline or len(order) < 5:
            return
        changed = _complete(search, _ruined(search, order, rng), most=value * (1.0 + WORSE))
        if changed is None:
            continue
        order, value = changed, search.value


def _reordered(search: RegionSearch, order: Ints, rng: np.random.Generator) -> Ints:
    """Return an order made shorter by exchanges among the touch points, as often as that gains."""
    while not search.orders.is_ordered and len(order) > 3:
        best, value = search.best, search.value
        lengths = np.linalg.norm(search.points[:, None] - search.points, axis=2)
        changed = improve_tour(lengths, np.arange(len(best)), KICKS, int(rng.integers(2**31)))
        if search.orders.home is not None:
            changed = np.roll(changed, -int(np.flatnonzero(best[changed] == search.orders.home)[0]))
        search.offer(best[changed])
        if search.value >= value - TOLERANCE * value:
            return order
        order = _bent(search, search.best, search.tour(search.best)[3])
    return order


def _ruined(search: RegionSearch, order: Ints, rng: np.random.Generator) -> Ints:
    """Return an order without some regions near each other; the home stays."""
    centres = search.shapes.centres[order]
    middle = int(rng.integers(len(order)))
    away = np.linalg.norm(centres - centres[middle], axis=1)
    if search.orders.home is not None:
        away[0] = np.inf
    out = np.argsort(away, kind="stable")[: int(rng.integers(2, min(MOST_OUT, len(order) - 3) + 1))]
    kept: Ints = np.delete(order, out)
    return kept


def _complete(search: RegionSearch, order: Ints, most: float = np.inf) -> Ints | None:
    """Insert regions until the tour touches all, and offer it; ``None`` when it gets longer than ``most``."""
    while True:
        _, value, p, u = search.tour(order)
        if value > most:
            return None
        gaps = search.orders.misses(order, p)
        region = int(np.argmax(gaps))
        if gaps[region] == 0.0:
            full = search.orders.all_in_order(order, p)
            if not isinstance(full, int):
                search.offer(full)
                return _bent(search, order, u)
            region = full
        order = np.insert(order, _best_place(search, order, region, p) + 1, region)


def _bent(search: RegionSearch, order: Ints, u: Floats) -> Ints:
    """Return an order without the regions that do not bend its tour."""
    bends = np.linalg.norm(np.roll(u, 1, axis=0) - u, axis=1) > SLACKEST
    if search.orders.home is not None:
        bends[0] = True
    return order[bends] if bends.sum() >= 3 and not search.orders.is_ordered else order


def _best_place(search: RegionSearch, order: Ints, region: int, p: Floats) -> int:
    """Return the place behind which to insert a region, the shortest among near ones."""
    places = np.array(search.orders.places(order, region), dtype=np.int64)
    centre = search.shapes.centres[region]
    after = np.roll(p, -1, axis=0)
    ways = np.linalg.norm(p - centre, axis=1) + np.linalg.norm(after - centre, axis=1)
    detours = ways - np.linalg.norm(after - p, axis=1)
    near = places[np.argsort(detours[places], kind="stable")[:NEAR_PLACES]]
    values = np.empty(len(near))
    insertions(search.shapes, order, region, near, np.inf, np.empty(len(near)), values)
    return int(near[np.argmin(values)])
