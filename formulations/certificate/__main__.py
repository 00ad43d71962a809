"""``python -m cutgap.formulations.certificate CERTIFICATE INSTANCE``: verify, and print what is proved.

Exit status: 0 proved, 1 refused, 2 a file cannot be read.
"""

import sys
from pathlib import Path

from cutgap.formulations.certificate.checker import verify
from cutgap.formulations.certificate.reading import MAX_CHARACTERS, Refused


def main(arguments: list[str]) -> int:
    """Verify and return the exit status."""
    if len(arguments) != 2:
        print("usage: python -m cutgap.formulations.certificate CERTIFICATE INSTANCE", file=sys.stderr)
        return 2
    try:
        certificate, instance = (_read(Path(name)) for name in arguments)
    except (OSError, UnicodeDecodeError) as error:
        print(f"cannot read: {error}", file=sys.stderr)
        return 2
    try:
        print(verify(certificate, instance).text)
    except Refused as error:
        print(f"refused: {error}", file=sys.stderr)
        return 1
    return 0


def _read(path: Path) -> str:
    """Read one character more than is allowed, so that a longer file is refused and not loaded."""
    with path.open(encoding="utf-8") as file:
        return file.read(MAX_CHARACTERS + 1)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
