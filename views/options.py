"""Command-line options that several commands share, so that each has one name and one meaning."""

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cutgap.instances import Rules
from cutgap.instances.formats import DrawingOptions, MachineOptions
from cutgap.instances.formats.options import FAULTS, Fault
from cutgap.instances.rules import Objective

File = Annotated[
    Path,
    Parameter(help="Instance: .json, .csv (id,x,y,z,perimeter), .tsp, .gtsp, .pcglns, .dxf, .svg ..."),
]
PlanFile = Annotated[Path, Parameter(help="Plan, as written by solve --out.")]
Json = Annotated[bool, Parameter(name="--json", help="Print JSON on stdout.")]
TimeLimit = Annotated[float | None, Parameter(help="Limit of a run in s.")]
Seed = Annotated[int, Parameter(help="Seed of the random numbers, at least 0.")]


DEFAULTS = Rules()
PICTURE_SUFFIXES = (".png", ".svg", ".pdf")


Choice = Annotated[bool | None, Parameter(negative=None)]
"""A rule that can be asked for, called off, or left as it is."""


@Parameter(name="*")
@dataclass(frozen=True, slots=True)
class RuleOptions:
    """What is asked of a plan, instead of what a suite asks for by itself; without a suite, of the defaults."""

    objective: Objective | None = None
    """Time until the last head is done (makespan, by default); sum of rapids; travel + weight * imbalance;
    highest temperature of a start point (peak)."""
    weight: float | None = None
    """Price of 1 s of imbalance in mm of travel, for the objective weighted."""
    balance: float | None = None
    """Largest imbalance in s."""
    non_overlap: float | None = None
    """Least partition gap in mm; 0, which allows touching, unless --overlap is given."""
    overlap: bool = False
    """Let the ranges of the heads overlap."""
    via_points: Choice = None
    """Each head cuts the leftmost contour of its range first."""
    empty_heads: Choice = None
    """Let a head stay without work."""
    parts_in_one_go: Choice = None
    """A part, once begun, is finished before another part."""
    neighbours_only: Choice = None
    """Go from a part only to one of its neighbours."""
    clear_rapids: Choice = None
    """No rapid crosses a contour that is cut already."""
    backward_price: float | None = None
    """Price in mm of travel of each mm of x that a rapid goes back."""
    free_entries: Choice = None
    """A contour may be entered anywhere in its region, not at its entry points alone."""
    temperature_cap: float | None = None
    """Highest temperature of a start point in deg C."""
    links: Choice = None
    """Contours may be joined by links, which the torch cuts without going out."""
    pierces: int | None = None
    """Most pierces, with --links."""

    @property
    def asks_one_thing(self) -> bool:
        """Whether what is minimised, or a cap, is named: then a suite asks for nothing besides."""
        return bool(self.objective or self.backward_price) or self.temperature_cap is not None

    def rules(self, base: Rules = DEFAULTS) -> Rules:
        """Return ``base`` with what is given put in its place.

        Raises
        ------
        ValueError
            When options contradict each other or a number is out of range.
        """
        if self.overlap and self.non_overlap is not None:
            raise ValueError(f"--non-overlap {self.non_overlap:g} and --overlap: give one of them")
        given = {name: value for name, value in asdict(self).items() if name != "overlap" and value is not None}
        if self.overlap:
            given["non_overlap"] = None
        return replace(base, **given)


@Parameter(name="*")
@dataclass(frozen=True, slots=True)
class MachineArguments:
    """Homes and speeds, for files that carry none or to replace theirs; how drawings are read."""

    home: Annotated[tuple[str, ...], Parameter(allow_leading_hyphen=True, negative="")] = ()
    """Home X,Y[,Z] of a head in mm; once per head."""
    v_jump: float | None = None
    """Speed of rapids, mm/s."""
    v_cut: float | None = None
    """Speed of cutting, mm/s."""
    t_aux: float | None = None
    """Auxiliary time per contour, s."""
    layers: str | None = None
    """Drawings: layers A,B to be read; all that are visible by default."""
    entries: str = "auto"
    """Drawings: entry points of a contour: auto (corners, quarter points of curves), or about N."""
    tolerance: float = DrawingOptions().tolerance
    """Drawings: largest gap between pieces of a contour, mm."""
    chord: float = DrawingOptions().chord
    """Drawings: largest distance between a curve and its polyline, mm."""
    skip: str | None = None
    """Drawings: leave out, instead of refusing, any of open,copies,crossing."""
    link_points: Annotated[bool, Parameter(negative="")] = False
    """Take places for links as entry points, instead of those of the file."""

    def options(self) -> MachineOptions:
        """Return the options as readers take them.

        Raises
        ------
        ValueError
            When a home is no list of two or three numbers, or a number is out of range.
        """
        homes = tuple(parse_home(text) for text in self.home)
        return MachineOptions(
            homes=homes,
            v_jump=self.v_jump,
            v_cut=self.v_cut,
            t_aux=self.t_aux,
            drawing=self._drawing(),
            link_points=self.link_points,
        )

    def _drawing(self) -> DrawingOptions:
        return DrawingOptions(
            layers=tuple(parse_names(self.layers, "--layers")),
            entries=parse_entries(self.entries),
            tolerance=self.tolerance,
            chord=self.chord,
            skip=tuple(parse_fault(name) for name in parse_names(self.skip, "--skip")),
        )


DEFAULT_RULES = RuleOptions()
FILE_MACHINE = MachineArguments()
"""Takes homes and speeds as the file has them."""


def parse_home(text: str) -> tuple[float, ...]:
    """Return the numbers of ``X,Y`` or ``X,Y,Z``."""
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError as error:
        raise ValueError(f"--home: expected X,Y or X,Y,Z in mm, got {text!r}") from error


def parse_names(text: str | None, option: str) -> list[str]:
    """Return the names of ``A,B,...``; none without a text."""
    names = [] if text is None else [name.strip() for name in text.split(",")]
    if not all(names):
        raise ValueError(f"{option}: expected names A,B,..., got {text!r}")
    return names


def parse_entries(text: str) -> int | None:
    """Return N of ``--entries N``, ``None`` for ``auto``."""
    if text == "auto":
        return None
    if not (text.isascii() and text.isdigit()):
        raise ValueError(f"--entries: expected auto or a number, got {text!r}")
    return int(text)


def parse_fault(name: str) -> Fault:
    """Return a kind of fault by its name."""
    for fault in FAULTS:
        if name == fault:
            return fault
    raise ValueError(f"--skip: expected some of {','.join(FAULTS)}, got {name!r}")


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
