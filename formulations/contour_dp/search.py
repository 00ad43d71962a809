r"""The exact dynamic programme over sets of contours, kept sparse by completion bounds.

    (1) F(S, v) = least s + sum c + sum p of a walk that has cut exactly S, the last one at point v
    (2) a state is dropped when F(S, v) + R(v, S) >= limit, with R(v, S) the least cost of a relaxed walk onward
        from v that remembers no contour of S
    (3) only sets that some order of cutting reaches are made, and the best walk of each S and v is kept

R is that of ``completion``, for the prices and memories of the ascent.

Source: Held and Karp (1962); Baldacci, Mingozzi, Roberti (2011) for completion bounds of this kind.
"""

from dataclasses import dataclass

import numpy as np

from cutgap.formulations.contour_dp.ascent import Relaxed
from cutgap.formulations.contour_dp.completion import completions
from cutgap.formulations.contour_dp.memory import Memory, build_memory
from cutgap.formulations.contour_dp.rows import Layer, Onward, Steps, extend_layer, may_follow
from cutgap.formulations.contour_dp.walks import Bools, Walks
from cutgap.instances.arrays import Floats, Ints

MOST_CONTOURS = 62
"""Sets of contours are bits of one signed word."""


@dataclass(frozen=True, slots=True)
class Searched:
    """What a search showed.

    Attributes
    ----------
    bound
        No walk costs less than the least of this, ``cost`` and the limit; infinite if no state was left out.
    cost, walk
        The best walk below the limit that was found; infinite and ``None`` without one.
    layers, relaxed_rows
        Number of rows (a set and a last contour) that were kept, for each position, and of those of the
        completion bounds (a memory and a contour at a position).
    """

    bound: float
    cost: float
    walk: Ints | None
    layers: tuple[int, ...]
    relaxed_rows: int

    @property
    def rows(self) -> int:
        """Number of rows that were kept."""
        return sum(self.layers)

    @property
    def complete(self) -> bool:
        """Whether no state was left out."""
        return bool(np.isinf(self.bound))


def search(walks: Walks, found: Relaxed, width: int) -> Searched:
    """Search for the best walk below the limit.

    Parameters
    ----------
    found
        What the ascent left: its limit, prices, memories and allowed points.
    width
        Most rows of a layer; of more, the most promising are kept.
    """
    stage = found.stages[-1]
    prices = np.array(stage.prices)
    memory = build_memory(walks, stage.members)
    limit = found.limit + float(prices.sum())
    bounds, relaxed_rows = completions(walks, memory, prices, found.allowed, limit)
    steps, bits = _steps(walks, prices), _member_bits(walks, memory)
    layers = [_first_layer(walks, prices, Onward(bits, memory.offset, bounds[0], limit))]
    left_out = np.inf
    for k in range(1, walks.count):
        layer = extend_layer(steps, Onward(bits, memory.offset, bounds[k], limit), layers[-1])
        layer, dropped = _narrowed(walks, layer, width)
        layers.append(layer)
        left_out = min(left_out, dropped)
    cost, walk = _best(walks, steps, layers)
    paid = float(prices.sum())
    sizes = tuple(len(layer.sets) for layer in layers)
    return Searched(left_out - paid, cost - paid, walk, sizes, relaxed_rows)


def _member_bits(walks: Walks, memory: Memory) -> Ints:
    """Return the bit of contour b in N_a, -1 where it is no member; shape (n, n)."""
    bits = np.full((walks.count, walks.count), -1, dtype=np.int64)
    for a, members in enumerate(memory.members):
        bits[a, list(members)] = np.arange(len(members))
    return bits


def _as_set(flags: Bools) -> int:
    return sum(1 << int(contour) for contour in np.flatnonzero(flags))


def _steps(walks: Walks, prices: Floats) -> Steps:
    alone = np.left_shift(np.int64(1), np.arange(walks.count))
    mates = alone
    if walks.parts is not None:
        mates = np.array([_as_set(walks.parts == part) for part in walks.parts], dtype=np.int64)
    crossed = np.zeros((0, 0), dtype=np.int64)
    if walks.crossed is not None:
        crossed = walks.crossed[:, :, 0].view(np.int64).copy()
    conflicts = alone + np.array([_as_set(row) for row in walks.before], dtype=np.int64)
    return Steps(walks.costs, prices, walks.first, walks.closed, conflicts, mates, crossed)


def _first_layer(walks: Walks, prices: Floats, onward: Onward) -> Layer:
    sets, starts, promise, rows = [], [], [], [np.empty(0)]
    lasts = []
    for a in range(walks.count):
        points = slice(walks.first[a], walks.first[a + 1])
        row = walks.start[points] + prices[a]
        total = row + onward.bound[onward.offset[a] : onward.offset[a] + len(row)]
        if total.min() < onward.limit:
            sets.append(1 << a)
            lasts.append(a)
            starts.append(sum(map(len, rows)))
            promise.append(float(total.min()))
            rows.append(np.where(total < onward.limit, row, np.inf))
    numbers = [np.array(each, dtype=np.int64) for each in (sets, lasts, starts)]
    return Layer(numbers[0], numbers[1], numbers[2], np.array(promise), np.concatenate(rows))


def _narrowed(walks: Walks, layer: Layer, width: int) -> tuple[Layer, float]:
    """Return the ``width`` most promising rows of a layer, and the promise of the best row left out."""
    if len(layer.promise) <= width:
        return layer, np.inf
    order = np.argpartition(layer.promise, width)
    kept = np.sort(order[:width])
    sizes = np.diff(walks.first)[layer.lasts[kept]]
    starts = np.concatenate(([0], np.cumsum(sizes)[:-1]))
    places = np.repeat(layer.starts[kept] - starts, sizes) + np.arange(sizes.sum())
    narrowed = Layer(layer.sets[kept], layer.lasts[kept], starts, layer.promise[kept], layer.values[places])
    return narrowed, float(layer.promise[order[width:]].min())


def _best(walks: Walks, steps: Steps, layers: list[Layer]) -> tuple[float, Ints | None]:
    """Return the least cost (prices counted) in the last layer and its walk, traced back through the layers."""
    last, walk = layers[-1], np.zeros(walks.count, dtype=np.int64)
    best, cut = np.inf, -1
    for a, begin, done in zip(last.lasts.tolist(), last.starts.tolist(), last.sets.tolist(), strict=True):
        points = slice(walks.first[a], walks.first[a + 1])
        total = last.values[begin : begin + points.stop - points.start] + walks.end[points]
        if total.min() < best:
            best, cut, walk[-1] = float(total.min()), done, points.start + int(total.argmin())
    if cut < 0:
        return best, None
    for k in range(walks.count - 2, -1, -1):
        b = int(walks.contour_of[walk[k + 1]])
        cut ^= 1 << b
        walk[k] = _predecessor(steps, layers[k], cut, b, int(walk[k + 1]))
    return best, walk


def _predecessor(steps: Steps, layer: Layer, cut: int, b: int, w: int) -> int:
    """Return the point from which point ``w`` of contour b is reached best with the set ``cut`` done."""
    best, point = np.inf, -1
    for state in np.flatnonzero(layer.sets == cut).tolist():
        a = int(layer.lasts[state])
        if steps.closed[a, b] or not may_follow(cut, steps.conflicts[b], steps.mates[a], b):
            continue
        points = np.arange(steps.first[a], steps.first[a + 1])
        total = layer.values[layer.starts[state] : layer.starts[state] + len(points)] + steps.costs[points, w]
        if len(steps.crossed):
            total = np.where(steps.crossed[points, w] & cut == 0, total, np.inf)
        if total.min() < best:
            best, point = float(total.min()), int(points[total.argmin()])
    return point
