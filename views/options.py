"""Command-line options that several commands share, so that each has one name and one meaning."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cutgap.instances import Rules
from cutgap.instances.formats import MachineOptions
from cutgap.instances.rules import Objective

File = Annotated[Path, Parameter(help="Instance: .json, .csv (id,x,y,z,perimeter), .tsp, or a list x y z r.")]
PlanFile = Annotated[Path, Parameter(help="Plan, as written by solve --out.")]
Json = Annotated[bool, Parameter(name="--json", help="Print JSON on stdout.")]
TimeLimit = Annotated[float | None, Parameter(help="Limit of a run in s.")]
Seed = Annotated[int, Parameter(help="Seed of the random numbers, at least 0.")]


PICTURE_SUFFIXES = (".png", ".svg", ".pdf")


@Parameter(name="*")
@dataclass(frozen=True, slots=True)
class RuleOptions:
    """What is asked of a plan."""

    objective: Objective = "makespan"
    """Time until the last head is done; sum of rapids; or travel + weight * imbalance."""
    weight: float = 0.0
    """Price of 1 s of imbalance in mm of travel, for the objective weighted."""
    balance: float | None = None
    """Largest imbalance in s."""
    non_overlap: float | None = None
    """Least partition gap in mm; 0, which allows touching, unless --overlap is given."""
    overlap: bool = False
    """Let the ranges of the heads overlap."""
    via_points: bool = False
    """Each head cuts the leftmost contour of its range first."""
    empty_heads: bool = False
    """Let a head stay without work."""
    parts_in_one_go: bool = False
    """A part, once begun, is finished before another part."""
    neighbours_only: bool = False
    """Go from a part only to one of its neighbours."""
    clear_rapids: bool = False
    """No rapid crosses a contour that is cut already."""
    backward_price: float = 0.0
    """Price in mm of travel of each mm of x that a rapid goes back."""

    def rules(self) -> Rules:
        """Return the rules.

        Raises
        ------
        ValueError
            When options contradict each other or a number is out of range.
        """
        if self.overlap and self.non_overlap is not None:
            raise ValueError(f"--non-overlap {self.non_overlap:g} and --overlap: give one of them")
        return Rules(
            objective=self.objective,
            weight=self.weight,
            non_overlap=None if self.overlap else self.non_overlap or 0.0,
            balance=self.balance,
            via_points=self.via_points,
            empty_heads=self.empty_heads,
            parts_in_one_go=self.parts_in_one_go,
            neighbours_only=self.neighbours_only,
            clear_rapids=self.clear_rapids,
            backward_price=self.backward_price,
        )


@Parameter(name="*")
@dataclass(frozen=True, slots=True)
class MachineArguments:
    """Homes and speeds, for files that carry none or to replace theirs."""

    home: Annotated[tuple[str, ...], Parameter(allow_leading_hyphen=True, negative="")] = ()
    """Home X,Y[,Z] of a head in mm; once per head."""
    v_jump: float | None = None
    """Speed of rapids, mm/s."""
    v_cut: float | None = None
    """Speed of cutting, mm/s."""
    t_aux: float | None = None
    """Auxiliary time per contour, s."""

    def options(self) -> MachineOptions:
        """Return the options as readers take them.

        Raises
        ------
        ValueError
            When a home is no list of two or three numbers, or a number is out of range.
        """
        homes = tuple(parse_home(text) for text in self.home)
        return MachineOptions(homes=homes, v_jump=self.v_jump, v_cut=self.v_cut, t_aux=self.t_aux)


DEFAULT_RULES = RuleOptions()
FILE_MACHINE = MachineArguments()
"""Takes homes and speeds as the file has them."""


def parse_home(text: str) -> tuple[float, ...]:
    """Return the numbers of ``X,Y`` or ``X,Y,Z``."""
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError as error:
        raise ValueError(f"--home: expected X,Y or X,Y,Z in mm, got {text!r}") from error


def require_seed(seed: int) -> None:
    """Raise ``ValueError`` for a negative seed."""
    if seed < 0:
        raise ValueError(f"--seed: expected a number of at least 0, got {seed}")


def require_time_limit(time_limit: float | None) -> None:
    """Raise ``ValueError`` for a limit that is not a positive number."""
    if time_limit is not None and not time_limit > 0:
        raise ValueError(f"--time-limit: expected a number above 0, got {time_limit:g}")


def require_picture_name(path: Path) -> None:
    """Raise ``ValueError`` when the suffix is none of ``PICTURE_SUFFIXES``."""
    if path.suffix.lower() not in PICTURE_SUFFIXES:
        raise ValueError(f"{path}: expected a name ending in {', '.join(PICTURE_SUFFIXES)}")
