"""Random regions of all kinds, many of them degenerate: points, segments, flat and coincident ones."""

import numpy as np

from cutgap.instances.region import Ellipsoid, Hull, Region


def random_region(
    rng: np.random.Generator, spread: float = 5.0, size: float = 3.0, flat: bool = False
) -> Region:
    """A region about ``spread`` from the origin; ``flat`` ones lie in the plane z = 0."""
    kind = int(rng.integers(5))
    height = 0.0 if flat else 1.0
    centre = rng.normal(size=3) * spread * [1, 1, height]
    if kind == 0:
        return Hull(centre[None])
    if kind == 1:  # on a grid, so that points repeat and lie in one line
        corners = rng.integers(-2, 3, size=(int(rng.integers(1, 7)), 3)) * size / 2.0
        return Hull(np.round(centre) + corners * [1, 1, height])
    if kind == 2:
        return Hull(centre + rng.normal(size=(int(rng.integers(1, 7)), 3)) * [size, size, size * height])
    axes = rng.normal(size=(int(rng.integers(1, 4)), 3)) * [size, size, size * height]
    if kind == 3:  # a segment, disc or ball
        axes = size * rng.random() * np.eye(3)[: min(len(axes), 2 if flat else 3)]
    return Ellipsoid(centre, axes * rng.choice([0.0, 1.0, 1.0], size=(len(axes), 1)))
