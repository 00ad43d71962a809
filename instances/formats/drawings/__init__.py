"""Drawings of plates: DXF and SVG.

file -> strands (``dxf``, ``svg``; ``curves``) -> loops (``chaining``) -> sound outlines (``outlines``,
``soundness``) -> entry points, parts and precedence (``entry_points``, ``plate``). All up to the outlines
happens in a child process (``child``, ``worker``), since files may be broken or hostile.
"""

import warnings

from cutgap.instances.formats.drawings.child import Limits, read_outlines
from cutgap.instances.formats.drawings.plate import instance_of, sheet_note
from cutgap.instances.formats.options import HOME_HINT, FormatNote, MachineOptions
from cutgap.instances.instance import Instance

LIMITS = Limits()


def parse_dxf(content: bytes, name: str, options: MachineOptions) -> Instance:
    """Return the plate in a DXF file; what was taken for granted or left out is warned of as ``FormatNote``.

    Raises
    ------
    ValueError
        Naming layer, entity and place, for what cannot be cut or read; see ``child`` and ``soundness``.
    """
    return _parse("dxf", content, name, options)


def parse_svg(content: bytes, name: str, options: MachineOptions) -> Instance:
    """Return the plate in an SVG file; as ``parse_dxf``."""
    return _parse("svg", content, name, options)


def _parse(kind: str, content: bytes, name: str, options: MachineOptions) -> Instance:
    outlines, notes = read_outlines(kind, content, options.drawing, LIMITS)
    homeless = [] if options.homes else [f"no home: the head makes a closed tour; {HOME_HINT} for one"]
    for note in (*notes, *sheet_note(outlines), *homeless):
        warnings.warn(note, FormatNote, stacklevel=4)
    return instance_of(outlines, name, options)
