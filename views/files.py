"""The commands ``generate`` and ``convert``."""

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cutgap.instances.formats import read_instance, write_instance
from cutgap.instances.formats.json_format import format_instance
from cutgap.instances.generate import generate as generate_instance
from cutgap.views.options import FILE_MACHINE, File, MachineArguments, Seed, require_seed


def generate(
    kind: str,
    /,
    *,
    holes: Annotated[int | None, Parameter(help="Number of holes, where the kind has no fixed one.")] = None,
    seed: Seed = 0,
    out: Annotated[Path | None, Parameter(help="File to write; without it JSON on stdout.")] = None,
) -> int:
    """Draw a random instance of a reference experiment.

    Parameters
    ----------
    kind
        random, b-pillars, door-panel, nest28, flame, plate, ties, coincident, collinear or one-column.
    """
    require_seed(seed)
    instance = generate_instance(kind, holes=holes, seed=seed)
    if out is None:
        sys.stdout.write(format_instance(instance))
    else:
        write_instance(instance, out)
    return 0


def convert(source: File, target: Path, /, *, machine: MachineArguments = FILE_MACHINE) -> int:
    """Write an instance in another format, which the suffix names.

    Parameters
    ----------
    target
        File to write: .json, .csv, .tsp, .atsp, .gtsp or .pcglns.
    """
    write_instance(read_instance(source, machine.options()), target)
    return 0
