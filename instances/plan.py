"""A plan: per head the visits in order."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from cutgap.instances.arrays import frozen_array


class Visit(NamedTuple):
    """A contour (index) and the entry point (index within the contour) at which it is pierced.

    Under the rule of free entries it may have a ``point`` of its own (x, y, z in mm), which replaces that one.
    """

    contour: int
    entry: int = 0
    point: tuple[float, float, float] | None = None


@dataclass(frozen=True, slots=True)
class Plan:
    """Per head its tour: the visits from leaving the home to returning to it.

    Whether it fits an instance is for ``check`` to say.
    """

    tours: tuple[tuple[Visit, ...], ...]

    def __post_init__(self) -> None:
        tours = tuple(tuple(_plain(Visit(*visit)) for visit in tour) for tour in self.tours)
        object.__setattr__(self, "tours", tours)

    @classmethod
    def of_contours(cls, orders: Iterable[Sequence[int]]) -> "Plan":
        """Build a plan from contour indices alone, each pierced at entry point 0."""
        return cls(tuple(tuple(Visit(int(contour)) for contour in order) for order in orders))


def _plain(visit: Visit) -> Visit:
    """Return a visit in Python's own numbers."""
    if visit.point is None:
        return Visit(int(visit.contour), int(visit.entry))
    point = frozen_array(visit.point, f"plan, contour {visit.contour}, point", columns=3)
    if point.ndim != 1:
        raise ValueError(f"plan, contour {visit.contour}, point: expected x, y, z, got shape {point.shape}")
    x, y, z = point.tolist()
    return Visit(int(visit.contour), int(visit.entry), (x, y, z))
