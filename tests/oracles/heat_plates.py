"""Small plates under heat with what breaks exact methods: ties, equal contours, contours without length."""

import numpy as np

from cutgap.instances import Contour, Head, Instance, Machine, Material
from cutgap.instances.generate.plates import dense_plate

STEEL = Material("steel", 48.0, 480.0, 7850.0, thickness_mm=5.0, power_w=1000.0, ambient_c=20.0)


def tied_plate(rng, contours, points=3, home=None, metric=None):
    """Return contours on whole millimetres, close together; some on one spot, some equal to the one before."""
    made = []
    for k in range(contours):
        corners = rng.integers(0, 20, 2) + rng.integers(0, 7, (4, 2))
        if rng.random() < 0.15:
            corners = np.repeat(corners[:1], 4, axis=0)
        if made and rng.random() < 0.2:
            corners = made[-1].geometry
        entries = np.column_stack([corners[rng.permutation(4)[:points]], np.zeros(points)])
        closed = np.vstack([corners, corners[:1]])
        length = float(np.hypot(*np.diff(closed, axis=0).T).sum())
        made.append(Contour(f"c{k}", entries, length, geometry=corners))
    home = bool(rng.integers(2)) if home is None else home
    metric = str(rng.choice(["euclidean", "chebyshev", "matrix"])) if metric is None else metric
    nodes = contours * points + home
    machine = Machine(
        v_jump=float(rng.choice([20.0, 67.0])),
        v_cut=float(rng.choice([10.0, 42.0])),
        t_aux=float(rng.choice([0.0, 0.0, 0.5])),
        metric=metric,
    )
    matrix = rng.integers(0, 30, (nodes, nodes)).astype(float) if metric == "matrix" else None
    head = Head("head", np.zeros(3) if home else None)
    return Instance("tied", tuple(made), (head,), machine, material=STEEL, matrix=matrix)


def few_starts(contours, starts, seed):
    """Return a dense plate with at most so many start points a contour."""
    plate = dense_plate(contours, np.random.default_rng(seed))
    chosen = []
    for contour in plate.contours:
        places = np.unique(np.linspace(0, len(contour.entry_points), starts, endpoint=False).astype(int))
        points = contour.entry_points[places]
        chosen.append(Contour(contour.id, points, contour.perimeter, geometry=contour.geometry))
    return Instance("few", tuple(chosen), plate.heads, plate.machine, material=plate.material)
