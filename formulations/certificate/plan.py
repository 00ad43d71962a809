"""A plan checked and valued exactly: whether the rules allow it, and what it is worth at most.

Lengths are irrational, so they are known between a floor and a ceiling at a fine scale, at which all rational
lengths are exact. Times are as irrational, so precedence between two heads is refused; so are rules on curves.
"""

from collections import Counter
from fractions import Fraction
from itertools import groupby, pairwise
from typing import Any

from cutgap.formulations.certificate.curves import Curves
from cutgap.formulations.certificate.free_plan import pinned
from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.proof import Budget
from cutgap.formulations.certificate.reading import entries, integer, require, show
from cutgap.formulations.certificate.rules import Rules, may_rest

FINE = 10**15
"""Lengths of a plan are known to 1 / FINE mm or better."""

Leg = tuple[int, int]
Visit = tuple[int, int]
"""A contour and the node of its entry point."""


def plan_value(problem: Problem, rules: Rules, value: Any) -> Fraction:
    """Return an upper bound on the objective of an allowed plan, s or mm; refuses plans that break a rule."""
    if rules.free_entries:
        require(
            not (rules.neighbours_only or rules.clear_rapids), "plan: free entries go with no rule on curves"
        )
        problem, value = pinned(problem, value)
    visits = _visits(problem, value)
    _check_order(problem, rules, visits)
    cap = rules.temperature_cap
    require(cap is None and rules.objective != "peak", "plan: temperatures are not checked here: leave it out")
    if rules.neighbours_only or rules.clear_rapids:
        require(len(visits) == 1, "plan: rules on curves are not checked for two heads here: leave it out")
        _check_curves(problem, rules, visits[0])
    tours = [[node for _, node in tour] for tour in visits]
    _check_places(problem, rules, tours)
    legs = [_legs(problem, head, tour) for head, tour in enumerate(tours)]
    seconds = [sum((problem.seconds[contour] for contour, _ in tour), Fraction(0)) for tour in visits]
    travel = [_between(problem, Counter(each))[1] for each in legs]
    if rules.objective == "makespan" and rules.balance is None:
        imbalance = Fraction(0)
    else:
        imbalance = _imbalance(problem, legs, seconds)
    require(rules.balance is None or imbalance <= rules.balance, "plan: the heads are not balanced")
    if rules.objective == "makespan":
        return max(length / problem.v_jump + work for length, work in zip(travel, seconds, strict=True))
    backward = rules.backward_price * _backward(problem, tours)
    return sum(travel, Fraction(0)) + rules.weight * imbalance + backward


def _visits(problem: Problem, value: Any) -> list[list[Visit]]:
    numbers = {name: number for number, name in enumerate(problem.ids)}
    tours: list[list[Visit]] = []
    for tour in entries(value, "plan", count=len(problem.homes)):
        tours.append([])
        for visit in entries(tour, "plan, tour"):
            name, entry = entries(visit, "plan, visit", count=2)
            require(isinstance(name, str) and name in numbers, f"plan: no contour {show(name)}")
            nodes = problem.entries[numbers[name]]
            known = integer(entry, "plan, entry", least=0) < len(nodes)
            require(known, f"plan: contour {show(name)} has no entry point {show(entry)}")
            tours[-1].append((numbers[name], nodes[entry]))
    cut = sorted(contour for tour in tours for contour, _ in tour)
    require(cut == list(range(len(problem.ids))), "plan: it must cut each contour once")
    return tours


def _check_order(problem: Problem, rules: Rules, tours: list[list[Visit]]) -> None:
    """Check the rules on the order of contours."""
    turns = {contour: (head, turn) for head, tour in enumerate(tours) for turn, (contour, _) in enumerate(tour)}
    for before, after in problem.precedence:
        one_head = turns[before][0] == turns[after][0]
        require(one_head, "plan: precedence between two heads is not checked here: leave it out")
        name = problem.ids[after]
        require(turns[before] < turns[after], f"plan: contour {show(name)} is cut before its precedence allows")
    for tour in tours if rules.parts_in_one_go else []:
        begun = [part for part, _ in groupby(problem.parts[contour] for contour, _ in tour)]
        require(len(set(begun)) == len(begun), "plan: a part is not cut in one go")


def _check_curves(problem: Problem, rules: Rules, tour: list[Visit]) -> None:
    """Check neighbours only and clear rapids on one head, where the order says what is cut."""
    curves, cut = Curves(problem, Budget()), 0
    for (one, v), (other, w) in pairwise(tour):
        cut |= 1 << one
        names = f"{show(problem.ids[one])} to {show(problem.ids[other])}"
        clear = not rules.clear_rapids or curves.crossed(v, w) & cut == 0
        require(clear, f"plan: the rapid from {names} crosses what is cut")
        parts = problem.parts[one], problem.parts[other]
        near = not rules.neighbours_only or parts[0] == parts[1] or curves.neighbours(*parts)
        require(near, f"plan: the way from {names} is not to a neighbour")


def _check_places(problem: Problem, rules: Rules, tours: list[list[int]]) -> None:
    """Check the rules on who cuts what and what comes first."""
    working = [[problem.xs[each] for each in tour] for tour in tours if tour]
    require(len(working) == len(tours) or may_rest(problem, rules), "plan: a head has no work")
    for left, right in pairwise(working):
        apart = min(right) - max(left)
        require(rules.non_overlap is None or apart >= rules.non_overlap, "plan: the heads overlap")
    for xs in working:
        require(not rules.via_points or xs[0] == min(xs), "plan: a head does not start with a leftmost contour")


def _legs(problem: Problem, head: int, tour: list[int]) -> list[Leg]:
    home = problem.homes[head]
    stops = [*tour, *tour[:1]] if home is None or not tour else [home, *tour, home]
    return list(pairwise(stops))


def _backward(problem: Problem, tours: list[list[int]]) -> Fraction:
    """Return by how much rapids between contours go back in x, mm."""
    steps = (problem.xs[u] - problem.xs[v] for tour in tours for u, v in pairwise(tour))
    return sum((step for step in steps if step > 0), Fraction(0))


def _between(problem: Problem, legs: Counter[Leg]) -> tuple[Fraction, Fraction]:
    """Return bounds on the sum of lengths times (signed) counts, mm."""
    scale = problem.denominator * FINE
    low, high = 0, 0
    for (u, v), count in legs.items():
        least, most = problem.range_of(u, v, scale)
        low += count * (least if count > 0 else most)
        high += count * (most if count > 0 else least)
    return Fraction(low, scale), Fraction(high, scale)


def _imbalance(problem: Problem, legs: list[list[Leg]], seconds: list[Fraction]) -> Fraction:
    """Return an upper bound on |T_0 - T_1|, s; legs of one length on both sides cancel exactly."""
    if len(legs) == 1:
        return Fraction(0)
    samples: dict[Any, Leg] = {}
    difference: Counter[Leg] = Counter()
    for sign, side in zip((1, -1), legs, strict=True):
        for u, v in side:
            leg = samples.setdefault(problem.length_key(u, v), (u, v))
            difference[leg] += sign
    low, high = _between(problem, difference)
    work = seconds[0] - seconds[1]
    return max(high / problem.v_jump + work, -low / problem.v_jump - work)
