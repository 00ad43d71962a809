"""Models and bounds: what docs/formulations-api.md lists, each with an example.

Names are loaded on first use, so that the checker of certificates runs without solvers and without numpy.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cutgap.formulations.certificate import verify
    from cutgap.formulations.compact import TOUR_FORMULATIONS, compact_model
    from cutgap.formulations.compact.links import links_model
    from cutgap.formulations.compact.proof import certified_bound, linear_bound
    from cutgap.formulations.front_door import METHODS, choose, resolve, solve
    from cutgap.formulations.links.best_points import best_link_points, polish
    from cutgap.formulations.links.outlines import outline_bound
    from cutgap.formulations.pareto import pareto_front
    from cutgap.formulations.relaxations.assignment import assignment, two_matching
    from cutgap.formulations.relaxations.bisection import bisection
    from cutgap.formulations.relaxations.connectivity import connectivity
    from cutgap.formulations.relaxations.cycle_distances import cycle_distances
    from cutgap.formulations.relaxations.held_karp import held_karp, one_tree
    from cutgap.formulations.relaxations.perspective_proof import perspective_bound
    from cutgap.formulations.relaxations.spanning_tree import spanning_tree
    from cutgap.formulations.relaxations.touring import shortest_in_order
    from cutgap.formulations.rungs import LADDER, ladder

_HOMES = {
    "certificate": ("verify",),
    "compact": ("TOUR_FORMULATIONS", "compact_model"),
    "compact.links": ("links_model",),
    "compact.proof": ("certified_bound", "linear_bound"),
    "front_door": ("METHODS", "choose", "resolve", "solve"),
    "links.best_points": ("best_link_points", "polish"),
    "links.outlines": ("outline_bound",),
    "pareto": ("pareto_front",),
    "relaxations.assignment": ("assignment", "two_matching"),
    "relaxations.bisection": ("bisection",),
    "relaxations.connectivity": ("connectivity",),
    "relaxations.cycle_distances": ("cycle_distances",),
    "relaxations.held_karp": ("held_karp", "one_tree"),
    "relaxations.perspective_proof": ("perspective_bound",),
    "relaxations.spanning_tree": ("spanning_tree",),
    "relaxations.touring": ("shortest_in_order",),
    "rungs": ("LADDER", "ladder"),
}
"""Public names by the module that defines them."""

__all__ = [
    "LADDER",
    "METHODS",
    "TOUR_FORMULATIONS",
    "assignment",
    "best_link_points",
    "bisection",
    "certified_bound",
    "choose",
    "compact_model",
    "connectivity",
    "cycle_distances",
    "held_karp",
    "ladder",
    "linear_bound",
    "links_model",
    "one_tree",
    "outline_bound",
    "pareto_front",
    "perspective_bound",
    "polish",
    "resolve",
    "shortest_in_order",
    "solve",
    "spanning_tree",
    "two_matching",
    "verify",
]


def __getattr__(name: str) -> Any:
    """Load a public name when it is asked for."""
    for module, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"cutgap.formulations.{module}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
