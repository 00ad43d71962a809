"""Seeded generators: the references' simulated parts, car-body parts and nest, and special cases.

Every generator takes its random numbers from the generator that is passed in; ``generate`` makes one from
a seed, so that kind, number of holes and seed name a part for good.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cutgap.instances.generate import b_pillars as pillars
from cutgap.instances.generate import door_panel as door
from cutgap.instances.generate.b_pillars import b_pillars
from cutgap.instances.generate.door_panel import door_panel
from cutgap.instances.generate.flame import SHAPES as FLAME_SHAPES
from cutgap.instances.generate.flame import flame
from cutgap.instances.generate.nest28 import CONTOURS as NEST28_CONTOURS
from cutgap.instances.generate.nest28 import nest28
from cutgap.instances.generate.plates import dense_plate, plate
from cutgap.instances.generate.random_parts import (
    coincident_part,
    collinear_part,
    one_column_part,
    random_part,
    tied_part,
)
from cutgap.instances.generate.structured_parts import (
    bolt_circles_part,
    clusters_part,
    columns_part,
    grid_part,
    staggered_grid_part,
)
from cutgap.instances.instance import Instance

__all__ = [
    "KINDS",
    "b_pillars",
    "bolt_circles_part",
    "clusters_part",
    "coincident_part",
    "collinear_part",
    "columns_part",
    "dense_plate",
    "door_panel",
    "flame",
    "generate",
    "grid_part",
    "nest28",
    "one_column_part",
    "plate",
    "random_part",
    "staggered_grid_part",
    "tied_part",
]

HOLE_LIMIT = 100_000


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of part: what it is, its number of holes unless another is given, whether that is fixed."""

    description: str
    make: Callable[[int, np.random.Generator], Instance]
    holes: int
    fixed: bool = False


KINDS: dict[str, Kind] = {
    "random": Kind("even in the reference's ranges", random_part, 45),
    "b-pillars": Kind("four B-pillars side by side", lambda _, rng: b_pillars(rng), pillars.HOLES, fixed=True),
    "door-panel": Kind("door inner panel", lambda _, rng: door_panel(rng), door.HOLES, fixed=True),
    "nest28": Kind("nest of 28 parts", lambda _, rng: nest28(rng), NEST28_CONTOURS, fixed=True),
    "flame": Kind("irregular outlines close together, for one stroke", flame, FLAME_SHAPES),
    "plate": Kind("polygons, circles and ellipses under heat, on 10 m x 5 m", plate, 30),
    "dense-plate": Kind("the same, small and close together", dense_plate, 30),
    "ties": Kind("columns of equal x", tied_part, 12),
    "coincident": Kind("half of the holes on top of others", coincident_part, 12),
    "collinear": Kind("all holes on one slanted line", collinear_part, 12),
    "grid": Kind("square grid of equal holes", grid_part, 64),
    "staggered-grid": Kind("grid of equilateral triangles", staggered_grid_part, 64),
    "bolt-circles": Kind("3 x 2 equal bolt circles", bolt_circles_part, 72),
    "clusters": Kind("scattered around four centres", clusters_part, 60),
    "columns": Kind("eight holes in each column of equal x", columns_part, 64),
    "one-column": Kind("all holes of equal x", one_column_part, 12),
}
"""The kinds of parts by name."""


def generate(kind: str, *, holes: int | None = None, seed: int) -> Instance:
    """Return the part that kind, number of holes and seed name, called ``KIND-HOLES-sSEED``.

    Parameters
    ----------
    kind
        A key of ``KINDS``.
    holes
        Number of holes; ``None`` takes the kind's own number.
    seed
        Seed of the random numbers, at least 0.

    Raises
    ------
    ValueError
        When the kind is unknown, or a number is out of range or not for this kind.
    """
    if kind not in KINDS:
        raise ValueError(f"kind: expected one of {', '.join(KINDS)}, got {kind!r:.40}")
    chosen = KINDS[kind]
    count = chosen.holes if holes is None else holes
    if chosen.fixed and count != chosen.holes:
        raise ValueError(f"holes: {kind} has {chosen.holes}, got {count}")
    if not 0 <= count <= HOLE_LIMIT:
        raise ValueError(f"holes: expected 0 to {HOLE_LIMIT}, got {count}")
    if seed < 0:
        raise ValueError(f"seed: expected at least 0, got {seed}")
    instance = chosen.make(count, np.random.default_rng(seed))
    return replace(instance, name=f"{kind}-{count}-s{seed}")
