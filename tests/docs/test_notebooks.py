"""Lessons as notebooks: what the site folds is folded, and answers are not overwritten."""

import runpy
from pathlib import Path

import nbformat
import pytest

LESSONS = Path(__file__).resolve().parents[2] / "docs" / "lessons"
main = runpy.run_path(str(LESSONS / "notebooks.py"))["main"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("lessons")
    main(made)
    return made


def test_each_lesson_is_a_notebook_with_all_its_cells(folder):
    names = {path.stem for path in LESSONS.glob("*.md")} - {"index"}
    assert {path.stem for path in folder.iterdir()} == names
    for name in names:
        text = (LESSONS / f"{name}.md").read_text(encoding="utf-8")
        cells = nbformat.read(folder / f"{name}.ipynb", as_version=4).cells
        code = [cell for cell in cells if cell.cell_type == "code"]
        assert len(code) == text.count("\n```{code-cell} python3\n")
        for cell in code:
            folded = {"hide-input", "hide-cell", "remove-cell"} & set(cell.metadata.get("tags", ()))
            assert bool(folded) == cell.metadata.get("jupyter", {}).get("source_hidden", False)


def test_a_notebook_with_answers_stays(folder, capsys):
    place = folder / "subtours.ipynb"
    place.write_text("mine", encoding="utf-8")
    main(folder)
    assert place.read_text(encoding="utf-8") == "mine"
    assert "subtours.ipynb is there already" in capsys.readouterr().out
