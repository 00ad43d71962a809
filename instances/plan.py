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


class Link(NamedTuple):
    """A straight cut between entry points of two contours, made once or twice (there and back)."""

    contour: int
    entry: int
    to_contour: int
    to_entry: int
    passes: int = 2


@dataclass(frozen=True, slots=True)
class Plan:
    """Per head its tour: the visits from leaving the home to returning to it.

    With ``links`` a visit is the start of a stroke, which cuts all contours that are linked to the visited one
    without another pierce (``links.strokes``). Whether a plan fits an instance is for ``check`` to say.
    """

    tours: tuple[tuple[Visit, ...], ...]
    links: tuple[Link, ...] = ()

    def __post_init__(self) -> None:
        tours = tuple(tuple(_plain(Visit(*visit)) for visit in tour) for tour in self.tours)
        object.__setattr__(self, "tours", tours)
        object.__setattr__(self, "links", tuple(_plain_link(Link(*link)) for link in self.links))

    @classmethod
    def of_contours(cls, orders: Iterable[Sequence[int]]) -> "Plan":
        """Build a plan from contour indices alone, each pierced at entry point 0."""
        return cls(tuple(tuple(Visit(int(contour)) for contour in order) for order in orders))


def _plain_link(link: Link) -> Link:
    """Return a link in Python's own numbers."""
    link = Link(*map(int, link))
    if link.contour == link.to_contour:
        raise ValueError(
            f"plan, link of contour {link.contour}: leads to the contour itself; join two contours"
        )
    if link.passes not in (1, 2):
        raise ValueError(
            f"plan, link {link.contour} to {link.to_contour}, passes: expected 1 or 2, got {link.passes}"
        )
    return link


def _plain(visit: Visit) -> Visit:
    """Return a visit in Python's own numbers."""
    if visit.point is None:
        return Visit(int(visit.contour), int(visit.entry))
    point = frozen_array(visit.point, f"plan, contour {visit.contour}, point", columns=3)
    if point.ndim != 1:
        raise ValueError(f"plan, contour {visit.contour}, point: expected x, y, z, got shape {point.shape}")
    x, y, z = point.tolist()
    return Visit(int(visit.contour), int(visit.entry), (x, y, z))
