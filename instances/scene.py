"""What a run has before it at one moment, as plain data from which pictures are made.

Places are nodes of the ``Instance``; while a scene is made they may be numbers of a model, which
``Scene.with_nodes`` turns into nodes. Bounds are in mm until ``Scene.with_bounds`` gives them the unit of the
objective.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from cutgap.instances.instance import Instance
from cutgap.instances.plan import Plan

State = Literal["open", "divided", "bound", "infeasible", "solution"]
"""A node of a tree: not finished, branched on, or closed by its bound, without solutions, by one."""

Range = tuple[float, float]
"""Lower and upper bound; the upper one is infinite when nothing was found."""

Relabel = Callable[[Sequence[int]], tuple[int, ...]]


@dataclass(frozen=True, slots=True)
class Leg:
    """A rapid between two nodes with its value in a solution: 1 when it is made once."""

    start: int
    end: int
    value: float
    head: int = 0


@dataclass(frozen=True, slots=True)
class Inequality:
    """A row of a model in words and symbols; ``left >= right`` is asked for.

    ``sets`` holds the nodes that each symbol stands for, ``left`` and ``right`` are the values of both sides
    at the solution shown. Without them it speaks of a family of ``count`` rows.
    """

    tag: str
    symbols: str
    words: str
    sets: tuple[tuple[str, tuple[int, ...]], ...] = ()
    left: float | None = None
    right: float | None = None
    count: int = 1


@dataclass(frozen=True, slots=True)
class Decision:
    """Bounds that branching puts on a variable, which ``symbol``, nodes and head name."""

    symbol: str
    nodes: tuple[int, ...]
    head: int | None
    lower: float
    upper: float


@dataclass(frozen=True, slots=True)
class Branch:
    """A node of a tree, by its number; the last of its decisions."""

    number: int
    parent: int | None
    bound: float
    state: State
    decision: Decision | None = None


@dataclass(frozen=True, slots=True)
class Threshold:
    """A division at ``x`` (mm) that gives ``count`` contours to the left head: bounds on T_1 and T_2 (s)."""

    x: float
    count: int
    times: tuple[Range, Range]


@dataclass(frozen=True, slots=True)
class Pass:
    """A pass of the dynamic programme; all but ``states`` (kept, for each position) by contour.

    ``prices`` in mm; ``visits`` is empty when no walk is shown; ``memories`` holds the contours that a walk
    standing at each one may remember.
    """

    prices: tuple[float, ...]
    visits: tuple[int, ...]
    memories: tuple[tuple[int, ...], ...]
    states: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Scene:
    """What a run does; ``None`` where it has nothing new to say.

    Attributes
    ----------
    text
        The step in a sentence.
    bound
        What the solution shown costs, or is known to cost at least.
    legs
        The solution shown.
    rows
        Inequalities that this solution breaks and that join the model, or families that it begins with.
    branch, branches
        The node worked on, and all nodes that came up or changed.
    best
        The incumbent, for each head the nodes in order, its home first if it has one.
    owners
        The head of each contour, -1 where it is not decided.
    """

    text: str
    bound: float | None = None
    legs: tuple[Leg, ...] | None = None
    rows: tuple[Inequality, ...] = ()
    branch: int | None = None
    branches: tuple[Branch, ...] = ()
    best: tuple[tuple[int, ...], ...] | None = None
    owners: tuple[int, ...] | None = None
    thresholds: tuple[Threshold, ...] | None = None
    threshold: int | None = None
    dp: Pass | None = None

    def with_bounds(self, unit: Callable[[float], float]) -> "Scene":
        """Return the scene with its bounds in another unit."""
        branches = tuple(replace(each, bound=unit(each.bound)) for each in self.branches)
        return replace(self, bound=None if self.bound is None else unit(self.bound), branches=branches)

    def with_nodes(self, nodes: Sequence[int]) -> "Scene":
        """Return the scene with ``nodes[v]`` in place of each v."""

        def moved(members: Sequence[int]) -> tuple[int, ...]:
            return tuple(int(nodes[v]) for v in members)

        return replace(
            self,
            legs=None if self.legs is None else tuple(_moved_leg(leg, moved) for leg in self.legs),
            rows=tuple(replace(row, sets=tuple((s, moved(m)) for s, m in row.sets)) for row in self.rows),
            branches=tuple(_decided(branch, moved) for branch in self.branches),
            best=None if self.best is None else tuple(map(moved, self.best)),
        )


def _moved_leg(leg: Leg, moved: Relabel) -> Leg:
    start, end = moved((leg.start, leg.end))
    return replace(leg, start=start, end=end)


def _decided(branch: Branch, moved: Relabel) -> Branch:
    if branch.decision is None:
        return branch
    return replace(branch, decision=replace(branch.decision, nodes=moved(branch.decision.nodes)))


def plan_nodes(instance: Instance, plan: Plan) -> tuple[tuple[int, ...], ...]:
    """Return the nodes of each head of a plan in order, its home first if it has one."""
    homes = [instance.home_node(head) for head in range(len(plan.tours))]
    return tuple(
        (*(() if home is None else (home,)), *(instance.node(visit.contour, visit.entry) for visit in tour))
        for home, tour in zip(homes, plan.tours, strict=True)
    )
