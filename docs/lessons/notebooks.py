"""Write the lessons as Jupyter notebooks beside their text; what the site folds away is folded there too."""

import sys
from pathlib import Path

import jupytext
import nbformat

LESSONS = Path(__file__).resolve().parent


def notebook(lesson: Path) -> nbformat.NotebookNode:
    """Return a lesson as a notebook whose checks and solutions are collapsed."""
    made = jupytext.read(lesson)
    for cell in made.cells:
        tags = cell.metadata.get("tags", ())
        if {"hide-input", "hide-cell", "remove-cell"} & set(tags):
            cell.metadata["jupyter"] = {"source_hidden": True, "outputs_hidden": "hide-input" not in tags}
    return made


def main(folder: Path = LESSONS) -> None:
    """Write all notebooks into a folder; one that is there, with a student's answers in it, stays."""
    for lesson in sorted(LESSONS.glob("*.md")):
        place = folder / lesson.with_suffix(".ipynb").name
        if lesson.stem == "index":
            continue
        if place.exists():
            print(f"{place.name} is there already: left as it is")
            continue
        nbformat.write(notebook(lesson), place)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
