"""Random parts with convex regions, for benchmarks: discs, ellipses and rectangles, a plate of convex parts."""

import numpy as np
import shapely

from cutgap.instances import Contour, Head, Instance
from cutgap.instances.arrays import Floats
from cutgap.instances.region import Ellipsoid

SIDE = 1000.0
"""Side of the square with the centres, mm."""
SIZES = (0.05, 0.15)
"""Range of radii and half sides, in parts of ``SIDE``."""


def random_discs(count: int, seed: int) -> Instance:
    """Return discs that may overlap; the tour is closed."""
    rng = np.random.default_rng(seed)
    contours = [_disc(f"d{i}", _centre(rng), _size(rng)) for i in range(count)]
    return Instance(f"discs-{count}-s{seed}", tuple(contours), (Head("head"),))


def random_mix(count: int, seed: int) -> Instance:
    """Return ellipses and rectangles in turn, at any angle; the tour is closed."""
    rng = np.random.default_rng(seed)
    contours = []
    for i in range(count):
        make = _rectangle if i % 2 else _ellipse
        contours.append(make(f"m{i}", _centre(rng), _size(rng), _size(rng), rng.uniform(0, np.pi)))
    return Instance(f"mix-{count}-s{seed}", tuple(contours), (Head("head"),))


def convex_plate(columns: int, rows: int, seed: int) -> Instance:
    """Return a plate of convex parts side by side, polygons and discs, with a home at its corner."""
    rng = np.random.default_rng(seed)
    step = SIDE / max(columns, rows)
    contours = []
    for i in range(columns * rows):
        centre = step * (np.array([i % columns + 0.5, i // columns + 0.5, 0.0]))
        radius = step * rng.uniform(0.25, 0.48)
        if i % 3 == 2:
            contours.append(_disc(f"p{i}", centre, radius))
        else:
            angles = np.sort(rng.uniform(0, 2 * np.pi, 8))
            curve = centre[:2] + radius * np.column_stack((np.cos(angles), np.sin(angles)))
            contours.append(_polygon(f"p{i}", curve))
    home = Head("head", np.zeros(3))
    return Instance(f"plate-{columns}x{rows}-s{seed}", tuple(contours), (home,))


def _centre(rng: np.random.Generator) -> Floats:
    return np.array([*rng.uniform(0, SIDE, 2), 0.0])


def _size(rng: np.random.Generator) -> float:
    return SIDE * float(rng.uniform(*SIZES))


def _disc(name: str, centre: Floats, radius: float) -> Contour:
    region = Ellipsoid(centre, radius * np.eye(3)[:2])
    return Contour(name, centre[None], 2 * np.pi * radius, region=region)


def _ellipse(name: str, centre: Floats, a: float, b: float, angle: float) -> Contour:
    turn = np.array([[np.cos(angle), np.sin(angle), 0.0], [-np.sin(angle), np.cos(angle), 0.0]])
    region = Ellipsoid(centre, np.array([[a], [b]]) * turn)
    around = shapely.LinearRing(region.boundary(1000)[:, :2]).length
    return Contour(name, centre[None], around, region=region)


def _rectangle(name: str, centre: Floats, a: float, b: float, angle: float) -> Contour:
    corners = np.array([[-a, -b], [a, -b], [a, b], [-a, b]])
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return _polygon(name, centre[:2] + corners @ turn)


def _polygon(name: str, curve: Floats) -> Contour:
    ring = shapely.LinearRing(curve)
    return Contour(name, np.array([[*curve[0], 0.0]]), ring.length, geometry=curve)
