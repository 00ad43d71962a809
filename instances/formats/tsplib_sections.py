"""The keyword-and-section layout that TSPLIB and its relatives (GTSPLIB, PCGTSP) share.

A file is a list of fields ``KEYWORD : value`` and of sections: a keyword alone on its line, then lines of
numbers up to the next keyword. Which keywords mean something is for the reader of each file type to say.

Source: Reinelt, TSPLIB 95 (1995), section 1.
"""

import re
from dataclasses import dataclass

_KEYWORD = re.compile(r"([A-Z][A-Z0-9_]*)\s*(:(.*))?", re.IGNORECASE)
_SECTION_ENDINGS = ("_SECTION", "_ORDERING")


@dataclass(frozen=True, slots=True)
class TsplibField:
    """A value of the specification part and its line."""

    line: int
    value: str


@dataclass(frozen=True, slots=True)
class TsplibSection:
    """A section: the line of its keyword, and its data lines as (line, words)."""

    line: int
    rows: tuple[tuple[int, tuple[str, ...]], ...]


@dataclass(frozen=True, slots=True)
class TsplibFile:
    """Fields and sections by keyword, in capitals."""

    fields: dict[str, TsplibField]
    sections: dict[str, TsplibSection]

    def choice(self, keyword: str, known: tuple[str, ...], default: str | None = None) -> str:
        """Return the value of a field that must be one of ``known``, in capitals."""
        if keyword not in self.fields:
            if default is not None:
                return default
            raise ValueError(f"{keyword}: the field is missing; add one of {', '.join(known)}")
        field = self.fields[keyword]
        # Some files put an author's name behind the value.
        value = field.value.upper().partition(" ")[0]
        if value not in known:
            raise ValueError(
                f"line {field.line}, {keyword}: expected one of {', '.join(known)}, got {field.value[:40]!r}"
            )
        return value

    def refuse_sections(self, known: tuple[str, ...]) -> None:
        """Refuse sections that would change the problem without being understood."""
        for keyword, section in self.sections.items():
            if keyword not in known:
                raise ValueError(f"line {section.line}, {keyword}: not known here; known: {', '.join(known)}")


def begins_with_field(text: str) -> bool:
    """Whether the first line that is not blank is a field ``KEYWORD : value``."""
    match = _KEYWORD.match(text.lstrip())
    return match is not None and match[2] is not None


def parse_sections(text: str) -> TsplibFile:
    """Split a text into fields and sections; lines after ``EOF`` are not read.

    Raises
    ------
    ValueError
        Naming line and content: a line that is neither, or a keyword that appears twice.
    """
    fields: dict[str, TsplibField] = {}
    sections: dict[str, tuple[int, list[tuple[int, tuple[str, ...]]]]] = {}
    rows: list[tuple[int, tuple[str, ...]]] | None = None
    for line, raw in enumerate(text.splitlines(), start=1):
        row = raw.strip()
        if not row:
            continue
        if row.upper() == "EOF":
            break
        match = _KEYWORD.fullmatch(row)
        if match is None and rows is not None:
            rows.append((line, tuple(row.split())))
            continue
        if match is None:
            raise ValueError(f"line {line}: expected KEYWORD : value or a section, got {row[:40]!r}")
        keyword = match[1].upper()
        # Comments may be spread over several fields of the same name.
        if keyword in sections or (keyword in fields and keyword != "COMMENT"):
            raise ValueError(f"line {line}, {keyword}: appears more than once")
        if keyword.endswith(_SECTION_ENDINGS) and not (match[3] or "").strip():
            rows = []
            sections[keyword] = (line, rows)
        elif match[2] is not None:
            rows = None
            fields[keyword] = TsplibField(line, match[3].strip())
        else:
            raise ValueError(f"line {line}: expected KEYWORD : value or a section, got {row[:40]!r}")
    closed = {keyword: TsplibSection(line, tuple(rows)) for keyword, (line, rows) in sections.items()}
    return TsplibFile(fields, closed)
