"""Numbers in text files, read strictly."""

import math
import re
from collections.abc import Sequence

# Python's float() also takes nan, infinity, 1_000 and digits of other scripts.
_DECIMAL = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
_DIGITS = re.compile(r"[-+.0-9eE]*")


def parse_number(text: str, place: str, *, least: float | None = None) -> float:
    """Return a finite decimal number.

    Raises
    ------
    ValueError
        Naming ``place`` and the text, when it is no finite decimal number or is below ``least``.
    """
    text = text.strip()
    if not _DECIMAL.fullmatch(text):
        hint = "; write decimals with a point" if re.fullmatch(r"[+-]?[0-9]+,[0-9]+", text) else ""
        raise ValueError(f"{place}: expected a finite decimal number, got {text[:40]!r}{hint}")
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"{place}: number too large: {text[:40]!r}")
    if least is not None and number < least:
        raise ValueError(f"{place}: expected a number of at least {least:g}, got {text[:40]!r}")
    return number


def parse_count(text: str, place: str) -> int:
    """Return a whole number of at least 1 and at most 18 digits; errors as for ``parse_number``."""
    text = text.strip()
    if not re.fullmatch(r"[0-9]{1,18}", text) or int(text) == 0:
        raise ValueError(f"{place}: expected a whole number of at least 1, got {text[:40]!r}")
    return int(text)


def parse_numbers(words: Sequence[str], place: str, *, least: float) -> list[float]:
    """Return many numbers as ``parse_number`` does, much faster while nothing is wrong."""
    # Of these characters alone float() makes the same numbers, and inf, but takes nothing else.
    if _DIGITS.fullmatch("".join(words)):
        try:
            numbers = [float(word) for word in words]
        except ValueError:
            numbers = [math.inf]
        if all(least <= number < math.inf for number in numbers):
            return numbers
    return [parse_number(word, place, least=least) for word in words]


def parse_integer(text: str, place: str) -> int:
    """Return a whole number of at most 18 digits, with or without a sign; errors as for ``parse_number``."""
    if not re.fullmatch(r"[+-]?[0-9]{1,18}", text):
        raise ValueError(f"{place}: expected a whole number, got {text[:40]!r}")
    return int(text)
