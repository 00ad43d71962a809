"""The command ``verify``."""

import json as json_library
import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cutgap.formulations.certificate import Refused
from cutgap.formulations.certificate import verify as check_certificate
from cutgap.formulations.certificate.reading import MAX_CHARACTERS
from cutgap.views.options import FILE_MACHINE, File, Json, MachineArguments

CertificateFile = Annotated[Path, Parameter(help="Certificate, as written by solve --certificate.")]


def verify(
    certificate: CertificateFile,
    file: File,
    /,
    *,
    machine: MachineArguments = FILE_MACHINE,
    json: Json = False,
) -> int:
    """Prove a bound again in exact arithmetic, without any solver; exit code 1 if the proof fails."""
    document = _instance_document(file, machine)
    try:
        verdict = check_certificate(_read(certificate), document)
    except Refused as error:
        print(f"cutgap: {certificate}: refused: {error}", file=sys.stderr)
        return 1
    if json:
        fields = {
            "objective": verdict.rules.objective,
            "unit": verdict.unit,
            "lower_bound": None if verdict.bound is None else str(verdict.bound),
            "value": None if verdict.value is None else str(verdict.value),
            "gap": None if verdict.gap is None else float(verdict.gap),
            "proved": verdict.text,
        }
        print(json_library.dumps(fields, indent=2))
    else:
        print(f"{certificate}: {verdict.text}")
    return 0


def _read(path: Path) -> str:
    """Return a certificate's text, at most one character more than the checker takes."""
    try:
        with path.open(encoding="utf-8") as file:
            return file.read(MAX_CHARACTERS + 1)
    except UnicodeDecodeError as error:
        raise Refused(f"the file is not UTF-8 text: {error}") from error
    except OSError as error:
        raise ValueError(f"{path}: cannot be read: {error.strerror or error}") from error


def _instance_document(file: Path, machine: MachineArguments) -> str:
    """Return the instance as JSON text; a JSON file that needs no options goes to the checker as it is."""
    if file.suffix.lower() == ".json" and machine == FILE_MACHINE:
        return file.read_text(encoding="utf-8")
    from cutgap.instances.formats import read_instance
    from cutgap.instances.formats.json_format import format_instance

    return format_instance(read_instance(file, machine.options()))
