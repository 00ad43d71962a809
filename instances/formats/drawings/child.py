"""Has a drawing read in a child process with limits, and takes plain outlines from it."""

import json
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cutgap.instances.formats.drawings.outlines import Outline
from cutgap.instances.formats.options import DrawingOptions


@dataclass(frozen=True, slots=True)
class Limits:
    """What the reading of one drawing may take."""

    seconds: float = 60.0
    memory_mib: int = 2048


def read_outlines(
    kind: str, content: bytes, options: DrawingOptions, limits: Limits
) -> tuple[list[Outline], list[str]]:
    """Return the sound outlines of a drawing, and notes on what was taken for granted or left out.

    Parameters
    ----------
    kind
        ``dxf`` or ``svg``.

    Raises
    ------
    ValueError
        When the drawing cannot be read within the limits, or for what the reader says of it.
    """
    job = {
        "kind": kind,
        "layers": options.layers,
        "tolerance": options.tolerance,
        "chord": options.chord,
        "skip": options.skip,
        "seconds": limits.seconds,
        "memory_mib": limits.memory_mib,
    }
    answer = json.loads(_answer(json.dumps(job).encode() + b"\n" + content, limits))
    if "error" in answer:
        raise ValueError(answer["error"])
    return [_outline(fields) for fields in answer["outlines"]], answer["notes"]


def _answer(request: bytes, limits: Limits) -> bytes:
    command = [sys.executable, "-m", "cutgap.instances.formats.drawings.worker"]
    # In a session of its own, as Ctrl-C is for the parent to handle.
    with subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
        cwd=Path(sys.executable).parent,
    ) as process:
        try:
            answer, _ = process.communicate(request, timeout=limits.seconds)
        except subprocess.TimeoutExpired:
            raise ValueError(
                f"reading it takes more than {limits.seconds:g} s; the file is broken, or too large: split it"
            ) from None
        finally:
            process.kill()
            process.wait()
    if process.returncode != 0 or not answer:
        code = process.returncode
        how = f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
        raise ValueError(
            f"reading it failed ({how}; limits {limits.seconds:g} s and {limits.memory_mib} MiB); "
            "open and save it with the program that made it, or split the drawing"
        )
    return answer


def _outline(fields: dict) -> Outline:
    return Outline(
        points=np.array(fields["points"], dtype=np.float64),
        corners=tuple(fields["corners"]),
        curved=tuple(fields["curved"]),
        perimeter=float(fields["perimeter"]),
        layer=fields["layer"],
        place=fields["place"],
    )
