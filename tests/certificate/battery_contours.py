"""Checks of proofs by dynamic programming: whatever the hints, they prove the optimum and no more."""

import copy
import json
import math
from dataclasses import asdict, replace
from functools import cache
from itertools import combinations, pairwise, product
from typing import Any

import numpy as np
import pytest
from oracles.entry_tours import best_plan
from oracles.exact_sheet import _meet
from oracles.random_instances import random_instance, random_plan
from oracles.random_sheets import random_sheet

from certificate.battery import battery
from cutgap.instances import Contour, Head, Instance, Rules, check
from cutgap.instances.formats.json_format import format_instance
from cutgap.instances.nesting import enclosures
from cutgap.instances.process import adjacent_parts

SCALE = 1000
SWITCHES = ("parts_in_one_go", "neighbours_only", "clear_rapids")
BEYOND = r"below the bound|costs nothing"
ON_CURVES = r"crosses what is cut|not to a neighbour"
Sample = tuple[Instance, Rules, float]


@cache
def samples() -> list[Sample]:
    """Instances with entry points under all rules, and their optima by brute force, mm."""
    drawn = []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        asked = dict.fromkeys(SWITCHES, False)
        if seed % 3:
            instance = random_sheet(rng, int(rng.integers(1, 5)), homes=None, entries=2)
            asked = {name: bool(rng.integers(2)) for name in SWITCHES}
        else:
            metric = ("euclidean", "chebyshev", "matrix")[seed // 3 % 3]
            instance = random_instance(
                rng, 4, heads=1, homes=None, entries=2, metric=metric, precedence=float(rng.choice([0.0, 0.3]))
            )
        price = 0.75 if instance.matrix is None and rng.integers(2) else 0.0
        rules = Rules("travel", backward_price=price, **asked)
        best = best_plan(instance, rules)
        if best is not None:
            drawn.append((instance, rules, best.value))
    return [*drawn, *(special_samples())]


def special_samples() -> list[Sample]:
    """Squares in a row, where rules on curves make the far one dear; a part left and come back to."""
    home = (Head("h", np.array([-100.0, 10.0, 0.0])),)
    found = []
    for order in ("abc", "bac", "cab"):
        row = tuple(square(name, "abc".index(name)) for name in order)
        for switch in ("neighbours_only", "clear_rapids"):
            for heads in (home, (Head("h"),)):
                for price in (0.0, 3.0):
                    instance = Instance("row", row, heads)
                    rules = Rules("travel", backward_price=price, **{switch: True})
                    found.append((instance, rules))
    xs = {"p": (0.0, "1"), "q": (400.0, "1"), "r": (100.0, None), "s": (300.0, None)}
    parts = tuple(Contour(n, np.array([[x, 0, 0], [x, 5, 0]]), 1.0, part=part) for n, (x, part) in xs.items())
    for heads in (home, (Head("h"),)):
        for pairs in ((), ((0, 1),), ((3, 2),)):
            found.append(
                (Instance("parts", parts, heads, precedence=pairs), Rules("travel", parts_in_one_go=True))
            )
    # Only neighbours make the order a, c, b of a row impossible, which a price of going back makes the best.
    row = tuple(square("abc"[i], i) for i in range(3))
    rules = Rules("travel", neighbours_only=True, backward_price=3.0)
    found.append((Instance("row", row, home, precedence=((2, 1),)), rules))
    # From right to left to right, which positions alone do not tell.
    line = tuple(Contour(f"c{x}", np.array([[100.0 * x, 0, 0]]), 1.0) for x in range(5))
    found += [(Instance("line", line, home, precedence=((4, 0), (0, 3))), Rules("travel"))] * 5
    # Corners of a square: in one go, the two opposite ones of a part are cut one after the other.
    corners = ((0, 0, "1"), (100, 0, None), (100, 100, "1"), (0, 100, None))
    tiles = tuple(Contour(f"t{i}", np.array([[x, y, 0.0]]), 1.0, part=p) for i, (x, y, p) in enumerate(corners))
    for heads in ((Head("h"),), (Head("h", np.array([50.0, 50.0, 0.0])),)):
        found += [(Instance("square", tiles, heads), Rules("travel", parts_in_one_go=True))] * 3
    for seed in range(5):
        halves = random_instance(np.random.default_rng(seed), 4, heads=1, entries=2, metric="matrix")
        assert halves.matrix is not None
        found.append((replace(halves, matrix=halves.matrix / 2), Rules("travel")))
    best = [(instance, rules, best_plan(instance, rules)) for instance, rules in found]
    return [(instance, rules, plan.value) for instance, rules, plan in best if plan is not None]


def square(name: str, place: int) -> Contour:
    """A square of a row, to be entered at its upper corners."""
    corners = np.array([[0.0, 0, 0], [30, 0, 0], [30, 30, 0], [0, 30, 0]]) + place * np.array([50.0, 0, 0])
    return Contour(name, corners[2:], 120.0, geometry=corners[:, :2])


def document_of(instance: Instance) -> dict[str, Any]:
    document: dict[str, Any] = json.loads(format_instance(instance))
    return document


def proof_of(rng: np.random.Generator, instance: Instance, every: bool) -> dict[str, Any]:
    """Random prices and memories for every beginning, or for those that suffice."""
    count = len(instance.contours)
    firsts: list[Any] = [None]
    if instance.heads[0].home is None:
        later = {after for _, after in instance.precedence}
        contours = [c for c in range(count) if c not in later] if every else [int(rng.integers(count))]
        firsts = [
            [instance.contours[c].id, e]
            for c in contours
            for e in range(len(instance.contours[c].entry_points))
        ]
    walks = []
    for first in firsts:
        share = rng.choice([0.0, 0.5, 1.0])
        memories = [np.flatnonzero(rng.random(count) < share).tolist() for _ in range(count)]
        prices = rng.integers(-100 * SCALE, 100 * SCALE, count).tolist()
        walks.append({"first": first, "prices": prices, "memories": memories})
    return {"kind": "contour-dp", "walks": walks}


def certificate_of(instance: Instance, rules: Rules, digest: str, bound: int, proof: Any) -> dict[str, Any]:
    return {
        "format": "cutgap-certificate",
        "version": 1,
        "instance": digest,
        "rules": asdict(rules),
        "scale": SCALE,
        "multiplier_scale": 1,
        "bound": bound,
        "plan": None,
        "proof": proof,
    }


def turns(instance: Instance, rules: Rules) -> bool:
    """Whether a closed tour may be turned."""
    return not instance.precedence and not rules.process


@battery
def contour_proofs_reach_the_optimum_and_no_more(api: Any) -> None:
    for number, (instance, rules, optimum) in enumerate(samples()):
        rng = np.random.default_rng(number)
        document = document_of(instance)
        digest = api.problem_of(document).digest
        whole = instance.matrix is not None
        # Each leg, and each price of going back, is rounded down by less than 1.
        lost = 0 if whole else 2 * len(instance.contours) + 2
        proof = proof_of(rng, instance, not turns(instance, rules) or bool(rng.integers(2)))
        reached = max(0, math.floor(optimum * SCALE + 1e-6) - lost)
        api.verify(certificate_of(instance, rules, digest, reached, proof), document)
        beyond = certificate_of(instance, rules, digest, math.floor(optimum * SCALE + 1e-6) + 1, proof)
        with pytest.raises(api.Refused, match=BEYOND):
            api.verify(beyond, document)


@battery
def makespans_count_the_work(api: Any) -> None:
    for number, (instance, rules, _) in enumerate(samples()[:20]):
        timed = replace(rules, objective="makespan", backward_price=0.0)
        best = best_plan(instance, timed)
        assert best is not None
        document = document_of(instance)
        digest, unit = api.problem_of(document).digest, SCALE * instance.machine.v_jump
        proof = proof_of(np.random.default_rng(number), instance, True)
        reached = math.floor(best.value * unit) - 2 * len(instance.contours) - 4
        api.verify(certificate_of(instance, timed, digest, reached, proof), document)
        with pytest.raises(api.Refused, match=BEYOND):
            api.verify(
                certificate_of(instance, timed, digest, math.floor(best.value * unit) + 2, proof), document
            )


@battery
def beginnings_are_not_left_out(api: Any) -> None:
    seen = 0
    for number, (instance, rules, _) in enumerate(samples()):
        if instance.heads[0].home is not None:
            continue
        document = document_of(instance)
        digest = api.problem_of(document).digest
        proof = proof_of(np.random.default_rng(number), instance, not turns(instance, rules))
        api.verify(certificate_of(instance, rules, digest, 0, proof), document)
        for place in range(len(proof["walks"])):
            less = copy.deepcopy(proof)
            del less["walks"][place]
            with pytest.raises(api.Refused, match="left out"):
                api.verify(certificate_of(instance, rules, digest, 0, less), document)
            seen += 1
    assert seen > 20


FORGED: list[tuple[str, Any, str]] = [
    ("walks", 5, "list"),
    ("first", "c0", "list"),
    ("first", ["x", 0], "no contour"),
    ("first", ["c0", 99], "no entry point"),
    ("first", ["c0", -1], "at least"),
    ("prices", [0], "entries"),
    ("prices", [0.5, 0, 0, 0], "whole number"),
    ("memories", [[]], "entries"),
    ("memories", [[4], [], [], []], "numbers of contours"),
    ("memories", [[-1], [], [], []], "numbers of contours"),
    ("memories", [[True], [], [], []], "numbers of contours"),
    ("extra", 0, "unknown field"),
]


@battery
def forged_contour_proofs_are_refused(api: Any) -> None:
    instance = random_instance(np.random.default_rng(1), 4, heads=1, homes=True, entries=2, metric="matrix")
    document, rules = document_of(instance), Rules("travel")
    digest = api.problem_of(document).digest
    good = {"first": None, "prices": [0] * 4, "memories": [[]] * 4}
    api.verify(certificate_of(instance, rules, digest, 0, {"kind": "contour-dp", "walks": [good]}), document)
    for field, value, message in FORGED:
        proof = {"kind": "contour-dp", "walks": value if field == "walks" else [{**good, field: value}]}
        with pytest.raises(api.Refused, match=message):
            api.verify(certificate_of(instance, rules, digest, 0, proof), document)
    twice = {"kind": "contour-dp", "walks": [good, good]}
    with pytest.raises(api.Refused, match="there already"):
        api.verify(certificate_of(instance, rules, digest, 0, twice), document)
    none = certificate_of(instance, rules, digest, 0, {"kind": "contour-dp", "walks": [good]}) | {"bound": None}
    with pytest.raises(api.Refused, match="bounds"):
        api.verify(none, document)
    two = replace(instance, heads=(Head("l"), Head("r")), matrix=instance.matrix[:-1, :-1])
    document = document_of(two)
    digest = api.problem_of(document).digest
    proof = {"kind": "contour-dp", "walks": [good]}
    with pytest.raises(api.Refused, match="one head"):
        api.verify(certificate_of(two, Rules("travel", non_overlap=None), digest, 0, proof), document)


@battery
def curves_are_needed_for_rules_on_curves(api: Any) -> None:
    instance = random_instance(np.random.default_rng(2), 3, heads=1, homes=True, entries=2)
    document, rules = document_of(instance), Rules("travel", clear_rapids=True)
    proof = proof_of(np.random.default_rng(0), instance, True)
    with pytest.raises(api.Refused, match="no geometry"):
        api.verify(certificate_of(instance, rules, api.problem_of(document).digest, 0, proof), document)


@battery
def segments_meet_where_they_should(api: Any) -> None:
    rng = np.random.default_rng(0)
    seen = {True: 0, False: 0}
    for _ in range(3000):
        p, q, a, b = (tuple(row) for row in rng.integers(0, 4, (4, 2)).tolist())
        if p == q or a == b:
            continue
        met = _meet(p, q, a, b)
        seen[met] += 1
        assert api.segments.meet(p, q, a, b) == met
    assert min(seen.values()) > 100


@battery
def curves_lie_in_curves(api: Any) -> None:
    seen = 0
    for seed in range(12):
        sheet = random_sheet(np.random.default_rng(seed), 6, nested=0.8)
        if seed == 0:  # of two equal curves the later one lies in the first
            sheet = replace(sheet, contours=(*sheet.contours, replace(sheet.contours[0], id="again")))
        curves = api.curves.Curves(api.problem_of(document_of(sheet)), api.proof.Budget())
        around = enclosures([contour.geometry for contour in sheet.contours])
        for one, other in combinations(range(len(around)), 2):
            found = api.nests.lies_in((one, other), curves.edges[one], curves.edges[other], curves.budget)
            assert found == (other in around[one], one in around[other])
            seen += any(found)
    assert seen > 20


@battery
def neighbours_in_doubt_are_refused(api: Any) -> None:
    """Curves that may cross, touch, or have no area: what the checker says the library says too."""
    seen = {"refused": 0, True: 0, False: 0}
    for seed in range(400):
        rng = np.random.default_rng(seed)
        square, contours = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]), []
        for name in "abc":
            corners = square * rng.integers(1, 9, 2) if rng.random() < 0.8 else rng.integers(0, 9, (3, 2))
            curve = (corners + rng.integers(0, 12, 2)) / 10
            contours.append(Contour(name, [[*curve[int(rng.integers(len(curve)))], 0]], 1.0, geometry=curve))
        sheet = Instance("sheet", tuple(contours), (Head("h"),))
        curves = api.curves.Curves(api.problem_of(document_of(sheet)), api.proof.Budget())
        for one, other in combinations(range(3), 2):
            try:
                found = curves.neighbours(one, other)
            except api.Refused:
                seen["refused"] += 1
                continue
            assert found == adjacent_parts(sheet)[one, other]
            seen[found] += 1
    assert min(seen.values()) > 20


@battery
def curves_in_doubt_are_known(api: Any) -> None:
    """Pairs of curves, and which one lies in the other; none where that depends on the point that is asked."""
    big, small = [(0, 0), (40, 0), (40, 40), (0, 40)], [(10, 10), (20, 10), (20, 20), (10, 20)]
    beside = [(40, 10), (60, 10), (60, 20), (40, 20)]
    bow, cross = [(10, 10), (20, 20), (20, 10), (10, 30)], [(30, 10), (60, 10), (60, 20), (30, 20)]
    spike = [(10, 10), (20, 10), (30, 10), (20, 10), (20, 20)]
    thin = [(-10, -10), (130, 130), (130, 129)]  # through two corners, outside at its corners and middles
    far = [(10**8 + x, 10**8 + y) for x, y in small]
    flat, corner = [(10, 10), (20, 10), (30, 10)], [(0, 0), (10, 10), (0, 20)]
    nearly = [(0, 0), (40 * 10**10, 0), (40 * 10**10, 40 * 10**10 - 1), (0, 40 * 10**10)]
    pairs = [
        (small, big, (True, False)), (big, small, (False, True)), (corner, big, (True, False)),
        (big, big, (False, True)), (beside, big, (False, False)), (big[1:] + big[:1], big, None),
        (bow, big, None), (cross, big, None), (spike, big, None), (thin, big, None), (flat, big, None),
        (far, [(10**7 * x, 10**7 * y) for x, y in big], None),
        ([(10**10 * x, 10**10 * y) for x, y in big], nearly, None),
    ]  # fmt: skip
    for one, other, expected in pairs:
        edges = [list(pairwise([*curve, curve[0]])) for curve in (one, other)]
        try:
            assert api.nests.lies_in((0, 1), *edges, api.proof.Budget()) == expected
        except api.Refused:
            assert expected is None
    with pytest.raises(api.Refused, match="too many steps"):
        api.nests.lies_in((0, 1), list(pairwise([*bow, bow[0]])), edges[1], api.proof.Budget(100))


@battery
def plans_are_checked_against_curves(api: Any) -> None:
    seen = {True: 0, False: 0}
    for seed, (neighbours, clear) in product(range(12), ((True, False), (False, True), (True, True))):
        rng = np.random.default_rng(seed)
        sheet = random_sheet(rng, 5, homes=None, entries=2)
        if seed >= 8:  # squares in a row, not all of them neighbours
            sheet = Instance("row", tuple(square(name, i) for i, name in enumerate("abcde")), (Head("h"),))
        rules = Rules("travel", neighbours_only=neighbours, clear_rapids=clear)
        document = document_of(sheet)
        problem = api.problem_of(document)
        exact = api.rules_of(asdict(rules), problem)
        for _ in range(10):
            plan = random_plan(rng, sheet)
            tours = [[[problem.ids[contour], entry] for contour, entry, *_ in tour] for tour in plan.tours]
            broken = {each.constraint for each in check(sheet, rules, plan)}
            if "precedence" in broken:
                continue
            seen[not broken] += 1
            if broken:
                with pytest.raises(api.Refused, match=ON_CURVES):
                    api.plan.plan_value(problem, exact, tours)
            else:
                assert api.plan.plan_value(problem, exact, tours) > 0
    assert min(seen.values()) > 20
