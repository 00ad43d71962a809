"""Checks of whole certificates, plans and hashes."""

import copy
import json
import re
from dataclasses import asdict, replace
from fractions import Fraction
from itertools import product
from typing import Any

import pytest
from oracles.random_instances import LAYOUTS, Layout

from certificate.battery import battery
from certificate.forgeries import FORGERIES, PLANS
from certificate.forgeries_generalized import GENERALIZED
from certificate.plans import all_plans
from certificate.producer import MULTIPLIER_SCALE
from certificate.samples import (
    CASES,
    SCALE,
    WEIGHTED,
    document_of,
    instance_of,
    sample,
    symmetric,
)
from cutgap.formulations import certificate as real
from cutgap.instances import Rules


@battery
def samples_are_verified(api: Any) -> None:
    for name in CASES:
        made = sample(name)
        for pair in (
            (made.certificate, made.document),
            (json.dumps(made.certificate), json.dumps(made.document, indent=1)),
        ):
            verdict = api.verify(*pair, rules=made.certificate["rules"])
            assert (verdict.bound is None) == (made.optimum is None), name
            if verdict.bound is None:
                assert "infeasible" in verdict.text
                continue
            problem = real.problem_of(made.document)
            unit = SCALE * (problem.v_jump if verdict.unit == "s" else 1)
            # What floors of lengths and work, and rounded multipliers, may lose.
            assert made.optimum - 100 <= verdict.bound * unit <= made.optimum + 1e-5, name
            assert verdict.value * unit == pytest.approx(made.optimum, abs=1e-5)
            assert 0 <= verdict.gap < Fraction(1, 1000)


@battery
def samples_prove_no_more(api: Any) -> None:
    for name in CASES:
        made = sample(name)
        if made.optimum is not None:
            more = {**made.certificate, "bound": int(made.optimum) + 1, "plan": None}
            with pytest.raises(api.Refused):
                api.verify(more, made.document)


@battery
def leaves_count_to_the_last_unit(api: Any) -> None:
    made = copy.deepcopy(sample("tour"))
    tour = made.certificate["proof"]["tour"]
    problem = api.problem_of(made.document)
    relaxation = api.tour_relaxation(problem, 0, list(range(len(problem.ids))), False, SCALE, MULTIPLIER_SCALE)
    pairs = tour["nodes"][0].get("leaf") or tour["nodes"][0]["fix"]
    rows = [relaxation.row(name) for name in tour["rows"]]
    value, _ = api.leaf_value(relaxation, relaxation.start, [(rows[i], y) for i, y in pairs])
    worth = value // MULTIPLIER_SCALE
    tour |= {"nodes": [{"leaf": pairs}], "length": worth}
    assert api.verify({**made.certificate, "bound": worth}, made.document).bound * SCALE == worth
    tour["length"] = worth + 1
    with pytest.raises(api.Refused, match="worth"):
        api.verify({**made.certificate, "bound": worth + 1}, made.document)


@battery
def below_a_fixing_that_reaches_the_target_nothing_is_asked(api: Any) -> None:
    made = copy.deepcopy(sample("tour"))
    tour = made.certificate["proof"]["tour"]
    pairs = tour["nodes"][0].get("leaf") or tour["nodes"][0]["fix"]
    split = {"branch": ["x", 0, 1], "at": 0, "down": 2, "up": 3}
    tour["nodes"] = [{"fix": pairs, "then": 1}, split, {"leaf": []}, {"leaf": []}]
    tour["length"] = tour["length"] * 9 // 10  # low enough for the root alone
    certificate = {**made.certificate, "bound": tour["length"]}
    assert api.verify(certificate, made.document).bound is not None
    tour["nodes"][0] = {"fix": [], "then": 1}
    with pytest.raises(api.Refused, match=r"node [23]: .*worth"):
        api.verify(certificate, made.document)


@battery
def forgeries_are_refused(api: Any) -> None:
    generalized = ((f"gtsp: {name}", "gtsp", forge, message) for name, forge, message in GENERALIZED)
    for name, base, forge, message in (*FORGERIES, *generalized):
        made = copy.deepcopy(sample(base))
        forge(made.certificate, made.document)
        try:
            api.verify(made.certificate, made.document)
        except api.Refused as error:
            refusal = str(error)
        else:
            raise AssertionError(f"{name}: accepted")
        assert re.search(message, refusal), f"{name}: {refusal}"


@battery
def plans_are_checked(api: Any) -> None:
    for name, base, tours, rules, message in PLANS:
        made = copy.deepcopy(sample(base))
        problem = api.problem_of(made.document)
        exact = api.rules_of(made.certificate["rules"] | rules, problem)
        if message is None:
            assert api.plan.plan_value(problem, exact, tours(problem)) > 0, name
            continue
        with pytest.raises(api.Refused, match=message):
            api.plan.plan_value(problem, exact, tours(problem))


@battery
def plans_are_worth_what_the_library_says(api: Any) -> None:
    for seed, layout in enumerate(LAYOUTS):
        instance = instance_of(seed, 4, layout)
        problem = api.problem_of(document_of(instance))
        for rules in (Rules(), Rules(**WEIGHTED, non_overlap=None, via_points=True, empty_heads=True)):
            exact = api.rules_of(asdict(rules), problem)
            for plan, evaluation in list(all_plans(instance, rules))[::3]:
                tours = [[[problem.ids[c], entry] for c, entry, *_ in tour] for tour in plan.tours]
                value = api.plan.plan_value(problem, exact, tours)
                assert float(value) == pytest.approx(evaluation.objective(rules), rel=1e-12, abs=1e-12)


@battery
def equal_tours_balance_exactly(api: Any) -> None:
    # Irrational lengths, equal on both sides.
    contours = [
        {"id": name, "entry_points": [[x, y, 0]], "perimeter": 1}
        for name, x, y in (("a", 1, 0), ("b", 1, 1), ("c", 3, 0), ("d", 3, 1))
    ]
    document = {
        **sample("split").document,
        "contours": contours,
        "heads": [{"id": "l", "home": [0, 0.5, 0]}, {"id": "r", "home": [4, 0.5, 0]}],
    }
    problem = api.problem_of(document)
    rules = api.rules_of(asdict(Rules(balance=0.0)), problem)
    assert api.plan.plan_value(problem, rules, [[["a", 0], ["b", 0]], [["c", 0], ["d", 0]]]) > 0
    with pytest.raises(api.Refused, match="balanced"):
        api.plan.plan_value(problem, rules, [[["a", 0]], [["b", 0], ["c", 0], ["d", 0]]])


@battery
def lengths_are_floors(api: Any) -> None:
    layouts: tuple[Layout, ...] = ("uniform", "grid")
    for seed, layout, metric in product(range(2), layouts, ("euclidean", "chebyshev", "matrix")):
        instance = instance_of(seed, 4, layout, metric=metric)
        if metric == "matrix":
            instance = replace(instance, matrix=(instance.matrix + instance.matrix.T) / 3)
        document = document_of(instance)
        problem = api.problem_of(document)
        places = [c["entry_points"][0] for c in document["contours"]] + [h["home"] for h in document["heads"]]
        for u, v, scale in product(range(6), range(6), (1, 7, 10**9)):
            length = problem.lengths(u, [v], scale)[0]
            apart = [Fraction(repr(a)) - Fraction(repr(b)) for a, b in zip(places[u], places[v], strict=True)]
            if metric == "euclidean":
                square = sum(a * a for a in apart)
            elif metric == "chebyshev":
                square = max(map(abs, apart)) ** 2
            else:
                square = Fraction(repr(document["matrix"][u][v])) ** 2 if u != v else Fraction(0)
            assert length**2 <= square * scale**2 < (length + 1) ** 2


@battery
def hashes_tell_problems_apart(api: Any) -> None:
    document = document_of(symmetric(instance_of(1, 4, "uniform", metric="matrix")))
    document["precedence"] = [["c0", "c1"], ["c0", "c3"]]
    digest = api.instance_hash(document)
    assert digest == api.instance_hash(json.dumps(document, sort_keys=True, indent=3))
    turned = {key: document[key] for key in reversed(document)}
    assert api.instance_hash({**turned, "name": "other", "located": True}) == digest
    assert api.instance_hash(json.dumps(document).replace("100.0", "1e2")) == digest
    for path, value in (
        (["machine", "v_jump"], 7.5),
        (["machine", "v_cut"], 7.5),
        (["machine", "t_aux"], 7.5),
        (["heads", 0, "home", 2], -1.0),
        (["heads", 1, "id"], "other"),
        (["contours", 2, "id"], "other"),
        (["contours", 2, "entry_points", 0, 1], 0.125),
        (["contours", 0, "perimeter"], 0.125),
        (["contours", 2, "part"], "bracket"),
        (["contours", 2, "geometry"], [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
        (["contours", 2, "region"], {"centre": [0.0, 0.0, 0.0], "axes": [[1.0, 0.0, 0.0]]}),
        (["precedence", 1], ["c1", "c3"]),
        (["precedence", 1], ["c3", "c0"]),
        (["located"], False),
    ):
        other = copy.deepcopy(document)
        place = other
        for step in path[:-1]:
            place = place[step]
        place[path[-1]] = value
        assert api.instance_hash(other) != digest, path
    for again in ([["c0", "c3"], ["c0", "c1"]], [["c0", "c1"], ["c0", "c3"], ["c0", "c1"]]):
        assert api.instance_hash({**document, "precedence": again}) == digest
    assert api.instance_hash({**document, "precedence": []}) != digest
    plane = {**document, "matrix": None, "machine": document["machine"] | {"metric": "euclidean"}}
    more = copy.deepcopy(plane)
    more["contours"][2]["entry_points"].append([1.0, 2.0, 3.0])
    assert api.instance_hash(more) != api.instance_hash(plane)
    other = copy.deepcopy(document)
    other["matrix"][0][1] = other["matrix"][1][0] = 0.125
    assert api.instance_hash(other) != digest
    other["matrix"] = copy.deepcopy(document["matrix"])
    other["matrix"][1][1] = 99.0  # to stay costs nothing, whatever the file says
    assert api.instance_hash(other) == digest


@battery
def other_rules_are_refused(api: Any) -> None:
    made = sample("split")
    with pytest.raises(api.Refused, match="other rules"):
        api.verify(made.certificate, made.document, rules=made.certificate["rules"] | {"via_points": True})
