"""Checks of the threshold form: cells, their bounds, and which sets a tour proof holds for."""

import copy
from dataclasses import asdict
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
import pytest

from certificate.battery import battery
from certificate.producer import subsets
from certificate.samples import (
    sample,
    strongest_split,
    tie_tree,
)
from cutgap.instances import Rules


@battery
def the_strongest_split_proof_proves_no_more_than_the_optimum(api: Any) -> None:
    for case in strongest_split():
        if case.optimum is not None:
            more = {**case.certificate, "bound": int(case.optimum) + 1}
            with pytest.raises(api.Refused, match="cell of"):
                api.verify(more, case.document)


@battery
def the_strongest_split_proof_reaches_the_optimum(api: Any) -> None:
    """Where every set is decided and proved, only rounding is lost."""
    for case in strongest_split():
        if case.complete and case.optimum is not None:
            less = {**case.certificate, "bound": int(case.optimum) - 60}
            assert api.verify(less, case.document).bound is not None


@battery
def proofs_with_via_points_pass_to_sets_with_the_same_leftmost(api: Any) -> None:
    document = copy.deepcopy(sample("two heads").document)
    for contour, x in zip(document["contours"], (0, 0, 1, 2), strict=True):
        contour["entry_points"][0][0] = x
    problem = api.problem_of(document)
    tours = api.tours.TourBounds(problem, [api.tours.ProvedTour(0, 0b0101, 7, True)])  # contours 0 and 2
    assert tours.length(0, [0, 2], []) == 7
    assert tours.length(0, [0, 2, 3], []) == 7
    assert tours.length(0, [0, 2], [3]) == 7
    assert tours.length(1, [0, 2], []) == 0
    assert tours.length(0, [0], []) == 0
    # Contour 1 may come first as well, and then the rest may begin with contour 2.
    assert tours.length(0, [0, 1, 2], []) == 0
    assert tours.length(0, [0, 2], [1]) == 0
    rules = api.rules_of(asdict(Rules(via_points=True)), problem)
    for contours, more, via in (("c0 c2", {}, True), ("c0 c1", {}, False), ("c0 c2", {"via": False}, False)):
        proof = {"head": 0, "contours": contours.split(), "length": 0, **more}
        assert api.tours.prove_tour(problem, rules, proof, 1, 1, api.proof.Budget()).via == via
    plain = api.tours.TourBounds(problem, [api.tours.ProvedTour(0, 0b0101, 7, False)])
    assert plain.length(0, [0, 1, 2], []) == plain.length(0, [0, 2], [1]) == 7


@battery
def cells_are_all_partitions(api: Any) -> None:
    document = copy.deepcopy(sample("split").document)
    rng = np.random.default_rng(4)
    for _ in range(60):
        xs, gap = rng.integers(0, 6, 5).tolist(), float(rng.choice([0, 0, 2, 3]))
        for contour, x in zip(document["contours"], xs, strict=True):
            contour["entry_points"][0][0] = x
        rules = Rules(non_overlap=gap, empty_heads=bool(rng.random() < 0.5))
        problem = api.problem_of(document)
        found = []

        class Recorder(api.split.Cells):
            def _bound(self, left: Any, right: Any, floating: Any, found: Any = found) -> Fraction:
                assert sorted(left + right) == list(range(5))
                assert not floating
                found.append(tuple(sorted(left)))
                return Fraction(0)

        exact = api.rules_of(asdict(rules), problem)
        cells = Recorder(problem, exact, api.tours.TourBounds(problem, []), 0, 1, api.proof.Budget())
        groups = [[problem.ids[i] for i in range(5) if xs[i] == x] for x in sorted(set(xs))]
        cells.check([tie_tree(names) for names in groups if len(names) > 1] if gap == 0 else [])
        allowed = set()
        for left in [[], *subsets(range(5))]:
            right = [i for i in range(5) if i not in left]
            if left and right:
                if min(xs[i] for i in right) - max(xs[i] for i in left) >= gap:
                    allowed.add(tuple(left))
            elif rules.empty_heads:
                allowed.add(tuple(left))
        assert set(found) == allowed


@battery
def bounds_of_cells_are_the_least_values(api: Any) -> None:
    """Against plans whose tours are longer than proved by any whole number up to 149."""
    document = copy.deepcopy(sample("split").document)
    document["machine"] |= {"v_jump": 1, "v_cut": 1, "t_aux": 0}
    rng = np.random.default_rng(5)
    more = np.arange(150)
    for number in range(120):
        for contour, perimeter in zip(document["contours"], rng.integers(0, 20, 5).tolist(), strict=True):
            contour["perimeter"] = perimeter
        objective: Any = ("makespan", "travel", "weighted", "weighted")[number % 4]
        weight = float(rng.choice([0.25, 1.0, 4.0])) if objective == "weighted" else 0.0
        balance = float(rng.integers(0, 12)) if rng.random() < 0.5 else None
        rules = Rules(objective, weight=weight, balance=balance)
        problem = api.problem_of(document)
        lengths = rng.integers(0, 30, 2).tolist()

        class Lengths(api.tours.TourBounds):
            def length(self, head: int, contours: Any, floating: Any, lengths: Any = lengths) -> int:
                return int(lengths[head])

        exact = api.rules_of(asdict(rules), problem)
        cells = api.split.Cells(problem, exact, Lengths(problem, []), 0, 1, api.proof.Budget())
        cut = [int(each) for each in rng.integers(0, 3 if number % 3 else 2, 5)]
        parts = [[i for i in range(5) if cut[i] == part] for part in range(3)]
        least = np.inf
        for choice in product((0, 1), repeat=len(parts[2])):
            work = [sum(float(problem.seconds[i]) for i in part) for part in parts[:2]]
            for i, head in zip(parts[2], choice, strict=True):
                work[head] += float(problem.seconds[i])
            first, second = lengths[0] + more[:, None], lengths[1] + more[None, :]
            apart = abs(first + work[0] - second - work[1])
            longest = np.maximum(first + work[0], second + work[1])
            value = longest if objective == "makespan" else first + second + weight * apart
            least = min(least, value[apart <= (np.inf if balance is None else balance)].min())
        bound = float(cells._bound(*parts))
        assert bound <= least + 1e-9
        if not parts[2] and weight <= 1:
            assert bound == pytest.approx(least)
