"""The page of models holds every model that the code states."""

import ast
import re
import runpy
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
with_models = runpy.run_path(str(ROOT / "docs" / "modelling.py"))["with_models"]


def test_each_model_of_the_code_is_on_the_page_once():
    page = with_models((ROOT / "docs" / "models.md").read_text(encoding="utf-8"))
    headings = re.findall(r"^### cutgap\.(\S+)$", page, re.MULTILINE)
    stated = []
    for folder in ("instances", "formulations", "heuristics"):
        for file in (ROOT / folder).rglob("*.py"):
            place = file.relative_to(ROOT)
            if {"formats", "generate", "suites"} & set(place.parts):  # about files and parts, no models
                continue
            docstring = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
            if any(line.startswith("    ") for line in docstring.splitlines()):
                stated.append(".".join(place.with_suffix("").parts).removesuffix(".__init__"))
                assert docstring in page
    assert sorted(headings) == sorted(stated)
