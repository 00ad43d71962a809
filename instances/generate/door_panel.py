"""A door inner panel with 91 holes, standing in for a part whose coordinates are not published.

Seen from the side: the hinge edge on the left, the lock edge on the right, the window in the upper third with
the slanted A-pillar frame, below it the belt, a large service opening, a speaker and a small pocket. Holes
follow the edges. The hinge edge, the lock edge with the window frame above it, and the upright sides of both
pockets are columns of exactly equal x. Diameters are such that cutting and auxiliary time per hole come
near the 1.9 s that Table 2 of Wang et al. (2025) implies with the default machine.
"""

import math

import numpy as np

from cutgap.instances.arrays import Floats
from cutgap.instances.generate.holes import part_of_holes
from cutgap.instances.instance import Instance

WIDTH, HEIGHT = 1150.0, 1050.0
ORIGIN = np.array([720.0, 330.0, 140.0])
HINGE_X, LOCK_X = 25.0, 1125.0
SMALL_DIAMETERS = (7.0, 12.0)
LARGE_DIAMETERS = (10.0, 18.0)
HOLES = 91


def door_panel(rng: np.random.Generator) -> Instance:
    """Return the panel; ``rng`` decides places along the edges and diameters."""
    edges = np.concatenate([outer_edge(rng), window_frame(rng)])
    inner = np.concatenate([belt(rng), service_opening(rng), speaker(rng), small_pocket(rng)])
    places = np.concatenate([edges, inner])
    points = np.column_stack([places, _height(places, recessed=np.arange(len(places)) >= len(edges))])
    diameters = [rng.uniform(*SMALL_DIAMETERS, len(edges)), rng.uniform(*LARGE_DIAMETERS, len(inner))]
    return part_of_holes("door-panel", points + ORIGIN, math.pi * np.concatenate(diameters))


def outer_edge(rng: np.random.Generator) -> Floats:
    """Return hinge column, lock column and bottom row below the belt, shape (32, 2), mm."""
    hinge = _column(HINGE_X, 70.0, 590.0, 10, rng)
    lock = _column(LOCK_X, 70.0, 590.0, 10, rng)
    x = np.linspace(90.0, 1060.0, 12) + rng.uniform(-12.0, 12.0, 12)
    bottom = np.column_stack([x, 25.0 + 20.0 * ((x - WIDTH / 2) / (WIDTH / 2)) ** 2])
    return np.concatenate([hinge, lock, bottom])


def window_frame(rng: np.random.Generator) -> Floats:
    """Return A-pillar slope, roof arc and rear upright around the window, shape (24, 2), mm."""
    along = np.linspace(0.0, 1.0, 9) + rng.uniform(-0.02, 0.02, 9)
    slope = np.column_stack([40.0 + 390.0 * along, 665.0 + 340.0 * along])
    along = np.linspace(0.1, 0.95, 8) + rng.uniform(-0.02, 0.02, 8)
    roof = np.column_stack([430.0 + 690.0 * along, 1005.0 + 30.0 * np.sin(math.pi * along)])
    return np.concatenate([slope, roof, _column(LOCK_X, 670.0, 960.0, 7, rng)])


def belt(rng: np.random.Generator) -> Floats:
    """Return the row below the window, shape (8, 2), mm."""
    x = np.linspace(120.0, 1040.0, 8) + rng.uniform(-15.0, 15.0, 8)
    return np.column_stack([x, 625.0 + 0.02 * x])


def service_opening(rng: np.random.Generator) -> Floats:
    """Return the rim of the large opening, two columns of four and two rows of three, shape (14, 2), mm."""
    left, right, bottom, top = 520.0, 900.0, 280.0, 540.0
    inner_x = np.linspace(left, right, 5)[1:-1]
    rows = [np.column_stack([inner_x + rng.uniform(-10.0, 10.0, 3), np.full(3, y)]) for y in (bottom, top)]
    columns = [_column(x, bottom + 20.0, top - 20.0, 4, rng) for x in (left, right)]
    return np.concatenate([*columns, *rows])


def speaker(rng: np.random.Generator) -> Floats:
    """Return the bolt circle of the speaker, turned at random, shape (8, 2), mm."""
    angles = rng.uniform(0.0, math.tau) + np.arange(8) * math.tau / 8
    return np.array([265.0, 230.0]) + 105.0 * np.column_stack([np.cos(angles), np.sin(angles)])


def small_pocket(rng: np.random.Generator) -> Floats:
    """Return the rim of the small pocket near the lock, a column of three and one of two, (5, 2), mm."""
    return np.concatenate([_column(780.0, 100.0, 210.0, 3, rng), _column(960.0, 115.0, 195.0, 2, rng)])


def _column(x: float, first: float, last: float, count: int, rng: np.random.Generator) -> Floats:
    y = np.linspace(first, last, count) + rng.uniform(-8.0, 8.0, count)
    return np.column_stack([np.full(count, x), y])


def _height(places: Floats, recessed: np.ndarray) -> Floats:
    """Return z of the stamped surface: crowned in both directions; holes inside lie 30 mm deeper."""
    x, y = places[:, 0] / WIDTH, places[:, 1] / HEIGHT
    return 70.0 * np.sin(math.pi * x) + 60.0 * np.sin(math.pi * y) - 30.0 * recessed
