"""The published heuristics, and a modern yardstick."""

from typing import Protocol

import numpy as np

from cutgap.heuristics.clustering import fuzzy_c_means, k_means
from cutgap.heuristics.local_search import local_search
from cutgap.heuristics.task_balancing import task_balancing
from cutgap.instances import Instance, Plan, Rules
from cutgap.instances.progress import Watch, nobody


class Heuristic(Protocol):
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


HEURISTICS: dict[str, Heuristic] = {
    "task-balancing": task_balancing,
    "k-means": k_means,
    "fuzzy-c-means": fuzzy_c_means,
    "local-search": local_search,
}

__all__ = ["HEURISTICS", "Heuristic", "fuzzy_c_means", "k_means", "local_search", "task_balancing"]
