r"""What the rows of compact models are made of, and what a plan means for it.

Heads h, contours i, j, k = 0..n-1, entry points u, v as nodes; -1 is the depot: a head's home, or what is
before the first and after the last contour without one. A term is a whole number and one of these names:

    x h u v         head h goes from entry point u to v                                 {0, 1}
    y h i j         it goes from contour i to j; either may be the depot
    z h i           it cuts contour i
    q h u           it cuts C(u) from entry point u
    first h u       and begins with it
    out h u         it leaves u
    T h             floor(l) of all its legs and floor(w) of all its contours, added up      [mm / scale]
    makespan, imbalance     times scale * v_jump                                        >= 0
    p h i           position of contour i in its order; n where another head cuts i     1 .. n
    f h i j         contours still to be cut where it goes from i to j, else 0          0 .. n
    g h i j         n - f where it goes from i to j, else 0                             0 .. n
    unit h k i j    1 where it goes from i to j before it cuts k, which it does         0 .. 1
    w h t i j       1 where it goes from i, cut at position t, to j                     0 .. 1

These are the values at which each allowed plan keeps each row; the modules of rows say why. y to T are sums of
legs: x, those between a home and an entry point, and without a home the one that closes the tour, c, from its
last entry point u to its first, v. It counts in y of (-1, C(v)) and of (C(u), -1).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from cutgap.formulations.certificate.curves import Curves
from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.proof import Budget
from cutgap.formulations.certificate.rules import Rules

DEPOT = -1

Name = tuple[Any, ...]
Terms = list[tuple[int, Name]]


@dataclass(frozen=True, slots=True)
class CompactRow:
    """The sum of the terms is at least ``rhs``, or equal to it."""

    equality: bool
    rhs: int
    terms: Terms


@dataclass(frozen=True)
class Setting:
    """What a row depends on.

    Attributes
    ----------
    budget
        Pays for rows and for what has to be known about curves.
    """

    problem: Problem
    rules: Rules
    scale: int
    budget: Budget

    @property
    def count(self) -> int:
        """Number of contours, n."""
        return len(self.problem.ids)

    @property
    def heads(self) -> range:
        """The heads."""
        return range(len(self.problem.homes))

    @property
    def alone(self) -> bool:
        """Whether one head cuts all contours."""
        return len(self.problem.homes) == 1

    @cached_property
    def contour_of(self) -> list[int]:
        """The contour of each entry point."""
        return [contour for contour, nodes in enumerate(self.problem.entries) for _ in nodes]

    @cached_property
    def curves(self) -> Curves:
        """The curves of the contours, each of which must have one."""
        return Curves(self.problem, self.budget)

    @cached_property
    def turns(self) -> bool:
        """Whether, without a home, only tours from contour 0 to another one need to be looked at.

        The closed tour of a single head may begin anywhere when no rule says what comes first: when it is
        turned, it keeps its value and all rules.
        """
        rules = self.rules
        ordered = rules.via_points or rules.parts_in_one_go or rules.neighbours_only or rules.clear_rapids
        free = not ordered and rules.backward_price == 0 and not self.problem.precedence
        return self.alone and self.count >= 2 and free

    def is_barred(self, u: int, v: int) -> bool:
        """Whether no head may go from u to v, entry points of different contours.

        Neighbours only: their parts are different and no neighbours. Clear rapids: the rapid crosses the
        contour that it leaves, which is cut by then.
        """
        i, parts = self.contour_of[u], self.problem.parts
        a, b = parts[i], parts[self.contour_of[v]]
        if self.rules.neighbours_only and a != b and not self.curves.neighbours(a, b):
            return True
        return self.rules.clear_rapids and bool(self.curves.crossed(u, v) >> i & 1)


Builder = Callable[..., CompactRow]
Families = dict[str, tuple[str, Builder]]
"""For each family the kinds of its indices, separated by blanks, and what builds a row of it."""


def difference(h: int, i: int, j: int) -> Terms:
    """Return p[h,j] - p[h,i]."""
    return [(1, ("p", h, j)), (-1, ("p", h, i))]
