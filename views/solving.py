"""The command ``solve``."""

import json as json_library
import sys
from pathlib import Path
from time import perf_counter
from typing import Annotated, Any

from cyclopts import Parameter

from cutgap.benchmark.methods import AUTO, is_exact, require_known, run
from cutgap.benchmark.wording import describe
from cutgap.formulations import choose
from cutgap.formulations.certify import proved_bound, proves
from cutgap.instances import Instance, Plan, Result, Rules, Status, conclude
from cutgap.instances.formats import read_instance, write_atomically, write_plan
from cutgap.instances.formats.json_format import format_plan
from cutgap.views.figures import evaluation_fields, json_number, print_evaluation
from cutgap.views.options import (
    DEFAULT_RULES,
    FILE_MACHINE,
    File,
    Json,
    MachineArguments,
    RuleOptions,
    Seed,
    TimeLimit,
    require_picture_name,
    require_seed,
    require_time_limit,
)
from cutgap.views.progress import watch_run


def solve(
    file: File,
    /,
    *,
    rules: RuleOptions = DEFAULT_RULES,
    method: Annotated[str, Parameter(help="auto, an exact method, or a heuristic.")] = AUTO,
    time_limit: TimeLimit = None,
    seed: Seed = 0,
    out: Annotated[Path | None, Parameter(help="File for the plan (.json).")] = None,
    certificate: Annotated[Path | None, Parameter(help="File for the proof of the bound (.json).")] = None,
    plot: Annotated[Path | None, Parameter(help="Picture of the plan (.png, .svg, .pdf).")] = None,
    machine: MachineArguments = FILE_MACHINE,
    json: Json = False,
) -> int:
    """Plan one instance and say how far the plan is from the optimum.

    Ctrl-C stops with the best plan found and the bound proved so far.
    """
    _require_targets(out, certificate, plot)
    require_known(method)
    if certificate is not None and not is_exact(method):
        raise ValueError(f"--certificate: the method {method} is a heuristic and proves no bound")
    require_seed(seed)
    require_time_limit(time_limit)
    instance = read_instance(file, machine.options())
    asked = rules.rules()
    if plot is not None and not instance.located:
        raise ValueError(
            f"{file}: it gives lengths but no coordinates, so --plot has nothing to draw; leave it out"
        )
    result = _run(instance, asked, method, seed, time_limit)
    if result.plan is not None and out is not None:
        write_plan(result.plan, instance, out)
    if certificate is not None and result.certificate is not None:
        write_atomically(certificate, json_library.dumps(result.certificate, separators=(",", ":")))
    if result.plan is not None and plot is not None:
        _draw(instance, result.plan, result, plot)
    if json:
        print(json_library.dumps(result_fields(instance, result), indent=2, allow_nan=False))
    else:
        _print_result(instance, result, choose(instance, asked).why if method == AUTO else "")
    for violation in result.violations:
        print(f"cutgap: the plan breaks a rule: {violation}", file=sys.stderr)
    if result.reason:
        print(f"cutgap: {result.reason}", file=sys.stderr)
    if certificate is not None and result.certificate is None:
        print(f"cutgap: no certificate: {result.method} found none, its bound is a claim", file=sys.stderr)
        return 1
    return 0 if result.status in (Status.OPTIMAL, Status.FEASIBLE) else 1


def _draw(instance: Instance, plan: Plan, result: Result, path: Path) -> None:
    from cutgap.views.plots import plan_figure, save  # slow to load, and seldom asked for

    rules = result.rules
    title = f"{instance.name}, {result.method}: {rules.objective} {result.value:.2f} {rules.unit}"
    save(plan_figure(instance, plan, via_points=rules.via_points, title=title), path)


def _require_targets(out: Path | None, certificate: Path | None, plot: Path | None) -> None:
    """Refuse names that cannot be written before the work, not after it."""
    for option, path in (("--out", out), ("--certificate", certificate)):
        if path is not None and path.suffix.lower() != ".json":
            raise ValueError(f"{option} {path}: expected a name ending in .json")
    if plot is not None:
        require_picture_name(plot)
    for path in (out, certificate, plot):
        if path is not None and not path.parent.is_dir():
            raise ValueError(f"{path}: the folder {path.parent} does not exist")


def _run(instance: Instance, rules: Rules, method: str, seed: int, time_limit: float | None) -> Result:
    """Run a method; the proof of an exact one's bound costs little next to the bound itself."""
    start, certify = perf_counter(), is_exact(method)
    try:
        with watch_run(f"{instance.name}, {method}", rules.unit) as watch:
            return run(method, instance, rules, seed=seed, time_limit=time_limit, certify=certify, watch=watch)
    except KeyboardInterrupt:
        seconds = perf_counter() - start
        return conclude(
            instance, rules, None, method=method, seconds=seconds, seed=seed, reason="stopped before any plan"
        )


def result_fields(instance: Instance, result: Result) -> dict[str, Any]:
    """Return a result as ``solve --json`` prints it; ``null`` is what was not found or not proved."""
    return {
        "status": str(result.status),
        "value": None if result.violations or result.value is None else json_number(result.value),
        "lower_bound": result.lower_bound,
        "gap": result.gap,
        "objective": result.rules.objective,
        "method": result.method,
        "seconds": result.seconds,
        "seed": result.seed,
        "reason": result.reason,
        "evaluation": None if result.evaluation is None else evaluation_fields(result.evaluation),
        "plan": None if result.plan is None else json_library.loads(format_plan(result.plan, instance)),
    }


def _proof(instance: Instance, result: Result) -> str:
    """Return how the bound is proved; a certificate may prove less."""
    proved = None if result.certificate is None else proved_bound(result.certificate, instance)
    if proved is None:
        return "the solver's claim"
    if proves(proved, result.lower_bound):
        return "certified"
    return f"the solver's claim; certified {proved:.3f} {result.rules.unit}"


def _print_result(instance: Instance, result: Result, why: str) -> None:
    unit = result.rules.unit
    print(f"{instance.name}: {result.status}, by {result.method} in {result.seconds:.2f} s")
    if why:
        print(f"  chosen for     {why}")
    print(f"  asked for      {describe(result.rules, len(instance.heads))}")
    if result.value is not None and not result.violations:
        print(f"  value          {result.value:.3f} {unit}")
    if result.lower_bound is not None:
        print(f"  lower bound    {result.lower_bound:.3f} {unit}, {_proof(instance, result)}")
    if result.gap is not None:
        print(f"  gap            {100 * result.gap:.4f} %")
    if result.plan is not None and result.evaluation is not None:
        print_evaluation(instance, result.plan, result.evaluation)
