"""Every lesson runs; its checks accept the solutions, and say what is wrong with wrong answers."""

import ast
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

LESSONS = Path(__file__).resolve().parents[2] / "docs" / "lessons"
CELL = re.compile(r"^```\{code-cell\} python3\n((?::[^\n]*\n)*)(.*?)^```$", re.DOTALL | re.MULTILINE)

WRONG = {
    path.stem: tomllib.loads(path.read_text(encoding="utf-8"))["wrong"]
    for path in (Path(__file__).parent / "wrong_answers").glob("*.toml")
}
"""By lesson: wrong answers, as calls of its checks, and what the check says of them."""


def run(code, names):
    """Run a cell like a notebook does and return the value of its last expression."""
    body = ast.parse(code).body
    last = body.pop() if body and isinstance(body[-1], ast.Expr) else None
    exec(compile(ast.Module(body, []), "cell", "exec"), names)
    return None if last is None else eval(compile(ast.Expression(last.value), "cell", "eval"), names)


@pytest.mark.parametrize("lesson", sorted(WRONG))
def test_a_lesson_accepts_its_solutions_and_rejects_wrong_answers(lesson, monkeypatch):
    monkeypatch.chdir(LESSONS)
    monkeypatch.syspath_prepend(str(LESSONS))
    names = {"__name__": lesson}
    solutions = []
    for tags, code in CELL.findall((LESSONS / f"{lesson}.md").read_text(encoding="utf-8")):
        value = run(code, names)
        if "solution" in tags:
            solutions.append(value)
    assert solutions
    assert all(verdict.right for verdict in solutions), solutions
    for wrong in WRONG[lesson]:
        verdict = run(wrong["answer"], names)
        assert not verdict.right, wrong
        assert wrong["says"] in verdict.why, (wrong, verdict.why)


def test_every_lesson_is_tested():
    lessons = {path.stem for path in LESSONS.glob("*.md")} - {"index"}
    assert lessons == set(WRONG)
    assert all(len(answers) >= 2 for answers in WRONG.values())


def test_a_check_without_an_answer_is_not_right(monkeypatch):
    monkeypatch.syspath_prepend(str(LESSONS))
    import checking

    assert not checking.number(None, 1.0, within=0.1).right
    assert not checking.bound(None, 1.0, at_least=0.0).right
    assert not checking.predicate(None, [], bool).right
    assert not checking.subtour_rows(None, lengths=np.zeros((3, 3)), at_least=0.0).right


def test_an_error_inside_an_answer_is_kept_and_says_with_what_it_was_called(monkeypatch):
    monkeypatch.syspath_prepend(str(LESSONS))
    import checking

    @checking.tried
    def check_half(half):
        return checking.number(half(0), 0.0, within=0.1)

    with pytest.raises(ZeroDivisionError) as caught:
        check_half(lambda x: 1 / x)
    assert caught.value.__notes__ == ["The check called the answer with 0."]
    assert "for 0 it returned 'none'" in check_half(lambda x: "none").why
    assert "for 0 it returned nothing" in check_half(lambda x: None).why
    assert "for 0 it returned nan" in check_half(lambda x: float("nan")).why
    assert not checking.bound(float("nan"), 1.0, at_least=0.0).right
    assert check_half(lambda x: x / 2).right
