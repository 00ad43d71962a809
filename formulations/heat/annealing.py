"""Good plans under heat: simulated annealing over orders and start points (numba).

    energy = travel (or largest rise) + price * (rise beyond the cap + travel beyond its limit)

Moves take a run of visits out and put it elsewhere, turned round or not, swap two visits, turn a run round, or
change a start point. A move is judged by its travel first; rises are computed anew only from the first visit
that changed, and no further than the energy that would be accepted.

Source: Kirkpatrick, Gelatt, Vecchi (1983).
"""

from typing import Any

import numpy as np
from numba import njit

from cutgap.formulations.heat.branching import TRAVEL, Limits
from cutgap.formulations.heat.plates import Plate, may_come, warmth
from cutgap.instances.arrays import Floats, Ints

MUCH = 1e9
"""Stands for an infinite rise, K."""

LONGEST_RUN = 5


@njit(cache=True)
def travel_of(plate: Plate, path: Ints) -> float:
    """Return (2) of ``plates`` in mm; infinite where a step is forbidden."""
    if plate.before[plate.contour_of[path[0]]] != 0:
        return np.inf
    total, cut = plate.out[path[0]], 0
    for i in range(len(path) - 1):
        v, w = path[i], path[i + 1]
        cut |= 1 << plate.contour_of[v]
        if not may_come(plate, cut, v, w):
            return np.inf
        total += plate.cost[v, w]
    first = path[0] if plate.back.shape[1] > 1 else 0
    return float(total + plate.back[path[-1], first])


@njit(cache=True)
def rise_of(plate: Plate, path: Ints, since: int, end: Floats, highest: Floats, enough: float) -> float:
    """Return the largest rise, K, or one beyond ``enough``.

    ``end`` and ``highest``, ends and largest rises up to each visit, are right before visit ``since`` and are
    set from it on.
    """
    for i in range(since, len(path)):
        w, rise = path[i], 0.0
        start = 0.0 if i == 0 else end[i - 1] + plate.time[path[i - 1], w]
        for j in range(i - 1, -1, -1):
            distance = plate.distance[w, plate.contour_of[path[j]]]
            rise += warmth(plate.constant, plate.spread, distance, start - end[j])
        end[i] = start + plate.service[plate.contour_of[w]]
        highest[i] = max(highest[i - 1] if i > 0 else 0.0, min(rise, MUCH))
        if highest[i] > enough:
            return float(highest[i])
    return float(highest[-1])


@njit(cache=True)
def _change(plate: Plate, path: Ints, trial: Ints, rng: Any) -> int:
    """Set ``trial`` to a neighbour of ``path``; return the first visit that changed, -1 for none."""
    n = len(path)
    trial[:] = path
    kind = rng.random()
    i = int(rng.random() * n)
    if kind < 0.3 or n < 2:
        return _other_point(plate, trial, i, rng)
    j = int(rng.random() * n)
    if i == j:
        return -1
    i, j = min(i, j), max(i, j)
    if kind < 0.45:
        trial[i], trial[j] = path[j], path[i]
    elif kind < 0.65:
        trial[i : j + 1] = path[i : j + 1][::-1]
    else:
        _move_run(path, trial, i, j, rng)
    if rng.random() < 0.4:
        _other_point(plate, trial, i, rng)
    if rng.random() < 0.4:
        _other_point(plate, trial, j, rng)
    return i


@njit(cache=True)
def _other_point(plate: Plate, trial: Ints, i: int, rng: Any) -> int:
    """Change the start point of visit i; return i, or -1 when it is the same."""
    a = plate.contour_of[trial[i]]
    old = trial[i]
    trial[i] = plate.first[a] + int(rng.random() * (plate.first[a + 1] - plate.first[a]))
    return -1 if trial[i] == old else i


@njit(cache=True)
def _move_run(path: Ints, trial: Ints, i: int, j: int, rng: Any) -> None:
    """Move a run at one end of visits i..j to the other end, turned round or not."""
    run = 1 + int(rng.random() * min(LONGEST_RUN, j - i))
    turned = rng.random() < 0.5
    if rng.random() < 0.5:
        trial[i : j + 1 - run] = path[i + run : j + 1]
        moved, low = path[i : i + run], j + 1 - run
    else:
        trial[i + run : j + 1] = path[i : j + 1 - run]
        moved, low = path[j + 1 - run : j + 1], i
    trial[low : low + run] = moved[::-1] if turned else moved


@njit(cache=True)
def anneal(
    plate: Plate, limits: Limits, path: Ints, price: float, hot: float, cold: float, rounds: int, rng: Any
) -> tuple[float, Ints]:
    """Return the least objective of a plan within the limits that was met, and the plan; infinite for none.

    ``path`` is changed in place and ends where the annealing ended.

    Parameters
    ----------
    price
        In units of the objective per K, and per mm.
    hot, cold
        Temperatures of the annealing at its begin and end, in units of the objective.
    """
    n = len(path)
    trial, best_path = path.copy(), path.copy()
    end, highest, new_end, new_highest = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    travel, rise = travel_of(plate, path), rise_of(plate, path, 0, end, highest, np.inf)
    energy = _energy(limits, travel, rise, price)
    best = _objective(limits, travel, rise)
    for k in range(rounds):
        heat = hot * (cold / hot) ** (k / rounds)
        since = _change(plate, path, trial, rng)
        if since < 0:
            continue
        most = energy - heat * np.log(1.0 - rng.random())
        new_travel = travel_of(plate, trial)
        if new_travel == np.inf or not _energy(limits, new_travel, 0.0, price) <= most:
            continue
        new_end[:since], new_highest[:since] = end[:since], highest[:since]
        enough = _rise_for(limits, new_travel, price, most)
        new_rise = rise_of(plate, trial, since, new_end, new_highest, enough)
        new_energy = _energy(limits, new_travel, new_rise, price)
        if not new_energy <= most:
            continue
        path[:], energy, rise, travel = trial, new_energy, new_rise, new_travel
        end[:], highest[:] = new_end, new_highest
        value = _objective(limits, travel, rise)
        if value < best:
            best = value
            best_path[:] = path
    return best, best_path


@njit(cache=True)
def _energy(limits: Limits, travel: float, rise: float, price: float) -> float:
    beyond = max(0.0, rise - limits.rise) + max(0.0, travel - limits.travel)
    return (travel if limits.objective == TRAVEL else rise) + price * beyond


@njit(cache=True)
def _rise_for(limits: Limits, travel: float, price: float, energy: float) -> float:
    """Return the rise beyond which the energy is larger, at least."""
    if limits.objective == TRAVEL:
        return limits.rise + (energy - travel) / price
    return energy


@njit(cache=True)
def _objective(limits: Limits, travel: float, rise: float) -> float:
    """Return the objective of a plan within the limits, else infinity."""
    if rise > limits.rise or travel > limits.travel or rise >= MUCH:
        return np.inf
    return travel if limits.objective == TRAVEL else rise
