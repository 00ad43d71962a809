"""Reading files that nobody vouches for, and writing so that nothing already written is lost."""

import os
from pathlib import Path
from uuid import uuid4

SIZE_LIMIT = 64 * 1024 * 1024
"""Largest file in bytes that is read or written: beyond it a text needs gigabytes once parsed."""


def read_bytes(path: Path) -> bytes:
    """Return the content of a file.

    Raises
    ------
    ValueError
        When the file cannot be opened or is larger than ``SIZE_LIMIT``.
    """
    try:
        with path.open("rb") as file:
            # One byte more than allowed: a size asked beforehand is 0 for pipes and may grow since.
            content = file.read(SIZE_LIMIT + 1)
    except OSError as error:
        raise ValueError(f"{path}: cannot be read: {error.strerror or error}") from error
    if len(content) > SIZE_LIMIT:
        raise ValueError(f"{path}: larger than {SIZE_LIMIT >> 20} MiB; split the job into smaller instances")
    return content


def read_text(path: Path) -> str:
    """Return the text of a UTF-8 file (a byte order mark is dropped).

    Raises
    ------
    ValueError
        As ``read_bytes``, and when the file is not UTF-8.
    """
    content = read_bytes(path)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(
            f"{path}: not UTF-8 text: byte 0x{content[error.start]:02x} at offset {error.start}; "
            "save the file as UTF-8"
        ) from error


def write_atomically(path: str | Path, content: str | bytes) -> None:
    """Replace a file as a whole: after a crash it holds either the old content or the new.

    The content goes to a new file in the same folder, is forced to disk, and takes the old one's name.

    Raises
    ------
    OSError
        When the folder does not exist or cannot be written; the old file is then untouched.
    """
    target = Path(os.path.realpath(path))
    data = content.encode("utf-8") if isinstance(content, str) else content
    temporary = target.with_name(f".{uuid4().hex}.tmp")
    try:
        with temporary.open("xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        if target.exists():
            temporary.chmod(target.stat().st_mode & 0o777)
        temporary.replace(target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    _sync_folder(target.parent)


def _sync_folder(folder: Path) -> None:
    """Force the new name to disk, where the system lets a folder be opened."""
    if not hasattr(os, "O_DIRECTORY"):
        return
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
