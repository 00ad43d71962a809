"""Checks of plans with links: proofs and forged ones, blocked and clear links, plans."""

import copy
from functools import cache
from itertools import combinations, permutations
from typing import Any

import numpy as np
import pytest
from oracles.link_plans import Sheet, least, runs_through
from oracles.random_link_sheets import instance_of, tiny

from certificate.battery import battery
from certificate.forgeries_links import LINKS, PLANS
from certificate.samples import document_of
from cutgap.formulations import solve
from cutgap.instances import Contour, Head, Instance, Machine, Rules, evaluate

SCALE = 10**9
SIZES = ((2, 2), (2, 2, 2), (1, 2, 2), (1, 1, 2, 1))
RULES = tuple(
    Rules(objective, links=True, pierces=pierces)
    for objective in ("travel", "makespan")
    for pierces in (None, 1, 2)
)
CASES = tuple((seed, rules) for seed in range(8) for rules in RULES)


@cache
def drawn(seed: int) -> tuple[Sheet, Instance]:
    sheet = tiny(np.random.default_rng(100 + seed), SIZES[seed % len(SIZES)])
    return sheet, instance_of(sheet)


@cache
def made(seed: int, rules: Rules) -> tuple[dict[str, Any], dict[str, Any], float | None]:
    """A true certificate, its instance, and the optimum in its units."""
    sheet, instance = drawn(seed)
    best = least(sheet, rules.objective, rules.pierces)
    certificate = solve(instance, rules, certify=True).certificate
    assert certificate is not None
    unit = SCALE * (sheet.v_jump if rules.objective == "makespan" else 1.0)
    return certificate, document_of(instance), None if best is None else best * unit


def tree_of(api: Any, certificate: dict[str, Any], document: dict[str, Any], names: list[Any]) -> Any:
    links = api.links
    problem = api.problem_of(document)
    rules = api.rules_of(certificate["rules"], problem)
    costs = links.Costs(problem, rules, SCALE, False)
    links._block(costs, certificate["proof"]["blocked"], links.Budget())
    return links.Tree(costs, rules, certificate["multiplier_scale"], names, links.Budget())


def more_rows(rng: np.random.Generator, instance: Instance, rules: Rules) -> list[Any]:
    """Rows of all families over any sets."""
    count, nodes = len(instance.contours), instance.node_count
    contour_of = np.repeat(np.arange(count), np.diff(instance.first_node))
    pairs = [(p, q) for p, q in combinations(range(nodes - 1), 2) if contour_of[p] != contour_of[q]]
    edges = [["s", p, q] for p, q in pairs] + [["r", p, nodes - 1] for p in range(nodes - 1)]
    edges += [["r", p, q] for p, q in pairs]
    rows: list[Any] = [["home"], ["partition", [[contour] for contour in range(count)]]]
    rows += [["partition", [[contour]]] for contour in range(count)]
    rows += [["group", [contour], []] for contour in range(count)]
    rows += [["pierces"]] if rules.pierces is not None else []
    for i, j in combinations(range(count), 2):
        own = [(p, q) for p, q in pairs if (contour_of[p], contour_of[q]) == (i, j)]
        rows.append(["group", [i, j], [[i, j, *own[int(rng.integers(len(own)))]]]])
    places = [*range(instance.node_count)]
    for i, j in permutations(range(count + 1), 2):
        own = [v for v in places if ([*contour_of, count][v] == i) and rng.random() < 0.5]
        rows.append(["bundle", i, j, own])
        rows += [["once", i, j]] if i < j else []
        for k in set(range(count + 1)) - {i, j}:
            other = [v for v in places if ([*contour_of, count][v] == j) and rng.random() < 0.5]
            rows.append(["triangle", i, j, k, own, other])
    triples = [list(triple) for triple in combinations(range(count + 1), 3)]
    for _ in range(3 * (count > 1)):
        triple = triples[int(rng.integers(len(triples)))]
        parts = [[contour] for contour in range(count) if rng.random() < 0.7] or [[0]]
        rows.append(["rank", parts, [triple]])
    for _ in range(12):
        inside = np.flatnonzero(rng.random(nodes) < rng.uniform(0.1, 0.7)).tolist() or [0]
        border = [edge for edge in edges if (edge[1] in inside) != (edge[2] in inside)]
        if border:
            rows.append(["parity", inside, [border[int(rng.integers(len(border)))]]])
    return rows


@battery
def proofs_of_links_reach_the_optimum(api: Any) -> None:
    for seed, rules in CASES:
        certificate, document, optimum = made(seed, rules)
        verdict = api.verify(certificate, document)
        if optimum is None:
            assert verdict.bound is None
            continue
        assert optimum - 1e-3 * SCALE <= certificate["bound"] <= optimum
        _, instance = drawn(seed)
        value = optimum / SCALE / (instance.machine.v_jump if rules.objective == "makespan" else 1.0)
        assert float(verdict.value) == pytest.approx(value, rel=1e-9, abs=1e-9)
        higher = certificate | {"bound": int(optimum) + 10**4, "plan": None}
        with pytest.raises(api.Refused):
            api.verify(higher, document)


@battery
def links_prove_no_more_than_the_optimum(api: Any) -> None:
    """Hill climbing over multipliers of any rows stays below brute force, and comes near it."""
    rng = np.random.default_rng(5)
    reached = 0
    for seed, rules in CASES:
        certificate, document, optimum = made(seed, rules)
        if optimum is None:
            continue
        sheet, instance = drawn(seed)
        names = [*certificate["proof"]["rows"], *more_rows(rng, instance, rules)]
        tree = tree_of(api, certificate, document, names)
        work = instance.perimeters.sum() * sheet.v_jump / sheet.v_cut if rules.objective == "makespan" else 0.0
        limit = optimum - SCALE * float(work)
        leaves = [node["leaf"] for node in certificate["proof"]["nodes"] if "leaf" in node]
        multipliers = dict(leaves[0])
        unit = certificate["multiplier_scale"] * SCALE
        best = tree._value([list(pair) for pair in multipliers.items()], {})
        for step in range(60):
            changed = dict(multipliers)
            for index in rng.integers(0, len(names), 2).tolist():
                size = int(unit * 10 ** rng.uniform(-2, 1.5))
                shift = int(rng.integers(-size, size + 1))
                is_home = names[index] == ["home"]
                changed[index] = (
                    changed.get(index, 0) + shift if is_home else max(0, changed.get(index, 0) + shift)
                )
            value = tree._value([list(pair) for pair in changed.items()], {})
            if value >= best or step < 3:
                best, multipliers = max(best, value), changed
        assert best <= certificate["multiplier_scale"] * (limit + 100), (seed, rules)
        reached += best >= 0.98 * certificate["multiplier_scale"] * limit
    assert reached > len(CASES) // 2


@battery
def each_row_alone_holds(api: Any) -> None:
    """A multiple of one row beside the best multipliers gains nothing."""
    rng = np.random.default_rng(6)
    for seed, rules in CASES[::2]:
        certificate, document, optimum = made(seed, rules)
        if optimum is None:
            continue
        sheet, instance = drawn(seed)
        names = [*certificate["proof"]["rows"], *more_rows(rng, instance, rules)]
        tree = tree_of(api, certificate, document, names)
        work = instance.perimeters.sum() * sheet.v_jump / sheet.v_cut if rules.objective == "makespan" else 0.0
        limit = certificate["multiplier_scale"] * (optimum - SCALE * float(work) + 100)
        leaf = next(node["leaf"] for node in certificate["proof"]["nodes"] if "leaf" in node)
        for index in range(len(names)):
            for power in (-1, 1, 2):
                price = int(certificate["multiplier_scale"] * SCALE * 10.0**power)
                changed = dict(leaf)
                changed[index] = changed.get(index, 0) + price
                assert tree._value([list(pair) for pair in changed.items()], {}) <= limit, names[index]


@battery
def rows_of_links_have_their_coefficients(api: Any) -> None:
    """What a row adds to the reduced cost of each variable is what docs/certificates.md says."""
    rng = np.random.default_rng(7)
    for seed, rules in CASES[:12]:
        certificate, document, optimum = made(seed, rules)
        if optimum is None:
            continue
        _, instance = drawn(seed)
        names = more_rows(rng, instance, rules)
        tree = tree_of(api, certificate, document, names)
        empty, count = tree._prices([]), len(instance.contours)
        place_of = [*np.repeat(np.arange(count), np.diff(instance.first_node)).tolist(), count]
        edges = [("d", i, j) for i, j in combinations(range(count + 1), 2)]
        for p, q in combinations(range(instance.node_count), 2):
            if place_of[p] != place_of[q]:
                edges += [("r", p, q)] if q == instance.node_count - 1 else [("s", p, q), ("r", p, q)]
        for index, name in enumerate(names):
            prices = tree._prices([[index, 1]])
            for edge in edges:
                if edge[0] != "d" and tree.costs.joined(*edge[1:]):
                    continue  # the link or the rapid, whichever is less
                found = tree._reduced(edge, empty) - tree._reduced(edge, prices)
                assert found == coefficient(name, edge, place_of, count), (name, edge)
            assert prices.value == right_side(name, rules)


def coefficient(name: list[Any], edge: tuple[str, int, int], place_of: list[int], home: int) -> int:
    """What a row says of a variable s, r or d."""
    kind, tail, head = edge
    i, j = (tail, head) if kind == "d" else (place_of[tail], place_of[head])
    single = kind != "d"
    match name:
        case ["home"]:
            return (j == home) * (1 if single else 2)
        case ["pierces"]:
            return -(kind == "r" and j != home)
        case ["partition" | "rank", parts, *_]:
            labels = [next((n for n, part in enumerate(parts) if place in part), None) for place in (i, j)]
            weight = 1 if name[0] == "rank" else len(parts) + (not single)
            return (labels[0] != labels[1]) * weight
        case ["parity", inside, [odd]]:
            across = single and (tail in inside) != (head in inside)
            return across * (-1 if list(edge) == odd else 1)
        case ["group", contours, joints]:
            ends = (i in contours) + (j in contours)
            joined = any(edge in (("d", a, b), ("s", *nodes)) for a, b, *nodes in joints)
            if kind == "r" or j == home:
                return -ends * (1 if single else 2)
            return -2 * joined
        case ["once", *pair]:
            return -(single and [i, j] == pair)
        case ["bundle", place, other, inside]:
            around = loose(edge, (place, {other}, inside), place_of)
            return single * (around - ({i, j} == {place, other}))
        case ["triangle", place, other, third, inside, outside]:
            sides = (place, {other, third}, inside), (other, {place, third}, outside)
            around = sum(loose(edge, side, place_of) for side in sides)
            return single * (around - ({i, j} == {place, other}))
    raise AssertionError(name)


def loose(edge: tuple[str, int, int], side: tuple[int, set[int], list[int]], place_of: list[int]) -> int:
    """Whether a single edge leaves a place by a node of a set to elsewhere, or by another one to the places."""
    place, near, inside = side
    ends = [(v, w) for v, w in (edge[1:], edge[:0:-1]) if edge[0] != "d" and place_of[v] == place]
    return sum((v in inside) != (place_of[w] in near) for v, w in ends)


def counted(name: list[Any]) -> tuple[dict[tuple[int, ...], int], dict[tuple[int, ...], int]]:
    """What a row says of the e that it names, and of the w."""
    match name:
        case ["once", i, j]:
            return {(i, j): 2}, {}
        case ["bundle", i, j, _]:
            return {(min(i, j), max(i, j)): 2}, {}
        case ["triangle", i, j, k, _, _]:
            return {(min(i, j), max(i, j)): 2}, {tuple(sorted((i, j, k))): 1}
        case ["rank", parts, [triple]]:
            labels = {next((n for n, part in enumerate(parts) if place in part), None) for place in triple}
            return {}, {tuple(triple): -1} if len(labels) > 1 else {}
    return {}, {}


def right_side(name: list[Any], rules: Rules) -> int:
    match name:
        case ["home"]:
            return 2
        case ["pierces"]:
            return 1 - (rules.pierces or 0)
        case ["partition", parts]:
            return len(parts) * (len(parts) + 1)
        case ["rank", parts, _]:
            return len(parts)
        case ["parity", _, odd]:
            return 1 - len(odd)
        case ["group", contours, _]:
            return -2 * len(contours)
        case ["once", *_]:
            return -1
    return 0


@battery
def joints_between_places_are_counted(api: Any) -> None:
    """The e and w of all rows, and what an e adds that partitions speak of."""
    rng = np.random.default_rng(8)
    for seed, rules in CASES[:12]:
        certificate, document, optimum = made(seed, rules)
        if optimum is None:
            continue
        _, instance = drawn(seed)
        names = more_rows(rng, instance, rules)
        tree = tree_of(api, certificate, document, names)
        for index, name in enumerate(names):
            prices = tree._prices([[index, 1]])
            excess, triples = counted(name)
            assert prices.excess == {pair: -value for pair, value in excess.items()}, name
            assert prices.triples == {triple: -value for triple, value in triples.items()}, name
            if name[0] not in ("partition", "rank"):
                assert prices.partitions == []
                continue
            ((weight, label),) = prices.partitions
            assert weight == (1 if name[0] == "rank" else len(name[1]) - 1)
            for i, j in combinations(range(len(label)), 2):
                pairs = len(tree.costs.members[i]) * len(tree.costs.members[j])
                crossed = weight * (label[i] != label[j])
                assert tree._excess(i, j, -5, prices) == min(0, crossed - 5) * pairs


@battery
def negative_counts_are_paid(api: Any) -> None:
    """A w or e of negative reduced cost makes the value less."""
    certificate, document, _ = made(1, RULES[0])
    rows = [["rank", [[0], [1], [2]], [[0, 1, 2]]], ["triangle", 0, 1, 2, [], []], ["once", 0, 1]]
    tree = tree_of(api, certificate, document, rows)
    far = 10**3 * certificate["multiplier_scale"] * SCALE
    tree.least = {pair: (far, far) for pair in tree.least}  # no link or rapid between contours counts
    pairs = len(tree.costs.members[0]) * len(tree.costs.members[1])
    prices = tree._prices([[1, 1]])
    assert (prices.triples[0, 1, 2], prices.excess[0, 1]) == (-1, -2)
    assert tree._value([[1, 1]], {}) == -1 - 2 * pairs
    assert tree._value([[2, 1]], {}) == -1 - 2 * pairs
    assert tree._value([[1, 1], [0, 2]], {}) <= 2 * 3


@battery
def fixed_variables_count_at_their_value(api: Any) -> None:
    for seed, rules in CASES[:12]:
        certificate, document, optimum = made(seed, rules)
        if optimum is None:
            continue
        tree = tree_of(api, certificate, document, certificate["proof"]["rows"])
        leaf = next(node["leaf"] for node in certificate["proof"]["nodes"] if "leaf" in node)
        value, prices = tree._value(leaf, {}), tree._prices(leaf)
        for edge in (("d", 0, 1), ("d", 0, tree.costs.home), ("r", 0, tree.costs.home_node)):
            reduced = tree._reduced(edge, prices)
            assert tree._value(leaf, {edge: 0}) == value - min(0, reduced)
            assert tree._value(leaf, {edge: 1}) == value - min(0, reduced) + reduced


@battery
def links_are_blocked_or_clear(api: Any) -> None:
    for seed in range(8):
        sheet, instance = drawn(seed)
        material = api.links.Material(api.problem_of(document_of(instance)))
        nodes = [spot for spots in sheet.entries for spot in spots]
        corners = [corner for shape in sheet.shapes for corner in shape]
        depth = 1e-7 * max(max(side) - min(side) for side in zip(*corners, strict=True))
        for p, q in combinations(range(len(nodes)), 2):
            through = any(runs_through(nodes[p], nodes[q], shape, depth) for shape in sheet.shapes)
            shares = [api.links.Fraction(k, 200) for k in range(201)]
            assert any(material.is_blocked(p, q, share) for share in shares) == through
            assert material.is_clear(p, q) == (not through)


@battery
def what_lies_in_a_hole_is_no_material(api: Any) -> None:
    material = api.links.Material(api.problem_of(document_of(RINGS)))
    half = api.links.Fraction(1, 2)
    assert material.is_blocked(0, 4, half)
    assert not material.is_blocked(4, 8, half)
    assert material.is_clear(4, 8)
    assert not material.is_clear(0, 4)
    # 1e-6 within the part is nothing on 30 mm, ten times that is too deep.
    for depth, clear in ((1e-6, True), (1e-5, False)):
        beside = (square(name, x, depth, 5) for name, x in (("b", 40), ("c", -20)))
        low = sheet_of(square("a", 0, 0, 30), *beside)
        near = api.links.Material(api.problem_of(document_of(low)))
        assert near.is_clear(4, 8) == clear
        assert not near.is_blocked(4, 8, half)  # for which it takes twice the depth


def square(name: str, x: float, y: float, side: float) -> Contour:
    corners = np.array([[x, y], [x + side, y], [x + side, y + side], [x, y + side]])
    return Contour(name, np.column_stack((corners, np.zeros(4))), 4 * side, geometry=corners)


def sheet_of(*contours: Contour) -> Instance:
    return Instance("squares", contours, (Head("head", np.array([0.0, -5.0, 0.0])),), Machine(100.0, 10.0, 2.0))


RINGS = sheet_of(square("outline", 0, 0, 30), square("hole", 10, 10, 10), square("inside", 13, 13, 4))
ROW = sheet_of(square("a", 0, 0, 10), square("b", 14, 0, 10), square("c", 30, 0, 10))


@cache
def base(name: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """The certificates that are forged."""
    instance, rules = {
        "row": (ROW, Rules("travel", links=True, pierces=1)),
        "row, makespan": (ROW, Rules("makespan", links=True, pierces=2)),
        "rings": (RINGS, Rules("travel", links=True, pierces=1)),
    }[name]
    certificate = solve(instance, rules, certify=True).certificate
    assert certificate is not None
    return certificate, document_of(instance)


@battery
def forged_proofs_of_links_are_refused(api: Any) -> None:
    for name, case, forge, message in LINKS:
        certificate, document = copy.deepcopy(base(case))
        api.verify(certificate, document)
        forge(certificate, document)
        with pytest.raises(api.Refused, match=message):
            print(name, api.verify(certificate, document).text)


@battery
def plans_with_links_are_checked(api: Any) -> None:
    problem = api.problem_of(document_of(ROW))
    for objective in ("travel", "makespan"):
        rules = Rules(objective, links=True, pierces=2)
        exact = api.rules_of(base("row")[0]["rules"] | {"objective": objective, "pierces": 2}, problem)
        for name, document, plan, message in PLANS:
            if message is None:
                value = evaluate(ROW, plan).objective(rules)
                found = float(api.link_plan.linked_plan_value(problem, exact, document))
                assert found == pytest.approx(value, rel=1e-12), name
                assert found >= value * (1 - 1e-15)
                continue
            with pytest.raises(api.Refused, match=message):
                print(name, api.link_plan.linked_plan_value(problem, exact, document))
