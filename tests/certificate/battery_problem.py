"""Checks of entry points, precedence, parts and matrices: the problem, and plans for it."""

from dataclasses import asdict, replace
from itertools import permutations, product
from typing import Any

import numpy as np
import pytest

from certificate.battery import battery
from certificate.samples import document_of, instance_of
from cutgap.instances import Contour, Head, Instance, Machine, Plan, Rules, Visit, check, evaluate

RULES = (
    Rules(),
    Rules("travel", parts_in_one_go=True),
    Rules("travel", backward_price=0.75),
    Rules("weighted", weight=2.0, via_points=True, parts_in_one_go=True, backward_price=2.5),
)


def parted(instance: Instance) -> Instance:
    """The instance with contours 0 and 2 in one part, and one that is called like a number."""
    parts = ("1", None, "1", "")
    contours = zip(instance.contours, parts, strict=False)
    return replace(instance, contours=tuple(replace(contour, part=part) for contour, part in contours))


def instances() -> list[Instance]:
    metrics = ("euclidean", "matrix", "chebyshev", "matrix")
    drawn = []
    for seed, metric in enumerate(metrics):
        options: dict[str, Any] = {"homes": seed > 1, "metric": metric, "precedence": 0.2 * (seed % 2)}
        drawn.append(parted(instance_of(seed, 4, "uniform", heads=1, entries=2, **options)))
    return drawn


@battery
def plans_with_entry_points_are_checked_and_valued(api: Any) -> None:
    seen = {True: 0, False: 0}
    for instance, rules in product(instances(), RULES):
        problem = api.problem_of(document_of(instance))
        exact = api.rules_of(asdict(rules), problem)
        sizes = [range(len(contour.entry_points)) for contour in instance.contours]
        for order, entries in product(permutations(range(4)), product(*sizes)):
            plan = Plan((tuple(Visit(contour, entries[contour]) for contour in order),))
            tours = [[[problem.ids[contour], entry] for contour, entry, *_ in tour] for tour in plan.tours]
            allowed = not check(instance, rules, plan)
            seen[allowed] += 1
            if not allowed:
                with pytest.raises(api.Refused, match="plan"):
                    api.plan.plan_value(problem, exact, tours)
                continue
            value = float(api.plan.plan_value(problem, exact, tours))
            assert value == pytest.approx(evaluate(instance, plan).objective(rules), rel=1e-12, abs=1e-12)
    assert min(seen.values()) > 100


@battery
def precedence_between_heads_is_not_valued(api: Any) -> None:
    places = [np.array([[x, 0.0, 0.0]]) for x in range(4)]
    contours = tuple(Contour(f"c{i}", place, 1.0) for i, place in enumerate(places))
    heads = (Head("l", np.zeros(3)), Head("r", np.zeros(3)))
    instance = Instance("line", contours, heads, Machine(), ((0, 1),))
    problem = api.problem_of(document_of(instance))
    rules = api.rules_of(asdict(Rules(non_overlap=None)), problem)
    assert api.plan.plan_value(problem, rules, [[["c0", 0], ["c1", 0]], [["c2", 0], ["c3", 0]]]) > 0
    with pytest.raises(api.Refused, match="precedence between two heads"):
        api.plan.plan_value(problem, rules, [[["c0", 0], ["c2", 0]], [["c1", 0], ["c3", 0]]])


@battery
def detours_of_a_matrix_are_tried_both_ways(api: Any) -> None:
    rng = np.random.default_rng(6)
    seen = {True: 0, False: 0}
    for number in range(200):
        instance = instance_of(number, 3, "uniform", heads=1, metric="matrix")
        matrix = rng.integers(5, 10 + number % 8, (4, 4)).astype(float)
        instance = replace(instance, matrix=matrix)
        problem = api.problem_of(document_of(instance))
        given = instance.rapids
        metric = all(given[u, v] <= given[u, w] + given[w, v] for u, v, w in product(range(4), repeat=3))
        seen[metric] += 1
        assert problem.is_metric() == metric
        assert problem.is_symmetric() == (given == given.T).all()
    assert min(seen.values()) > 20
