"""The folder of a benchmark's results: what is there already, and what is written at the end."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from cutgap.benchmark.records import FILE_NAME, Damage, Record, append_record, finished, read_records
from cutgap.instances import Instance
from cutgap.instances.formats import write_atomically, write_instance

TABLE_NAME = "table.csv"
REPORT_NAME = "report.html"
AUDIT_TABLE_NAME = "audit.csv"
AUDIT_REPORT_NAME = "audit.html"
CERTIFICATES = "certificates"
INSTANCES = "instances"
"""Sub-folder of the instances that certificates speak of, so that they can be verified where they are."""


@dataclass(frozen=True, slots=True)
class Folder:
    """Results in ``path``; build it with ``open_folder``.

    Attributes
    ----------
    done
        Records to go on from, by task key.
    damages
        Lines that cannot be trusted; their runs count as not done.
    set_aside
        Where earlier results went; ``None`` when there were none, or the run goes on from them.
    """

    path: Path
    done: dict[str, Record]
    damages: tuple[Damage, ...]
    set_aside: Path | None

    @property
    def results(self) -> Path:
        """The file of records."""
        return self.path / FILE_NAME

    def append(self, record: Record) -> None:
        """Add a finished run, on disk and in ``done``; its certificate goes to a file of its own, first."""
        proof = record.result.certificate
        if proof is not None:
            name = f"{record.key}.json"
            (self.path / CERTIFICATES).mkdir(exist_ok=True)
            write_atomically(self.path / CERTIFICATES / name, json.dumps(proof, separators=(",", ":")))
            record = replace(record, certificate=name, result=replace(record.result, certificate=None))
        append_record(self.results, record)
        self.done[record.key] = record

    def keep_instances(self, instances: Mapping[str, Instance]) -> None:
        """Write the instances, by hash, of which a certificate is there."""
        proved = {record.instance_hash for record in self.done.values() if record.certificate is not None}
        for key in sorted(proved & instances.keys()):
            (self.path / INSTANCES).mkdir(exist_ok=True)
            write_instance(instances[key], self.path / INSTANCES / f"{key}.json")

    def among(self, keys: Iterable[str]) -> list[Record]:
        """Return the records of these tasks, in their order, as far as they are finished."""
        return [self.done[key] for key in keys if key in self.done]


def open_folder(path: Path, *, resume: bool) -> Folder:
    """Make the folder ready for new records.

    With ``resume`` the records in it count as done. Without, results of an earlier run are moved to a
    sub-folder ``earlier-1``, ``earlier-2``, ...: nothing is overwritten.

    Raises
    ------
    OSError
        When the folder cannot be made, read or written.
    """
    path.mkdir(parents=True, exist_ok=True)
    if resume:
        records, damages = read_records(path / FILE_NAME)
        return Folder(path, finished(records), tuple(damages), None)
    return Folder(path, {}, (), _set_aside(path) if (path / FILE_NAME).exists() else None)


def _set_aside(path: Path) -> Path:
    number = 1
    while (path / f"earlier-{number}").exists():
        number += 1
    target = path / f"earlier-{number}"
    target.mkdir()
    for name in (
        FILE_NAME,
        TABLE_NAME,
        REPORT_NAME,
        AUDIT_TABLE_NAME,
        AUDIT_REPORT_NAME,
        CERTIFICATES,
        INSTANCES,
    ):
        if (path / name).exists():
            (path / name).rename(target / name)
    return target
