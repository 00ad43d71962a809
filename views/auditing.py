"""The command ``gaps paper-audit``: a published table against proven optima of random parts."""

import json as json_library
import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cutgap.benchmark.audit import audit_csv, audit_fields, audit_rows, audit_tasks
from cutgap.benchmark.folder import AUDIT_REPORT_NAME, AUDIT_TABLE_NAME, open_folder
from cutgap.instances.formats import write_atomically
from cutgap.views.audit_page import AuditRun, audit_html, print_audit
from cutgap.views.options import Json, TimeLimit, require_time_limit
from cutgap.views.running import Dask, Jobs, Resume, require_one_place, run_all, say_what_is_there

RESULTS = Path("results/paper-audit")


def paper_audit(
    *,
    parts: Annotated[int, Parameter(help="Random parts of each size.")] = 100,
    sizes: Annotated[
        str | None, Parameter(help="Numbers of holes with commas between; all by default.")
    ] = None,
    travel: Annotated[bool, Parameter(help="Prove least travel too; takes ten times as long.")] = False,
    time_limit: TimeLimit = 120.0,
    jobs: Jobs = 1,
    dask: Dask = None,
    resume: Resume = False,
    out: Annotated[
        Path, Parameter(help="Folder for results.jsonl, audit.csv and audit.html, kept as by gaps.")
    ] = RESULTS,
    json: Json = False,
) -> int:
    """Place the published Table 1 of Wang et al. (2025) among proven optima of random parts.

    The published coordinates are missing, so parts are drawn in the published ranges and solved to proven
    optimality, with the published via points and without. Prints, for each number of holes, the distribution
    of the optima, where the published figures of the three methods fall, and the average gap that this
    implies; writes results.jsonl, audit.csv and audit.html.
    """
    require_time_limit(time_limit)
    require_one_place(jobs, dask)
    tasks = audit_tasks(parts=parts, sizes=parse_sizes(sizes), travel=travel, time_limit=time_limit)
    folder = open_folder(out, resume=resume)
    say_what_is_there(folder, tasks)
    failures, stopped = run_all(tasks, folder, jobs, dask)
    records = folder.among(task.key for task in tasks)
    rows = audit_rows(records)
    for failure in failures:
        print(f"cutgap: failed: {failure}", file=sys.stderr)
    write_atomically(folder.path / AUDIT_TABLE_NAME, audit_csv(rows))
    page = audit_html(AuditRun(parts, time_limit, len(tasks)), rows, records, failures)
    write_atomically(folder.path / AUDIT_REPORT_NAME, page)
    if json:
        print(json_library.dumps([audit_fields(row) for row in rows], indent=2, allow_nan=False))
    else:
        print_audit(rows, records)
    print(f"cutgap: {folder.path / AUDIT_REPORT_NAME}", file=sys.stderr)
    if stopped:
        print("cutgap: stopped; finished runs are kept, --resume goes on from them", file=sys.stderr)
    return 1 if failures or stopped else 0


def parse_sizes(text: str | None) -> tuple[int, ...] | None:
    """Return the numbers of ``45,50``; ``None`` without a text."""
    if text is None:
        return None
    try:
        return tuple(int(each) for each in text.split(","))
    except ValueError as error:
        raise ValueError(f"--sizes: expected whole numbers with commas between, got {text!r}") from error
