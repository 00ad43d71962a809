"""Random sheets of square parts in a grid, some with a square hole; entry points are corners and midpoints."""

import numpy as np

from cutgap.instances import Contour, Head, Instance
from cutgap.instances.arrays import Floats

CELL = 100.0


def square_parts(
    rng: np.random.Generator,
    columns: int,
    rows: int,
    *,
    holes: float = 0.4,
    home: bool = True,
    entries: int = 8,
) -> Instance:
    """Draw one part a cell, 40 to 90 mm wide; ``holes`` is the share of parts with a hole, to be cut first."""
    contours: list[Contour] = []
    precedence = []
    for cell in range(columns * rows):
        corner = CELL * np.array(divmod(cell, rows)) + rng.integers(1, 10, 2)
        side = float(rng.integers(40, 90))
        if rng.random() < holes:
            precedence.append((len(contours), len(contours) + 1))
            contours.append(
                _square(rng, f"{cell}-hole", corner + 10.0, side - 20.0, f"part {cell}", "inner", entries)
            )
        contours.append(_square(rng, f"{cell}-outline", corner, side, f"part {cell}", "outer", entries))
    head = Head("head", np.zeros(3) if home else None)
    return Instance("square parts", tuple(contours), (head,), precedence=tuple(precedence))


def _square(
    rng: np.random.Generator, name: str, corner: Floats, side: float, part: str, ring: str, entries: int
) -> Contour:
    """Return a square of four corners and four midpoints, up to ``entries`` of them entry points."""
    turns = np.array([(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)])
    curve = corner + side / 2 * turns
    chosen = np.sort(rng.permutation(8)[: int(rng.integers(1, entries + 1))])
    points = np.column_stack([curve[chosen], np.zeros(len(chosen))])
    return Contour(name, points, 4 * side, part=part, ring=ring, geometry=curve)  # type: ignore[arg-type]
