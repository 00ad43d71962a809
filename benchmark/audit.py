r"""Published plans against the distribution of proven optima: Table 1 of Wang et al. (2025).

The table (see ``published``) has one part for each of ten numbers of holes, without the coordinates. So random
parts in the published ranges are solved to proven optimality, and a published figure y is placed among their
optima y*_1 .. y*_n with mean m and standard deviation s:

    (1) rank         share of optima below y
    (2) implied gap  g = (y - m) / y
    (3) its error    s sqrt(1 + 1/n) / y   the published part is one more draw, and m is a mean of n
    (4) overall      mean of g over the sizes, error sqrt(sum of squares) / number of sizes

Figures of a plan: makespan max(T_1, T_2) and travel L_1 + L_2. The makespan of a part varies mostly with its
perimeters. The published figures tell these in sum: the work is S = T_1 + T_2 - (L_1 + L_2) / v_jump, the same
for all methods on one part. So the optima are also taken *at equal work*:

    (5) makespan* - S*/2 + S/2

which to first order depends neither on the perimeters drawn nor on v_cut and t_aux. The table prints times to
0.1 s, and in part 2 one time of K-means is a misprint by 3 s; S is the median over the three methods.
"""

import csv
import io
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from math import sqrt
from statistics import fmean, median

import numpy as np

from cutgap.benchmark.published import published_sizes, published_table
from cutgap.benchmark.records import Record
from cutgap.benchmark.tasks import Task, suite_tasks
from cutgap.instances import Machine, Rules, Status
from cutgap.instances.generate import generate

PERCENTS = (5.0, 50.0, 95.0)
MAKESPAN_RULES = (Rules("makespan", via_points=True), Rules("makespan"))
"""With the published via points, and without."""
TRAVEL_RULES = (Rules("travel", via_points=True), Rules("travel"))
MAKESPAN, EQUAL_WORK, TRAVEL = "makespan", "makespan at equal work", "travel"
UNITS = {MAKESPAN: "s", EQUAL_WORK: "s", TRAVEL: "mm"}
"""The figures that are compared, with their units."""


@dataclass(frozen=True, slots=True)
class AuditRow:
    """One published figure among the optima of random parts of its size.

    Attributes
    ----------
    rules, figure
        What was optimised, and the figure of the optimal plans that is compared.
    parts, unproved
        Random parts with a proven optimum, and those left out for want of one.
    published, mean, deviation, p05, p50, p95
        In the unit of the figure; the deviation needs two parts.
    rank_percent, gap, gap_error
        Equations (1), (2), (3); gap and error as shares.
    overlaps
        Whether the published plan overlaps, which the optima must not.
    """

    rules: Rules
    figure: str
    holes: int
    method: str
    parts: int
    unproved: int
    published: float
    mean: float
    deviation: float | None
    p05: float
    p50: float
    p95: float
    rank_percent: float
    gap: float
    gap_error: float | None
    overlaps: bool


@dataclass(frozen=True, slots=True)
class Overall:
    """Equation (4): the implied gap of a method over ``sizes`` numbers of holes, as a share."""

    rules: Rules
    figure: str
    method: str
    sizes: int
    gap: float
    gap_error: float | None


def audit_tasks(
    *, parts: int, sizes: Sequence[int] | None = None, travel: bool = False, time_limit: float | None = None
) -> list[Task]:
    """Return the tasks of an audit, part after part over all sizes, so that a stopped run is even.

    Parameters
    ----------
    parts
        Random parts of each size, with seeds 0 .. parts - 1.
    sizes
        Numbers of holes among the published ones; all by default.
    travel
        Whether least travel is proved too, which takes most of the time.
    time_limit
        Limit of a run in s; ``None`` sets none.

    Raises
    ------
    ValueError
        When there is no part, or a size is not in the published table or named twice.
    """
    if parts < 1:
        raise ValueError(f"parts: expected at least 1, got {parts}")
    known = published_sizes()
    chosen = known if sizes is None else tuple(sizes)
    for size in chosen:
        if size not in known:
            raise ValueError(f"sizes: expected some of {', '.join(map(str, known))}, got {size}")
        if chosen.count(size) > 1:
            raise ValueError(f"sizes: {size} is named more than once")
    drawn = [generate("random", holes=size, seed=seed) for seed in range(parts) for size in chosen]
    rules = (*MAKESPAN_RULES, *(TRAVEL_RULES if travel else ()))
    return [
        task
        for instance in drawn
        for each in rules
        for task in suite_tasks([(instance, each)], ("split",), seeds=1, time_limit=time_limit)
    ]


def audit_rows(records: Iterable[Record]) -> list[AuditRow]:
    """Return the rows of an audit by rules, figure, size and method; sizes without an optimum have none."""
    groups: dict[Rules, dict[int, list[Record]]] = defaultdict(lambda: defaultdict(list))
    for record in records:
        groups[record.result.rules][record.contours].append(record)
    return [
        row
        for rules in (*MAKESPAN_RULES, *TRAVEL_RULES)
        for figure in figures(rules)
        for holes, group in sorted(groups.get(rules, {}).items())
        for row in _rows_of_size(rules, figure, holes, group)
    ]


def figures(rules: Rules) -> tuple[str, ...]:
    """Return the figures that are compared for plans that are optimal under the rules."""
    return (MAKESPAN, EQUAL_WORK, TRAVEL) if rules.objective == "makespan" else (TRAVEL,)


def _rows_of_size(rules: Rules, figure: str, holes: int, group: Sequence[Record]) -> list[AuditRow]:
    published = [row for row in published_table() if row.holes == holes]
    proved = [record for record in group if record.result.status == Status.OPTIMAL]
    if not published or not proved:
        return []
    work_s = median(row.work_s(Machine().v_jump) for row in published)
    optima = np.array([_optimal_figure(record, figure, work_s) for record in proved])
    count, mean = len(optima), float(optima.mean())
    deviation = float(optima.std(ddof=1)) if count > 1 else None
    p05, p50, p95 = np.percentile(optima, PERCENTS).tolist()
    rows = []
    for row in published:
        value = row.travel_mm if figure == TRAVEL else row.makespan_s
        error = None if deviation is None else deviation * sqrt(1 + 1 / count) / value
        rank, gap = 100 * float((optima < value).mean()), (value - mean) / value
        rows.append(
            AuditRow(
                rules=rules,
                figure=figure,
                holes=holes,
                method=row.method,
                parts=count,
                unproved=len(group) - count,
                published=value,
                mean=mean,
                deviation=deviation,
                p05=p05,
                p50=p50,
                p95=p95,
                rank_percent=rank,
                gap=gap,
                gap_error=error,
                overlaps=row.overlaps,
            )
        )
    return rows


def _optimal_figure(record: Record, figure: str, work_s: float) -> float:
    """Return a figure of an optimal plan, for equation (5) moved to ``work_s``."""
    evaluation = record.result.evaluation
    if evaluation is None:
        raise ValueError(f"record {record.key}: optimal without a plan")
    if figure == TRAVEL:
        return evaluation.total_travel_mm
    if figure == MAKESPAN:
        return evaluation.makespan_s
    own_work_s = sum(evaluation.time_s) - evaluation.total_travel_mm / Machine().v_jump
    return evaluation.makespan_s + (work_s - own_work_s) / 2


def overall(rows: Iterable[AuditRow]) -> list[Overall]:
    """Return equation (4) for each rules, figure and method."""
    groups: dict[tuple[Rules, str, str], list[AuditRow]] = defaultdict(list)
    for row in rows:
        groups[row.rules, row.figure, row.method].append(row)
    found = []
    for (rules, figure, method), group in groups.items():
        errors = [row.gap_error for row in group if row.gap_error is not None]
        error = sqrt(sum(each**2 for each in errors)) / len(group) if len(errors) == len(group) else None
        found.append(Overall(rules, figure, method, len(group), fmean(row.gap for row in group), error))
    return found


def balance_of_optima(records: Iterable[Record]) -> Mapping[Rules, tuple[float, float]]:
    """Return for each rules the mean imbalance (s) of the optimal plans and the share within 0.5 s."""
    imbalances: dict[Rules, list[float]] = defaultdict(list)
    for record in records:
        if record.result.status == Status.OPTIMAL and record.result.evaluation is not None:
            imbalances[record.result.rules].append(record.result.evaluation.imbalance_s)
    return {rules: (fmean(each), fmean(s <= 0.5 for s in each)) for rules, each in imbalances.items()}


def audit_csv(rows: Iterable[AuditRow]) -> str:
    """Return the rows as CSV text; an empty field is a figure that does not exist."""
    names = [field.name for field in fields(AuditRow) if field.name != "rules"]
    text = io.StringIO()
    columns = ["objective", "via_points", *names, "unit"]
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(audit_fields(row) for row in rows)
    return text.getvalue()


def audit_fields(row: AuditRow) -> dict[str, object]:
    """Return a row's figures by name."""
    found = asdict(row)
    del found["rules"]
    return {
        "objective": row.rules.objective,
        "via_points": row.rules.via_points,
        **found,
        "unit": UNITS[row.figure],
    }
