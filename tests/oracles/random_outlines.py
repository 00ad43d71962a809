"""Random tiny sheets of squares, triangles and angles, near each other, some in holes of others.

Coordinates are whole, entry points quarters of edges, so that they are exactly on their curves.
"""

import numpy as np

from cutgap.instances import Contour, Head, Instance, Machine
from cutgap.instances.arrays import Floats

CELL = 12.0
SHAPES = {
    "square": [(0, 0), (8, 0), (8, 8), (0, 8)],
    "bar": [(0, 0), (9, 0), (9, 3), (0, 3)],
    "triangle": [(0, 0), (9, 1), (3, 8)],
    "arrow": [(0, 0), (8, 4), (0, 8), (3, 4)],
    "angle": [(0, 0), (9, 0), (9, 3), (3, 3), (3, 9), (0, 9)],
}


def random_outlines(
    rng: np.random.Generator,
    contours: int,
    *,
    entries: int = 2,
    nested: float = 0.2,
    metric: str | None = None,
) -> Instance:
    """Draw up to as many entry points a contour as ``entries``; one head with a home, no precedence.

    Parameters
    ----------
    nested
        Chance that the first square is a plate with a hole, and the next outline lies in that.
    metric
        Of rapids; ``None`` draws ``euclidean`` or ``chebyshev``.
    """
    columns = int(rng.choice([1, 2, 3]))
    cells = [CELL * np.array(divmod(cell, columns), dtype=np.float64) for cell in rng.permutation(3 * columns)]
    curves: list[Floats] = []
    if contours >= 2 and rng.random() < nested:
        corner = cells.pop()
        curves += [corner + scale * np.array(SHAPES["square"]) / 8 + (11 - scale) / 2 for scale in (11.0, 9.0)]
        if contours >= 3:
            inner = _turned(rng, np.array(SHAPES["arrow"]) / 2)
            curves.append(corner + rng.integers(3, 5, 2) + inner)
    while len(curves) < contours and cells:
        shape = np.array(SHAPES[str(rng.choice(list(SHAPES)))], dtype=np.float64)
        curves.append(cells.pop() + rng.integers(0, 3, 2) + _turned(rng, shape))
    found = [_contour(rng, f"c{number}", curve, entries) for number, curve in enumerate(curves)]
    machine = Machine(
        v_jump=float(rng.choice([20.0, 150.0])),
        v_cut=float(rng.choice([5.0, 40.0])),
        t_aux=float(rng.choice([0.0, 0.5, 2.0, 80.0])),
        metric=metric or str(rng.choice(["euclidean", "chebyshev"])),  # type: ignore[arg-type]
    )
    home = np.array([*rng.integers(-10, 30, 2), rng.choice([0, 5])], dtype=np.float64)
    return Instance("random outlines", tuple(found), (Head("head", home),), machine)


def _turned(rng: np.random.Generator, shape: Floats) -> Floats:
    """Return a shape turned by quarters, its lower left corner at the origin."""
    for _ in range(int(rng.integers(4))):
        shape = np.column_stack((-shape[:, 1], shape[:, 0]))
    return shape - shape.min(axis=0)


def _contour(rng: np.random.Generator, name: str, curve: Floats, entries: int) -> Contour:
    steps = np.roll(curve, -1, axis=0) - curve
    # Corners twice as likely as the other quarters together.
    share = np.where(rng.random(len(curve)) < 0.65, 0.0, rng.choice([0.25, 0.5, 0.75], len(curve)))
    places = curve + share[:, None] * steps
    chosen = rng.choice(len(places), min(len(places), int(rng.integers(1, entries + 1))), replace=False)
    points = np.column_stack((places[chosen], np.zeros(len(chosen))))
    return Contour(name, points, float(np.hypot(*steps.T).sum()), geometry=curve)
