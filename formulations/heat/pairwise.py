r"""The least possible pairwise peak: a lower bound on the peak, by bisection on a level theta with CP-SAT.

    pairwise peak  P = ambient + max over i, j before i of T(L_ij, start_i - end_j)  <=  peak

as all terms of a rise are at least 0. "Contour j heats start i above theta" means that the lag lies in an open
interval (``instances.heat.lag_window``), so whether P <= theta is possible is a question of order and time
(``pairwise_worker``). When the answer is no, every peak is above theta.

Rounding. Starts are floors of scale times the true ones. Differences of floors are the floor or the ceiling of
the true difference, so each true plan keeps (time); a lag of integers differs from the true one by less than 1,
so windows shrink by 1 at both ends: A = floor(scale (t- + s_j)) + 1, B = ceil(scale (t+ + s_j)) - 1. Each plan
with P <= theta so is one of the model, which makes "no" hold for the true problem. Process rules and ways from
and to the home are left out, which only adds plans. The answer is the solver's word: there is no certificate.
"""

import math
import time
from dataclasses import dataclass

import numpy as np

from cutgap.formulations.cpsat.solving import GRACE_S, WORKERS, Child, default_memory_mib
from cutgap.formulations.cpsat.worker import Message
from cutgap.formulations.heat.pairwise_worker import Question, Window, answer
from cutgap.formulations.heat.plates import Plate, plate_of, warmth
from cutgap.formulations.heat.tables import ways_into
from cutgap.instances import Instance, Rules
from cutgap.instances.arrays import Ints
from cutgap.instances.heat import lag_window, require_heat

WORKER = "cutgap.formulations.heat.pairwise_worker"
UNITS = 5_000
"""Units of time from the first start to the latest possible one."""
LOWEST, STRIDE = 1024.0, 4.0
"""The first level is so small a part of the rise to begin with, the next ones so much higher:
low levels are soon refused, and middle ones may take for ever."""
MOST_POINTS = 60
"""Most points that are nodes of the circuit; beyond, contours are."""
SHARE = 0.3
"""Share of the time that is left that one question may take."""
PRECISION = 1e-3
"""Relative width of the interval at which the bisection ends."""
ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class PairwiseBound:
    """No plan's pairwise peak, and so no peak, is below ``lower_bound``, deg C.

    Attributes
    ----------
    upper_bound
        A pairwise peak that is possible on integers, up to rounding, or the one that the search began with.
    complete
        Whether both bounds meet, up to ``PRECISION``.
    scale
        Units of time per second.
    """

    lower_bound: float
    upper_bound: float
    complete: bool
    scale: float


def pairwise_bound(
    instance: Instance,
    rules: Rules,
    *,
    warmest: float,
    time_limit: float | None = None,
    workers: int = WORKERS,
    memory_mib: int | None = None,
    isolated: bool = True,
) -> PairwiseBound:
    """Bound the peak by pairs.

    Parameters
    ----------
    warmest
        A peak that some plan has, deg C: where the bisection begins from above.
    time_limit
        Seconds; what was shown until then is returned, also on Ctrl-C.
    isolated
        Whether to ask in child processes; within this one there is no limit on memory, and Ctrl-C waits.
    """
    ambient = require_heat(instance).ambient_c
    deadline = np.inf if time_limit is None else time.perf_counter() + time_limit
    memory = default_memory_mib() if memory_mib is None else memory_mib
    plate = plate_of(instance, rules)
    scale = UNITS / max(1e-9, _horizon(plate))
    # Up to ``aim`` the answers are still open: it falls where one takes too long.
    warmest_rise = warmest - ambient
    low, high, aim = 0.0, warmest_rise, warmest_rise
    try:
        while aim - low > PRECISION * max(high, 1e-6) and time.perf_counter() < deadline:
            theta = min((low + aim) / 2.0, max(STRIDE * low, warmest_rise / LOWEST))
            left = max(1.0, SHARE * (deadline - time.perf_counter()))
            seconds = None if np.isinf(left) else left
            status, order = _ask(_question(instance, plate, theta, scale, seconds, workers, memory), isolated)
            if status == "INFEASIBLE":
                low = theta
            elif order is not None:
                high = aim = max(low, min(theta, _pairwise(plate, order)))
            elif status:
                aim = theta
            else:
                break
    except KeyboardInterrupt:
        pass
    complete = high - low <= PRECISION * max(high, 1e-6)
    return PairwiseBound(ambient + low, ambient + high, complete, scale)


def _horizon(plate: Plate) -> float:
    """Return a time by which each contour has started, s."""
    return float(plate.service.sum() + ways_into(plate)[1].sum()) * (1.0 + ROUNDING)


def _question(
    instance: Instance,
    plate: Plate,
    theta: float,
    scale: float,
    seconds: float | None,
    workers: int,
    memory: int,
) -> Question:
    stops, low, high = _spans(plate, scale)
    return Question(
        first=tuple(int(each) for each in plate.first),
        stops=tuple(stops.tolist()),
        spans=[
            [None if a < 0 else (a, b) for a, b in zip(*rows, strict=True)]
            for rows in zip(low.tolist(), high.tolist(), strict=True)
        ],
        windows=_windows(instance, plate, theta, scale),
        horizon=math.ceil(scale * _horizon(plate)) + 1,
        works=tuple(math.floor(scale * work * (1.0 - ROUNDING)) for work in plate.service.tolist()),
        precedence=instance.precedence,
        seconds=seconds,
        workers=workers,
        memory_mib=memory,
    )


def _spans(plate: Plate, scale: float) -> tuple[Ints, Ints, Ints]:
    """Return the nodes of the circuit, and the least and largest D between them; -1 where there is no step."""
    spans = scale * (plate.service[plate.contour_of][:, None] + plate.time)
    # Whether D is a whole number hangs on its last digits: both neighbours are let in.
    slack = ROUNDING * np.maximum(1.0, spans)
    barred = np.isinf(plate.cost)
    low = np.where(barred, np.inf, np.floor(spans - slack))
    high = np.where(barred, -np.inf, np.ceil(spans + slack))
    stops = plate.contour_of
    if len(stops) > MOST_POINTS:
        stops = np.arange(len(plate.service))
        first = plate.first[:-1]
        low = np.minimum.reduceat(np.minimum.reduceat(low, first, axis=0), first, axis=1)
        high = np.maximum.reduceat(np.maximum.reduceat(high, first, axis=0), first, axis=1)
    barred = np.isinf(low)
    return stops, np.where(barred, -1, low).astype(np.int64), np.where(barred, -1, high).astype(np.int64)


def _windows(instance: Instance, plate: Plate, theta: float, scale: float) -> list[Window]:
    windows = []
    for v, contour in enumerate(plate.contour_of.tolist()):
        for j in range(len(plate.service)):
            window = None if j == contour else lag_window(instance, float(plate.distance[v, j]), theta)
            if window is not None:
                low = scale * (window[0] + plate.service[j]) * (1.0 + ROUNDING)
                high = scale * (window[1] + plate.service[j]) * (1.0 - ROUNDING)
                last = None if math.isinf(high) else math.ceil(high) - 1
                if last is None or last > math.floor(low) + 2:
                    windows.append((v, j, math.floor(low) + 1, last))
    return windows


def _ask(asked: Question, isolated: bool) -> tuple[str, Ints | None]:
    """Return the solver's status, empty when it died, and the points of a plan if it has one."""
    messages: list[Message] = []
    if isolated:
        child = Child(asked, WORKER)
        try:
            messages += child.messages(None if asked.seconds is None else asked.seconds + GRACE_S)
        finally:
            child.kill()
    else:
        answer(asked, messages.append)
    found = dict(messages)
    order = found.get("plan")
    return found.get("done", ""), None if order is None else np.array(order, dtype=np.int64)


def _pairwise(plate: Plate, path: Ints) -> float:
    """Return the true pairwise rise of a plan, K."""
    most = 0.0
    for last in range(len(path)):
        lag, w = 0.0, path[last]
        for i in range(last - 1, -1, -1):
            lag += float(plate.time[path[i], path[i + 1]])
            a = plate.contour_of[path[i]]
            most = max(most, warmth(plate.constant, plate.spread, float(plate.distance[w, a]), lag))
            lag += float(plate.service[a])
    return most
