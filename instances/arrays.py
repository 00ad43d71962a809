"""Read-only arrays and the checks that every class of the problem shares."""

import math
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


def frozen_array(values: Any, name: str, columns: int | None = None) -> Floats:
    """Return a read-only float64 copy of ``values``, all finite.

    Parameters
    ----------
    values
        Anything that ``numpy.array`` takes.
    name
        What the values are, for the message.
    columns
        Asked length of the last axis; ``None`` takes any.

    Raises
    ------
    ValueError
        When the shape is wrong or an entry is not a finite number.
    """
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"{name}: expected numbers, got {values!r:.80}") from error
    if columns is not None and (array.ndim == 0 or array.shape[-1] != columns):
        raise ValueError(f"{name}: expected {columns} numbers a row, got shape {array.shape}")
    if not np.isfinite(array).all():
        bad = array[~np.isfinite(array)].ravel()[0]
        raise ValueError(f"{name}: expected finite numbers, got {bad}")
    array.setflags(write=False)
    return array


def closed_length(points: Floats) -> float:
    """Return the length of the closed polyline through points, the last joined to the first (may be inf)."""
    with np.errstate(over="ignore"):
        return float(np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1).sum())


def difference(smaller: float, larger: float) -> float:
    """Return ``larger - smaller`` as their decimal texts mean it: 0.3 - 0.1 is 0.2, not 0.19999999999999998.

    Limits on gaps are compared with it, since coordinates are given as decimals.
    """
    return float(Fraction(repr(float(larger))) - Fraction(repr(float(smaller))))


def finite_number(
    value: float,
    name: str,
    *,
    above: float | None = None,
    least: float | None = None,
) -> float:
    """Return ``value`` as a float, or say which limit it breaks."""
    if isinstance(value, bool) or not isinstance(value, int | float | np.floating | np.integer):
        raise ValueError(f"{name}: expected a number, got {value!r:.80}")
    try:
        number = float(value)
    except OverflowError:  # an integer beyond the range of a float
        number = math.inf if value > 0 else -math.inf
    if not math.isfinite(number):
        raise ValueError(f"{name}: expected a finite number, got {number}")
    if above is not None and not number > above:
        raise ValueError(f"{name}: expected a number above {above:g}, got {number:g}")
    if least is not None and not number >= least:
        raise ValueError(f"{name}: expected a number of at least {least:g}, got {number:g}")
    return number
