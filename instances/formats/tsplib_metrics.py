"""Distances of TSPLIB: rounded metrics over coordinates, and the layouts of explicit matrices.

Source: Reinelt, TSPLIB 95 (1995), section 2. Lengths are whole numbers without a unit, read as mm.
"""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from cutgap.instances.arrays import Floats

GEO_PI = 3.141592  # as printed in TSPLIB 95; the published optima depend on it
EARTH_RADIUS_KM = 6378.388


def euc_2d(points: Floats) -> Floats:
    """Return Euclidean distances rounded to the nearest integer."""
    return np.floor(np.sqrt(_squared(points)) + 0.5)


def ceil_2d(points: Floats) -> Floats:
    """Return Euclidean distances rounded up."""
    return np.ceil(np.sqrt(_squared(points)))


def att(points: Floats) -> Floats:
    """Return the pseudo-Euclidean distance: sqrt of a tenth of the squared distance, rounded up.

    TSPLIB rounds to nearest and adds one where that fell short, which is rounding up.
    """
    return np.ceil(np.sqrt(_squared(points) / 10.0))


def geo(points: Floats) -> Floats:
    """Return great-circle distances in km, for (latitude, longitude) in degrees and minutes DDD.MM.

    Degrees are cut off, not rounded as the text of TSPLIB 95 says: only so do published optima hold.
    """
    degrees = np.trunc(points[:, :2])
    latitude, longitude = (GEO_PI * (degrees + 5.0 * (points[:, :2] - degrees) / 3.0) / 180.0).T
    q1 = np.cos(np.subtract.outer(longitude, longitude))
    q2 = np.cos(np.subtract.outer(latitude, latitude))
    q3 = np.cos(np.add.outer(latitude, latitude))
    cosine = np.clip(0.5 * ((1.0 + q1) * q2 - (1.0 - q1) * q3), -1.0, 1.0)
    return np.trunc(EARTH_RADIUS_KM * np.arccos(cosine) + 1.0)


METRICS: dict[str, Callable[[Floats], Floats]] = {
    "EUC_2D": euc_2d,
    "CEIL_2D": ceil_2d,
    "ATT": att,
    "GEO": geo,
}


def _squared(points: Floats) -> Floats:
    x, y = points[:, 0], points[:, 1]
    # Coordinates too large for this give inf, which the instance refuses.
    with np.errstate(over="ignore"):
        return np.subtract.outer(x, x) ** 2 + np.subtract.outer(y, y) ** 2


def _triangle(size: int, upper: bool, diagonal: bool) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    if upper:
        return np.triu_indices(size, 0 if diagonal else 1)
    return np.tril_indices(size, 0 if diagonal else -1)


LAYOUTS: dict[str, tuple[bool, bool]] = {
    "UPPER_ROW": (True, False),
    "LOWER_ROW": (False, False),
    "UPPER_DIAG_ROW": (True, True),
    "LOWER_DIAG_ROW": (False, True),
}
"""Triangles listed row by row: (upper, with diagonal)."""

FORMATS = ("FULL_MATRIX", *LAYOUTS)


def entry_count(layout: str, size: int) -> int:
    """Return how many numbers a layout lists for ``size`` nodes."""
    if layout == "FULL_MATRIX":
        return size * size
    return size * (size + 1) // 2 if LAYOUTS[layout][1] else size * (size - 1) // 2


def explicit_matrix(layout: str, size: int, numbers: Floats) -> Floats:
    """Return the matrix that a list of numbers describes, its diagonal as listed (zero if not)."""
    if layout == "FULL_MATRIX":
        return numbers.reshape(size, size).copy()
    matrix = np.zeros((size, size))
    rows, columns = _triangle(size, *LAYOUTS[layout])
    matrix[rows, columns] = numbers
    matrix[columns, rows] = numbers
    return matrix
