"""A family of constraints: a block of rows of one kind, and what duality makes of them.

Rows are written ``left >= right`` or ``left = right``, all variables on the left (docs/formulations.md). For
any multipliers m, those of inequalities at least 0,

    (1) cost x  >=  m right + min over the variables' bounds of (cost - m left) x

is a lower bound: weak duality. ``Family.multipliers`` gives m with these signs.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import cvxpy as cp
import numpy as np

RowName = tuple[Any, ...]
"""Name of the family, then whole numbers, words and sets as tuples of whole numbers."""


@dataclass(frozen=True, eq=False)
class Family:
    """A block of rows.

    Parameters
    ----------
    name
        What docs/formulations.md calls the family.
    prefix
        What all its rows have in common after the name, as ``(head,)``.
    rows
        The rest of each row's name, in the order of the constraint.
    constraint
        ``left >= right`` or ``left == right`` of shape (rows,).
    """

    name: str
    prefix: tuple[int, ...]
    rows: tuple[tuple[Any, ...], ...]
    constraint: cp.Constraint

    def __post_init__(self) -> None:
        if self.constraint.shape != (len(self.rows),):
            raise ValueError(f"family {self.name}: {len(self.rows)} names for shape {self.constraint.shape}")

    @property
    def is_equation(self) -> bool:
        """Whether its rows are equations."""
        return isinstance(self.constraint, cp.constraints.Equality)

    @property
    def names(self) -> list[RowName]:
        """The full name of each row."""
        return [(self.name, *self.prefix, *row) for row in self.rows]

    def multipliers(self) -> dict[RowName, float]:
        """Return m of (1) for each row of the last solved relaxation; empty when the solver gave none.

        cvxpy adds ``dual * (left - right)`` to the cost for an equation and takes ``dual * (left - right)``
        off for ``left >= right``, so that equations change their sign here.
        """
        duals = self.constraint.dual_value
        if duals is None:
            return {}
        signed = np.negative(duals) if self.is_equation else np.maximum(duals, 0.0)
        return dict(zip(self.names, np.ravel(signed).tolist(), strict=True))


def family(name: str, prefix: tuple[int, ...], rows: Iterable[Any], constraint: cp.Constraint) -> Family:
    """Build a family; a row's name may be given as a bare number."""
    return Family(name, prefix, tuple(r if isinstance(r, tuple) else (r,) for r in rows), constraint)
