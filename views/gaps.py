"""The command ``gaps``: methods against proved bounds over a suite."""

import json as json_library
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from cutgap.benchmark.folder import REPORT_NAME, TABLE_NAME, Folder, open_folder
from cutgap.benchmark.methods import default_methods
from cutgap.benchmark.runner import Failure
from cutgap.benchmark.table import cells, gap_table, table_csv
from cutgap.benchmark.tasks import Suite, Task, find_suite, instance_hash, suite_tasks
from cutgap.benchmark.trade_off import ContradictionError
from cutgap.instances.formats import write_atomically
from cutgap.views.figures import json_number
from cutgap.views.options import (
    DEFAULT_RULES,
    FILE_MACHINE,
    Json,
    MachineArguments,
    RuleOptions,
    TimeLimit,
    require_time_limit,
)
from cutgap.views.report import Run, report_html
from cutgap.views.running import Dask, Jobs, Resume, require_one_place, run_all, say_what_is_there
from cutgap.views.tables import print_gaps

RESULTS = Path("results")

app = App(name="gaps")
app.command("cutgap.views.auditing:paper_audit", name="paper-audit", help="Audit a published table.")


@app.default
def gaps(
    suite: str = "table1",
    /,
    *,
    methods: Annotated[
        str | None, Parameter(help="Names with commas between; by default auto and all heuristics that apply.")
    ] = None,
    seeds: Annotated[int, Parameter(help="Runs of each heuristic, with seeds 0, 1, ...")] = 5,
    rules: RuleOptions = DEFAULT_RULES,
    time_limit: TimeLimit = 60.0,
    jobs: Jobs = 1,
    dask: Dask = None,
    resume: Resume = False,
    out: Annotated[
        Path | None,
        Parameter(
            help="Folder for results.jsonl, table.csv and report.html; results/SUITE by default. "
            "Without --resume what is there moves to earlier-1, earlier-2, ... in it."
        ),
    ] = None,
    machine: MachineArguments = FILE_MACHINE,
    json: Json = False,
) -> int:
    """Compare methods with proved optima or bounds over a suite.

    Prints the gap table and writes results.jsonl, table.csv and report.html, with the certificates of proved
    bounds and the instances they speak of beside them. Results that are there already are moved to a folder
    earlier-1, earlier-2, ... unless --resume is given. Ctrl-C keeps what is finished.

    Parameters
    ----------
    suite
        Name of a shipped suite; gtsp:PATH, pcgtsp:PATH or cutting-paths:PATH for published files of one kind,
        which ask for the least travel, or nests:PATH for outlines to be cut in one stroke; an instance file; or
        a folder of instance files.
    """
    require_time_limit(time_limit)
    require_one_place(jobs, dask)
    found = find_suite(suite, machine.options())
    asked = rules.rules(found.rules)
    named = None if methods is None else tuple(name.strip() for name in methods.split(","))
    problems = found.problems(asked, None if rules.asks_one_thing else rules.rules)
    tasks = suite_tasks(problems, named, seeds=seeds, time_limit=time_limit)
    folder = open_folder(out if out is not None else RESULTS / found.name, resume=resume)
    say_what_is_there(folder, tasks)
    failures, stopped = run_all(tasks, folder, jobs, dask)
    chosen = default_methods(found.instances, asked) if named is None else named
    heads = max(len(instance.heads) for instance in found.instances)
    every = tuple(dict.fromkeys([asked, *(each for _, each in problems)]))
    run = Run(found.name, every, chosen, seeds, time_limit, len(tasks), heads)
    for failure in failures:
        print(f"cutgap: failed: {failure}", file=sys.stderr)
    try:
        _publish(run, found, tasks, folder, failures, json)
    except ContradictionError as error:
        print(f"cutgap: no table, because results contradict each other: {error}", file=sys.stderr)
        return 1
    if stopped:
        print("cutgap: stopped; finished runs are kept, --resume goes on from them", file=sys.stderr)
    return 1 if failures or stopped else 0


def _publish(
    run: Run, suite: Suite, tasks: Sequence[Task], folder: Folder, failures: Sequence[Failure], json: bool
) -> None:
    """Print the table of this command's runs, and write table and report."""
    records = folder.among(task.key for task in tasks)
    rows = gap_table(records, suite.published if run.rules == (suite.rules,) else {})
    instances = {instance_hash(instance): instance for instance in suite.instances}
    folder.keep_instances(instances)
    write_atomically(folder.path / TABLE_NAME, table_csv(rows))
    write_atomically(folder.path / REPORT_NAME, report_html(run, records, rows, instances, failures))
    if json:
        fields = [
            {name: json_number(cell) if isinstance(cell, float) else cell for name, cell in cells(row).items()}
            for row in rows
        ]
        print(json_library.dumps(fields, indent=2, allow_nan=False))
    else:
        print_gaps(rows)
    print(f"cutgap: {folder.path / REPORT_NAME}", file=sys.stderr)
