"""The Python code on every page of ``docs`` runs, and prints what the page shows."""

import doctest
import re
from pathlib import Path

import pytest

PAGES = sorted((Path(__file__).resolve().parents[2] / "docs").glob("*.md"))
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize("page", PAGES, ids=[page.stem for page in PAGES])
def test_the_code_of_a_page_runs(page, tmp_path, monkeypatch):
    """Blocks share one namespace; those with prompts are compared with the output that they show."""
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": page.stem}
    text = page.read_text(encoding="utf-8")
    for block in BLOCK.finditer(text):
        line = text[: block.start(1)].count("\n")
        if ">>> " in block[1]:
            names = checked(block[1], names, page, line)
        else:
            # Empty lines in front make tracebacks name the line of the page.
            exec(compile("\n" * line + block[1], page.name, "exec"), names)


def checked(code, names, page, line):
    """Run a block with prompts and return the names after it; fail where the output differs."""
    test = doctest.DocTestParser().get_doctest(code, names, page.stem, page.name, line)
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    report = []
    runner.run(test, out=report.append, clear_globs=False)
    assert runner.failures == 0, "".join(report)
    return test.globs


def test_there_are_pages_with_code():
    assert any(BLOCK.search(page.read_text(encoding="utf-8")) for page in PAGES)


def test_a_wrong_output_is_noticed(tmp_path):
    with pytest.raises(AssertionError, match="Expected"):
        checked(">>> 1 + 1\n3\n", {}, tmp_path / "page.md", 0)
