"""The variables of one head, and its way: what a tour formulation may know of a problem.

    x        legs, 0 or 1 (see ``network``; closing legs included)
    y, z, q, first, time    linear in x:  z[i] = sum_j y[j,i], depot included;  time = T of the head  [s]
    p[i]     position of a contour in the head's order, 1 .. n, where a family asks for it

Where contours have several entry points, y is a variable of its own, tied to x by ``y = (matrix of y) x``:
rows between contours then stay short. It is free, so its reduced cost is 0 and what these rows are multiplied
by follows from the other rows: multipliers of those alone hold for the model with y written out.
"""

from dataclasses import dataclass
from functools import cached_property

import cvxpy as cp
import numpy as np

from cutgap.formulations.compact.network import Network, Pairs


class Way:
    """One head between contours: all that a tour formulation sees.

    Attributes
    ----------
    head
        Index of the head.
    pairs
        The pairs (i, j) of contours and depot, in the order of y.
    y
        Shape (pairs,): 1 when the head goes from i to j.
    z
        Shape (contours,): 1 when the head cuts the contour.
    alone
        Whether there is no other head: all contours are on this way.
    """

    def __init__(self, head: int, pairs: Pairs, y: cp.Expression, *, alone: bool) -> None:
        self.head, self.pairs, self.y, self.alone = head, pairs, y, alone
        self.z: cp.Expression = pairs.into @ y

    @property
    def contours(self) -> int:
        """Number of contours, n."""
        return self.pairs.contours

    @cached_property
    def position(self) -> cp.Variable:
        """The variable p, shape (contours,); made when it is first asked for."""
        return cp.Variable(self.contours, name=f"p{self.head}", bounds=[1, self.contours])


@dataclass(frozen=True, eq=False)
class HeadVariables:
    """Variables and shorthands of one head.

    Attributes
    ----------
    x
        Shape (legs,).
    q, first
        Shape (entry points,).
    time
        T, s.
    cost
        Sum of d x, mm.
    definitions
        What ties y to x.
    """

    network: Network
    x: cp.Variable
    way: Way
    q: cp.Expression
    first: cp.Expression
    time: cp.Expression
    cost: cp.Expression
    definitions: tuple[cp.Constraint, ...]


def head_variables(network: Network, *, integer: bool) -> HeadVariables:
    """Build the variables of a head; without ``integer`` they are those of the relaxation."""
    instance, name = network.instance, f"x{network.head}"
    legs = len(network.tails)
    x = cp.Variable(legs, name, boolean=True) if integer else cp.Variable(legs, name, bounds=[0, 1])
    written_out = network.to_pairs @ x
    y, definitions = written_out, list[cp.Constraint]()
    if int(instance.first_node[-1]) > len(instance.contours):
        y = cp.Variable(len(network.pairs.tails), name=f"y{network.head}")
        definitions = [y == written_out]
    way = Way(network.head, network.pairs, y, alone=len(instance.heads) == 1)
    seconds = network.lengths / instance.machine.v_jump
    return HeadVariables(
        network=network,
        x=x,
        way=way,
        q=network.into @ x,
        first=network.from_depot @ x,
        time=seconds @ x + np.array(instance.service_times) @ way.z,
        cost=network.costs @ x,
        definitions=tuple(definitions),
    )
