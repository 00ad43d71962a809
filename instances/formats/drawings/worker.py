"""Reading itself, in a process of its own: parsers of drawings may loop or eat memory on broken files.

Run as a module it reads a line of JSON (kind, options, limits) and then the file from standard input, and
writes JSON to standard output: the sound outlines and notes, or an error.
"""

import json
import os
import sys
from collections.abc import Callable
from typing import Any

from cutgap.instances.formats.drawings import dxf, svg
from cutgap.instances.formats.drawings.chaining import chain
from cutgap.instances.formats.drawings.curves import Strand
from cutgap.instances.formats.drawings.outlines import Outline
from cutgap.instances.formats.drawings.soundness import sound_outlines
from cutgap.instances.formats.options import DrawingOptions

MEBIBYTE = 2**20

_STRANDS: dict[str, Callable[[bytes, DrawingOptions], tuple[list[Strand], list[str]]]] = {
    "dxf": dxf.strands_of,
    "svg": svg.strands_of,
}


def read(kind: str, content: bytes, options: DrawingOptions) -> tuple[list[Outline], list[str]]:
    """Return the sound outlines of a drawing (``dxf`` or ``svg``), and notes.

    Raises
    ------
    ValueError
        When there are none, or the drawing has faults that are not to be skipped.
    """
    strands, notes = _STRANDS[kind](content, options)
    outlines, more = sound_outlines(chain(strands, options.tolerance), options)
    if not outlines:
        said = "; ".join((*notes, *more)) or "it is empty"
        raise ValueError(f"no closed contour in the drawing; draw closed curves, choose other layers ({said})")
    return outlines, [*notes, *more]


def limit(seconds: float, mebibytes: int) -> None:
    """Limit this process's memory, computing time and writing, where the system can."""
    if sys.platform == "win32":
        return
    import resource

    for what, most in (
        (resource.RLIMIT_AS, mebibytes * MEBIBYTE),
        # The parent ends it by the clock; this is for a parent that died.
        (resource.RLIMIT_CPU, int(seconds) + 2),
        (resource.RLIMIT_CORE, 0),
    ):
        hard = resource.getrlimit(what)[1]
        resource.setrlimit(what, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def main() -> None:
    """Serve one file."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # so that nothing that a library prints comes between
    job = json.loads(sys.stdin.buffer.readline())
    limit(job["seconds"], job["memory_mib"])
    options = DrawingOptions(
        layers=tuple(job["layers"]), tolerance=job["tolerance"], chord=job["chord"], skip=tuple(job["skip"])
    )
    answer: dict[str, Any]
    try:
        outlines, notes = read(job["kind"], sys.stdin.buffer.read(), options)
        answer = {"outlines": [_fields(outline) for outline in outlines], "notes": notes}
    except MemoryError:
        answer = {"error": f"reading it takes more than {job['memory_mib']} MiB; split the drawing"}
    except ValueError as error:
        answer = {"error": str(error)}
    except Exception as error:  # a broken file can end these libraries in any way
        answer = {"error": f"cannot be read as {job['kind'].upper()} ({type(error).__name__}: {error!s:.200})"}
    json.dump(answer, answers)
    answers.close()


def _fields(outline: Outline) -> dict[str, Any]:
    return {
        "points": outline.points.tolist(),
        "corners": outline.corners,
        "curved": outline.curved,
        "perimeter": outline.perimeter,
        "layer": outline.layer,
        "place": outline.place,
    }


if __name__ == "__main__":
    main()
