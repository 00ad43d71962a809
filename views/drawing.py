"""The command ``plot``."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cutgap.instances.formats import read_instance, read_plan
from cutgap.views.options import FILE_MACHINE, File, MachineArguments, PlanFile, require_picture_name
from cutgap.views.plots import plan_figure, save


def plot(
    file: File,
    plan: PlanFile | None = None,
    /,
    *,
    out: Annotated[Path, Parameter(help="Picture to write: .png, .svg or .pdf.")],
    via_points: Annotated[bool, Parameter(help="Name the first contours via points.")] = False,
    machine: MachineArguments = FILE_MACHINE,
) -> int:
    """Draw an instance, or a plan for it, from above."""
    require_picture_name(out)
    instance = read_instance(file, machine.options())
    shown = None if plan is None else read_plan(plan, instance)
    save(plan_figure(instance, shown, via_points=via_points), out)
    return 0
