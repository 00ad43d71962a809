"""Random regions of all kinds, many of them degenerate: points, segments, flat and coincident ones."""

import numpy as np
from scipy.spatial import ConvexHull

from cutgap.instances import Contour, Head, Instance
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


def random_contour(rng: np.random.Generator, name: str, *, flat: bool) -> Contour:
    """A contour with a region of any kind; flat ones are at height 0. Many meet, or are one in the other."""
    height = 0.0 if flat else float(rng.integers(-2, 3))
    centre = np.append(np.round(rng.normal(size=2) * 5.0, int(rng.integers(0, 3))), height)
    kind = int(rng.integers(4))
    if kind == 0:
        return Contour(name, centre[None], 0.0)
    if kind == 1:
        corners = rng.choice([rng.normal(size=(7, 2)), rng.integers(-2, 3, size=(7, 2)) + 0.0]) * 1.5
        corners = np.concatenate((corners, np.eye(3, 2)))
        curve = corners[ConvexHull(corners).vertices] + centre[:2]
        return Contour(name, np.column_stack((curve, np.full(len(curve), height))), 1.0, geometry=curve)
    axes = rng.normal(size=(int(rng.integers(1, 4)), 3)) * [2.0, 2.0, 0.0 if flat else 2.0]
    if kind == 2:
        axes = rng.uniform(0.2, 4.0) * np.eye(3)[: 2 if flat else 3]
    return Contour(name, centre[None], 1.0, region=Ellipsoid(centre, axes))


def random_plate(
    rng: np.random.Generator, contours: int, *, flat: bool = True, home: bool = True, precedence: float = 0.0
) -> Instance:
    """Contours with regions and one head, whose home may lie inside of some."""
    names = [f"c{index}" for index in range(contours)]
    place = np.round(rng.normal(size=3) * [4.0, 4.0, 0.0 if flat else 4.0], 1) if home else None
    pairs = [(a, b) for a in range(contours) for b in range(a + 1, contours) if rng.random() < precedence]
    return Instance(
        "plate",
        tuple(random_contour(rng, name, flat=flat) for name in names),
        (Head("head", place),),
        precedence=tuple(pairs),
    )
