"""Random rows of rectangular parts, some with an inner ring; slender parts hide each other."""

import numpy as np

from cutgap.instances import Contour, Head, Instance
from cutgap.instances.arrays import Floats


def random_row(
    rng: np.random.Generator, contours: int, *, entries: int = 2, home: bool = True, slender: bool = False
) -> Instance:
    """Draw a sheet: parts side by side in a row of cells, inner rings before outlines.

    Parameters
    ----------
    entries
        Largest number of entry points, corners and middles of sides.
    slender
        Whether parts are tall and close, so that they hide each other.
    """
    drawn: list[Contour] = []
    pairs: list[tuple[int, int]] = []
    cell = 0
    while len(drawn) < contours:
        low = np.array([100.0 * cell, 0.0]) + rng.uniform(5, 20, 2)
        high = np.array([100.0 * cell + 90.0, 300.0 if slender else 80.0]) - rng.uniform(0, 30, 2)
        rings = int(rng.integers(1, 3 if len(drawn) + 1 < contours else 2))
        for ring in range(rings):
            shrunk = (rings - 1 - ring) * rng.uniform(8, 12, 2)
            curve = rectangle(low + shrunk, high - shrunk)
            kind = "outer" if ring == rings - 1 else "inner"
            chosen = rng.permutation(8)[: int(rng.integers(1, entries + 1))]
            part = f"part {cell}" if rings > 1 or rng.random() < 0.5 else None
            drawn.append(contour(f"{cell}-{ring}", curve, chosen, part, kind))
        if rings == 2:
            pairs.append((len(drawn) - 2, len(drawn) - 1))
        cell += 1
    heads = (Head("head", np.array([0.0, -50.0, 0.0]) if home else None),)
    return Instance("random row", tuple(drawn), heads, precedence=tuple(pairs))


def rectangle(low: Floats, high: Floats) -> Floats:
    """Return corners and middles of sides, in order, shape (8, 2), mm."""
    middle = (low + high) / 2
    xs = [low[0], middle[0], high[0], high[0], high[0], middle[0], low[0], low[0]]
    ys = [low[1], low[1], low[1], middle[1], high[1], high[1], high[1], middle[1]]
    return np.column_stack((xs, ys))


def contour(name: str, curve: Floats, chosen: np.ndarray, part: str | None, kind: str) -> Contour:
    points = np.column_stack((curve[chosen], np.zeros(len(chosen))))
    return Contour(name, points, 100.0, part, kind if part else "hole", curve)  # type: ignore[arg-type]
