"""Checks of a student's answers; a wrong one is told why, on a small instance where all plans can be listed.

A model is wrong in one of three ways: it cuts off a feasible plan, it lets through what is no plan, or it is
valid but weak. A bound is wrong in two: it exceeds the value of a plan, or it is weak.
"""

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import wraps
from itertools import permutations
from math import isnan
from typing import Any, TypeVar

import numpy as np
from scipy.optimize import linprog

Case = TypeVar("Case")
SLACK = 1e-6


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether an answer is right, and why not."""

    right: bool
    why: str

    def __str__(self) -> str:
        return f"{'Right' if self.right else 'Not yet'}: {self.why}"

    __repr__ = __str__


NO_ANSWER = Verdict(False, "there is no answer yet")


def tried(check: Callable[[Any], Verdict]) -> Callable[[Any], Verdict]:
    """Let a check of a function tell what it was called with, when it fails or returns what is no answer."""

    @wraps(check)
    def judge(answer: Any) -> Verdict:
        if not callable(answer):
            return check(answer)
        own: list[Exception] = []
        last: list[Any] = []

        def watched(*given: Any) -> Any:
            try:
                said = answer(*given)
            except Exception as error:
                if not own:
                    error.add_note(f"The check called the answer with {_shown(given)}.")
                own.append(error)
                raise
            last[:] = [given, said]
            if isinstance(said, float) and isnan(said):  # no comparison would find it wrong
                raise ArithmeticError("not a number")
            return said

        try:
            verdict = check(watched)
            if last and last[1] is None and NO_ANSWER.why in verdict.why:
                return Verdict(False, f"for {_shown(last[0])} it returned nothing: is there a `return`?")
            return verdict
        except Exception as error:
            if error in own or not last:
                raise
            why = f"for {_shown(last[0])} it returned {_shown(last[1])}, which is no answer: {error}"
            return Verdict(False, why)

    return judge


def _shown(value: Any, most: int = 300) -> str:
    text = ", ".join(map(repr, value)) if isinstance(value, tuple) else repr(value)
    text = " ".join(text.split())
    return text if len(text) <= most else f"{text[:most]} ..."


@dataclass(frozen=True, slots=True)
class Row:
    """The constraint ``sum of terms[name] * variable[name] >= at_least``.

    ``("x", i, j)`` is the arc from i to j, which is 0 or 1; any other name is a free variable of its own.
    """

    terms: Mapping[Hashable, float]
    at_least: float
    name: str = field(default="a row")


def number(
    answer: float | None, truth: float, *, within: float, mistakes: Mapping[float, str] | None = None
) -> Verdict:
    """Check a number; ``mistakes`` says what leads to which wrong value."""
    if answer is None:
        return NO_ANSWER
    if abs(answer - truth) <= within:
        return Verdict(True, _figure(truth))
    for wrong, why in (mistakes or {}).items():
        if abs(answer - wrong) <= within:
            return Verdict(False, why)
    return Verdict(False, f"{float(answer):g} is too {'large' if answer > truth else 'small'}")


def bound(answer: float | None, optimum: float, *, at_least: float) -> Verdict:
    """Check a lower bound against the optimum and the bound that was asked for."""
    if answer is None:
        return NO_ANSWER
    if not answer <= optimum + SLACK:
        return Verdict(False, f"no bound: it says {float(answer):.3f}, and there is a plan of {optimum:.3f}")
    if answer < at_least - SLACK:
        return Verdict(False, f"valid but weak: {float(answer):.3f}, where {at_least:.3f} can be had")
    return Verdict(True, f"a bound of {float(answer):.3f}")


def predicate(
    answer: Callable[[Case], bool] | None,
    cases: Iterable[Case],
    truth: Callable[[Case], bool],
    *,
    missed: str = "it cuts off a feasible plan",
    passed: str = "it lets through what is no plan",
) -> Verdict:
    """Check a test of what is allowed against the truth, on each of the cases."""
    if answer is None:
        return NO_ANSWER
    count = 0
    for case in cases:
        said, true = bool(answer(case)), truth(case)
        count += 1
        if true and not said:
            return Verdict(False, f"{missed}: {case}")
        if said and not true:
            return Verdict(False, f"{passed}: {case}")
    return Verdict(True, f"agrees with all {count} cases")


def subtour_rows(
    rows: Callable[[int], Sequence[Row]] | None, *, lengths: np.ndarray, at_least: float, nodes: int = 5
) -> Verdict:
    """Check rows against subtours, then by the bound of their LP.

    They are tried on all successors of ``nodes`` nodes, and on all tours of one node more.

    Parameters
    ----------
    rows
        Writes down the rows for nodes 0 to n - 1; each node is left and entered once anyhow.
    lengths
        Shape (n, n), where the bound is measured.
    at_least
        What the bound should reach.
    """
    if rows is None:
        return NO_ANSWER
    for count in (nodes, nodes + 1):
        written = list(rows(count))
        for successor in permutations(range(count)):
            if any(i == j for i, j in enumerate(successor)):
                continue
            fixed = {
                ("x", i, j): float(successor[i] == j) for i in range(count) for j in range(count) if i != j
            }
            tour = _cycle(successor)
            if len(tour) == count and _least(written, fixed, {}) is None:
                return Verdict(False, f"they cut off a feasible plan: the tour {_arrows(tour)}")
            if len(tour) < count == nodes and _least(written, fixed, {}) is not None:
                return Verdict(False, f"they let through what is no plan: the subtour {_arrows(tour)}")
    reached = assignment_bound(rows(len(lengths)), lengths)
    if reached < at_least - SLACK:
        return Verdict(False, f"valid but weak: their LP says {reached:.2f}, where {at_least:.2f} can be had")
    return Verdict(True, f"valid, and their LP says {reached:.2f}")


def assignment_bound(rows: Sequence[Row], lengths: np.ndarray) -> float:
    """Return the value of the LP: each node left and entered once, and the rows; inf when it is infeasible."""
    n = len(lengths)
    arcs = [(i, j) for i in range(n) for j in range(n) if i != j]
    degrees = [
        Row({("x", *arc): sign for arc in arcs if arc[end] == node}, sign, "degree")
        for node in range(n)
        for end in (0, 1)
        for sign in (1.0, -1.0)
    ]
    value = _least([*degrees, *rows], {}, {("x", i, j): float(lengths[i, j]) for i, j in arcs})
    return np.inf if value is None else value


def _least(
    rows: Sequence[Row], fixed: Mapping[Hashable, float], costs: Mapping[Hashable, float]
) -> float | None:
    """Return the least cost under the rows, ``None`` when there is no point."""
    names = list(dict.fromkeys([*fixed, *costs, *(name for row in rows for name in row.terms)]))
    place = {name: i for i, name in enumerate(names)}
    left = np.zeros((len(rows), len(names)))
    for i, row in enumerate(rows):
        for name, coefficient in row.terms.items():
            left[i, place[name]] += coefficient
    bounds: list[Any] = [(fixed[name], fixed[name]) if name in fixed else _range(name) for name in names]
    answer = linprog(
        [costs.get(name, 0.0) for name in names], -left, [-row.at_least for row in rows], bounds=bounds
    )
    return float(answer.fun) if answer.status == 0 else None


def _figure(value: float) -> str:
    return str(value) if isinstance(value, int) else f"{value:g}"


def _range(name: Hashable) -> tuple[float | None, float | None]:
    return (0.0, 1.0) if isinstance(name, tuple) and name[:1] == ("x",) else (None, None)


def _cycle(successor: Sequence[int]) -> list[int]:
    """Return the nodes of the cycle through node 0."""
    cycle = [0]
    while successor[cycle[-1]] != 0:
        cycle.append(successor[cycle[-1]])
    return cycle


def _arrows(cycle: Sequence[int]) -> str:
    return " -> ".join(map(str, [*cycle, cycle[0]]))
