"""Small random parts for the heuristics' tests, and rules to try them under."""

import numpy as np

from cutgap.heuristics import HEURISTICS
from cutgap.instances import Contour, Head, Instance, Machine, Rules

RULES = (
    Rules(),
    Rules(via_points=True),
    Rules(objective="travel"),
    Rules(objective="weighted", weight=50.0, via_points=True),
    Rules(non_overlap=30.0),
    Rules(non_overlap=None),
    Rules(empty_heads=True, via_points=True),
)


def random_part(rng: np.random.Generator, holes: int, *, heads: int = 2, tied: bool = False) -> Instance:
    """Return a part in 2400 x 1000 x 200 mm; tied ones have few places, so that holes share x or coincide."""
    points = rng.uniform((300, 500, 100), (2400, 1500, 300), (holes, 3))
    if tied:
        points = np.multiply(rng.integers(0, 4, (holes, 3)), 50.0)
    contours = tuple(Contour(f"hole-{i}", p[None], float(rng.uniform(20, 100))) for i, p in enumerate(points))
    homes = np.linspace((200, 200, 400), (2400, 1400, 400), heads)
    return Instance("random", contours, tuple(Head(f"head-{i}", h) for i, h in enumerate(homes)), Machine())


FOR_TWO_HEADS = tuple(
    name for name, each in HEURISTICS.items() if each.applies(random_part(np.random.default_rng(0), 4), Rules())
)
