"""The models that the docstrings of modules state, as text for a page."""

import ast
import re
from importlib.util import find_spec
from pathlib import Path

PLACE = re.compile(r"^\{models\} (\S+)$", re.MULTILINE)
FORMULA = re.compile(r"^    \S", re.MULTILINE)
"""What is set in from the margin: a docstring that has it states a model."""


def with_models(text: str) -> str:
    """Return a page in which each line ``{models} PACKAGE`` is replaced by the models of this package."""
    return PLACE.sub(lambda place: "\n\n".join(models_of(place[1])), text)


def states_model(docstring: str) -> bool:
    """Return whether a docstring states a model."""
    return FORMULA.search(docstring) is not None


def models_of(package: str) -> list[str]:
    """Return a section for each module of a package, without those below, that states a model.

    Raises
    ------
    ValueError
        When there is none.
    """
    spec = find_spec(package)
    folders = [] if spec is None else spec.submodule_search_locations or []
    files = sorted(file for folder in folders for file in Path(folder).glob("*.py"))
    sections = []
    for file in files:
        docstring = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
        if states_model(docstring):
            name = package if file.stem == "__init__" else f"{package}.{file.stem}"
            sections.append(f"### {name}\n\n```text\n{docstring}\n```")
    if not sections:
        raise ValueError(f"{package}: no docstring of a module states a model")
    return sections
