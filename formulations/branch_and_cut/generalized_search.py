"""The search over ``GeneralizedTourModel``: a first tour by the entry search, then branch and cut."""

import time

import numpy as np

from cutgap.formulations.branch_and_cut.engine import BranchAndCut, Outcome
from cutgap.formulations.branch_and_cut.generalized_tour import GeneralizedTourModel
from cutgap.formulations.branch_and_cut.tour import TOLERANCE
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.entry_tours import EntrySearch, plain_task, shortest_in_order
from cutgap.instances.progress import Watch, nobody

START_ROUNDS, START_MOST, START_PIECE = 300, 30_000, 500
"""Rounds of local search a contour, and at most, before branch and cut; rounds between looks at the clock."""


def shortest_generalized_tour(
    lengths: Floats,
    first: Ints,
    *,
    start: Ints | None = None,
    step: float = 0.0,
    deadline: float = np.inf,
    watch: Watch = nobody,
) -> Outcome:
    """Find the shortest closed tour through one node of each contour.

    Parameters
    ----------
    lengths
        Shape (n, n), mm, symmetric, not negative.
    first
        Shape (contours + 1,): contour h has the nodes first[h] .. first[h + 1] - 1; at least two contours.
    start
        Nodes of a tour to start from.
    step
        A length that divides all lengths of tours; 0 when none is known.

    Returns
    -------
    Outcome
        ``solution`` holds the nodes in order.
    """
    task = plain_task(lengths, first)
    local = EntrySearch(task, min(START_MOST, START_ROUNDS * (len(first) - 1)), rng=np.random.default_rng(0))
    while not local.over and (local.done == 0 or time.perf_counter() < deadline):
        local.run(START_PIECE)
    best = shortest_in_order(task, [visit.contour for visit in local.best.visits])
    if start is not None:
        order = np.searchsorted(first, start, side="right") - 1
        best = min(best, shortest_in_order(task, order), key=lambda tour: tour[0])
    search = BranchAndCut(
        GeneralizedTourModel(lengths, first, best[1]),
        incumbent=best,
        tolerance=TOLERANCE,
        step=step,
        deadline=deadline,
        watch=watch,
    )
    return search.run()
