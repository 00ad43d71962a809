"""Finished runs on disk: ``results.jsonl``, one line a run, which is only ever appended to.

A line is a JSON object whose last entry, ``checksum``, is a hash of all others. A process that is killed
while it writes leaves a torn last line: reading reports it and goes on, the next record starts on a new
line, and the run counts as not done.
"""

import json
import math
import os
import platform
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from cutgap.benchmark.tasks import Task, canonical, digest, instance_hash, release
from cutgap.formulations.certify import proved_bound, proves
from cutgap.instances import Result, check, evaluate

FILE_NAME = "results.jsonl"
LIBRARIES = ("highspy", "numpy", "scipy", "numba", "scikit-learn")
"""Libraries whose version can change a result or its time."""


@dataclass(frozen=True, slots=True)
class Record:
    """One finished run.

    Attributes
    ----------
    key
        Key of its task.
    instance, instance_hash, contours, heads
        Name, hash, number of contours and of heads of the instance.
    seed, time_limit
        As in the task; the limit in s.
    result
        The outcome; its plan was evaluated and checked.
    certificate
        Name of the file with a verified proof; ``None`` when the bound is the solver's claim.
    certified_bound
        What the certificate proves, in the unit of the objective; it may be less than the bound.
    versions
        Of Python, of this package and of the libraries behind it.
    """

    key: str
    instance: str
    instance_hash: str
    contours: int
    heads: int
    seed: int
    time_limit: float | None
    result: Result
    versions: dict[str, str]
    certificate: str | None = None
    certified_bound: float | None = None

    @property
    def certified(self) -> bool:
        """Whether the certificate proves the bound, and not less."""
        return self.certificate is not None and proves(self.certified_bound, self.result.lower_bound)

    def __post_init__(self) -> None:
        if self.result.plan is not None and self.result.evaluation is None:
            raise ValueError(f"record {self.key}: the plan of {self.result.method} was not checked")


@dataclass(frozen=True, slots=True)
class Damage:
    """A line of a results file that cannot be trusted: its number from 1 and what is wrong with it."""

    line: int
    reason: str

    def __str__(self) -> str:
        return f"line {self.line}: {self.reason}"


def make_record(task: Task, result: Result) -> Record:
    """Return the record of a finished task.

    Raises
    ------
    ValueError
        When the result's figures or violations are not those of its plan.
    """
    if result.plan is not None:
        violations = tuple(check(task.instance, task.rules, result.plan))
        if result.evaluation != evaluate(task.instance, result.plan) or result.violations != violations:
            raise ValueError(f"{task.method} on {task.instance.name!r}: the plan was not checked")
    certificate = result.certificate
    return Record(
        key=task.key,
        instance=task.instance.name,
        instance_hash=instance_hash(task.instance),
        contours=len(task.instance.contours),
        heads=len(task.instance.heads),
        seed=task.seed,
        time_limit=task.time_limit,
        result=result,
        versions=versions(),
        certified_bound=None if certificate is None else proved_bound(certificate, task.instance),
    )


@cache
def versions() -> dict[str, str]:
    """Return the versions of what produces results here."""
    return {
        "cutgap": release(),
        "python": platform.python_version(),
        **{name: version(name) for name in LIBRARIES},
    }


def append_record(path: Path, record: Record) -> None:
    """Append a record and wait until it is on the disk; a torn last line is ended first."""
    content = _storable(_adapter().dump_python(record, mode="json"))
    line = canonical({**content, "checksum": digest(content)}) + b"\n"
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a+b") as file:
        if file.seek(0, os.SEEK_END) > 0:
            file.seek(-1, os.SEEK_END)
            if file.read(1) != b"\n":
                line = b"\n" + line
        file.write(line)
        file.flush()
        os.fsync(file.fileno())


def _storable(content: Any) -> Any:
    """Return content with infinite numbers, as a peak may be, as texts that are read as such."""
    if isinstance(content, dict):
        return {key: _storable(value) for key, value in content.items()}
    if isinstance(content, list):
        return [_storable(value) for value in content]
    return str(content) if isinstance(content, float) and math.isinf(content) else content


def read_records(path: Path) -> tuple[list[Record], list[Damage]]:
    """Return the records of a file and the lines that cannot be trusted; no file holds no records."""
    records, damages = [], []
    if not path.exists():
        return [], []
    for number, line in enumerate(path.read_bytes().split(b"\n"), start=1):
        if not line.strip():
            continue
        try:
            records.append(parse_record(line))
        except ValueError as error:
            damages.append(Damage(number, str(error)))
    return records, damages


def parse_record(line: bytes) -> Record:
    """Return the record of one line.

    Raises
    ------
    ValueError
        When the line is no JSON object, its checksum differs, or it is no record of this version.
    """
    try:
        content: Any = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise ValueError("torn or not JSON") from error
    if not isinstance(content, dict) or "checksum" not in content:
        raise ValueError("no checksum")
    checksum = content.pop("checksum")
    try:
        intact = checksum == digest(content)
    except ValueError as error:
        raise ValueError("a number is not finite") from error
    if not intact:
        raise ValueError("the checksum does not fit the content")
    try:
        return _adapter().validate_python(content)
    except ValidationError as error:
        raise ValueError(f"not a record: {error.errors()[0]['msg']}") from error


def finished(records: Iterable[Record]) -> dict[str, Record]:
    """Return the records by task key; of several, the last."""
    return {record.key: record for record in records}


@cache
def _adapter() -> TypeAdapter[Record]:
    return TypeAdapter(Record)
