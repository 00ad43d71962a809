"""Good plans for a given division of the holes: tours by local search, and moves of single holes."""

import numpy as np

from cutgap.formulations.sides import Sides
from cutgap.formulations.two_heads.lengthening import balanced
from cutgap.instances import Instance, Plan, Rules, check, evaluate
from cutgap.instances.arrays import Floats

MOVES = 12
"""Most holes moved to the other head when a division is improved."""

PENALTY = 1e3
"""Price, in mm, of one mm-equivalent of imbalance beyond its limit while searching."""


class Divisions:
    """Plans for divisions of the holes between two heads, each division planned once."""

    def __init__(self, instance: Instance, rules: Rules, sides: tuple[Sides, Sides]) -> None:
        self.instance, self.rules, self.sides = instance, rules, sides
        self.everything = (1 << len(instance.contours)) - 1
        self.work = instance.service_times * instance.machine.v_jump
        self._seen: set[int] = set()

    def around(self, share: Floats, plan: Plan | None = None) -> tuple[float, Plan] | None:
        """Return the best allowed plan near ``share`` (how far head 0 has each hole), with its value in mm.

        A ``plan`` is looked at first. ``None`` when there is no allowed one, or none that is new.
        """
        left = sum(1 << hole for hole in np.flatnonzero(share >= 0.5).tolist())
        best = None if plan is None else self._valued(plan)
        for _ in range(MOVES + 1):
            if left in self._seen:
                break
            self._seen.add(left)
            found = self._planned(left)
            if found is not None and (best is None or found[0] < best[0]):
                best = found
            move = self._best_move(left)
            if move is None:
                break
            left ^= 1 << move
        return best

    def _planned(self, left: int) -> tuple[float, Plan] | None:
        orders = [self.sides[0].tour(left).order, self.sides[1].tour(self.everything & ~left).order]
        return self._valued(balanced(self.instance, self.rules, Plan.of_contours(orders)))

    def _valued(self, plan: Plan) -> tuple[float, Plan] | None:
        if check(self.instance, self.rules, plan):
            return None
        return self.in_mm(evaluate(self.instance, plan).objective(self.rules)), plan

    def in_mm(self, value: float) -> float:
        """Return an objective value in mm: a makespan times v_jump."""
        return value * self.instance.machine.v_jump if self.rules.objective == "makespan" else value

    def _best_move(self, left: int) -> int | None:
        """Return the hole whose move to the other head promises the best objective, if one gains."""
        members = (left, self.everything & ~left)
        sides = [self.sides[head].tour(each) for head, each in enumerate(members)]
        lengths = np.array([side.upper for side in sides])
        work = np.array([self.work[list(side.contours)].sum() for side in sides])
        best, best_hole = self._score(lengths, work) - 1e-9, None
        for source in (0, 1):
            target = 1 - source
            order = sides[source].order
            if len(order) < 2:
                continue
            for hole, gain in zip(order, self.sides[source].removal_gains(order), strict=True):
                cost = self.sides[target].insertion_cost(sides[target].order, hole)
                moved_lengths, moved_work = lengths.copy(), work.copy()
                moved_lengths[source] -= gain
                moved_lengths[target] += cost
                moved_work[source] -= self.work[hole]
                moved_work[target] += self.work[hole]
                score = self._score(moved_lengths, moved_work)
                if score < best and (left ^ (1 << hole)) not in self._seen:
                    best, best_hole = score, hole
        return best_hole

    def _score(self, lengths: Floats, work: Floats) -> float:
        times = lengths + work
        imbalance = abs(float(times[0] - times[1]))
        speed = self.instance.machine.v_jump
        if self.rules.objective == "makespan":
            value = float(times.max())
        else:
            value = float(lengths.sum()) + self.rules.weight / speed * imbalance
        limit = np.inf if self.rules.balance is None else self.rules.balance * speed
        return value + PENALTY * max(0.0, imbalance - limit)
