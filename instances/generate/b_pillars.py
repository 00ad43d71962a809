"""Four equal B-pillars side by side, 76 holes, standing in for a part whose coordinates are not published.

A pillar is a stamped hat section: two flanges at the level of the sheet and a raised web between them, wide at
the foot, narrow in the middle, wider again at the head, bowed to the side and upwards. Each flange carries a
row of seven small holes, the web five larger ones. Diameters are such that cutting and auxiliary time per
hole come near the 1.6 s that Table 2 of Wang et al. (2025) implies with the default machine.
"""

import math

import numpy as np

from cutgap.instances.arrays import Floats
from cutgap.instances.generate.holes import DECIMALS, part_of_holes
from cutgap.instances.instance import Instance

PILLARS = 4
PITCH = 420.0
LENGTH = 1100.0
ORIGIN = np.array([620.0, 300.0, 150.0])
FLANGE_HOLES = 7
WEB_HOLES = 5
FLANGE_DIAMETERS = (5.5, 7.5)
WEB_DIAMETERS = (9.0, 14.0)
HOLES = PILLARS * (2 * FLANGE_HOLES + WEB_HOLES)


def b_pillars(rng: np.random.Generator) -> Instance:
    """Return the four pillars; ``rng`` decides places along the rows and diameters, the same in each."""
    points, perimeters = pillar(rng)
    # Rounded before the parts are set out, so that they are equal to the last digit.
    points = np.round(points, DECIMALS)
    offsets = [ORIGIN + PITCH * number * np.array([1.0, 0.0, 0.0]) for number in range(PILLARS)]
    ids = [f"p{p}-h{h:02d}" for p in range(1, PILLARS + 1) for h in range(1, len(points) + 1)]
    return part_of_holes(
        "b-pillars", np.concatenate([points + offset for offset in offsets]), np.tile(perimeters, PILLARS), ids
    )


def pillar(rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Return the holes of one pillar around (0, 0, 0): points (19, 3) and perimeters (19,), mm."""
    rows = []
    for side in (-1.0, 1.0):
        along = _spread(FLANGE_HOLES, 0.03, 0.97, rng)
        rows.append(_surface(along, side * (_half_width(along) - 10.0), lift=0.0))
    along = _spread(WEB_HOLES, 0.08, 0.9, rng)
    rows.append(_surface(along, rng.uniform(-8.0, 8.0, WEB_HOLES), lift=45.0))
    diameters = [rng.uniform(*FLANGE_DIAMETERS, 2 * FLANGE_HOLES), rng.uniform(*WEB_DIAMETERS, WEB_HOLES)]
    return np.concatenate(rows), math.pi * np.concatenate(diameters)


def _spread(count: int, first: float, last: float, rng: np.random.Generator) -> Floats:
    """Return even places along the pillar (0 foot, 1 head), each moved by up to 0.02."""
    return np.linspace(first, last, count) + rng.uniform(-0.02, 0.02, count)


def _half_width(along: Floats) -> Floats:
    foot, head = np.exp(-((along / 0.2) ** 2)), np.exp(-(((1.0 - along) / 0.15) ** 2))
    return 50.0 + 65.0 * foot + 20.0 * head


def _surface(along: Floats, across: Floats, lift: float) -> Floats:
    """Return points ``across`` mm beside the bowed middle line and ``lift`` mm above the flanges."""
    bow = np.sin(math.pi * along)
    return np.column_stack([across + 35.0 * bow, LENGTH * along, lift + 80.0 * bow])
