"""Readers and writers of instances and plans; the suffix of the file name chooses the format.

========  ====================================  =======  ==========================================
suffix    content                               written  homes
========  ====================================  =======  ==========================================
.json     everything, and plans                 yes      in the file; given ones replace them
.json     CAM routing task                      no       in the file; given ones replace them
.json     CAM list of nested parts              no       must be given
.json     nest of outlines                      no       must be given
.csv      holes ``id,x,y,z,perimeter``          yes      must be given
.tsp      TSPLIB, symmetric                     yes      closed tour without; given where computable
.atsp     TSPLIB, asymmetric                    yes      as .tsp
.gtsp     GTSPLIB: sets of entry points         yes      as .tsp
.pcglns   GTSPLIB with an ordering              yes      start set of one node; given where computable
.txt      cutting paths: GTSPLIB in mm          no       set 1 if of one node; given ones replace it
.txt      discs ``x y z r``                     no       a depot comment, or given
.cetsp    discs ``x y z r``                     no       a depot comment, or given
.dxf      drawing of a plate                    no       closed tour without
.svg      drawing of a plate                    no       closed tour without
========  ====================================  =======  ==========================================

Where a suffix has several contents, the content itself says which it is.
"""

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import TypeVar

from cutgap.instances.formats import (
    cam_parts,
    cam_routing,
    csv_format,
    discs,
    drawings,
    gtsp,
    gtsp_writer,
    json_format,
    nests,
    tsplib,
)
from cutgap.instances.formats.files import SIZE_LIMIT, read_bytes, read_text, write_atomically
from cutgap.instances.formats.json_text import load_json
from cutgap.instances.formats.options import NO_OVERRIDES, DrawingOptions, FormatNote, MachineOptions
from cutgap.instances.formats.tsplib_sections import begins_with_field
from cutgap.instances.instance import Instance
from cutgap.instances.links.points import with_link_points
from cutgap.instances.plan import Plan

__all__ = [
    "NO_OVERRIDES",
    "READABLE_SUFFIXES",
    "DrawingOptions",
    "FormatNote",
    "MachineOptions",
    "read_instance",
    "read_plan",
    "write_atomically",
    "write_instance",
    "write_plan",
]


def _parse_json(text: str, name: str, options: MachineOptions) -> Instance:
    """Read a ``.json`` file in the dialect that its content shows."""
    document = load_json(text)
    for dialect in (cam_routing, cam_parts, nests):
        if dialect.recognises(document):
            return dialect.parse_document(document, name, options)
    return json_format.parse_document(document, options)


def _parse_txt(text: str, name: str, options: MachineOptions) -> Instance:
    """Read a ``.txt`` file: sets of nodes when it begins with a field, else discs."""
    reader = gtsp if begins_with_field(text) else discs
    return reader.parse_instance(text, name, options)


_READERS: dict[str, Callable[[str, str, MachineOptions], Instance]] = {
    ".json": _parse_json,
    ".csv": csv_format.parse_instance,
    ".tsp": tsplib.parse_instance,
    ".atsp": tsplib.parse_instance,
    ".gtsp": gtsp.parse_instance,
    ".pcglns": gtsp.parse_instance,
    ".cetsp": discs.parse_instance,
    ".txt": _parse_txt,
}
# Drawings come in many encodings, and binary.
_DRAWING_READERS: dict[str, Callable[[bytes, str, MachineOptions], Instance]] = {
    ".dxf": drawings.parse_dxf,
    ".svg": drawings.parse_svg,
}
READABLE_SUFFIXES = (*_READERS, *_DRAWING_READERS)
"""Suffixes of files that ``read_instance`` takes."""
_WRITERS: dict[str, Callable[[Instance], str]] = {
    ".json": json_format.format_instance,
    ".csv": csv_format.format_instance,
    ".tsp": tsplib.format_instance,
    ".atsp": tsplib.format_instance,
    ".gtsp": gtsp_writer.format_gtsp,
    ".pcglns": gtsp_writer.format_pcglns,
}
_PLAN_SUFFIXES = {".json": None}
_Entry = TypeVar("_Entry")


def read_instance(path: str | Path, overrides: MachineOptions = NO_OVERRIDES) -> Instance:
    """Return the instance in a file.

    Parameters
    ----------
    path
        The file; formats without a name field name the instance after it.
    overrides
        Homes and machine figures for formats that carry none, or in place of the file's; how drawings are read.

    Raises
    ------
    ValueError
        Naming file, place and value: unknown suffix, unreadable or malformed file, missing homes.
    """
    path = Path(path)
    parse: Callable[[str, MachineOptions], Instance]
    if path.suffix.lower() in _DRAWING_READERS:
        parse = partial(_chosen(path, _DRAWING_READERS, "read"), read_bytes(path))
    else:
        parse = partial(_chosen(path, _READERS, "read", READABLE_SUFFIXES), read_text(path))
    try:
        instance = parse(path.stem, overrides)
        return with_link_points(instance) if overrides.link_points else instance
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def write_instance(instance: Instance, path: str | Path) -> None:
    """Write an instance, replacing the file as a whole.

    CSV files and those of the TSPLIB family hold no machine figures, CSV files no homes: they are given again
    on reading.

    Raises
    ------
    ValueError
        When the suffix is unknown or the format cannot hold the instance; nothing is written then.
    OSError
        When the file system refuses.
    """
    path = Path(path)
    writer = _chosen(path, _WRITERS, "written")
    try:
        _write(path, writer(instance))
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def read_plan(path: str | Path, instance: Instance) -> Plan:
    """Return the plan in a JSON file; it names contours and heads of ``instance`` by id.

    Raises
    ------
    ValueError
        Naming file, field path and value; also for what the instance does not have.
    """
    path = Path(path)
    _chosen(path, _PLAN_SUFFIXES, "read as a plan")
    text = read_text(path)
    try:
        return json_format.parse_plan(text, instance)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def write_plan(plan: Plan, instance: Instance, path: str | Path) -> None:
    """Write a plan as JSON, replacing the file as a whole; errors as for ``write_instance``."""
    path = Path(path)
    _chosen(path, _PLAN_SUFFIXES, "written as a plan")
    try:
        _write(path, json_format.format_plan(plan, instance))
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def _chosen(path: Path, table: dict[str, _Entry], verb: str, known: Iterable[str] = ()) -> _Entry:
    """Return the entry for a path's suffix; ``known`` are the suffixes to be named, the table's by default."""
    suffix = path.suffix.lower()
    if suffix not in table:
        names = ", ".join(known or table)
        raise ValueError(f"{path}: unknown suffix {suffix!r}; files that can be {verb} end in {names}")
    return table[suffix]


def _write(path: Path, text: str) -> None:
    content = text.encode("utf-8")
    if len(content) > SIZE_LIMIT:
        raise ValueError(f"larger than the {SIZE_LIMIT >> 20} MiB that can be read again")
    write_atomically(path, content)
