"""What ``check`` finds."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Violation:
    """One broken constraint: its name, where, and by how much (in ``unit``)."""

    constraint: str
    place: str
    amount: float
    unit: str

    def __str__(self) -> str:
        return f"{self.constraint}: {self.place} ({self.amount:g} {self.unit})"
