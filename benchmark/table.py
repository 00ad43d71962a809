"""The gap table: how far the plans of each method are from a proved bound.

The gap of a run is (value - lower_bound) / value, where the bound is the best one that any run proved for
the same instance and rules; of a peak it is a share of the rise above ambient (``trade_off``). A plan that
breaks a rule has its violation in the table and no gap.
"""

import csv
import io
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import fmean, median

from cutgap.benchmark.best_known import BestKnown
from cutgap.benchmark.records import Record
from cutgap.benchmark.trade_off import Against, ContradictionError, against, gap_to, slack, speaks_of_heat
from cutgap.benchmark.wording import describe, question
from cutgap.instances import Evaluation, Rules, Status


@dataclass(frozen=True, slots=True)
class TableRow:
    """One method on one instance, over its seeds.

    Attributes
    ----------
    runs, allowed
        Number of runs, and of those whose plan keeps the rules.
    best
        Record of the best allowed run; without one, of the run that is shown in its place.
    value, mean_value
        Best and mean value of the allowed runs, in the objective's unit.
    lower_bound
        Best bound that any method proved for the instance and rules, same unit.
    proved
        Whether that bound is the optimum: some allowed plan meets it.
    certified
        Whether a certificate of the bound was verified; else it is a solver's claim.
    certified_bound
        The best bound that certificates prove; it may be less.
    gaps
        Of each allowed run; empty without a bound.
    seconds
        Mean time of a run.
    note
        Why there is no allowed plan: a violation, or what the run says.
    published
        What others published about the instance under these rules.
    travel, peak
        Both figures against their bounds, where temperatures are asked for.
    """

    instance: str
    contours: int
    rules: Rules
    method: str
    runs: int
    allowed: int
    best: Record
    value: float | None
    mean_value: float | None
    lower_bound: float | None
    proved: bool
    certified: bool
    gaps: tuple[float, ...]
    seconds: float
    note: str
    published: BestKnown | None = None
    travel: Against | None = None
    peak: Against | None = None
    certified_bound: float | None = None

    @property
    def evaluation(self) -> Evaluation | None:
        """Figures of the run that is shown."""
        return self.best.result.evaluation

    @property
    def gap(self) -> float | None:
        """Gap of the best allowed run."""
        return min(self.gaps, default=None)

    @property
    def mean_gap(self) -> float | None:
        """Mean gap of the allowed runs."""
        return fmean(self.gaps) if self.gaps else None


@dataclass(frozen=True, slots=True)
class Summary:
    """One method over all instances: gaps of all allowed runs that have one, mean seconds of a run.

    ``question`` tells apart what is asked of it, where that is several things; ``travel_gap`` and ``peak_gap``
    are mean gaps of both figures, where temperatures are asked for.
    """

    question: str
    method: str
    instances: int
    runs: int
    allowed: int
    gaps: tuple[float, ...]
    seconds: float
    travel_gap: float | None = None
    peak_gap: float | None = None

    @property
    def spread(self) -> tuple[float | None, float | None, float | None, float | None]:
        """Least, mean, median and largest gap; all ``None`` without gaps."""
        if not self.gaps:
            return None, None, None, None
        return min(self.gaps), fmean(self.gaps), median(self.gaps), max(self.gaps)


def gap_table(records: Iterable[Record], published: Mapping[str, BestKnown] | None = None) -> list[TableRow]:
    """Return the table's rows, instances and methods in the order in which they appear.

    Parameters
    ----------
    records
        Finished runs.
    published
        What is published about instances under the rules of the records, by their names.

    Raises
    ------
    ContradictionError
        When a record contradicts a proved bound.
    """
    problems: dict[tuple[str, Rules], dict[str, list[Record]]] = defaultdict(lambda: defaultdict(list))
    instances: dict[str, list[Record]] = defaultdict(list)
    for record in records:
        instances[record.instance_hash].append(record)
        problems[record.instance_hash, record.result.rules][record.result.method].append(record)
    rows = []
    for methods in problems.values():
        every = [record for group in methods.values() for record in group]
        bound = best_bound(every)
        certified = bound is not None and any(
            each.certified and (each.result.lower_bound or 0.0) >= bound - slack(bound) for each in every
        )
        best = min((value for each in every if (value := allowed_value(each)) is not None), default=None)
        proved = bound is not None and best is not None and best <= bound + slack(bound)
        known = (published or {}).get(every[0].instance)
        lesser = max((b for each in every if (b := each.certified_bound) is not None), default=None)
        rows += [
            replace(_table_row(group, bound, proved, certified), published=known, certified_bound=lesser)
            for group in methods.values()
        ]
    if any(map(speaks_of_heat, instances.values())):
        groups = [group for methods in problems.values() for group in methods.values()]
        rows = [_both(row, group, instances) for row, group in zip(rows, groups, strict=True)]
    return rows


def _both(row: TableRow, group: Sequence[Record], instances: Mapping[str, Sequence[Record]]) -> TableRow:
    """Add both figures against their bounds."""
    every = instances[row.best.instance_hash]
    travel, peak = (against(every, group, row.best, figure) for figure in ("travel", "peak"))
    return replace(row, travel=travel, peak=peak)


def allowed_value(record: Record) -> float | None:
    """Return the value of a record's plan if the plan keeps the rules."""
    return None if record.result.violations else record.result.value


def best_bound(records: Sequence[Record]) -> float | None:
    """Return the best proved bound of one instance and its rules.

    Raises
    ------
    ContradictionError
        When an allowed plan is below the bound, or exists where none was proved to.
    """
    bound = max((b for each in records if (b := each.result.lower_bound) is not None), default=None)
    impossible = [each for each in records if each.result.status == Status.INFEASIBLE]
    for record in records:
        value = allowed_value(record)
        if value is None:
            continue
        place = f"{record.result.method} on {record.instance!r}, seed {record.seed}: value {value}"
        if bound is not None and value < bound - slack(value):
            raise ContradictionError(f"{place} is below the proved bound {bound}")
        if impossible:
            raise ContradictionError(f"{place}, yet {impossible[0].result.method} proved that no plan exists")
    return bound


def _table_row(group: Sequence[Record], bound: float | None, proved: bool, certified: bool) -> TableRow:
    values = [(value, each) for each in group if (value := allowed_value(each)) is not None]
    shown = min(values, key=lambda pair: pair[0])[1] if values else group[0]
    return TableRow(
        instance=shown.instance,
        contours=shown.contours,
        rules=shown.result.rules,
        method=shown.result.method,
        runs=len(group),
        allowed=len(values),
        best=shown,
        value=min((value for value, _ in values), default=None),
        mean_value=fmean(value for value, _ in values) if values else None,
        lower_bound=bound,
        proved=proved,
        certified=certified,
        gaps=tuple(gap_to(value, bound, each.result.zero) for value, each in values)
        if bound is not None
        else (),
        seconds=fmean(each.result.seconds for each in group),
        note="" if values else _why_not(shown),
    )


def _why_not(record: Record) -> str:
    result = record.result
    if result.violations:
        return "; ".join(str(violation) for violation in result.violations)
    return f"{result.status}: {result.reason}" if result.reason else str(result.status)


def summarise(rows: Sequence[TableRow]) -> list[Summary]:
    """Return one summary for what is asked and each method, in the order in which they appear."""
    methods: dict[tuple[str, str], list[TableRow]] = defaultdict(list)
    for row in rows:
        methods[question(row.rules), row.method].append(row)
    order = list(dict.fromkeys(asked for asked, _ in methods))
    return [
        Summary(
            question=asked,
            method=method,
            instances=len(group),
            runs=sum(row.runs for row in group),
            allowed=sum(row.allowed for row in group),
            gaps=tuple(gap for row in group for gap in row.gaps),
            seconds=sum(row.seconds * row.runs for row in group) / sum(row.runs for row in group),
            travel_gap=_mean_gap(row.travel for row in group),
            peak_gap=_mean_gap(row.peak for row in group),
        )
        for (asked, method), group in sorted(methods.items(), key=lambda each: order.index(each[0][0]))
    ]


def _mean_gap(figures: Iterable[Against | None]) -> float | None:
    gaps = [gap for each in figures if each is not None for gap in each.gaps]
    return fmean(gaps) if gaps else None


def table_csv(rows: Sequence[TableRow]) -> str:
    """Return the table as CSV text; an empty field is a figure that does not exist."""
    heads = max((row.best.heads for row in rows), default=2)
    published = any(row.published is not None for row in rows)
    heat = any(row.peak is not None for row in rows)
    links = any(row.rules.links for row in rows)
    text = io.StringIO()
    writer = csv.DictWriter(
        text, csv_columns(heads, published=published, heat=heat, links=links), lineterminator="\n"
    )
    writer.writeheader()
    writer.writerows(cells(row) for row in rows)
    return text.getvalue()


def csv_columns(heads: int, *, published: bool = False, heat: bool = False, links: bool = False) -> list[str]:
    """Return the names of the CSV's columns for that many heads, with figures of other kinds or without."""
    times = [f"time_{head + 1}_s" for head in range(heads)]
    figures = ["imbalance_s", "makespan_s", "partition_gap_mm", "unit", "value", "value_mean"]
    proof = ["lower_bound", "proven_optimum", "certified", "gap_percent", "gap_mean_percent", "seconds", "note"]
    run = ["part", "contours", "rules", "method", "runs", "allowed_runs", "travel_mm"]
    both = [
        *("temperature_cap_c", "travel_lower_bound", "travel_gap_percent", "travel_gap_mean_percent"),
        *("peak_c", "peak_lower_bound", "rise_gap_percent", "rise_gap_mean_percent"),
    ]
    others = ["published_value", "published_bound"] if published else []
    linked = ["pierces", "links_mm"] if links else []
    return [*run, *linked, *times, *figures, *proof, *others, *(both if heat else [])]


def cells(row: TableRow) -> dict[str, object]:
    """Return a row's figures by the names of ``csv_columns``; what does not exist is ``None`` or left out."""
    found: dict[str, object] = {
        "part": row.instance,
        "contours": row.contours,
        "rules": describe(row.rules, row.best.heads),
        "method": row.method,
        "runs": row.runs,
        "allowed_runs": row.allowed,
        "unit": row.rules.unit,
        "value": row.value,
        "value_mean": row.mean_value,
        "lower_bound": row.lower_bound,
        "proven_optimum": "yes" if row.proved else "no",
        "certified": "yes" if row.certified else "no",
        "gap_percent": None if row.gap is None else 100 * row.gap,
        "gap_mean_percent": None if row.mean_gap is None else 100 * row.mean_gap,
        "seconds": row.seconds,
        "note": row.note,
    }
    if row.evaluation is not None:
        found |= {f"time_{head + 1}_s": time for head, time in enumerate(row.evaluation.time_s)}
        found |= {
            "travel_mm": row.evaluation.total_travel_mm,
            "imbalance_s": row.evaluation.imbalance_s,
            "makespan_s": row.evaluation.makespan_s,
            "partition_gap_mm": row.evaluation.partition_gap_mm,
        }
        if row.rules.links:
            found |= {"pierces": sum(row.evaluation.pierces), "links_mm": sum(row.evaluation.link_mm)}
    if row.published is not None:
        found |= {"published_value": row.published.value, "published_bound": row.published.lower_bound}
    return found | _heat_cells(row)


def _heat_cells(row: TableRow) -> dict[str, object]:
    if row.travel is None or row.peak is None:
        return {}
    found: dict[str, object] = {"temperature_cap_c": row.rules.temperature_cap}
    if row.evaluation is not None:
        found["peak_c"] = row.evaluation.peak_temperature_c
    for figure, share, each in (("travel", "travel", row.travel), ("peak", "rise", row.peak)):
        found |= {
            f"{figure}_lower_bound": each.lower_bound,
            f"{share}_gap_percent": None if each.gap is None else 100 * each.gap,
            f"{share}_gap_mean_percent": None if each.mean_gap is None else 100 * each.mean_gap,
        }
    return found
