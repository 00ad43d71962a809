"""JSON of unknown origin, parsed strictly: errors are ``ValueError`` that name field path and value."""

import json
import re
import reprlib
from collections.abc import Iterable
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

Model = TypeVar("Model", bound=BaseModel)

# Doubles hold whole numbers of 15 digits exactly; longer ones can only be meant as floats.
_LONGEST_INT = 15


def parse_json(text: str, model: type[Model], format_name: str) -> Model:
    """Return the model that a JSON text of a format of ours describes.

    Raises
    ------
    ValueError
        When the text is no JSON, of another format or version, or does not fit the model.
    """
    return fit_format(load_json(text), model, format_name)


def load_json(text: str) -> Any:
    """Return the content of a JSON text.

    Python's parser takes NaN, Infinity, 1e999 and repeated keys; here the first three become
    non-finite floats, which the models refuse with their place, and repeated keys are refused.

    Raises
    ------
    ValueError
        When the text is no JSON.
    """
    repeated: list[tuple[dict[str, Any], str]] = []

    def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        table = dict(pairs)
        if len(table) < len(pairs):
            keys = [key for key, _ in pairs]
            repeated.append((table, next(key for key in keys if keys.count(key) > 1)))
        return table

    try:
        document = json.loads(text, object_pairs_hook=unique, parse_int=_whole, parse_constant=float)
    except RecursionError:
        raise ValueError("nested too deeply to be a cutgap file") from None
    except json.JSONDecodeError as error:
        raise ValueError(
            f"line {error.lineno}, column {error.colno}: not JSON ({error.msg}); is the file complete?"
        ) from error
    if repeated:
        table, key = repeated[0]
        place = _join([*(_find(document, table) or ()), key])
        raise ValueError(f"{place}: the key appears more than once; keep one")
    return document


def fit_format(document: Any, model: type[Model], format_name: str) -> Model:
    """Return the model that the content of a JSON file of ours describes; errors as for ``parse_json``."""
    _check_format(document, format_name)
    return fit(document, model)


def fit(document: Any, model: type[Model]) -> Model:
    """Return the model that the content of a JSON file describes; errors name field path and value."""
    try:
        return model.model_validate(document)
    except ValidationError as error:
        raise ValueError(_first_error(error)) from None


def _whole(digits: str) -> int | float:
    return int(digits) if len(digits) <= _LONGEST_INT else float(digits)


def _check_format(document: Any, format_name: str) -> None:
    """Say what kind of file it is before complaining about its fields."""
    if not isinstance(document, dict):
        raise ValueError(f"expected a JSON object with format {format_name!r}, got {_show(document)}")
    if document.get("format") != format_name:
        raise ValueError(f"format: expected {format_name!r}, got {_show(document.get('format'))}")
    version = document.get("version")
    if type(version) is not int or version != 1:
        hint = "; a newer cutgap reads it" if type(version) is int and version > 1 else ""
        raise ValueError(f"version: expected 1, got {_show(version)}{hint}")


def _first_error(error: ValidationError) -> str:
    first = error.errors(include_url=False, include_context=False)[0]
    if first["type"].startswith("recursion"):
        return "nested too deeply to be a cutgap file"
    place = _join(first["loc"]) or "a key"
    if first["type"] == "missing":
        return f"{place}: missing; add it"
    if first["type"] == "extra_forbidden":
        return f"{place}: unknown field; remove it or correct its name"
    message = first["msg"].removeprefix("Input should be ")
    return f"{place}: expected {message}, got {_show(first['input'])}"


def _join(path: Any) -> str:
    """Return a field path such as ``contours[3].entry_points[0]``."""
    text = ""
    for step in path:
        name = step if re.fullmatch(r"\w{1,60}", str(step), re.ASCII) else _show(step)
        text += f"[{step}]" if isinstance(step, int) else f".{name}"
    return text.removeprefix(".")


def _find(node: Any, target: object) -> list[str | int] | None:
    """Return the path to an object inside a document, found by identity."""
    stack: list[tuple[Any, list[str | int]]] = [(node, [])]
    while stack:
        found, path = stack.pop()
        if found is target:
            return path
        items: Iterable[tuple[str | int, Any]] = enumerate(found) if isinstance(found, list) else found.items()
        stack += [(child, [*path, step]) for step, child in items if isinstance(child, dict | list)]
    return None


def _show(value: Any) -> str:
    return reprlib.repr(value)
