"""Small random plates under heat, with ties, and all their plans by brute force from the published formula."""

import math
from itertools import permutations, product

import numpy as np

from cutgap.instances import Contour, Head, Instance, Machine, Material

STEEL = Material("steel", 48.0, 480.0, 7850.0, thickness_mm=5.0, power_w=1000.0, ambient_c=20.0)


def random_plate(rng, contours=4, points=3, home=None, metric=None):
    """Return contours close together; some on one spot, some without length, some equal."""
    made = []
    for k in range(contours):
        corners = rng.integers(0, 20, 2) + rng.integers(0, 7, (4, 2))
        if rng.random() < 0.15:
            corners = np.repeat(corners[:1], 4, axis=0)
        if made and rng.random() < 0.2:
            corners = made[-1].geometry + 0.0
        entries = corners[rng.permutation(4)[:points]]
        closed = np.vstack([corners, corners[:1]])
        length = float(np.hypot(*np.diff(closed, axis=0).T).sum())
        made.append(
            Contour(f"c{k}", np.column_stack([entries, np.zeros(len(entries))]), length, geometry=corners)
        )
    home = bool(rng.integers(2)) if home is None else home
    metric = str(rng.choice(["euclidean", "chebyshev", "matrix"])) if metric is None else metric
    matrix = None
    if metric == "matrix":
        nodes = contours * min(points, 4) + home
        matrix = rng.integers(0, 30, (nodes, nodes)).astype(float)
    machine = Machine(
        v_jump=float(rng.choice([20.0, 67.0])),
        v_cut=float(rng.choice([10.0, 42.0])),
        t_aux=float(rng.choice([0.0, 0.0, 0.5])),
        metric=metric,
    )
    head = Head("head", np.zeros(3) if home else None)
    return Instance("small", tuple(made), (head,), machine, material=STEEL, matrix=matrix)


def all_plans(instance):
    """Yield order, entries, travel (mm) and peak (deg C) of every plan."""
    near = [
        [[_to_curve(point[:2], other.geometry) for other in instance.contours] for point in c.entry_points]
        for c in instance.contours
    ]
    sizes = [range(len(c.entry_points)) for c in instance.contours]
    ways = instance.rapids.tolist()
    first = [0]
    for size in sizes:
        first.append(first[-1] + len(size))
    home = first[-1] if instance.heads[0].home is not None else None
    machine = instance.machine
    works = [c.perimeter / machine.v_cut + machine.t_aux for c in instance.contours]
    for order in permutations(range(len(sizes))):
        for entries in product(*sizes):
            nodes = [first[c] + entries[c] for c in order]
            legs = [ways[a][b] for a, b in zip(nodes, nodes[1:], strict=False)]
            out = 0.0 if home is None or not nodes else ways[home][nodes[0]]
            back = 0.0
            if nodes:
                back = ways[nodes[-1]][nodes[0] if home is None else home]
            ends, peak, now = [], 0.0, 0.0
            for place, c in enumerate(order):
                now += legs[place - 1] / machine.v_jump if place else 0.0
                rise = sum(
                    _kernel(instance, near[c][entries[c]][j], now - end)
                    for j, end in zip(order, ends, strict=False)
                )
                peak = max(peak, rise)
                now += works[c]
                ends.append(now)
            yield order, entries, out + sum(legs) + back, instance.material.ambient_c + peak


def _kernel(instance, distance_mm, lag_s):
    material = instance.material
    if lag_s <= 0.0:
        return 0.0 if distance_mm > 0.0 else math.inf
    stored = material.specific_heat_j_per_kg_k * material.density_kg_per_m3
    spread = material.conductivity_w_per_m_k / stored
    thickness, speed = material.thickness_mm / 1000.0, instance.machine.v_cut / 1000.0
    scale = math.sqrt(4.0 * math.pi * material.conductivity_w_per_m_k * stored * lag_s)
    decay = math.exp(-((distance_mm / 1000.0) ** 2) / (4.0 * spread * lag_s))
    return material.power_w / (speed * thickness * scale) * decay


def _to_curve(point, curve):
    corners = curve.tolist()
    return min(_to_segment(point, a, b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True))


def _to_segment(point, a, b):
    dx, dy = b[0] - a[0], b[1] - a[1]
    size = dx * dx + dy * dy
    share = 0.0
    if size > 0.0:
        share = min(1.0, max(0.0, ((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / size))
    return math.hypot(point[0] - a[0] - share * dx, point[1] - a[1] - share * dy)
