"""The published heuristics, and a modern yardstick."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np

from cutgap.heuristics.ant_colony import AntColonyParameters, ant_colony
from cutgap.heuristics.clustering import fuzzy_c_means, k_means
from cutgap.heuristics.dual_coded import dual_coded, has_hot_route
from cutgap.heuristics.dual_coded_fitness import DualCodedParameters
from cutgap.heuristics.entry_search import entry_search
from cutgap.heuristics.euler_bridging import euler_bridging
from cutgap.heuristics.link_search import link_search
from cutgap.heuristics.local_search import local_search
from cutgap.heuristics.sides import (
    has_links,
    has_one_head,
    has_single_tour,
    has_tours,
    has_two_sides,
    on_curves,
)
from cutgap.heuristics.task_balancing import task_balancing
from cutgap.instances import Instance, Plan, Rules
from cutgap.instances.progress import Watch, nobody


class PlanMaker(Protocol):
    """Makes a plan; what it may break is for ``check`` to say. The same seed gives the same plan."""

    def __call__(
        self,
        instance: Instance,
        rules: Rules,
        *,
        rng: np.random.Generator,
        watch: Watch = nobody,
        time_limit: float | None = None,
    ) -> Plan:
        """Return a plan; ``time_limit`` in s."""
        ...


@dataclass(frozen=True, slots=True)
class Heuristic:
    """A heuristic as methods and tables use it; it is called like its ``make``.

    Parameters
    ----------
    make
        Makes the plan.
    applies
        Whether it is meant for an instance and rules; a gap table leaves it out elsewhere unless it is named.
    """

    make: PlanMaker
    applies: Callable[[Instance, Rules], bool]

    def __call__(
        self,
        instance: Instance,
        rules: Rules,
        *,
        rng: np.random.Generator,
        watch: Watch = nobody,
        time_limit: float | None = None,
    ) -> Plan:
        """Return a plan; ``time_limit`` in s."""
        return self.make(instance, rules, rng=rng, watch=watch, time_limit=time_limit)


PRICED = AntColonyParameters(dropped_price_mm=20_000.0)
"""The reference's ants step across what is cut when they are stuck, and others follow; these pay for it."""

COOL = DualCodedParameters(mu=0.6)
IMPROVED = DualCodedParameters(mu=None)
PLAIN = DualCodedParameters(mu=None, conventional=True)
GENETIC: dict[str, DualCodedParameters] = {
    "dual-coded-ga": DualCodedParameters(),
    "dual-coded-ga-cool": COOL,
    "dual-coded-ga-travel": IMPROVED,
    "plain-ga": PLAIN,
}
"""The rows of the table of Yang, Liu, Ju (2012)."""

HEURISTICS: dict[str, Heuristic] = {
    "task-balancing": Heuristic(task_balancing, has_two_sides),
    "k-means": Heuristic(k_means, has_two_sides),
    "fuzzy-c-means": Heuristic(fuzzy_c_means, has_two_sides),
    "local-search": Heuristic(local_search, has_tours),
    "entry-search": Heuristic(entry_search, has_one_head),
    "ant-colony": Heuristic(ant_colony, has_single_tour),
    "priced-ant-colony": Heuristic(partial(ant_colony, parameters=PRICED), on_curves),
    "euler-bridging": Heuristic(euler_bridging, has_links),
    "link-search": Heuristic(link_search, has_links),
    **{
        name: Heuristic(partial(dual_coded, parameters=parameters), has_hot_route)
        for name, parameters in GENETIC.items()
    },
}

__all__ = [
    "COOL",
    "GENETIC",
    "HEURISTICS",
    "IMPROVED",
    "PLAIN",
    "Heuristic",
    "PlanMaker",
    "ant_colony",
    "dual_coded",
    "entry_search",
    "euler_bridging",
    "fuzzy_c_means",
    "k_means",
    "link_search",
    "local_search",
    "task_balancing",
]
