r"""Plates of polygons, circles and ellipses: the reference's, and smaller ones on which heat matters.

``plate``        30 contours on 10 m x 5 m, one in each cell of a 6 x 5 grid, at a random place in it
``dense_plate``  contours of 8 to 20 mm in three rows, webs of 2 to 5 mm between the circles around them

45 steel of 5 mm, 1000 W, 2.5 m/min, axes at 4 m/min that move at once; no time for piercing, which the
reference does not count. Start points are the corners of polygons and eight points at equal angles of circles
and ellipses. Coordinates of the reference's own plate are not published.

Source: Yang, Liu, Ju (2012), sections 2.1 and 3; constants of 45 steel from tables.
"""

import math

import numpy as np

from cutgap.instances.arrays import Floats, closed_length
from cutgap.instances.instance import Contour, Head, Instance, Machine, Material

STEEL_45 = Material(
    name="45 steel",
    conductivity_w_per_m_k=48.0,
    specific_heat_j_per_kg_k=480.0,
    density_kg_per_m3=7850.0,
    thickness_mm=5.0,
    power_w=1000.0,
)
MM_PER_S = 1000.0 / 60.0
"""1 m/min."""
MACHINE = Machine(v_jump=4.0 * MM_PER_S, v_cut=2.5 * MM_PER_S, t_aux=0.0, metric="chebyshev")

PLATE = (10_000.0, 5_000.0)
GRID = (6, 5)
PLATE_DIAMETERS = (250.0, 800.0)
DENSE_DIAMETERS = (8.0, 20.0)
DENSE_WEBS = (2.0, 5.0)
DENSE_ROWS = 3
CORNERS = (3, 7)
"""Fewest corners of a polygon, and one more than most."""
CURVE_POINTS = 64
"""Corners of the polyline of a circle or ellipse, of which every eighth is a start point."""


def plate(contours: int, rng: np.random.Generator) -> Instance:
    """Return contours on the reference's plate, one in each cell of a grid.

    Raises
    ------
    ValueError
        When there are more contours than cells.
    """
    cells = GRID[0] * GRID[1]
    if contours > cells:
        raise ValueError(f"holes: the plate has room for {cells} contours, got {contours}")
    size = np.array([PLATE[0] / GRID[0], PLATE[1] / GRID[1]])
    made = []
    for number, cell in enumerate(np.sort(rng.choice(cells, contours, replace=False)).tolist()):
        diameter = rng.uniform(*PLATE_DIAMETERS)
        corner = size * np.array([cell % GRID[0], cell // GRID[0]])
        centre = corner + diameter / 2 + rng.uniform(0.0, 1.0, 2) * (size - diameter)
        made.append(_contour(str(number + 1), centre, diameter, rng))
    return _instance(f"plate-{contours}", made)


def dense_plate(contours: int, rng: np.random.Generator) -> Instance:
    """Return small contours in rows, as near to each other as webs of 2 to 5 mm allow.

    Three rows: neighbours above and below are still hot when a short route comes by, and a plate so long has
    room to keep away from them.
    """
    columns = math.ceil(contours / DENSE_ROWS)
    made: list[Contour] = []
    lower = 0.0
    while len(made) < contours:
        left, upper = 0.0, lower
        for _ in range(min(columns, contours - len(made))):
            diameter = rng.uniform(*DENSE_DIAMETERS)
            left += rng.uniform(*DENSE_WEBS)
            base = lower + rng.uniform(*DENSE_WEBS)
            centre = np.array([left, base]) + diameter / 2
            made.append(_contour(str(len(made) + 1), centre, diameter, rng))
            left, upper = left + diameter, max(upper, base + diameter)
        lower = upper
    return _instance(f"dense-plate-{contours}", made)


def _instance(name: str, contours: list[Contour]) -> Instance:
    head = Head("head", np.zeros(3))
    return Instance(name, tuple(contours), (head,), MACHINE, material=STEEL_45)


def _contour(name: str, centre: Floats, diameter: float, rng: np.random.Generator) -> Contour:
    """Return a polygon, a circle or an ellipse within a circle of this diameter."""
    kind = int(rng.integers(3))
    turn = rng.uniform(0.0, math.tau)
    if kind == 0:
        corners = int(rng.integers(*CORNERS))
        # Angles that share the turn unevenly, but leave each corner apart from the next.
        shares = rng.uniform(0.6, 1.4, corners)
        angles = turn + math.tau * np.cumsum(shares) / shares.sum()
        curve = diameter / 2 * np.column_stack([np.cos(angles), np.sin(angles)])
        starts = np.arange(corners)
    else:
        angles = math.tau * np.arange(CURVE_POINTS) / CURVE_POINTS
        minor = 1.0 if kind == 1 else rng.uniform(0.4, 0.8)
        plain = diameter / 2 * np.column_stack([np.cos(angles), minor * np.sin(angles)])
        curve = plain @ np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
        starts = np.arange(0, CURVE_POINTS, CURVE_POINTS // 8)
    curve = np.round(centre + curve, 3)
    entries = np.column_stack([curve[starts], np.zeros(len(starts))])
    return Contour(name, entries, round(closed_length(curve), 3), geometry=curve)
