r"""Runs of visits that overheat, and walk problems without them.

    run       sets E_0, .., E_k of points of k + 1 contours: a plan that visits one of E_0, then one of E_1 and
              so on, one right after the other, has a rise beyond the cap at the last of them
    (1)       R >= sum over i < k of T(L_wi, time from the end of visit i to the start at w in E_k)
    item      (run, i): the last i visits were in E_0, .., E_(i-1)
    state     a point and the items with i >= 2 that hold there
    (2)       from a state a step to w leads to the state of w and the items that go on; it is forbidden when
              a run is complete

    (3)       G_i(v) = min over steps v -> u, u in E_(i+1), of G_(i+1)(u)  +  least T(L_wv, t) over t in I_i(v)
              least rise at w of the visits from v in E_i on;  G_k(w) = 0,  I_k(w) = 0
              I_i(v) = [least, most] over these steps of d_vu + s_u + I_(i+1)(u), without s_u for u = w

(1) holds since all terms are at least 0, and the times within a run follow from its points alone. (3) is at
most (1) for each combination: by induction from w back, the lag of visit i is in I_i(v), where the kernel is
least at an end, and one of the u is the combination's own. A run is a walk that exceeds the cap by (1), widened
by points as long as G_0 exceeds it at each w; so all its combinations do, and no plan within the cap contains
it. Walks over states by (2), each contour at one of its states, are exactly the walks over points that contain
no run: the walk problem over states is a relaxation of travel under the cap, and its optimum is a lower bound.
When its best walk keeps the cap, that is the best plan; else a visit is too warm, the last k + 1 visits up to
it, the fewest that exceed the cap, are a new run, and no walk comes back. There are finitely many walks, so
this ends.

Source: the determinisation of an automaton for forbidden words (Aho and Corasick, 1975), over sets of points.
"""

from dataclasses import replace

import numpy as np
from numba import njit

from cutgap.formulations.contour_dp.walks import Walks
from cutgap.formulations.heat.plates import Plate, least_warmth, warmth
from cutgap.instances.arrays import Ints

Run = tuple[frozenset[int], ...]
Items = frozenset[tuple[int, int]]

ROUNDING = 1e-12
"""Relative slack of times."""


@njit(cache=True)
def rise_from(plate: Plate, points: Ints, since: int, last: int) -> float:
    """Return the part of the rise at visit ``last`` of a sequence that comes from visits ``since`` on, K."""
    lag, rise, w = 0.0, 0.0, points[last]
    for i in range(last - 1, since - 1, -1):
        lag += plate.time[points[i], points[i + 1]]
        rise += warmth(plate.constant, plate.spread, plate.distance[w, plate.contour_of[points[i]]], lag)
        lag += plate.service[plate.contour_of[points[i]]]
    return rise


@njit(cache=True)
def least_rise_at(plate: Plate, w: int, choices: Ints, sizes: Ints) -> float:
    """Return the least G_0 of (3) at point w, K; row i of ``choices`` begins with E_i, of one contour."""
    widest = choices.shape[1]
    soon, late, rise = np.zeros(widest), np.zeros(widest), np.zeros(widest)
    after, count = np.full(widest, w), 1
    for i in range(len(sizes) - 1, -1, -1):
        new_soon, new_late, new_rise = np.full(widest, np.inf), np.zeros(widest), np.full(widest, np.inf)
        for x in range(sizes[i]):
            v = choices[i, x]
            for y in range(count):
                u = after[y]
                if plate.cost[v, u] == np.inf or rise[y] == np.inf:
                    continue
                way = plate.time[v, u]
                if i < len(sizes) - 1:
                    way += plate.service[plate.contour_of[u]]
                new_soon[x] = min(new_soon[x], way + soon[y])
                new_late[x] = max(new_late[x], way + late[y])
                new_rise[x] = min(new_rise[x], rise[y])
            if new_rise[x] < np.inf:
                soonest, latest = new_soon[x] * (1.0 - ROUNDING), new_late[x] * (1.0 + ROUNDING)
                far = plate.distance[w, plate.contour_of[v]]
                new_rise[x] += least_warmth(plate.constant, plate.spread, far, soonest, latest)
        soon, late, rise = new_soon, new_late, new_rise
        after, count = choices[i], sizes[i]
    return float(rise[:count].min())


def too_warm(plate: Plate, walk: Ints, cap: float) -> list[list[int]]:
    """Return, for each visit beyond the cap, the fewest last visits up to it that exceed it."""
    found = []
    for last in range(1, len(walk)):
        if rise_from(plate, walk, 0, last) > cap:
            since = last - 1
            while not rise_from(plate, walk, since, last) > cap:
                since -= 1
            found.append(walk[since : last + 1].tolist())
    return found


def widened(plate: Plate, points: list[int], cap: float) -> Run:
    """Return a run that contains these points, with more points of the same contours by (3)."""
    sets = [[point] for point in points]
    for i, point in enumerate(points):
        a = int(plate.contour_of[point])
        others = [each for each in range(int(plate.first[a]), int(plate.first[a + 1])) if each != point]
        # All at once where that is possible, since it mostly is.
        for more in (others, *([each] for each in others)):
            trial = [*sets[:i], sets[i] + more, *sets[i + 1 :]]
            if more and overheats(plate, trial, cap):
                sets = trial
                if more is others:
                    break
    return tuple(frozenset(each) for each in sets)


def overheats(plate: Plate, sets: list[list[int]], cap: float) -> bool:
    """Whether (3) shows that all combinations exceed the cap."""
    sizes = np.array([len(each) for each in sets[:-1]], dtype=np.int64)
    choices = np.zeros((len(sizes), int(sizes.max())), dtype=np.int64)
    for i, each in enumerate(sets[:-1]):
        choices[i, : len(each)] = each
    return all(least_rise_at(plate, w, choices, sizes) > cap for w in sets[-1])


def without_hot_pairs(plate: Plate, walks: Walks, cap: float) -> Walks:
    """Return the walks without the steps that exceed the cap alone: the runs of two points."""
    lag = plate.time
    near = plate.distance[:, plate.contour_of].T
    with np.errstate(divide="ignore", invalid="ignore"):
        rises = plate.constant * np.exp(-(near**2) / (plate.spread * lag)) / np.sqrt(lag)
    rises = np.where(lag > 0.0, rises, np.where(near > 0.0, 0.0, np.inf))
    return replace(walks, costs=np.where(rises > cap, np.inf, walks.costs))


class States:
    """The states of (2) for some runs, and the walk problem over them."""

    def __init__(self, walks: Walks, runs: list[Run]) -> None:
        self.walks, self.runs = walks, runs
        self.begun: dict[int, list[int]] = {}
        for number, run in enumerate(runs):
            for point in run[0]:
                self.begun.setdefault(point, []).append(number)
        self.found = {(point, frozenset[tuple[int, int]]()): None for point in range(len(walks.end))}
        self.steps: dict[tuple[int, Items], dict[int, Items | None]] = {}
        waiting = list(self.found)
        for state in waiting:
            self.steps[state] = self._steps(*state)
            for point, items in self.steps[state].items():
                if items is not None and (point, items) not in self.found:
                    self.found[point, items] = None
                    waiting.append((point, items))

    def _steps(self, point: int, items: Items) -> dict[int, Items | None]:
        """Return where steps to points lead on which a run goes on: to a state with items, or nowhere."""
        after: dict[int, set[tuple[int, int]]] = {}
        complete = set()
        for number, length in [*items, *((number, 1) for number in self.begun.get(point, ()))]:
            run = self.runs[number]
            for target in run[length]:
                if length + 1 == len(run):
                    complete.add(target)
                after.setdefault(target, set()).add((number, length + 1))
        return {target: None if target in complete else frozenset(each) for target, each in after.items()}

    def problem(self) -> tuple[Walks, Ints]:
        """Return the walk problem over states, and the point of each."""
        contour_of = self.walks.contour_of
        states = sorted(self.found, key=lambda state: (contour_of[state[0]], state[0], len(state[1])))
        number = {state: k for k, state in enumerate(states)}
        point_of = np.array([point for point, _ in states], dtype=np.int64)
        plain = np.array([number[point, frozenset()] for point in range(len(contour_of))])
        costs = np.full((len(states), len(states)), np.inf)
        costs[:, plain] = self.walks.costs[point_of]
        for k, state in enumerate(states):
            for target, items in self.steps[state].items():
                costs[k, plain[target]] = np.inf
                if items is not None:
                    costs[k, number[target, items]] = self.walks.costs[state[0], target]
        start = np.full(len(states), np.inf)
        start[plain] = self.walks.start
        crossed = self.walks.crossed
        problem = replace(
            self.walks,
            visits=tuple(self.walks.visits[point] for point in point_of),
            first=np.searchsorted(contour_of[point_of], np.arange(self.walks.count + 1)).astype(np.int64),
            costs=costs,
            start=start,
            end=self.walks.end[point_of],
            crossed=None if crossed is None else np.ascontiguousarray(crossed[np.ix_(point_of, point_of)]),
        )
        return problem, point_of
