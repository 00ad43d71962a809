"""Small instances under all rules, with the programmes of their compact models and all their plans."""

from collections import Counter
from dataclasses import dataclass
from functools import cache
from itertools import pairwise, permutations, product
from typing import Any

import numpy as np
from oracles.compact_programmes import FORMULATIONS, CompactProgramme
from oracles.entry_tours import best_plan
from oracles.random_instances import random_instance
from oracles.random_sheets import random_sheet

from certificate.samples import document_of
from cutgap.instances import Evaluation, Instance, Plan, Rules, Visit, check, evaluate

SCALE = 10**6
MULTIPLIER_SCALE = 2**30


@dataclass(frozen=True)
class CompactSample:
    """An instance and rules, with the optimum by brute force, mm or s."""

    instance: Instance
    rules: Rules
    document: dict[str, Any]
    optimum: float

    @property
    def unit(self) -> float:
        """Units of a certificate per mm or s."""
        speed = self.instance.machine.v_jump if self.rules.objective == "makespan" else 1.0
        return SCALE * speed

    @property
    def factor(self) -> int:
        """q of weight / v_jump = p / q; weights and speeds are whole here."""
        weighted = self.rules.objective == "weighted" and len(self.instance.heads) == 2
        speed = int(self.instance.machine.v_jump)
        return speed // int(np.gcd(int(self.rules.weight), speed)) if weighted else 1


def drawn(seed: int, rules: Rules, contours: int, **options: Any) -> tuple[Instance, Rules]:
    return random_instance(np.random.default_rng(seed), contours, **options), rules


def sheet(seed: int, rules: Rules, contours: int, **options: Any) -> tuple[Instance, Rules]:
    return random_sheet(np.random.default_rng(seed), contours, entries=2, **options), rules


ONE: dict[str, Any] = {"heads": 1, "entries": 2}
TWO: dict[str, Any] = {"heads": 2, "entries": 2}
PRICED: dict[str, Any] = {"weight": 20.0, "non_overlap": None}
ON_CURVES: dict[str, Any] = {"neighbours_only": True, "clear_rapids": True}

CASES = (
    drawn(1, Rules("travel"), 4, layout="uniform", homes=True, **ONE),
    drawn(8, Rules("travel"), 4, homes=False, metric="matrix", **ONE),
    drawn(3, Rules("makespan"), 4, layout="uniform", homes=False, precedence=0.3, **ONE),
    drawn(4, Rules("weighted", weight=7.0, via_points=True, balance=0.0), 3, layout="grid", homes=False, **ONE),
    drawn(5, Rules("makespan"), 2, homes=False, metric="chebyshev", layout="uniform", **ONE),
    drawn(2, Rules("travel"), 1, layout="uniform", homes=False, **ONE),
    sheet(0, Rules("travel", parts_in_one_go=True, backward_price=0.75, **ON_CURVES), 4, homes=True),
    sheet(3, Rules("travel", parts_in_one_go=True, clear_rapids=True), 4, homes=False, shape="rectangles"),
    sheet(2, Rules("travel", parts_in_one_go=True), 3, homes=False, precedence=False),
    sheet(1, Rules("travel", neighbours_only=True), 3, homes=False, precedence=False),
    sheet(3, Rules("travel", clear_rapids=True), 3, homes=False, precedence=False),
    drawn(4, Rules("travel", backward_price=0.5), 3, layout="uniform", homes=False, **ONE),
    drawn(7, Rules("makespan", non_overlap=None), 3, layout="uniform", homes=True, **TWO),
    drawn(
        8, Rules("weighted", **PRICED, balance=30.0, empty_heads=True), 3, layout="uniform", homes=False, **TWO
    ),
    drawn(9, Rules("weighted", weight=75.0, non_overlap=50.0, via_points=True), 3, layout="grid", **TWO),
    drawn(10, Rules("travel", non_overlap=None, balance=9.0), 3, layout="uniform", precedence=0.5, **TWO),
    drawn(11, Rules("makespan", non_overlap=0.0), 1, layout="uniform", **TWO),
    sheet(3, Rules("makespan", non_overlap=None, parts_in_one_go=True, **ON_CURVES), 3, heads=2),
    sheet(4, Rules("weighted", **PRICED, clear_rapids=True, backward_price=0.5), 3, heads=2, homes=False),
)


@cache
def compact_samples() -> list[CompactSample]:
    found = []
    for instance, rules in CASES:
        best = best_plan(instance, rules)
        assert best is not None
        found.append(CompactSample(instance, rules, document_of(instance), best.value))
    return found


@cache
def programme(number: int, formulation: str) -> CompactProgramme:
    made = compact_samples()[number]
    return CompactProgramme(made.instance, made.rules, formulation)


def models() -> list[tuple[CompactSample, CompactProgramme, str]]:
    """Every sample with every formulation."""
    pairs = product(range(len(CASES)), FORMULATIONS)
    return [(compact_samples()[number], programme(number, name), name) for number, name in pairs]


@cache
def plans(number: int) -> list[tuple[Plan, Evaluation]]:
    """All allowed plans of a sample; of closed tours that may be turned, those that begin with contour 0."""
    made = compact_samples()[number]
    instance, turned = made.instance, programme(number, "assignment").anywhere
    sizes = [range(len(contour.entry_points)) for contour in instance.contours]
    found = []
    for order, entries in product(permutations(range(len(sizes))), product(*sizes)):
        visits = [Visit(contour, entries[contour]) for contour in order]
        for cut in range(len(order) + 1) if len(instance.heads) == 2 else [len(order)]:
            plan = Plan((tuple(visits[:cut]), tuple(visits[cut:]))[: len(instance.heads)])
            if not (turned and order[0] != 0) and not check(instance, made.rules, plan):
                found.append((plan, evaluate(instance, plan)))
    return found


def terms_of(problem: Any, instance: Instance, plan: Plan, evaluation: Evaluation) -> Counter[Any]:
    """What a plan means for the terms of rows, as ``certificate.compact.terms`` lists them."""
    unit, n = SCALE * instance.machine.v_jump, len(instance.contours)
    terms: Counter[Any] = Counter({("p", h, i): n for h in range(len(plan.tours)) for i in range(n)})
    terms["makespan",], terms["imbalance",] = evaluation.makespan_s * unit, evaluation.imbalance_s * unit
    for h, tour in enumerate(plan.tours):
        nodes = [instance.node(*visit[:2]) for visit in tour]
        stops = [-1, *(visit.contour for visit in tour), -1]
        for t, (i, j) in enumerate(pairwise(stops) if tour else ()):
            terms["y", h, i, j] = terms["w", h, t, i, j] = 1
            terms["f", h, i, j], terms["g", h, i, j] = len(tour) - t, n - (len(tour) - t)
            for k in stops[t + 1 : -1]:
                terms["unit", h, k, i, j] = 1
        for place, (u, i) in enumerate(zip(nodes, stops[1:], strict=False)):
            terms["z", h, i] = terms["q", h, u] = terms["out", h, u] = 1
            terms["p", h, i] = place + 1
            terms["first", h, u] = place == 0
            terms["T", h] += int(problem.work(i, SCALE))
        home = problem.homes[h]
        for u, v in pairwise(nodes):
            terms["x", h, u, v] = 1
        for u, v in pairwise([*nodes, *nodes[:1]] if home is None or not tour else [home, *nodes, home]):
            terms["T", h] += problem.lengths(u, [v], SCALE)[0]
    return terms
