"""The ladder of bounds: every relaxation that applies to an instance, and the optimum, side by side.

Each rung is a bound on the same objective, so their distance is what a formulation is worth. Linear models come
from ``compact``, the others from ``relaxations``; the last rung is the exact method that ``solve`` would take.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from cutgap.formulations.compact import TOUR_FORMULATIONS
from cutgap.formulations.compact.proof import linear_bound
from cutgap.formulations.front_door import solve
from cutgap.formulations.relaxations.assignment import two_matching
from cutgap.formulations.relaxations.bound import RelaxationBound
from cutgap.formulations.relaxations.connectivity import connectivity
from cutgap.formulations.relaxations.cycle_distances import cycle_distances
from cutgap.formulations.relaxations.held_karp import held_karp, one_tree
from cutgap.formulations.relaxations.perspective_proof import perspective_bound
from cutgap.instances import Instance, Result, Rules
from cutgap.instances.progress import Progress, Watch, nobody


class Relaxation(NamedTuple):
    """What has to be solved (``linear``, ``combinatorial``, ``semidefinite``, ``cone``), and the function."""

    kind: str
    bound: Callable[..., RelaxationBound]


LADDER: dict[str, Relaxation] = {
    **{name: Relaxation("linear", partial(linear_bound, formulation=name)) for name in TOUR_FORMULATIONS},
    "two-matching": Relaxation("combinatorial", two_matching),
    "one-tree": Relaxation("combinatorial", one_tree),
    "held-karp": Relaxation("combinatorial", held_karp),
    "connectivity": Relaxation("semidefinite", connectivity),
    "cycle-distances": Relaxation("semidefinite", cycle_distances),
    "perspective": Relaxation("cone", perspective_bound),
}
"""The relaxations by name."""


@dataclass(frozen=True, slots=True)
class Rung:
    """One bound of the ladder.

    Attributes
    ----------
    kind
        What has to be solved: ``linear``, ``combinatorial``, ``semidefinite``, ``cone``; or ``exact``.
    bound
        Proved, in ``rules.unit``; ``None`` when there is none, and then ``note`` says why.
    variables, constraints, nonzeros
        Size of the model; ``None`` where none is written down.
    certificate
        A verified proof of the bound.
    """

    formulation: str
    kind: str
    seconds: float
    bound: float | None = None
    variables: int | None = None
    constraints: int | None = None
    nonzeros: int | None = None
    certificate: dict[str, Any] | None = None
    note: str | None = None

    def gap(self, value: float | None) -> float | None:
        """Return (value - bound) / value for the value of the best plan."""
        if self.bound is None or value is None:
            return None
        return 0.0 if value == 0 else max(0.0, (value - self.bound) / value)


def require_rungs(names: Sequence[str]) -> None:
    """Raise ``ValueError`` for a name that is no relaxation of the ladder."""
    for name in names:
        if name not in LADDER:
            raise ValueError(f"formulation: expected some of {', '.join(LADDER)}, got {name!r}")


def optimum(
    instance: Instance, rules: Rules, *, time_limit: float | None = None, watch: Watch = nobody
) -> tuple[Result, Rung]:
    """Return the exact method's result, against which the ladder is read, and its rung."""
    result = solve(instance, rules, time_limit=time_limit, certify=True, watch=watch)
    rung = Rung(
        result.method,
        "exact",
        result.seconds,
        result.lower_bound,
        certificate=result.certificate,
        note=result.reason if result.lower_bound is None else None,
    )
    return result, rung


def ladder(
    instance: Instance,
    rules: Rules,
    *,
    names: Sequence[str] | None = None,
    time_limit: float | None = None,
    watch: Watch = nobody,
) -> Iterator[Rung]:
    """Yield the rungs of an instance, each as soon as it is known.

    Parameters
    ----------
    names
        Relaxations of ``LADDER``; by default all of them. One that does not apply is a rung without bound.
    time_limit
        Seconds for each rung.

    Raises
    ------
    ValueError
        For an unknown name.
    """
    chosen = list(LADDER) if names is None else list(names)
    require_rungs(chosen)
    begun = perf_counter()
    for name in chosen:
        watch(Progress(perf_counter() - begun, message=name))
        yield _rung(instance, rules, name, time_limit)


# See ``compact.programme.assemble``: the warning comes from cvxpy's sums of any model.
@np.errstate(invalid="ignore")
def _rung(instance: Instance, rules: Rules, name: str, time_limit: float | None) -> Rung:
    begun = perf_counter()
    try:
        found = LADDER[name].bound(instance, rules, time_limit=time_limit)
    except ValueError as error:
        return Rung(name, LADDER[name].kind, perf_counter() - begun, note=str(error))
    note = "proves that no plan is allowed" if found.bound is None else None
    return Rung(
        name,
        LADDER[name].kind,
        found.seconds,
        found.bound,
        found.variables,
        found.constraints,
        found.nonzeros,
        found.certificate,
        note,
    )
