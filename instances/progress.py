"""How long work reports to whoever watches: the same event from heuristics and exact methods."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Progress:
    """State of a run: best value and proved bound so far (objective's unit), seconds since its start."""

    seconds: float
    value: float | None = None
    lower_bound: float | None = None
    message: str = ""


Watch = Callable[[Progress], None]


def nobody(progress: Progress) -> None:
    """Watch nothing: the default."""
