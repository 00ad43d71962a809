"""The gap table's columns, once for terminal and report: heading, definition, and how a cell reads."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from cutgap.benchmark.table import Summary, TableRow
from cutgap.benchmark.trade_off import Against
from cutgap.benchmark.wording import question
from cutgap.instances import Evaluation

NOTHING = "-"
"""What stands where a figure does not exist."""


@dataclass(frozen=True, slots=True)
class Column:
    """One column: its heading, the definition printed under the table, and the text of a row's cell."""

    heading: str
    definition: str
    cell: Callable[[TableRow], str]
    numeric: bool = True


def number(value: float | None, digits: int) -> str:
    """Return a figure with fixed digits, without a minus in front of zero."""
    return NOTHING if value is None else f"{value:z.{digits}f}"


def percent(share: float | None) -> str:
    """Return a share as percent with three digits."""
    return NOTHING if share is None else f"{100 * share:z.3f}"


def bound(row: TableRow) -> str:
    """Return the bound: ``= optimum``, or ``≥ bound`` when no plan meets it; ``claimed`` without a proof."""
    return _bound(row)


def _bound(row: TableRow | Against) -> str:
    return _plain_bound(row) + ("" if row.certified or row.lower_bound is None else " claimed")


def _plain_bound(row: TableRow | Against, digits: int = 2) -> str:
    return NOTHING if row.lower_bound is None else f"{'=' if row.proved else '≥'} {row.lower_bound:.{digits}f}"


def published(row: TableRow) -> str:
    """Return the published value: ``= value`` when it is the optimum, else with the bound if there is one."""
    if row.published is None:
        return NOTHING
    value, lower_bound = row.published.value, row.published.lower_bound
    if lower_bound is None:
        return f"{value:.10g}"
    return f"= {value:.10g}" if lower_bound >= value else f"{value:.10g} ≥ {lower_bound:.10g}"


def seconds(value: float) -> str:
    """Return a time in s with three significant digits, at most three decimals."""
    return f"{value:.3f}" if value < 1 else f"{value:.2f}" if value < 10 else f"{value:.1f}"


def runs(allowed: int, total: int) -> str:
    """Return the number of runs, with that of the allowed ones when some break rules."""
    return str(total) if allowed == total else f"{allowed}/{total}"


def _figure(heading: str, definition: str, digits: int, get: Callable[[Evaluation], float | None]) -> Column:
    def cell(row: TableRow) -> str:
        return NOTHING if row.evaluation is None else number(get(row.evaluation), digits)

    return Column(heading, definition, cell)


def _head_time(head: int) -> Column:
    def get(evaluation: Evaluation) -> float | None:
        return evaluation.time_s[head] if head < len(evaluation.time_s) else None

    definition = (
        f"Time of head {head + 1} from leaving its home to being back, cutting and auxiliary time included."
    )
    return _figure(f"T_{head + 1} [s]", definition, 1, get)


PUBLISHED = Column(
    "published",
    "Best published value of the objective; =: published as the optimum; a ≥ b: with the best bound b.",
    published,
)


VALUE = Column("value", "Value of the objective.", lambda row: number(row.value, 2))
IMBALANCE = _figure("imbalance [s]", "Longest T minus shortest T.", 2, lambda e: e.imbalance_s)
PARTITION_GAP = _figure(
    "F [mm]",
    "Partition gap: smallest x of the right head's contours minus largest x of the left head's; "
    "negative is an overlap.",
    1,
    lambda e: e.partition_gap_mm,
)


def several(rows: Sequence[TableRow]) -> bool:
    """Whether several things are asked for."""
    return len({question(row.rules) for row in rows}) > 1


def row_name(row: TableRow, rows: Sequence[TableRow]) -> str:
    """Return the method, and where several things are asked for also which."""
    return f"{row.method} ({question(row.rules)})" if several(rows) else row.method


PART = Column("part", "Name of the instance.", lambda row: row.instance, numeric=False)
SIZE = Column("N", "Number of contours.", lambda row: str(row.contours))
ASKED = Column(
    "asked", "What is minimised, and whether under a cap.", lambda row: question(row.rules), numeric=False
)
CAP = Column("cap [C]", "Temperature cap, deg C.", lambda row: number(row.rules.temperature_cap, 1))
METHOD = Column("method", "What planned the tours.", lambda row: row.method, numeric=False)
RUNS = Column(
    "runs",
    "Number of runs with different seeds; a/b: only a of b plans keep the rules. "
    "The figures are those of the best allowed run.",
    lambda row: runs(row.allowed, row.runs),
)
TRAVEL = _figure("travel [mm]", "Length of all rapids of all heads.", 1, lambda e: e.total_travel_mm)
PEAK = _figure("peak [C]", "Highest temperature of a start point, deg C.", 1, lambda e: e.peak_temperature_c)
PIERCES = Column(
    "pierces",
    "How often the torch is lit.",
    lambda row: NOTHING if row.evaluation is None else str(sum(row.evaluation.pierces)),
)
LINKS = _figure("links [mm]", "Length of all links, as often as they are passed.", 3, lambda e: sum(e.link_mm))
IDLE = _figure(
    "idle [mm]",
    "Length of all rapids and links: what is travelled besides contours.",
    3,
    lambda e: e.total_travel_mm,
)


def _proof(row: TableRow) -> str:
    if row.lower_bound is None:
        return NOTHING
    less = "" if row.certified_bound is None else f", certified ≥ {row.certified_bound:.6g}"
    return "certified" if row.certified else f"claimed{less}"


PROOF = Column(
    "proof",
    "certified: the certificate of the bound was verified in exact arithmetic; claimed: by the solver alone, "
    "or the certificate proves less.",
    _proof,
    numeric=False,
)
SECONDS = Column(
    "time [s]",
    "Mean wall time of a run, after one on a few contours that loads and compiles and is not counted; "
    "what that one did not need, the first run on a machine still compiles.",
    lambda row: seconds(row.seconds),
)


GAP = Column(
    "gap [%]",
    "(value - bound) / value of the best allowed run; none for a plan that breaks a rule.",
    lambda row: percent(row.gap),
)
MEAN_GAP = Column("mean gap [%]", "Mean gap of all allowed runs.", lambda row: percent(row.mean_gap))


def _against(
    get: Callable[[TableRow], Against | None], figure: str, share: str, definition: str
) -> list[Column]:
    """Return bound, gap and mean gap of one of two figures."""

    def cell(show: Callable[[Against], str]) -> Callable[[TableRow], str]:
        return lambda row: NOTHING if (found := get(row)) is None else show(found)

    return [
        Column(
            f"{figure} bound",
            f"=: the least {figure} under the rules; ≥: a lower bound that no plan meets yet. It holds for the "
            "plans of all methods. claimed: by the solver, without a certificate.",
            cell(_bound),
        ),
        Column(f"{share} gap [%]", f"{definition}, of the run that is shown.", cell(lambda a: percent(a.gap))),
        Column(f"mean {share} gap [%]", "Mean of all allowed runs.", cell(lambda a: percent(a.mean_gap))),
    ]


def columns(rows: Sequence[TableRow]) -> list[Column]:
    """Return the columns for rows: some only where there are several heads, combined or published values.

    Where temperatures are asked for, both figures stand beside their bounds.
    """
    if any(row.peak is not None for row in rows):
        return heat_columns(rows)
    if any(row.rules.links for row in rows):
        return link_columns(rows)
    heads = max((row.best.heads for row in rows), default=2)
    is_published = any(row.published is not None for row in rows)
    # Where the objective is no figure of its own in the table, it gets a column.
    combined = any(row.rules.objective == "weighted" or row.rules.backward_price > 0 for row in rows)
    return [
        PART,
        SIZE,
        METHOD,
        RUNS,
        TRAVEL,
        *([VALUE] if combined else []),
        *([_head_time(head) for head in range(heads)] if heads > 1 else []),
        *([IMBALANCE] if heads > 1 else []),
        _figure("makespan [s]", "The longest T: what the machine waits for.", 2, lambda e: e.makespan_s),
        *([PARTITION_GAP] if heads > 1 else []),
        Column(
            "bound",
            "=: the optimum of the objective; ≥: a lower bound that no plan meets yet. Its certificate was "
            "verified in exact arithmetic; claimed: by the solver alone, or the certificate proves less.",
            bound,
        ),
        *([PUBLISHED] if is_published else []),
        GAP,
        MEAN_GAP,
        SECONDS,
    ]


def link_columns(rows: Sequence[TableRow]) -> list[Column]:
    """Return the columns where contours may be joined by links."""
    return [
        PART,
        SIZE,
        *([ASKED] if several(rows) else []),
        METHOD,
        RUNS,
        PIERCES,
        LINKS,
        IDLE,
        _figure("makespan [s]", "Time from leaving the home to being back.", 2, lambda e: e.makespan_s),
        Column(
            "bound",
            "=: the optimum of the objective; ≥: a lower bound that no plan meets yet. It holds for links "
            "between the entry points of the instance.",
            lambda row: _plain_bound(row, 3),
        ),
        GAP,
        MEAN_GAP,
        PROOF,
        SECONDS,
    ]


def heat_columns(rows: Sequence[TableRow]) -> list[Column]:
    """Return the columns where temperatures are asked for."""
    capped = any(row.rules.temperature_cap is not None for row in rows)
    return [
        PART,
        SIZE,
        *([ASKED] if several(rows) else []),
        *([CAP] if capped else []),
        METHOD,
        RUNS,
        TRAVEL,
        *_against(lambda row: row.travel, "travel", "travel", "(travel - bound) / travel"),
        PEAK,
        *_against(lambda row: row.peak, "peak", "rise", "(peak - bound) / (peak - ambient), 0 within 0.005 K"),
        SECONDS,
    ]


def summary_headings(summaries: Sequence[Summary]) -> list[str]:
    """Return the headings of a summary of methods."""
    return [
        *(["asked"] if _questions(summaries) > 1 else []),
        *("method", "parts", "runs", "least gap [%]", "mean gap [%]", "median gap [%]", "largest gap [%]"),
        *(["mean travel gap [%]", "mean rise gap [%]"] if _has_two_figures(summaries) else []),
        "time [s]",
    ]


def summary_rows(summaries: Sequence[Summary]) -> list[list[str]]:
    """Return the cells of each summary, in the order of ``summary_headings``."""
    asked, both = _questions(summaries) > 1, _has_two_figures(summaries)
    return [
        [
            *([each.question] if asked else []),
            each.method,
            str(each.instances),
            runs(each.allowed, each.runs),
            *[percent(share) for share in each.spread],
            *([percent(each.travel_gap), percent(each.peak_gap)] if both else []),
            seconds(each.seconds),
        ]
        for each in summaries
    ]


def summary_name(summary: Summary, summaries: Sequence[Summary]) -> str:
    """Return the method of a summary, and where several things are asked for also which."""
    return f"{summary.method} ({summary.question})" if _questions(summaries) > 1 else summary.method


def _questions(summaries: Sequence[Summary]) -> int:
    return len({each.question for each in summaries})


def _has_two_figures(summaries: Sequence[Summary]) -> bool:
    return any(each.travel_gap is not None or each.peak_gap is not None for each in summaries)
