"""Parts as they are drawn in practice: grids, bolt circles, clusters, columns; their tours tie often.

Holes lie in the reference's ranges (Wang et al., 2025, section 3) on a level sheet; perimeters are equal where
the holes of a real part would be.
"""

import math

import numpy as np

from cutgap.instances.arrays import Floats
from cutgap.instances.generate.holes import (
    PERIMETER_RANGE,
    X_RANGE,
    Y_RANGE,
    Z_RANGE,
    part_of_holes,
    uniform_perimeters,
)
from cutgap.instances.instance import Instance

PITCHES = (80.0, 140.0)
BOLT_CIRCLES = (3, 2)
BOLT_RADII = (60.0, 150.0)
CLUSTERS = 4
CLUSTER_SPREAD = 70.0
COLUMN_HOLES = 8
CENTRE = np.array([[sum(X_RANGE) / 2, sum(Y_RANGE) / 2]])


def grid_part(holes: int, rng: np.random.Generator) -> Instance:
    """Return a square grid, its last row perhaps not full; ``rng`` decides the pitch and the perimeter."""
    return _level_part(f"grid-{holes}", _grid(holes, rng, staggered=False), rng)


def staggered_grid_part(holes: int, rng: np.random.Generator) -> Instance:
    """Return a grid of equilateral triangles, as in perforated sheets."""
    return _level_part(f"staggered-grid-{holes}", _grid(holes, rng, staggered=True), rng)


def bolt_circles_part(holes: int, rng: np.random.Generator) -> Instance:
    """Return 3 x 2 equal bolt circles; what does not divide by 6 goes to the first ones."""
    columns, rows = BOLT_CIRCLES
    circles = columns * rows
    radius, first = rng.uniform(*BOLT_RADII), rng.uniform(0.0, math.tau)
    places = [np.empty((0, 2))]
    for circle in range(circles):
        count = holes // circles + (circle < holes % circles)
        angles = first + math.tau * np.arange(count) / max(1, count)
        column, row = divmod(circle, rows)
        # The lattice leaves at least 100 mm between the largest circles.
        centre = CENTRE + 400.0 * np.array([[column - (columns - 1) / 2, row - (rows - 1) / 2]])
        places.append(centre + radius * np.column_stack([np.cos(angles), np.sin(angles)]))
    return _level_part(f"bolt-circles-{holes}", np.concatenate(places), rng)


def clusters_part(holes: int, rng: np.random.Generator) -> Instance:
    """Return holes scattered around four centres, one in each quarter of the ranges."""
    low, high = np.array([X_RANGE, Y_RANGE]).T
    quarters = np.array([[a, b] for a in (0.0, 0.5) for b in (0.0, 0.5)])
    centres = low + (high - low) * (quarters + rng.uniform(0.15, 0.35, (CLUSTERS, 2)))
    places = centres[np.arange(holes) % CLUSTERS] + rng.normal(0.0, CLUSTER_SPREAD, (holes, 2))
    places = np.clip(places, low, high)
    heights = rng.uniform(*Z_RANGE, holes)
    return part_of_holes(
        f"clusters-{holes}", np.column_stack([places, heights]), uniform_perimeters(holes, rng)
    )


def columns_part(holes: int, rng: np.random.Generator) -> Instance:
    """Return columns of exactly equal x, eight holes in each, the last one perhaps shorter."""
    columns = -(-holes // COLUMN_HOLES)
    xs = np.repeat(np.linspace(*X_RANGE, max(1, columns)), COLUMN_HOLES)[:holes]
    ys = rng.uniform(*Y_RANGE, holes)
    heights = np.full(holes, sum(Z_RANGE) / 2)
    return part_of_holes(f"columns-{holes}", np.column_stack([xs, ys, heights]), uniform_perimeters(holes, rng))


def _grid(holes: int, rng: np.random.Generator, *, staggered: bool) -> Floats:
    """Return a nearly square grid in the middle of the ranges, shape (holes, 2), mm."""
    side = math.isqrt(max(0, holes - 1)) + 1
    row, column = np.divmod(np.arange(holes), side)
    shift = 0.5 * (row % 2) if staggered else 0.0
    height = math.sqrt(0.75) if staggered else 1.0
    # Large grids get a finer pitch, so that they stay in the ranges.
    pitch = round(min(rng.uniform(*PITCHES), (Y_RANGE[1] - Y_RANGE[0]) / (side + 1)), 3)
    places = pitch * np.column_stack([column + shift, row * height])
    return CENTRE + places - pitch * (side - 1) / 2


def _level_part(name: str, places: Floats, rng: np.random.Generator) -> Instance:
    """Return a part on a level sheet with equal holes."""
    heights = np.full(len(places), sum(Z_RANGE) / 2)
    perimeters = np.full(len(places), rng.uniform(*PERIMETER_RANGE))
    return part_of_holes(name, np.column_stack([places, heights]), perimeters)
