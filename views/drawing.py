"""The command ``plot``."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cutgap.instances import Instance, Plan
from cutgap.instances.formats import read_instance, read_plan
from cutgap.instances.heat import has_heat
from cutgap.views.options import FILE_MACHINE, File, MachineArguments, PlanFile, require_picture_name
from cutgap.views.plots import plan_figure, save

ANIMATED = ".gif"


def plot(
    file: File,
    plan: PlanFile | None = None,
    /,
    *,
    out: Annotated[
        Path, Parameter(help="Picture to write: .png, .svg or .pdf; .gif for heat or the head's way in motion.")
    ],
    via_points: Annotated[bool, Parameter(help="Name the first contours via points.")] = False,
    heat: Annotated[bool, Parameter(help="Show the sheet's temperature, at the hottest pierce.")] = False,
    at: Annotated[float | None, Parameter(help="Show heat at this time in s.")] = None,
    steps: Annotated[
        int | None,
        Parameter(help="Show so many panels: heat as contours are pierced, or the head's way, without heat."),
    ] = None,
    over_time: Annotated[
        bool, Parameter(help="Show how warm each start point is until it is pierced.")
    ] = False,
    temperature_cap: Annotated[float | None, Parameter(help="Cap to mark in --over-time, deg C.")] = None,
    machine: MachineArguments = FILE_MACHINE,
) -> int:
    """Draw an instance, or a plan for it, from above; or the heat of a plan."""
    hot = heat or at is not None
    moves = out.suffix.lower() == ANIMATED
    _require_one_picture(out, hot=hot, over_time=over_time, at=at, steps=steps, has_plan=plan is not None)
    if temperature_cap is not None and not over_time:
        raise ValueError(f"--temperature-cap {temperature_cap:g}: goes with --over-time")
    instance = read_instance(file, machine.options())
    shown = None if plan is None else read_plan(plan, instance)
    if shown is not None and over_time:
        from cutgap.views.heat_plots import warming_figure

        save(warming_figure(instance, shown, temperature_cap), out)
    elif shown is not None and not hot and (moves or steps is not None) and _is_cold(instance, shown):
        from cutgap.views.link_plots import save_motion, steps_figure

        if moves:
            save_motion(instance, shown, out)
        elif steps is not None:
            save(steps_figure(instance, shown, steps), out)
    elif shown is not None and (hot or steps is not None):
        _draw_heat(instance, shown, out, at, steps)
    else:
        save(plan_figure(instance, shown, via_points=via_points), out)
    return 0


def _require_one_picture(
    out: Path, *, hot: bool, over_time: bool, at: float | None, steps: int | None, has_plan: bool
) -> None:
    """Raise ``ValueError`` when it is not clear what is to be drawn."""
    moves = out.suffix.lower() == ANIMATED
    # Of a plan without links ``save`` refuses .gif, unless heat is asked for.
    if not moves or over_time or not has_plan:
        require_picture_name(out)
    elif at is not None or steps is not None:
        raise ValueError(f"--out {out}: .gif shows what moves; leave out --at and --steps")
    if (hot or over_time or steps is not None) and not has_plan:
        raise ValueError("--heat, --steps and --over-time: need a plan; give its file after the instance")
    if (hot or steps is not None) and over_time:
        raise ValueError("--heat and --over-time: give one of them")
    if at is not None and steps is not None:
        raise ValueError("--at and --steps: give one of them")
    if at is not None and not 0 <= at < float("inf"):
        raise ValueError(f"--at: expected a time in s of at least 0, got {at:g}")
    if steps is not None and steps < 1:
        raise ValueError(f"--steps: expected at least 1, got {steps}")


def _is_cold(instance: Instance, plan: Plan) -> bool:
    """Whether steps are those of the head's way, not of heat."""
    return bool(plan.links) or not has_heat(instance)


def _draw_heat(instance: Instance, plan: Plan, out: Path, at: float | None, steps: int | None) -> None:
    from cutgap.views.heat_plots import heat_figure, save_animation, step_moments

    if out.suffix.lower() == ANIMATED:
        save_animation(instance, plan, out)
        return
    moments = [at] if at is not None else [] if steps is None else step_moments(instance, plan, steps)
    save(heat_figure(instance, plan, moments), out)
