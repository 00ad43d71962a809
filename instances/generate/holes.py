"""The machine of the reference's experiments, and parts made of holes with one entry point each.

Source: Wang et al. (2025), section 3; lengths in mm. Coordinates and perimeters are rounded to 1 um, so that
files stay readable and no place of a decimal depends on the platform's sine.
"""

import numpy as np
import numpy.typing as npt

from cutgap.instances.arrays import Floats
from cutgap.instances.instance import Contour, Head, Instance

X_RANGE = (300.0, 2400.0)
Y_RANGE = (500.0, 1500.0)
Z_RANGE = (100.0, 300.0)
PERIMETER_RANGE = (20.0, 100.0)
LEFT_HOME = (200.0, 200.0, 400.0)
RIGHT_HOME = (2400.0, 1400.0, 400.0)
DECIMALS = 3


def reference_heads() -> tuple[Head, Head]:
    """Return the two heads of the reference, O_1 and O_2."""
    return (Head("left", np.array(LEFT_HOME)), Head("right", np.array(RIGHT_HOME)))


def part_of_holes(
    name: str, points: npt.ArrayLike, perimeters: npt.ArrayLike, ids: list[str] | None = None
) -> Instance:
    """Return a part for the reference's machine.

    Parameters
    ----------
    points
        Shape (holes, 3), mm.
    perimeters
        Shape (holes,), mm.
    ids
        Ids of the holes; 1, 2, ... when left out.
    """
    places = np.round(np.asarray(points, dtype=np.float64).reshape(-1, 3), DECIMALS)
    lengths = np.round(np.asarray(perimeters, dtype=np.float64), DECIMALS)
    names = ids or [str(number) for number in range(1, len(places) + 1)]
    contours = (
        Contour(hole, place[None], float(length))
        for hole, place, length in zip(names, places, lengths, strict=True)
    )
    return Instance(name, tuple(contours), reference_heads())


def uniform_points(holes: int, rng: np.random.Generator) -> Floats:
    """Return points even in the reference's ranges, shape (holes, 3), mm."""
    low, high = np.array([X_RANGE, Y_RANGE, Z_RANGE]).T
    return rng.uniform(low, high, (holes, 3))


def uniform_perimeters(holes: int, rng: np.random.Generator) -> Floats:
    """Return perimeters even in the reference's range, mm."""
    return rng.uniform(*PERIMETER_RANGE, holes)
