"""JSON of unknown origin, read exactly and within limits; whatever is wrong is ``Refused`` with its place.

Numbers with a point or exponent become fractions of their decimal text, so 0.1 is one tenth.
"""

import json
import math
from fractions import Fraction
from typing import Any

MAX_CHARACTERS = 40_000_000
"""Longest document."""
MAX_DIGITS = 64
"""Longest text of one number."""
MAX_EXPONENT = 60
"""Largest power of ten, up or down; ``Fraction("1e1000000")`` eats memory."""


class Refused(ValueError):  # noqa: N818, it is a verdict
    """The certificate proves nothing: what is wrong, and where."""


def require(condition: bool, message: str) -> None:
    """Raise ``Refused`` unless the condition holds."""
    if not condition:
        raise Refused(message)


def read_document(text: str) -> dict[str, Any]:
    """Return the JSON object in a text; refuses what is too long, too deep, repeated, or no number."""
    require(len(text) <= MAX_CHARACTERS, f"longer than {MAX_CHARACTERS} characters")
    try:
        document = json.loads(
            text, parse_int=_integer, parse_float=_decimal, parse_constant=_constant, object_pairs_hook=_unique
        )
    except RecursionError:
        raise Refused("nested too deeply") from None
    except json.JSONDecodeError as error:
        raise Refused(f"not JSON: {error.msg}, line {error.lineno}; is the file complete?") from None
    require(isinstance(document, dict), f"expected a JSON object, got {show(document)}")
    return dict(document)


def _integer(digits: str) -> int:
    require(len(digits) <= MAX_DIGITS, f"a number of more than {MAX_DIGITS} digits: {digits[:20]}...")
    return int(digits)


def _decimal(text: str) -> Fraction:
    require(len(text) <= MAX_DIGITS, f"a number of more than {MAX_DIGITS} digits: {text[:20]}...")
    exponent = int(text.lower().partition("e")[2] or 0)
    require(abs(exponent) <= MAX_EXPONENT, f"the number {text} is out of range")
    return Fraction(text)


def _constant(name: str) -> Any:
    raise Refused(f"{name} is no number")


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    require(len(table) == len(pairs), f"a key appears more than once among {show([key for key, _ in pairs])}")
    return table


def show(value: Any) -> str:
    """Return a short text of any value, safe to print."""
    if isinstance(value, list | dict):
        return f"a {type(value).__name__} of {len(value)}"
    if isinstance(value, int) and abs(value) >= 10**60:
        return f"a number of {value.bit_length()} bits"
    text = ascii(value[:60]) if isinstance(value, str) else str(value)
    return text if len(text) <= 60 else text[:57] + "..."


def fields(table: Any, where: str, needed: str, optional: str = "") -> dict[str, Any]:
    """Return an object that has all needed fields and no unknown ones (names separated by blanks)."""
    require(isinstance(table, dict), f"{where}: expected an object, got {show(table)}")
    for name in needed.split():
        require(name in table, f"{where}: the field {name} is missing")
    unknown = set(table) - {*needed.split(), *optional.split()}
    require(not unknown, f"{where}: unknown field {show(min(unknown, default=''))}")
    return dict(table)


def entries(value: Any, where: str, count: int | None = None) -> list[Any]:
    """Return a list, of ``count`` entries if that is given."""
    require(isinstance(value, list), f"{where}: expected a list, got {show(value)}")
    require(count is None or len(value) == count, f"{where}: expected {count} entries, got {len(value)}")
    return list(value)


def text_of(value: Any, where: str) -> str:
    """Return a text that is not empty."""
    require(isinstance(value, str) and value != "", f"{where}: expected a text, got {show(value)}")
    return str(value)


def flag(value: Any, where: str) -> bool:
    """Return true or false."""
    require(isinstance(value, bool), f"{where}: expected true or false, got {show(value)}")
    return bool(value)


def integer(value: Any, where: str, least: int | None = None) -> int:
    """Return a whole number."""
    require(type(value) is int, f"{where}: expected a whole number, got {show(value)}")
    require(least is None or value >= least, f"{where}: expected at least {least}, got {show(value)}")
    return int(value)


def number(value: Any, where: str, least: int | None = None) -> Fraction:
    """Return a number as a fraction; a float (of a document made in Python) counts by its shortest text."""
    if isinstance(value, float):
        require(math.isfinite(value), f"{where}: {value} is no number")
        value = _decimal(float.__repr__(value))
    is_number = isinstance(value, int | Fraction) and not isinstance(value, bool)
    require(is_number, f"{where}: expected a number, got {show(value)}")
    require(least is None or value >= least, f"{where}: expected at least {least}, got {show(value)}")
    return Fraction(value)


def decimal(value: Fraction, digits: int, up: bool = False) -> str:
    """Return a decimal text, rounded down or up."""
    scaled = value * 10**digits
    whole = -(-scaled.numerator // scaled.denominator) if up else scaled.numerator // scaled.denominator
    sign, whole = "-" if whole < 0 else "", abs(whole)
    return f"{sign}{whole // 10**digits}.{whole % 10**digits:0{digits}d}"
