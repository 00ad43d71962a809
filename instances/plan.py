"""A plan: per head the visits in order."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple


class Visit(NamedTuple):
    """A contour (index) and the entry point (index within the contour) at which it is pierced."""

    contour: int
    entry: int = 0


@dataclass(frozen=True, slots=True)
class Plan:
    """Per head its tour: the visits from leaving the home to returning to it.

    Whether it fits an instance is for ``check`` to say.
    """

    tours: tuple[tuple[Visit, ...], ...]

    def __post_init__(self) -> None:
        tours = tuple(tuple(Visit(int(c), int(e)) for c, e in tour) for tour in self.tours)
        object.__setattr__(self, "tours", tours)

    @classmethod
    def of_contours(cls, orders: Iterable[Sequence[int]]) -> "Plan":
        """Build a plan from contour indices alone, each pierced at entry point 0."""
        return cls(tuple(tuple(Visit(int(contour)) for contour in order) for order in orders))
