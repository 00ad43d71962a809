"""Random tiny sheets for links: squares and triangles, some of which touch."""

import numpy as np

from cutgap.instances import Contour, Head, Instance, Machine
from oracles.link_plans import Sheet

SIZES = ((2,), (1, 2), (2, 2), (3, 2), (2, 2, 2), (1, 2, 3), (2, 1, 1, 1), (1, 1, 2, 2))
"""Numbers of entry points of the shapes."""


def tiny(rng: np.random.Generator, sizes: tuple[int, ...]) -> Sheet:
    """Squares and triangles in cells of a coarse grid, so that some touch; corners are entry points."""
    side = int(rng.integers(3, 7))
    cells = rng.permutation([(x, y) for x in range(3) for y in range(2)])[: len(sizes)]
    shapes, entries = [], []
    for (x, y), size in zip((cells * 6).tolist(), sizes, strict=True):
        corners = [
            (float(a), float(b)) for a, b in ((x, y), (x + side, y), (x + side, y + side), (x, y + side))
        ]
        if rng.random() < 0.4:
            corners.pop(int(rng.integers(4)))
        shapes.append(corners)
        entries.append([corners[each] for each in sorted(rng.permutation(len(corners))[:size].tolist())])
    t_aux = float(rng.choice([0.0, 0.05, 0.5, 80.0]))
    return Sheet(
        shapes, entries, (float(rng.integers(-5, 20)), -1.0), 150.0, float(rng.choice([10, 40, 300])), t_aux
    )


def instance_of(sheet: Sheet) -> Instance:
    contours = []
    for number, (shape, spots) in enumerate(zip(sheet.shapes, sheet.entries, strict=True)):
        curve = np.array(shape)
        length = float(np.linalg.norm(curve - np.roll(curve, -1, axis=0), axis=1).sum())
        contours.append(
            Contour(f"c{number}", np.array([(*spot, 0.0) for spot in spots]), length, geometry=curve)
        )
    machine = Machine(sheet.v_jump, sheet.v_cut, sheet.t_aux)
    return Instance("tiny", tuple(contours), (Head("head", np.array([*sheet.home, 0.0])),), machine)
