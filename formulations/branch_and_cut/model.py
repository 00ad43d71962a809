"""What the engine asks of a problem: a relaxation that can be solved, cut, priced, rounded and branched on."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Fixing:
    """A branching decision: new bounds of one variable of the model."""

    variable: int
    lower: float
    upper: float


class Model(ABC):
    """A mixed-integer problem as the engine sees it.

    The model numbers its variables; which of them have a column in the linear program is its own affair. All
    rows are valid for the whole problem, so they stay when the engine moves to another node.
    """

    @abstractmethod
    def apply(self, fixings: Sequence[Fixing]) -> None:
        """Reset all bounds to the root's, then set the given ones."""

    @abstractmethod
    def solve(self, iteration_limit: int | None = None) -> bool:
        """Solve the relaxation, pricing included unless a limit is given; False when it is infeasible."""

    @abstractmethod
    def bound(self) -> float:
        """Return a lower bound on the current node from the row duals, by weak duality."""

    @abstractmethod
    def separate(self, *, thorough: bool) -> int:
        """Add violated rows and return how many; without ``thorough`` only those that solutions need."""

    @abstractmethod
    def round(self) -> tuple[float, Any] | None:
        """Return a solution near the current point with its value; the point itself when it is one."""

    @abstractmethod
    def tighten(self, cutoff: float) -> None:
        """At the root: drop variables that no solution below the cutoff uses, by reduced costs."""

    @abstractmethod
    def candidates(self, most: int) -> list[int]:
        """Return up to ``most`` fractional variables, the most promising first; none when integral."""

    @abstractmethod
    def children(self, variable: int) -> tuple[Fixing, Fixing]:
        """Return the two sides of branching on a fractional variable."""

    @abstractmethod
    def save_basis(self) -> Any:
        """Return the basis of the linear program."""

    @abstractmethod
    def restore_basis(self, basis: Any) -> None:
        """Go back to a saved basis (no rows or columns were added since)."""
