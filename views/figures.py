"""Rules and figures of a plan, as text and as JSON."""

import math
from typing import Any

from cutgap.instances import Evaluation, Instance, Plan


def evaluation_fields(evaluation: Evaluation) -> dict[str, Any]:
    """Return the figures of a plan; travel and time are lists, one entry a head.

    An infinite peak is the text ``infinite``, since JSON has no such number.
    """
    peak = evaluation.peak_temperature_c
    return {
        "travel_mm": list(evaluation.travel_mm),
        "time_s": list(evaluation.time_s),
        "makespan_s": evaluation.makespan_s,
        "imbalance_s": evaluation.imbalance_s,
        "partition_gap_mm": evaluation.partition_gap_mm,
        "backward_mm": list(evaluation.backward_mm),
        "link_mm": list(evaluation.link_mm),
        "pierces": list(evaluation.pierces),
        "peak_temperature_c": None if peak is None else json_number(peak),
    }


def json_number(value: float) -> float | str:
    """Return a number as JSON takes it: an infinite one as text."""
    return "infinite" if math.isinf(value) else value


def print_evaluation(instance: Instance, plan: Plan, evaluation: Evaluation) -> None:
    """Print the figures of a plan, one a line."""
    figures = zip(instance.heads, plan.tours, evaluation.travel_mm, evaluation.time_s, strict=True)
    for head, tour, travel, time in figures:
        # A visit with links is the start of a stroke through several contours.
        count = f"{len(tour)} {'pierces' if plan.links else 'contours'}"
        print(f"  {head.id:<14} {count}, travel {travel:.1f} mm, time {time:.2f} s")
    print(f"  travel         {evaluation.total_travel_mm:.1f} mm")
    if plan.links:
        print(f"  links          {sum(evaluation.link_mm):.1f} mm of it, {len(plan.links)} between contours")
    if sum(evaluation.backward_mm) > 0:
        print(f"  back in x      {sum(evaluation.backward_mm):.1f} mm")
    print(f"  makespan       {evaluation.makespan_s:.2f} s")
    print(f"  imbalance      {evaluation.imbalance_s:.2f} s")
    if evaluation.peak_temperature_c is not None:
        print(f"  peak           {evaluation.peak_temperature_c:.2f} deg C, the hottest start point")
    if evaluation.partition_gap_mm is not None:
        print(f"  partition gap  {evaluation.partition_gap_mm:.1f} mm")
    if evaluation.separation_mm is not None:
        print(f"  separation     {evaluation.separation_mm:.1f} mm at least, in x, while the heads move")
