"""The published table that is audited: Table 1 of Wang et al. (2025), as data.

Ten parts, three methods each; the coordinates are not published. Empty fields of ``table1.csv`` are missing in
the source, and its comments say what is wrong there.
"""

import csv
import io
from dataclasses import dataclass
from functools import cache
from importlib.resources import files


@dataclass(frozen=True, slots=True)
class Published:
    """One row of the published table; mm and s.

    Attributes
    ----------
    partition_gap_mm
        ``None`` where the source has none.
    comment
        What is wrong with the row in the source.
    """

    part: int
    holes: int
    method: str
    travel_mm: float
    time_1_s: float
    time_2_s: float
    imbalance_s: float
    partition_gap_mm: float | None
    comment: str

    @property
    def overlaps(self) -> bool:
        """Whether the heads' ranges overlap."""
        return self.partition_gap_mm is not None and self.partition_gap_mm < 0

    def work_s(self, v_jump: float) -> float:
        """Return cutting and auxiliary time of all holes, s, for a rapid speed in mm/s."""
        return self.time_1_s + self.time_2_s - self.travel_mm / v_jump

    @property
    def makespan_s(self) -> float:
        """Time until the second head is done."""
        return max(self.time_1_s, self.time_2_s)


@cache
def published_table() -> tuple[Published, ...]:
    """Return Table 1 of Wang et al. (2025), row by row."""
    text = files("cutgap.benchmark").joinpath("table1.csv").read_text(encoding="utf-8")
    return tuple(
        Published(
            part=int(row["part"]),
            holes=int(row["holes"]),
            method=row["method"],
            travel_mm=float(row["travel_mm"]),
            time_1_s=float(row["time_1_s"]),
            time_2_s=float(row["time_2_s"]),
            imbalance_s=float(row["imbalance_s"]),
            partition_gap_mm=float(row["partition_gap_mm"]) if row["partition_gap_mm"] else None,
            comment=row["comment"],
        )
        for row in csv.DictReader(io.StringIO(text))
    )


def published_sizes() -> tuple[int, ...]:
    """Return the numbers of holes of the published parts."""
    return tuple(dict.fromkeys(row.holes for row in published_table()))
