"""Hole lists as CSV: a header with ``id,x,y,z,perimeter`` (mm), then one hole a line.

``z`` may be left out and is then 0; the order of columns is free. Other columns are refused, because a
misspelt ``z`` or ``perimeter`` would otherwise be ignored without a word. The format carries holes only:
homes and machine figures are given when it is read, and the instance is named after the file.
"""

import csv
import io
from collections.abc import Iterator

import numpy as np

from cutgap.instances.formats.numbers import parse_number
from cutgap.instances.formats.options import MachineOptions
from cutgap.instances.instance import Contour, Instance

COLUMNS = ("id", "x", "y", "z", "perimeter")
REQUIRED = ("id", "x", "y", "perimeter")


def parse_instance(text: str, name: str, options: MachineOptions) -> Instance:
    """Return the instance in a CSV text; errors are ``ValueError`` naming line, column and value."""
    rows = _rows(text)
    _, header = next(rows, (0, []))
    columns = _columns(header)
    lines_of_ids: dict[str, int] = {}
    contours = []
    for line, row in rows:
        if len(row) != len(columns):
            raise ValueError(f"line {line}: expected {len(columns)} columns as in the header, got {len(row)}")
        contour = _contour(line, dict(zip(columns, row, strict=True)))
        if contour.id in lines_of_ids:
            first = lines_of_ids[contour.id]
            raise ValueError(
                f"line {line}, column id: {contour.id!r} is already on line {first}: ids must be unique"
            )
        lines_of_ids[contour.id] = line
        contours.append(contour)
    return Instance(name, tuple(contours), options.heads(), options.machine())


def format_instance(instance: Instance) -> str:
    """Return the holes of an instance as CSV text.

    Raises
    ------
    ValueError
        When the instance has more to it than the format holds.
    """
    for reason, found in _obstacles(instance).items():
        if found:
            raise ValueError(f"instance {instance.name!r}: CSV cannot hold {reason}; write .json instead")
    out = io.StringIO(newline="")
    # Left to itself the writer quotes no lone carriage return, which readers take for a line break.
    returns = any("\r" in contour.id for contour in instance.contours)
    writer = csv.writer(out, lineterminator="\n", quoting=csv.QUOTE_ALL if returns else csv.QUOTE_MINIMAL)
    writer.writerow(COLUMNS)
    for contour in instance.contours:
        numbers = [*contour.entry_points[0].tolist(), contour.perimeter]
        writer.writerow([contour.id, *map(repr, numbers)])
    return out.getvalue()


def _rows(text: str) -> Iterator[tuple[int, list[str]]]:
    """Yield line number and cells; blank lines are left out."""
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    while True:
        line = reader.line_num + 1
        try:
            row = next(reader, None)
        except csv.Error as error:
            raise ValueError(f"line {line}: not CSV: {error}") from error
        if row is None:
            return
        if row:
            yield line, row


def _columns(header: list[str]) -> list[str]:
    columns = [cell.strip() for cell in header]
    wanted = f"the header is {','.join(COLUMNS)} (z may be left out)"
    if not any(columns):
        raise ValueError(f"line 1: empty file; {wanted}")
    for column in columns:
        if column not in COLUMNS:
            hint = "; separate columns by commas" if ";" in column or "\t" in column else ""
            raise ValueError(f"line 1: unknown column {column[:40]!r}; {wanted}{hint}")
        if columns.count(column) > 1:
            raise ValueError(f"line 1: column {column!r} appears more than once")
    for column in REQUIRED:
        if column not in columns:
            raise ValueError(f"line 1: column {column!r} is missing; {wanted}")
    return columns


def _contour(line: int, cells: dict[str, str]) -> Contour:
    if not cells["id"]:
        raise ValueError(f"line {line}, column id: empty; every hole needs an id")
    point = [parse_number(cells.get(axis, "0"), f"line {line}, column {axis}") for axis in "xyz"]
    perimeter = parse_number(cells["perimeter"], f"line {line}, column perimeter", least=0.0)
    return Contour(cells["id"], np.array([point]), perimeter)


def _obstacles(instance: Instance) -> dict[str, bool]:
    contours = instance.contours
    return {
        "several entry points": any(len(contour.entry_points) > 1 for contour in contours),
        "geometry": any(contour.geometry is not None for contour in contours),
        "regions": any(contour.region is not None for contour in contours),
        "parts and rings": any(contour.part is not None or contour.ring != "hole" for contour in contours),
        "precedence": bool(instance.precedence),
        f"the metric {instance.machine.metric}": instance.machine.metric != "euclidean",
        "a material": instance.material is not None,
        "a closed tour (its heads have homes)": any(head.home is None for head in instance.heads),
    }
