"""Every lesson runs; its checks accept the solutions, and say what is wrong with wrong answers."""

import ast
import re
from pathlib import Path

import numpy as np
import pytest

LESSONS = Path(__file__).resolve().parents[2] / "docs" / "lessons"
CELL = re.compile(r"^```\{code-cell\} python3\n((?::[^\n]*\n)*)(.*?)^```$", re.DOTALL | re.MULTILINE)

WRONG = {
    "one-pierce": [
        ("check_euler(lambda edges: odd_points(edges) == 0)", "lights the torch again"),
        ("check_euler(lambda edges: odd_points(edges) <= 2)", "no single stroke"),
        ("check_doubled(12.0)", "tree cut once"),
        ("check_doubled(32.0)", "three links"),
        ("check_bound(24.0)", "no bound"),
        ("check_bound(12.0)", "weak"),
    ],
    "why-bounds": [
        ("check_work(12.0)", "t_aux"),
        ("check_work(13.0)", "each hole"),
        ("check_travel(lambda order: travel(order) - float(np.hypot(*places[order[-1]])))", "way home"),
        ("check_travel(lambda order: 2 * travel(order))", "too large"),
        ("check_bound(best + 1)", "no bound"),
        ("check_bound(199.0)", "weak"),
    ],
    "held-karp": [
        ("check_tree(plain - 24)", "edges at node 0"),
        ("check_tree(plain - 14)", "second edge"),
        ("check_prices([0] * 6)", "weak"),
        ("check_checker(lambda prices, claimed: True)", "believes too much"),
        ("check_checker(lambda prices, claimed: claimed == bound_of(prices))", "refuses a proof"),
    ],
    "subtours": [
        ("check_positions(lambda n: [])", "let through"),
        ("check_positions(around)", "cut off a feasible plan"),
        ("check_strong(lambda n: sets(n)[: (n - 1) * (n - 2) // 2])", "let through"),
        ("check_strong(positions)", "weak"),
        ("check_count(2**40)", "empty set"),
        ("check_count(780)", "pairs"),
    ],
}
"""Wrong answers by lesson, and what the check has to say of them."""


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
    for answer, words in WRONG[lesson]:
        verdict = run(answer, names)
        assert not verdict.right, answer
        assert re.search(words, verdict.why), (answer, verdict.why)


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
