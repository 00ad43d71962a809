"""What is given with a file: homes and machine figures that it lacks, and how a drawing is read."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from cutgap.instances.arrays import Floats, finite_number, frozen_array
from cutgap.instances.instance import Head, Machine, Metric

HOME_HINT = "give --home X,Y[,Z] once per head"

Fault = Literal["open", "copies", "crossing"]
MOST_ENTRIES = 10_000
FAULTS: tuple[Fault, ...] = get_args(Fault)


class FormatNote(UserWarning):
    """Something that a reader took for granted or left out; commands print it on stderr."""


@dataclass(frozen=True, slots=True)
class DrawingOptions:
    """How the contours of a drawing are found.

    Parameters
    ----------
    layers
        Names of the layers to be read, in any case of letters; empty reads all that are visible.
    entries
        Entry points of a contour (see ``drawings.entry_points``): ``None`` takes its corners and the quarter
        points of its curves, a number about so many.
    tolerance
        Largest gap in mm between pieces of one contour.
    chord
        Largest distance in mm between a curve and the polyline that stands for it.
    skip
        Kinds of faults that are left out instead of refused: open chains, copies of contours, and
        contours that cross themselves or each other (all of them).
    """

    layers: tuple[str, ...] = ()
    entries: int | None = None
    tolerance: float = 0.05
    chord: float = 0.01
    skip: tuple[Fault, ...] = ()

    def __post_init__(self) -> None:
        if self.entries is not None and not 1 <= self.entries <= MOST_ENTRIES:
            raise ValueError(
                f"--entries: expected auto or a number from 1 to {MOST_ENTRIES}, got {self.entries}"
            )
        finite_number(self.tolerance, "--tolerance", above=0.0)
        finite_number(self.chord, "--chord", above=0.0)
        for kind in self.skip:
            if kind not in FAULTS:
                raise ValueError(f"--skip: expected some of {','.join(FAULTS)}, got {kind!r}")


@dataclass(frozen=True, slots=True)
class MachineOptions:
    """What stands in for figures of a file, or replaces them; how drawings are read; where links may end.

    Parameters
    ----------
    homes
        One home per head, X,Y or X,Y,Z in mm; Z is 0 when left out. Empty keeps the file's heads.
    v_jump, v_cut
        Speed of rapids and of cutting, mm/s; ``None`` keeps the file's, or the default of ``Machine``.
    t_aux
        Auxiliary time per contour, s; ``None`` likewise.
    drawing
        For drawings only.
    link_points
        Whether the entry points are replaced by places for links (``links.points``).
    """

    homes: tuple[tuple[float, ...], ...] = ()
    v_jump: float | None = None
    v_cut: float | None = None
    t_aux: float | None = None
    drawing: DrawingOptions = DrawingOptions()
    link_points: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "homes", tuple(_home(home) for home in self.homes))
        for name in ("v_jump", "v_cut"):
            if getattr(self, name) is not None:
                finite_number(getattr(self, name), f"--{name.replace('_', '-')}", above=0.0)
        if self.t_aux is not None:
            finite_number(self.t_aux, "--t-aux", least=0.0)

    def heads(self) -> tuple[Head, ...]:
        """Return one head per home, from left to right.

        The homes are sorted by x (equal x keeps the given order), because neighbouring heads of an
        instance run from left to right. One head is called ``head``, two are ``left`` and ``right``,
        more are ``head-1``, ``head-2``, ...

        Raises
        ------
        ValueError
            When there is no home.
        """
        if not self.homes:
            raise ValueError(f"homes: the format carries none; {HOME_HINT}")
        homes = sorted(self.homes, key=lambda home: home[0])
        names = {1: ["head"], 2: ["left", "right"]}.get(
            len(homes), [f"head-{number}" for number in range(1, len(homes) + 1)]
        )
        return tuple(Head(name, _floats(home)) for name, home in zip(names, homes, strict=True))

    def machine(self, base: Machine | None = None, metric: Metric | None = None) -> Machine:
        """Return ``base`` (or the default machine) with the given figures put in."""
        base = base or Machine()
        return Machine(
            v_jump=base.v_jump if self.v_jump is None else self.v_jump,
            v_cut=base.v_cut if self.v_cut is None else self.v_cut,
            t_aux=base.t_aux if self.t_aux is None else self.t_aux,
            metric=metric or base.metric,
        )


NO_OVERRIDES = MachineOptions()


def _home(home: Sequence[float]) -> tuple[float, float, float]:
    numbers = tuple(finite_number(number, "--home") for number in home)
    if len(numbers) not in (2, 3):
        raise ValueError(f"--home: expected X,Y or X,Y,Z, got {len(numbers)} numbers: {home!r:.80}")
    return (numbers[0], numbers[1], numbers[2] if len(numbers) == 3 else 0.0)


def _floats(home: Sequence[float]) -> Floats:
    return frozen_array(home, "--home", columns=3)
