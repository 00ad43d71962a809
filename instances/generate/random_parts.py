"""Random parts in the reference's ranges: the general one, and those whose points are special.

Source of the ranges: Wang et al. (2025), section 3.
"""

import numpy as np

from cutgap.instances.generate.holes import (
    Y_RANGE,
    Z_RANGE,
    part_of_holes,
    uniform_perimeters,
    uniform_points,
)
from cutgap.instances.instance import Instance

LINE_STEPS = 140
"""Collinear holes lie on whole steps (15, 7, 1) mm from (300, 500, 100): exact in binary, inside the ranges."""


def random_part(holes: int, rng: np.random.Generator) -> Instance:
    """Return a simulated part of the reference: coordinates and perimeters even in their ranges."""
    points = uniform_points(holes, rng)
    return part_of_holes(f"random-{holes}", points, uniform_perimeters(holes, rng))


def tied_part(holes: int, rng: np.random.Generator) -> Instance:
    """Return a part whose holes stand in a few columns of exactly equal x, about three holes in each."""
    points = uniform_points(holes, rng)
    columns = points[: max(1, holes // 3), 0]
    if holes:
        points[:, 0] = rng.choice(columns, holes)
    return part_of_holes(f"ties-{holes}", points, uniform_perimeters(holes, rng))


def coincident_part(holes: int, rng: np.random.Generator) -> Instance:
    """Return a part in which half of the holes lie exactly where another one does."""
    points = uniform_points(holes, rng)
    originals = (holes + 1) // 2
    if originals < holes:
        points[originals:] = points[rng.integers(0, originals, holes - originals)]
    return part_of_holes(f"coincident-{holes}", rng.permutation(points), uniform_perimeters(holes, rng))


def collinear_part(holes: int, rng: np.random.Generator) -> Instance:
    """Return a part whose holes lie on one slanted line, each at a place of its own.

    Raises
    ------
    ValueError
        When there are more holes than places.
    """
    if holes > LINE_STEPS + 1:
        raise ValueError(f"holes: a collinear part has at most {LINE_STEPS + 1}, got {holes}")
    steps = rng.choice(LINE_STEPS + 1, holes, replace=False)
    points = np.array([300.0, 500.0, 100.0]) + steps[:, None] * np.array([15.0, 7.0, 1.0])
    return part_of_holes(f"collinear-{holes}", points, uniform_perimeters(holes, rng))


def one_column_part(holes: int, rng: np.random.Generator) -> Instance:
    """Return a part whose holes all have the same x, so that no positive partition gap exists."""
    x = uniform_points(1, rng)[0, 0]
    points = np.column_stack([np.full(holes, x), rng.uniform(*Y_RANGE, holes), rng.uniform(*Z_RANGE, holes)])
    return part_of_holes(f"one-column-{holes}", points, uniform_perimeters(holes, rng))
