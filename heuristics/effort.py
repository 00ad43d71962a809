"""How long searches by ruin and recreate work."""

from dataclasses import dataclass

PIECE_SECONDS = 0.1
"""About how long the kernel works between two looks at the clock."""


@dataclass(frozen=True, slots=True)
class SearchEffort:
    """Effort of a search by ruin and recreate.

    Parameters
    ----------
    rounds_per_contour
        Rounds of ruin and recreate for each contour.
    """

    rounds_per_contour: int = 500

    def __post_init__(self) -> None:
        rounds = self.rounds_per_contour
        if isinstance(rounds, bool) or not isinstance(rounds, int) or rounds < 0:
            raise ValueError(f"rounds_per_contour: expected a whole number of at least 0, got {rounds!r}")
