"""Random tiny sheets that heat up: those of ``random_sheets`` at a tenth of their size, with a material."""

from dataclasses import replace

import numpy as np

from cutgap.instances import Instance, Material
from oracles.random_sheets import moved_sheet, random_sheet

SCALE = 0.1
"""Contours are then up to 20 mm wide, and heat reaches the next within seconds; perimeters stay."""


def random_plate(
    rng: np.random.Generator,
    contours: int,
    *,
    entries: int = 3,
    homes: bool | None = True,
    precedence: bool | None = False,
    nested: float = 0.3,
) -> Instance:
    """Draw a sheet of one head with a material; arguments as for ``random_sheet``."""
    sheet = random_sheet(rng, contours, entries=entries, homes=homes, precedence=precedence, nested=nested)
    material = Material(
        name="random metal",
        conductivity_w_per_m_k=float(rng.uniform(20.0, 400.0)),
        specific_heat_j_per_kg_k=float(rng.uniform(300.0, 900.0)),
        density_kg_per_m3=float(rng.uniform(2500.0, 9000.0)),
        thickness_mm=float(rng.uniform(1.0, 10.0)),
        power_w=float(rng.uniform(200.0, 4000.0)),
        ambient_c=float(rng.choice([0.0, 20.0])),
    )
    return replace(moved_sheet(sheet, SCALE * np.eye(2), (0.0, 0.0)), material=material)
