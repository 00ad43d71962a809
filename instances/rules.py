"""What is asked of a plan: the objective and the constraints beyond "each contour once"."""

from dataclasses import dataclass, replace
from typing import Literal

from cutgap.instances.arrays import finite_number
from cutgap.instances.instance import ABSOLUTE_ZERO_C

Objective = Literal["makespan", "travel", "weighted", "peak"]
OBJECTIVES: tuple[Objective, ...] = ("makespan", "travel", "weighted", "peak")


@dataclass(frozen=True, slots=True)
class Rules:
    """Objective and constraints.

    ``parts_in_one_go`` to ``backward_price`` are process rules for parts of several contours; source: Li et
    al. (2019).

    Parameters
    ----------
    objective
        ``makespan`` (s): the time that the machine waits for; ``travel`` (mm): sum of rapids;
        ``weighted`` (mm): travel + weight * imbalance; ``peak`` (deg C): highest start-point temperature
        (``heat``).
    weight
        Price of one second of imbalance in mm of travel, for ``weighted`` only. Above ``v_jump`` a
        plan can gain by lengthening the shorter tour.
    non_overlap
        Least partition gap F in mm between neighbouring heads; 0 allows touching, and then
        contours of equal x may go either side. ``None`` lets the ranges overlap.
    balance
        Largest imbalance in s; ``None`` sets no limit.
    via_points
        Each head cuts the leftmost contour of its range first (any of them when several are).
    empty_heads
        Whether a head may stay without work though there are at least as many contours as heads.
    parts_in_one_go
        A part, once begun, is finished before a contour of another part is cut by the same head.
    neighbours_only
        A head goes from a part only to one of its neighbours (``process.adjacent_parts``).
    clear_rapids
        No rapid between contours crosses a contour that is cut already (``process.crossings``).
    backward_price
        Price, in mm of travel, of one mm of x by which a rapid between contours goes back; for ``travel``
        and ``weighted`` only.
    free_entries
        A contour may be entered anywhere in its region (``free_entries.region_of``), not at its entry points
        alone.
    temperature_cap
        Highest start-point temperature allowed, deg C; ``None`` sets no limit.
    links
        Contours may be joined by links, which the torch cuts without going out (``links.strokes``).
    pierces
        Most pierces, with links only; 1 asks for everything in one stroke. ``None`` sets no limit.
    """

    objective: Objective = "makespan"
    weight: float = 0.0
    non_overlap: float | None = 0.0
    balance: float | None = None
    via_points: bool = False
    empty_heads: bool = False
    parts_in_one_go: bool = False
    neighbours_only: bool = False
    clear_rapids: bool = False
    backward_price: float = 0.0
    free_entries: bool = False
    temperature_cap: float | None = None
    links: bool = False
    pierces: int | None = None

    def __post_init__(self) -> None:
        if self.objective not in OBJECTIVES:
            raise ValueError(
                f"rules, objective: expected one of {', '.join(OBJECTIVES)}, got {self.objective!r}"
            )
        object.__setattr__(self, "weight", finite_number(self.weight, "rules, weight", least=0.0))
        if self.weight > 0 and self.objective != "weighted":
            raise ValueError(f"rules, weight: goes with the objective weighted, not {self.objective}")
        price = finite_number(self.backward_price, "rules, backward_price", least=0.0)
        object.__setattr__(self, "backward_price", price)
        if price > 0 and self.objective not in ("travel", "weighted"):
            raise ValueError(
                f"rules, backward_price: goes with the objectives travel and weighted, not {self.objective}"
            )
        if self.temperature_cap is not None:
            cap = finite_number(self.temperature_cap, "rules, temperature_cap", least=ABSOLUTE_ZERO_C)
            object.__setattr__(self, "temperature_cap", cap)
        self._check_pierces()
        for name in ("non_overlap", "balance"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, finite_number(value, f"rules, {name}", least=0.0))

    def _check_pierces(self) -> None:
        if self.pierces is None:
            return
        if isinstance(self.pierces, bool) or not isinstance(self.pierces, int) or self.pierces < 1:
            raise ValueError(f"rules, pierces: expected a whole number of at least 1, got {self.pierces!r}")
        if not self.links:
            raise ValueError("rules, pierces: goes with links; without them each contour is pierced once")

    @property
    def process(self) -> tuple[str, ...]:
        """Names of the process rules (Li et al., 2019) that are asked for."""
        asked = {
            "parts in one go": self.parts_in_one_go,
            "neighbours only": self.neighbours_only,
            "clear rapids": self.clear_rapids,
            "backward price": self.backward_price > 0,
        }
        return tuple(name for name, is_asked in asked.items() if is_asked)

    @property
    def constraints(self) -> "Rules":
        """The same constraints for least travel, whatever these rules minimise."""
        return replace(self, objective="travel", weight=0.0, backward_price=0.0)

    @property
    def unit(self) -> str:
        """Unit of the objective."""
        return {"makespan": "s", "peak": "deg C"}.get(self.objective, "mm")

    @property
    def speaks_of_heat(self) -> bool:
        """Whether temperatures are asked for."""
        return self.objective == "peak" or self.temperature_cap is not None
