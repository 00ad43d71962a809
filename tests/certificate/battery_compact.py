"""Checks of bounds by rows of compact models: rows are those of the page, hold for plans and prove no more."""

from dataclasses import asdict, replace
from itertools import combinations, permutations, product
from typing import Any

import numpy as np
import pytest
from oracles.compact_programmes import FORMULATIONS, CompactProgramme

from certificate.battery import battery
from certificate.compact_samples import (
    MULTIPLIER_SCALE,
    SCALE,
    CompactSample,
    compact_samples,
    models,
    plans,
    programme,
    terms_of,
)
from certificate.plans import SLACK
from cutgap.instances import Rules

PRICED = ("makespan", "imbalance")
TIMES = (*PRICED, "balance")


def rows_of(api: Any, made: CompactSample, formulation: str) -> Any:
    problem = api.problem_of(made.document)
    rules = api.rules_of(asdict(made.rules), problem)
    return api.CompactRows(problem, rules, formulation, SCALE, api.proof.Budget())


def listed(name: tuple[Any, ...]) -> list[Any]:
    """The name of a row as in a certificate."""
    return [list(part) if isinstance(part, tuple) else part for part in name]


@battery
def rows_of_compact_models_hold_and_are_tight(api: Any) -> None:
    tight: set[str] = set()
    for number, formulation in product(range(len(compact_samples())), FORMULATIONS):
        made = compact_samples()[number]
        rows = rows_of(api, made, formulation)
        points = [
            terms_of(rows.setting.problem, made.instance, *each)
            for each in plans(number)[:: 1 + len(plans(number)) // 100]
        ]
        assert points
        for name in programme(number, formulation).rows:
            row = rows.row(listed(name))
            over = [sum(factor * point[term] for factor, term in row.terms) - row.rhs for point in points]
            assert min(over) >= -SLACK, (formulation, name)
            assert not row.equality or max(over) == 0
            # Rows of times are tight but for what floors lose, balance where the limit is reached.
            if min(over) <= (SCALE / 100 if name[0] in PRICED else 0):
                tight.add(name[0])
    families = {name[0] for _, each, _ in models() for name in each.rows}
    assert tight == families - {"balance"}


@battery
def balance_rows_leave_room_for_floors(api: Any) -> None:
    for number, made in enumerate(compact_samples()):
        if len(made.instance.heads) == 1:
            continue
        for plan, evaluation in plans(number)[::5]:
            limited = replace(made, rules=replace(made.rules, balance=evaluation.imbalance_s + 1e-9))
            rows = rows_of(api, limited, "assignment")
            point = terms_of(rows.setting.problem, made.instance, plan, evaluation)
            late = 0 if evaluation.time_s[0] > evaluation.time_s[1] else 1
            row = rows.row(["balance", late, 1 - late])
            over = sum(factor * point[term] for factor, term in row.terms) - row.rhs
            assert -SLACK <= over <= 4 * len(made.instance.contours) + 3 + SCALE * 1e-6


def candidates(rows: Any, family: str) -> list[list[Any]]:
    """Every name of a family whose indices are in their ranges."""
    sets = [
        list(s)
        for size in range(2, rows.setting.count + 1)
        for s in combinations(range(rows.setting.count), size)
    ]
    kinds = rows.families[family][0].split()
    return [[family, *each] for each in product(*(sets if k == "set" else rows.ranges[k] for k in kinds))]


@battery
def compact_models_have_the_rows_of_the_page(api: Any) -> None:
    for made, model, formulation in models():
        rows = rows_of(api, made, formulation)
        expected = {str(listed(name)): (equal, right) for name, (_, equal, right) in model.rows.items()}
        found = {}
        for name in (each for family in rows.families for each in candidates(rows, family)):
            try:
                row = rows.row(name)
            except api.Refused:
                continue
            found[str(name)] = (row.equality, expected[str(name)][1] if name[0] in TIMES else row.rhs)
        assert found == expected, formulation


def random_multipliers(
    rng: np.random.Generator, made: CompactSample, model: CompactProgramme
) -> tuple[list[list[Any]], dict[Any, float]]:
    """Integers for all rows, as pairs and in the units of the programme."""
    pairs, floats = [], {}
    times = MULTIPLIER_SCALE * made.factor
    per_time = times / (1 if made.rules.objective == "makespan" else made.instance.machine.v_jump)
    cost = 1.0 if made.rules.objective == "makespan" else made.rules.weight
    for name, (_, equal, _) in model.rows.items():
        if name[0] in TIMES:
            integer = int(rng.random() * 0.5 * cost * per_time)
            floats[name] = integer / per_time
        else:
            # As large as legs are long, so that legs of either sign occur.
            integer = int(rng.uniform(-2000 if equal else 0, 2000) * SCALE * times)
            floats[name] = integer / (per_time * SCALE * made.instance.machine.v_jump)
        pairs.append([listed(name), integer])
    return pairs, floats


def worth(api: Any, made: CompactSample, formulation: str, pairs: list[list[Any]]) -> int:
    problem = api.problem_of(made.document)
    rules = api.rules_of(asdict(made.rules), problem)
    value: int = api.compact_value(problem, rules, formulation, pairs, SCALE, MULTIPLIER_SCALE)
    return value


@battery
def compact_multipliers_are_worth_what_the_page_says(api: Any) -> None:
    rng = np.random.default_rng(0)
    for made, model, formulation in models():
        for share in (1.0, 0.2):
            pairs, floats = random_multipliers(rng, made, model)
            pairs = [pair for pair in pairs if rng.random() < share]
            kept = {str(pair[0]) for pair in pairs}
            expected = model.worth({name: m for name, m in floats.items() if str(listed(name)) in kept})
            found = worth(api, made, formulation, pairs) / made.unit
            assert found == pytest.approx(expected, rel=1e-7, abs=1e-3), formulation


def dual_pairs(made: CompactSample, model: CompactProgramme) -> list[list[Any]]:
    """The multipliers of the solved programme as integers, all rounded down."""
    times = MULTIPLIER_SCALE * made.factor
    per_time = times / (1 if made.rules.objective == "makespan" else made.instance.machine.v_jump)
    others = per_time * SCALE * made.instance.machine.v_jump
    return [
        [listed(name), int(np.floor(m * (per_time if name[0] in TIMES else others) * (1 - 1e-12)))]
        for name, m in model.solved.multipliers.items()
    ]


def certificate(
    api: Any, made: CompactSample, formulation: str, pairs: Any, bound: int | None
) -> dict[str, Any]:
    return {
        "format": "cutgap-certificate",
        "version": 1,
        "instance": api.instance_hash(made.document),
        "rules": asdict(made.rules),
        "scale": SCALE,
        "multiplier_scale": MULTIPLIER_SCALE,
        "bound": bound,
        "plan": None,
        "proof": {"kind": "compact", "formulation": formulation, "multipliers": pairs},
    }


@battery
def compact_relaxations_are_proved_and_no_more(api: Any) -> None:
    for made, model, formulation in models():
        pairs = dual_pairs(made, model)
        value = worth(api, made, formulation, pairs)
        assert model.solved.value is not None
        assert value / made.unit == pytest.approx(model.solved.value, rel=1e-6, abs=1e-4)
        assert value <= made.optimum * made.unit + SLACK
        if formulation == "dfj":
            api.verify(certificate(api, made, formulation, pairs, value), made.document)
            with pytest.raises(api.Refused, match="less than the claimed"):
                api.verify(certificate(api, made, formulation, pairs, value + 1), made.document)


@battery
def climbing_multipliers_prove_no_more(api: Any) -> None:
    rng = np.random.default_rng(1)
    for made, model, formulation in models()[::11]:
        is_equation = [equal for _, equal, _ in model.rows.values()]
        pairs, best = dual_pairs(made, model), -(10**18)
        for _ in range(40):
            tried = [list(pair) for pair in pairs]
            for place in rng.integers(len(pairs), size=3).tolist():
                step = int(rng.normal() * 10.0 ** rng.uniform(0, 2) * SCALE * MULTIPLIER_SCALE)
                if tried[place][0][0] not in TIMES:
                    tried[place][1] += step if is_equation[place] else abs(step)
            value = worth(api, made, formulation, tried)
            assert value <= made.optimum * made.unit + SLACK
            if value > best:
                pairs, best = tried, value


FORGED: list[tuple[int, str, Any, str]] = [
    (0, "mtz", 5, "list"),
    (0, "mtz", [["cut-once", 0]], "no row|whole number|list"),
    (0, "mtz", [[["cut-once", 0]]], "2 entries"),
    (0, "mtz", [[["cut-once", 0], 1.5]], "whole number"),
    (0, "mtz", [[["cut-once", 0], True]], "whole number"),
    (0, "mtz", [[["position", 0, 0, 1], -1]], "no equation"),
    (0, "mtz", [[[], 1]], "no row"),
    (0, "mtz", [[[["cut-once"], 0], 1]], "no row"),
    (0, "mtz", [[["clock", 0, 1, "least"], 1]], "no row"),
    (0, "mtz", [[["late", 0, 1], 1]], "no row"),
    (0, "mtz", [[["neighbours", 0, 1], 1]], "no row"),
    (0, "mtz", [[["cut-once"], 1]], "expected contour"),
    (0, "mtz", [[["cut-once", 0, 0], 1]], "expected contour"),
    (0, "mtz", [[["cut-once", 4], 1]], "no contour"),
    (0, "mtz", [[["cut-once", -1], 1]], "no contour"),
    (0, "mtz", [[["cut-once", False], 1]], "no contour"),
    (0, "mtz", [[["cut-once", 0.0], 1]], "no contour"),
    (0, "mtz", [[["cut-once", "c0"], 1]], "no contour"),
    (0, "mtz", [[["continuity", 1, 0], 1]], "no head"),
    (0, "mtz", [[["continuity", 0, 99], 1]], "no node"),
    (0, "mtz", [[["position", 0, 1, 1], 1]], "two different"),
    (0, "mtz", [[["position", 0, -1, 1], 1]], "no contour"),
    (0, "mtz", [[["lifted-position", 0, 0, 1], 1]], "no row"),
    (0, "mtz", [[["flow-keep", 0, 1], 1]], "no row"),
    (0, "assignment", [[["position", 0, 0, 1], 1]], "no row"),
    (0, "lifted-mtz", [[["position", 0, 0, 1], 1]], "no row"),
    (0, "lifted-mtz", [[["lifted-position", 0, 2, 2], 1]], "two different"),
    (0, "single-commodity", [[["flow-most", 0, 1, -1], 1]], "no contour"),
    (0, "single-commodity", [[["flow-most", 0, 1, 1], 1]], "two different"),
    (0, "two-commodity", [[["load-and-space", 0, -1, -1], 1]], "two different"),
    (0, "two-commodity", [[["load-and-space", 0, -2, 0], 1]], "no place"),
    (0, "multi-commodity", [[["through", 0, 1, 1], 1]], "two different"),
    (0, "multi-commodity", [[["flow-within", 0, 1, 2, 2], 1]], "two different"),
    (0, "time-indexed", [[["step", 0, 0, 1], 1]], "no position"),
    (0, "time-indexed", [[["step", 0, 5, 1], 1]], "no position"),
    (0, "time-indexed", [[["timed", 0, 1, 1], 1]], "two different"),
    (0, "dfj", [[["enter", 0, [1]], 1]], "two contours"),
    (0, "dfj", [[["enter", 0, [1, 1]], 1]], "different contours"),
    (0, "dfj", [[["enter", 0, [2, 1]], 1]], "ascending"),
    (0, "dfj", [[["enter", 0, [1, 4]], 1]], "two contours"),
    (0, "dfj", [[["enter", 0, [-1, 1]], 1]], "two contours"),
    (0, "dfj", [[["enter", 0, [True, 2]], 1]], "two contours"),
    (0, "dfj", [[["enter", 0, 3], 1]], "list"),
    (0, "dfj", [[["enter", 0, [0, 1], 1], 1]], "expected head set"),
    (0, "dfj", [[["makespan", 0], 1]], "no row"),
    (0, "dfj", [[["via", 0, 0, 1], 1]], "no row"),
    (0, "dfj", [[["one-go", 0, 0], 1]], "no row"),
    (0, "dfj", [[["precedence", 0, 0, 1], 1]], "no row"),
    (0, "dfj", [[["clear", 0, 0, 1, 2], 1]], "no row"),
    (0, "dfj", [[["balance", 0, 0], 1]], "no row"),
    (0, "dfj", [[["apart", 0, 1], 1]], "no row"),
    (3, "dfj", [[["imbalance", 0, 0], 1]], "no row"),
    (3, "dfj", [[["balance", 0, 0], 1]], "no row"),
    (12, "dfj", [[["enter", 0, [0, 1], 2], 1]], "not in the set"),
    (12, "dfj", [[["enter", 0, [0, 1]], 1]], "expected head set contour"),
    (12, "dfj", [[["makespan", 0], MULTIPLIER_SCALE + 1]], "more than 1"),
    (12, "dfj", [[["makespan", 0], MULTIPLIER_SCALE], [["makespan", 1], 1]], "more than 1"),
    (12, "dfj", [[["imbalance", 0, 1], 1]], "no row"),
    (12, "lifted-mtz", [[["lifted-last", 0, 1], 1]], "no row"),
    (13, "dfj", [[["imbalance", 1, 1], 1]], "two different"),
    (13, "dfj", [[["balance", 0, 0], 1]], "two different"),
    (13, "dfj", [[["imbalance", 0, 1], 20 * MULTIPLIER_SCALE + 1]], "more than the weight"),
    (13, "nearest", [], "formulation"),
    (13, ["dfj"], [], "formulation"),
]


@battery
def compact_forgeries_are_refused(api: Any) -> None:
    for number, formulation, pairs, message in FORGED:
        made = compact_samples()[number]
        with pytest.raises(api.Refused, match=message):
            api.verify(certificate(api, made, formulation, pairs, 0), made.document)
    made = compact_samples()[0]
    api.verify(certificate(api, made, "mtz", [], 0), made.document)
    with pytest.raises(api.Refused, match="proves bounds"):
        api.verify(certificate(api, made, "mtz", [], None), made.document)
    for change in ({"rows": []}, {"formulation": None}):
        forged = certificate(api, made, "mtz", [], 0)
        forged["proof"] |= change
        with pytest.raises(api.Refused, match=r"unknown field|formulation"):
            api.verify(forged, made.document)


@battery
def compact_proofs_have_a_budget(api: Any) -> None:
    made = compact_samples()[0]
    problem = api.problem_of(made.document)
    rules = api.rules_of(asdict(made.rules), problem)
    for formulation, name in (("dfj", ["enter", 0, [0, 1, 2]]), ("multi-commodity", ["to-sink", 0, 1])):
        for pairs, steps in (([[name, 0]] * 1000, 10_000), ([], 10)):
            with pytest.raises(api.Refused, match="too many steps"):
                api.compact_value(problem, rules, formulation, pairs, SCALE, 1, api.proof.Budget(steps))


@battery
def curves_are_needed_for_compact_rows_on_curves(api: Any) -> None:
    made = replace(compact_samples()[0], rules=Rules("travel", clear_rapids=True))
    with pytest.raises(api.Refused, match="no geometry"):
        rows_of(api, made, "mtz").row(["clear", 0, *next(iter(permutations((0, 3), 2))), 1])
