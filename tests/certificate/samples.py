"""Certificates of tiny instances, with the optimum that brute force finds."""

import json
from dataclasses import asdict, dataclass, replace
from functools import cache
from itertools import groupby, permutations, product
from typing import Any

import numpy as np
from oracles.brute_force import brute_force
from oracles.random_instances import Layout, random_instance

from certificate.producer import (
    MULTIPLIER_SCALE,
    Prover,
    generalized_rows,
    subsets,
    tour_rows,
    two_heads_rows,
)
from cutgap.formulations.certificate import (
    GeneralizedRelaxation,
    Problem,
    Refused,
    TwoHeadsRelaxation,
    problem_of,
    rules_of,
    tour_relaxation,
    verify,
)
from cutgap.instances import Contour, Head, Instance, Machine, Rules
from cutgap.instances.formats.json_format import format_instance

SCALE = 1000


@dataclass(frozen=True)
class Sample:
    """A certificate, its instance document, and the optimum in its units (``None``: infeasible)."""

    certificate: dict[str, Any]
    document: dict[str, Any]
    optimum: float | None


def document_of(instance: Instance) -> dict[str, Any]:
    document: dict[str, Any] = json.loads(format_instance(instance))
    return document


def units(problem: Problem, rules: Rules, value: float) -> float:
    return value * SCALE * (float(problem.v_jump) if rules.objective == "makespan" else 1.0)


def frame(
    instance: Instance, rules: Rules, proof: dict[str, Any], bound: int | None, with_plan: bool = False
) -> Sample:
    document = document_of(instance)
    problem = problem_of(document)
    best = brute_force(instance, rules)
    tours = None
    if best is not None and with_plan:
        tours = [[[problem.ids[contour], entry] for contour, entry, *_ in tour] for tour in best.tours]
    certificate = {
        "format": "cutgap-certificate",
        "version": 1,
        "instance": problem.digest,
        "rules": asdict(rules),
        "scale": SCALE,
        "multiplier_scale": MULTIPLIER_SCALE,
        "bound": bound,
        "plan": tours,
        "proof": proof,
    }
    return Sample(certificate, document, None if best is None else units(problem, rules, best.value))


def shortest(problem: Problem, head: int, contours: list[int], via: bool) -> int:
    """Integer length of a shortest tour, by trying all orders."""
    home, best = problem.homes[head], None
    for order in permutations(contours):
        first_is_leftmost = not order or problem.xs[order[0]] == min(problem.xs[c] for c in order)
        if via and home is not None and not first_is_leftmost:
            continue
        around = order if home is None else (home, *order)
        legs = zip(around, (*around[1:], *around[:1]), strict=True)
        length = sum(problem.lengths(u, [v], SCALE)[0] for u, v in legs)
        best = length if best is None else min(best, length)
    assert best is not None
    return best


def tour_proof(problem: Problem, head: int, contours: list[int], via: bool, fix: bool = True) -> dict[str, Any]:
    """Prove a shortest length but for two units, which the rounding of multipliers may take."""
    proof: dict[str, Any] = {"head": head, "contours": [problem.ids[c] for c in contours]}
    via = via and problem.homes[head] is not None
    length = shortest(problem, head, contours, via)
    count = len(contours) + (problem.homes[head] is not None)
    if count <= 3:
        return {**proof, "length": length}
    relaxation = tour_relaxation(problem, head, contours, via, SCALE, MULTIPLIER_SCALE)
    rows = tour_rows(count, via)
    nodes = Prover(relaxation, rows, count).prove(MULTIPLIER_SCALE * (length - 2), fix)
    return {**proof, "length": length - 2, "rows": rows, "nodes": nodes}


def tie_tree(names: list[str]) -> list[dict[str, Any]]:
    """Divide a group completely."""
    nodes: list[dict[str, Any]] = []

    def add(rest: list[str]) -> int:
        index = len(nodes)
        nodes.append({"leaf": True})
        if rest:
            nodes[index] = {"branch": rest[0], "left": add(rest[1:]), "right": add(rest[1:])}
        return index

    add(names)
    return nodes


def split_sample(instance: Instance, rules: Rules, bound: int | None = 0) -> Sample:
    """A certificate with a proof for every set that a cell can have; its bound is still to be raised."""
    problem = problem_of(document_of(instance))
    order = sorted(range(len(problem.ids)), key=lambda c: problem.xs[c])
    groups = [list(group) for _, group in groupby(order, key=lambda c: problem.xs[c])]
    lefts = {tuple(order[:k]) for k in range(len(order) + 1)}
    if rules.non_overlap == 0:
        for group in groups:
            before = [c for c in order if problem.xs[c] < problem.xs[group[0]]]
            lefts |= {(*before, *sorted(part)) for part in subsets(group)}
    tours = []
    for left in sorted(lefts) if bound is not None else []:
        right = [c for c in order if c not in left]
        for head, contours in enumerate((list(left), right)):
            if contours:
                tours.append(tour_proof(problem, head, contours, rules.via_points))
    ties = [tie_tree([problem.ids[c] for c in group]) for group in groups if len(group) > 1]
    proof = {"kind": "split", "tours": tours, "ties": ties if rules.non_overlap == 0 else []}
    return frame(instance, rules, proof, bound, with_plan=bound is not None)


def two_heads_sample(instance: Instance, rules: Rules) -> Sample:
    problem = problem_of(document_of(instance))
    best = brute_force(instance, rules)
    exact = rules_of(asdict(rules), problem)
    relaxation = TwoHeadsRelaxation(problem, exact, SCALE, MULTIPLIER_SCALE, costless=best is None)
    names = two_heads_rows(problem, rules)
    prover = Prover(relaxation, names, len(problem.ids))
    if best is None:
        return frame(instance, rules, {"kind": "two-heads", "rows": names, "nodes": prover.prove(1)}, None)
    # Floors of lengths and work lose up to 2 units a contour and home, the slack of imbalance rows more.
    bound = int(units(problem, rules, best.value)) - 12 * (len(problem.ids) + 2)
    nodes = prover.prove(MULTIPLIER_SCALE * relaxation.factor * bound)
    return frame(instance, rules, {"kind": "two-heads", "rows": names, "nodes": nodes}, bound, with_plan=True)


def tour_sample(instance: Instance, rules: Rules, fix: bool = True) -> Sample:
    problem = problem_of(document_of(instance))
    tour = tour_proof(problem, 0, list(range(len(problem.ids))), rules.via_points, fix)
    work = sum(problem.work(c, SCALE) for c in range(len(problem.ids)))
    bound = int(tour["length"] + (work if rules.objective == "makespan" else 0))
    return frame(instance, rules, {"kind": "tour", "tour": tour}, bound, with_plan=True)


def generalized_sample(instance: Instance, rules: Rules) -> Sample:
    problem = problem_of(document_of(instance))
    best = brute_force(instance, rules)
    assert best is not None
    work = sum(problem.work(c, SCALE) for c in range(len(problem.ids))) if rules.objective == "makespan" else 0
    relaxation = GeneralizedRelaxation(problem, SCALE, MULTIPLIER_SCALE)
    # Floors lose up to a unit a leg, rounded multipliers a few more.
    length = int(sum(best.figures.travel) * SCALE) // relaxation.step * relaxation.step
    length -= 2 * len(relaxation.contours) if relaxation.step == 1 else 0
    rows = generalized_rows(relaxation)
    target = MULTIPLIER_SCALE * (length - relaxation.step) + 1
    nodes = Prover(relaxation, rows, relaxation.count).prove(target)
    proof = {"kind": "gtsp", "length": length, "rows": rows, "nodes": nodes}
    return frame(instance, rules, proof, int(length + work), with_plan=True)


def raised(sample: Sample) -> Sample:
    """The sample with the largest bound that its proof is worth, found by bisection."""
    certificate = {**sample.certificate, "plan": None}
    low, high = -(10**9), 10**9
    while high - low > 1:
        middle = (low + high) // 2
        try:
            verify({**certificate, "bound": middle}, sample.document)
            low = middle
        except Refused:
            high = middle
    return Sample({**sample.certificate, "bound": low}, sample.document, sample.optimum)


def instance_of(seed: int, holes: int, layout: Layout, **options: Any) -> Instance:
    return random_instance(np.random.default_rng(seed), holes, layout=layout, **options)


def symmetric(instance: Instance) -> Instance:
    """The instance with a matrix and its transpose added up."""
    assert instance.matrix is not None
    return replace(instance, matrix=instance.matrix + instance.matrix.T)


def entries_of(seed: int, holes: int, **options: Any) -> Instance:
    """An instance of one head, each contour with two entry points."""
    instance = instance_of(seed, 2 * holes, "uniform", heads=1, **options)
    points = [contour.entry_points for contour in instance.contours]
    contours = [
        replace(contour, entry_points=np.concatenate(points[2 * i : 2 * i + 2]))
        for i, contour in enumerate(instance.contours[:holes])
    ]
    return replace(instance, contours=tuple(contours))


WEIGHTED = {"objective": "weighted", "weight": 40.0}

CASES: dict[str, tuple[Any, Instance, Rules]] = {
    "tour": (tour_sample, instance_of(1, 6, "uniform", heads=1), Rules("travel")),
    "tour with via points": (tour_sample, instance_of(2, 6, "uniform", heads=1), Rules(via_points=True)),
    "closed tour": (
        tour_sample,
        instance_of(3, 6, "grid", heads=1, homes=False),
        Rules(objective="travel", via_points=True),
    ),
    "small tour": (tour_sample, instance_of(4, 2, "uniform", heads=1), Rules("travel")),
    "gtsp": (generalized_sample, entries_of(16, 3), Rules("travel")),
    "gtsp, matrix": (
        generalized_sample,
        symmetric(entries_of(17, 3, homes=False, metric="matrix")),
        Rules("travel"),
    ),
    "gtsp, makespan": (generalized_sample, entries_of(18, 1), Rules()),
    "split": (split_sample, instance_of(5, 5, "uniform"), Rules()),
    "split with ties": (split_sample, instance_of(3, 4, "grid"), Rules()),
    "split with via points": (split_sample, instance_of(7, 5, "uniform"), Rules(**WEIGHTED, via_points=True)),
    "split with a gap": (split_sample, instance_of(8, 5, "uniform"), Rules("travel", non_overlap=150.0)),
    "split with balance": (split_sample, instance_of(9, 4, "uniform"), Rules(**WEIGHTED, balance=20.0)),
    "split with rest": (split_sample, instance_of(10, 4, "column"), Rules("travel", empty_heads=True)),
    "split, infeasible": (
        lambda instance, rules: split_sample(instance, rules, bound=None),
        instance_of(11, 4, "column"),
        Rules(non_overlap=10.0),
    ),
    "two heads": (two_heads_sample, instance_of(12, 4, "uniform"), Rules(non_overlap=None)),
    "two heads, travel": (
        two_heads_sample,
        instance_of(13, 4, "uniform"),
        Rules("travel", non_overlap=None, balance=25.0),
    ),
    "two heads, all rules": (
        two_heads_sample,
        instance_of(14, 4, "uniform"),
        Rules(**WEIGHTED, non_overlap=20.0, balance=9.0, via_points=True, empty_heads=True),
    ),
    "two heads, infeasible": (
        two_heads_sample,
        instance_of(15, 3, "uniform"),
        Rules("travel", non_overlap=0.0, balance=0.0),
    ),
}


@cache
def sample(name: str) -> Sample:
    make, instance, rules = CASES[name]
    made: Sample = make(instance, rules)
    return raised(made) if name.startswith("split") and made.certificate["bound"] is not None else made


@dataclass(frozen=True)
class StrongSplit(Sample):
    """A split certificate with the true length of every set, and whether its tie trees decide everything."""

    complete: bool = False


def truncated_tree(rng: np.random.Generator, names: list[str]) -> list[dict[str, Any]]:
    """A tie tree that leaves contours undecided here and there."""
    nodes: list[dict[str, Any]] = []

    def add(rest: list[str]) -> int:
        index = len(nodes)
        nodes.append({"leaf": True})
        if rest and (rng.random() < 0.5):
            nodes[index] = {"branch": rest[0], "left": add(rest[1:]), "right": add(rest[1:])}
        return index

    add(names)
    return nodes


def strong_split(instance: Instance, rules: Rules, rng: np.random.Generator | None) -> StrongSplit:
    """Prove the shortest tour of every set, with and without via points; a generator truncates the ties."""
    problem = problem_of(document_of(instance))
    tours = []
    for head, contours in product((0, 1), subsets(range(len(problem.ids)))):
        tours.append(tour_proof(problem, head, contours, rules.via_points))
        if rules.via_points and problem.homes[head] is not None:
            tours.append({**tour_proof(problem, head, contours, False), "via": False})
    order = sorted(range(len(problem.ids)), key=lambda c: problem.xs[c])
    groups = [list(group) for _, group in groupby(order, key=lambda c: problem.xs[c])]
    named = [[problem.ids[c] for c in group] for group in groups if len(group) > 1]
    ties = [tie_tree(names) if rng is None else truncated_tree(rng, names) for names in named]
    proof = {"kind": "split", "tours": tours, "ties": ties if rules.non_overlap == 0 else []}
    made = frame(instance, rules, proof, 0)
    priced = rules.weight > instance.machine.v_jump
    return StrongSplit(made.certificate, made.document, made.optimum, rng is None and not priced)


def thin_instance(rng: np.random.Generator, xs: list[int]) -> Instance:
    """Contours nearly above each other: the first one by x may be anywhere, so via points cost a lot."""
    holes = len(xs)
    points = rng.uniform(0, 1000, (holes + 2, 3)).round()
    points[:, 0] = [*xs, 0, 0]
    perimeters = rng.uniform(0, 400, holes)
    contours = tuple(Contour(f"c{i}", points[i][None], float(perimeters[i])) for i in range(holes))
    return Instance("thin", contours, tuple(Head(f"h{i}", points[holes + i]) for i in (0, 1)), Machine())


def with_matrix(rng: np.random.Generator, instance: Instance) -> Instance:
    """The instance with random lengths, which are no metric."""
    matrix = np.triu(rng.integers(0, 500, (instance.node_count, instance.node_count))).astype(float)
    machine = replace(instance.machine, metric="matrix")
    return replace(instance, machine=machine, matrix=matrix + matrix.T)


def drawn_split(seed: int) -> StrongSplit:
    """Any rules, three contours."""
    rng = np.random.default_rng(seed)
    if seed % 2:
        instance = thin_instance(rng, rng.integers(0, 3, 3).tolist())
    else:
        layout: Layout = ("uniform", "grid", "column", "equal points")[seed // 2 % 4]
        instance = instance_of(seed, 3, layout, homes=None if seed % 3 else True)
    if seed % 5 == 4:
        instance = with_matrix(rng, instance)
    objective = ("makespan", "travel", "weighted", "weighted")[int(rng.integers(4))]
    rules = Rules(
        objective,
        weight=float(rng.choice([50.0, 100.0, 600.0])) if objective == "weighted" else 0.0,
        non_overlap=float(rng.choice([0.0, 0.0, 2.0])),
        balance=float(rng.uniform(1, 8)) if rng.random() < 0.3 else None,
        via_points=bool(rng.random() < 0.5),
        empty_heads=bool(rng.random() < 0.4),
    )
    return strong_split(instance, rules, rng if rng.random() < 0.4 else None)


def via_split(seed: int) -> StrongSplit:
    """One head may do all of four contours, and which one comes first matters."""
    rng = np.random.default_rng(seed)
    instance = thin_instance(rng, [0, 1, 2, 3] if seed % 2 else [0, 0, 1, 2])
    rules = Rules("travel", via_points=True, empty_heads=True)
    return strong_split(instance, rules, rng)


@cache
def strongest_split() -> list[StrongSplit]:
    """Instances with via points, ties, no metric, weights above v_jump, balance, rest and gaps."""
    return [drawn_split(seed) for seed in range(50)] + [via_split(seed) for seed in range(8)]
