"""Tour formulations: what keeps the way of a head in one piece. Each sees a ``Way`` alone.

The names are those of docs/formulations.md. A new formulation is a function from a way to its families, entered
below with the largest number of contours that it takes.
"""

from collections.abc import Callable

from cutgap.formulations.compact.family import Family
from cutgap.formulations.compact.tours.flows import multi_commodity, single_commodity, two_commodity
from cutgap.formulations.compact.tours.order import assignment, lifted_mtz, position
from cutgap.formulations.compact.tours.subtours import dfj, no_sets
from cutgap.formulations.compact.tours.timed import time_indexed
from cutgap.formulations.compact.variables import Way

TOUR_FORMULATIONS: dict[str, Callable[[Way], list[Family]]] = {
    "assignment": assignment,
    "mtz": position,
    "lifted-mtz": lifted_mtz,
    "single-commodity": single_commodity,
    "two-commodity": two_commodity,
    "multi-commodity": multi_commodity,
    "time-indexed": time_indexed,
    "dfj": dfj,
    "dfj-rounds": no_sets,
}

MOST_CONTOURS: dict[str, int] = {
    "assignment": 400,
    "mtz": 400,
    "lifted-mtz": 400,
    "single-commodity": 400,
    "two-commodity": 400,
    "multi-commodity": 60,
    "time-indexed": 60,
    "dfj": 12,
    "dfj-rounds": 400,
}
"""Largest number of contours for each: n^2 variables a head, n^3 for two of them, and 2^n rows for ``dfj``."""

ROUNDS = "dfj-rounds"
"""The formulation whose rows are found as they are needed."""

RELAXATIONS = ("assignment",)
"""Formulations that leave cycles: they bound, and are not solved."""

POSITIONS = ("mtz", "lifted-mtz")
"""Formulations whose families tie the positions p to the way, so that rules on order need no more."""

__all__ = ["MOST_CONTOURS", "POSITIONS", "RELAXATIONS", "ROUNDS", "TOUR_FORMULATIONS", "Way"]
