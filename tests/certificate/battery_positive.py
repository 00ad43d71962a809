"""Checks of what follows from semidefinite matrices: cosines, rows of vectors, spreads of bisections."""

import copy
import re
from decimal import Decimal, getcontext, localcontext
from fractions import Fraction
from functools import cache
from itertools import combinations, pairwise, permutations, product
from typing import Any

import numpy as np
import pytest
from oracles.held_karp import shortest_tour

from certificate.battery import battery
from certificate.plans import excess, tour_points
from certificate.samples import document_of, instance_of
from cutgap.formulations.relaxations.bisection import bisection
from cutgap.formulations.relaxations.connectivity import connectivity
from cutgap.formulations.relaxations.cycle_distances import cycle_distances
from cutgap.instances import Rules

TRAVEL = Rules("travel")


def pi() -> Decimal:
    """Gauss and Legendre: arithmetic and geometric means."""
    a, b, t, p = Decimal(1), 1 / Decimal(2).sqrt(), Decimal("0.25"), 1
    for _ in range(8):
        a, b, t, p = (a + b) / 2, (a * b).sqrt(), t - p * ((a - b) / 2) ** 2, 2 * p
    return (a + b) ** 2 / (4 * t)


def true_cosine(steps: int, count: int) -> Decimal:
    """Of a small angle, doubled 60 times."""
    angle = 2 * pi() * steps / count / 2**60
    value = 1 - angle**2 / 2 + angle**4 / 24 - angle**6 / 720
    for _ in range(60):
        value = 2 * value**2 - 1
    return value


@battery
def cosines_are_enclosed(api: Any) -> None:
    unit = api.cosines.UNIT
    with localcontext() as context:
        context.prec = 110
        assert getcontext().prec == 110
        for count in (2, 3, 4, 5, 7, 12, 60, 997):
            for steps in {0, 1, count // 4, count // 3, count // 2, count - 1, count + 1}:
                low, high = api.cosines.cosine(steps, count)
                assert low <= unit * true_cosine(steps, count) <= high
                assert high - low <= 5


def tour_of(api: Any, seed: int, nodes: int, model: str = "edges", via: bool = False) -> Any:
    problem = api.problem_of(document_of(instance_of(seed, nodes - 1, "grid", heads=1)))
    return api.tour_relaxation(problem, 0, list(range(nodes - 1)), via, 10, 2, model)


def vectors(rng: Any, nodes: int) -> list[list[int]]:
    """Small and large ones, and the waves of the tour 0, 1, 2 ..."""
    waves = [np.rint(10**6 * f(2 * np.pi * np.arange(nodes) / nodes)).astype(int) for f in (np.cos, np.sin)]
    drawn = [rng.integers(-size, size + 1, nodes) for size in (1, 1, 1, 3, 10, 1000)]
    alternating = [[1, 0, -1, 0, 0, 0, 0][:nodes], [1] + [0] * (nodes - 1), [10**6] * nodes]
    return [[int(v) for v in f] for f in (*waves, *drawn, *alternating)]


@battery
def rows_of_connectivity_hold_and_are_tight(api: Any) -> None:
    rng = np.random.default_rng(0)
    for nodes in (4, 5, 6, 7):
        relaxation = tour_of(api, nodes, nodes)
        _, points = tour_points(relaxation, nodes)
        beta = 2 - 2 * np.cos(2 * np.pi / nodes)
        tight = 0
        for f in vectors(rng, nodes):
            row = relaxation.row(["connectivity", f])
            over = excess(relaxation, [row], points)[0]
            assert (over >= 0).all(), f
            spread = sum(v * v for v in f) - sum(f) ** 2 / nodes
            # Rounded up, but by no more than one.
            assert row.rhs == pytest.approx(beta * spread, abs=1 + 1e-9 * spread)
            tight += over.min() <= 1e-5 * max(1, row.rhs)
        assert tight >= 4  # both waves, and vectors whose rows are rounded up


def distance_points(relaxation: Any, nodes: int) -> Any:
    """The variables of every tour, one a row, and its order."""
    orders = [(0, *order) for order in permutations(range(1, nodes))]
    points = np.zeros((len(orders), len(relaxation.costs)))
    for order, point in zip(orders, points, strict=True):
        for (p, u), (q, v) in combinations(enumerate(order), 2):
            steps = min(q - p, nodes - q + p)
            point[relaxation.variable(["x", steps, min(u, v), max(u, v)])] = 1
    return orders, points


@battery
def rows_of_distances_hold_and_are_tight(api: Any) -> None:
    rng = np.random.default_rng(1)
    for nodes in (4, 5, 6, 7):
        relaxation = tour_of(api, nodes, nodes, "distances")
        orders, points = distance_points(relaxation, nodes)
        steps = range(1, nodes // 2 + 1)
        equations = [["pair", u, v] for u, v in combinations(range(nodes), 2)]
        equations += [["degree", k, v] for k, v in product(steps, range(nodes))]
        assert (excess(relaxation, [relaxation.row(name) for name in equations], points) == 0).all()
        for i in steps:
            names = [["cosine", i, f] for f in vectors(rng, nodes)]
            over = excess(relaxation, [relaxation.row(name) for name in names], points)
            sizes = np.array([sum(v * v for v in f) for _, _, f in names], dtype=float)
            assert (over >= -1e-15 * sizes[:, None]).all()
            assert over[-1].max() <= 1e-9 * sizes[-1]  # equal numbers cancel out
        problem = api.problem_of(document_of(instance_of(nodes, nodes - 1, "grid", heads=1)))
        home, *_ = problem.homes
        places = [home, *range(nodes - 1)]
        for order, worth in zip(orders, points @ np.array(relaxation.costs, dtype=float), strict=True):
            around = [places[v] for v in (*order, 0)]
            assert worth == 2 * sum(problem.lengths(u, [v], 10)[0] for u, v in pairwise(around))


@battery
def via_rows_of_distances_hold(api: Any) -> None:
    relaxation = tour_of(api, 1, 6, "distances", via=True)
    orders, points = distance_points(relaxation, 6)
    over = excess(relaxation, [relaxation.row(["via"])], points)[0] >= 0
    assert over.tolist() == [bool({order[1], order[-1]} & set(relaxation.leftmost)) for order in orders]
    assert 0 < over.sum() < len(over)
    with pytest.raises(api.Refused, match="no row"):
        tour_of(api, 1, 6, "distances").row(["via"])


@cache
def tour_bound(name: str) -> tuple[dict[str, Any], dict[str, Any], float]:
    """Certificate and document of six nodes, where vectors close a gap of the degrees, and the optimum, mm."""
    part = instance_of(13, 5, "uniform", heads=1)
    relaxation = {"connectivity": connectivity, "distances": cycle_distances}[name]
    return relaxation(part, TRAVEL).certificate, document_of(part), shortest_tour(part.rapids.tolist())[0]


@battery
def vectors_prove_the_optimum_and_no_more(api: Any) -> None:
    for name in ("connectivity", "distances"):
        certificate, document, optimum = tour_bound(name)
        bound = api.verify(certificate, document).bound
        assert optimum * (1 - 1e-6) <= bound <= optimum * (1 + 1e-12)
        rng, rows = np.random.default_rng(2), certificate["proof"]["tour"]["rows"]
        for _ in range(60):
            # The best claim that disturbed vectors and multipliers prove stays below the optimum.
            made = copy.deepcopy(certificate)
            for row in made["proof"]["tour"]["rows"]:
                if row[0] in ("connectivity", "cosine"):
                    row[-1] = [v + int(rng.integers(-(10**6), 10**6)) for v in row[-1]]
            tour = made["proof"]["tour"]
            model = tour["model"]
            problem = api.problem_of(document)
            relaxation = api.tour_relaxation(
                problem, 0, list(range(5)), False, made["scale"], made["multiplier_scale"], model
            )
            built = [relaxation.row(each) for each in tour["rows"]]
            pairs = [(built[i], int(y * rng.uniform(0.99, 1.01))) for i, y in tour["nodes"][0]["leaf"]]
            value, _ = api.leaf_value(relaxation, relaxation.start, pairs)
            assert value <= optimum * made["scale"] * made["multiplier_scale"] * (1 + 1e-12)
        assert {"connectivity": "connectivity", "distances": "cosine"}[name] in {row[0] for row in rows}


def heaviest(family: str, rows: list[Any]) -> int:
    """Number of the row of a family with the largest number."""
    return max(
        (number for number, row in enumerate(rows) if row[0] == family),
        key=lambda number: max(map(abs, rows[number][-1])) if isinstance(rows[number][-1], list) else 0,
    )


TAMPERED: list[tuple[str, str, Any, str]] = [
    ("connectivity", "connectivity", lambda row: row[1].append(0), "vector: expected 6 entries, got 7"),
    ("connectivity", "connectivity", lambda row: row[1].pop(), "vector: expected 6 entries, got 5"),
    ("connectivity", "connectivity", lambda row: row[1].__setitem__(0, 0.5), "whole number"),
    ("connectivity", "connectivity", lambda row: row[1].__setitem__(0, True), "whole number"),
    ("connectivity", "connectivity", lambda row: row[1].__setitem__(0, 10**12 + 1), "beyond"),
    ("connectivity", "connectivity", lambda row: row[1].__setitem__(0, -(10**4000)), "beyond"),
    ("connectivity", "connectivity", lambda row: row.__setitem__(1, [0] * 6), "worth"),
    ("connectivity", "connectivity", lambda row: row.append(1), "no row"),
    ("connectivity", "connectivity", lambda row: row.__setitem__(1, "f"), "no row"),
    ("distances", "cosine", lambda row: row[2].append(0), "vector: expected 6 entries, got 7"),
    ("distances", "cosine", lambda row: row[2].__setitem__(0, "1"), "whole number"),
    ("distances", "cosine", lambda row: row[2].__setitem__(0, 10**13), "beyond"),
    ("distances", "cosine", lambda row: row.__setitem__(2, [9] * 6), "worth"),
    ("distances", "cosine", lambda row: row.__setitem__(1, 0), "no row"),
    ("distances", "cosine", lambda row: row.__setitem__(1, 4), "no row"),
    ("distances", "degree", lambda row: row.__setitem__(1, 4), "no row"),
    ("distances", "degree", lambda row: row.__setitem__(1, 0), "no row"),
    ("distances", "degree", lambda row: row.__setitem__(2, 6), "no row"),
    ("distances", "pair", lambda row: row.__setitem__(1, row[2]), "no row"),
    ("distances", "pair", lambda row: row.__setitem__(1, -1), "no row"),
]


@battery
def tampered_vectors_are_refused(api: Any) -> None:
    for name, family, change, message in TAMPERED:
        certificate, document, _ = tour_bound(name)
        made = copy.deepcopy(certificate)
        rows = made["proof"]["tour"]["rows"]
        change(rows[heaviest(family, rows)])
        assert re.search(message, refusal(api, made, document)), (family, message)


@battery
def models_go_with_their_rows(api: Any) -> None:
    certificate, document, _ = tour_bound("distances")
    for change, message in (
        ({"model": "edges"}, "no row"),
        ({"model": "beauty"}, "model: no 'beauty'"),
        ({"model": 3}, "model: no 3"),
        ({"nodes": [{"branch": ["x", 4, 0, 1], "at": 0, "down": 1, "up": 2}]}, "no variable"),
        ({"nodes": [{"branch": ["x", 1, 1, 0], "at": 0, "down": 1, "up": 2}]}, "no variable"),
    ):
        made = copy.deepcopy(certificate)
        made["proof"]["tour"] |= change
        assert message in refusal(api, made, document)
    made = copy.deepcopy(certificate)
    tour = made["proof"]["tour"]
    del tour["rows"], tour["nodes"]
    assert "model: goes with" in refusal(api, made, document)
    number = heaviest("cosine", certificate["proof"]["tour"]["rows"])
    made = copy.deepcopy(certificate)
    made["proof"]["tour"]["nodes"][0]["leaf"].append([number, -1])
    assert "no equation" in refusal(api, made, document)


def refusal(api: Any, certificate: Any, document: Any) -> str:
    with pytest.raises(api.Refused) as caught:
        api.verify(certificate, document)
    return str(caught.value)


@battery
def distances_are_limited(api: Any) -> None:
    problem = api.problem_of(document_of(instance_of(0, 64, "uniform", heads=1)))
    with pytest.raises(api.Refused, match="distances: 65 nodes, the most is 64"):
        api.tour_relaxation(problem, 0, list(range(64)), False, 1, 1, "distances")
    assert api.tour_relaxation(problem, 0, list(range(63)), False, 1, 1, "distances").count == 64


# Bisections


def spreads(document: dict[str, Any], limit: Fraction) -> list[Fraction]:
    """The spread of every division within the limit, by trying all."""
    places = [[Fraction(repr(x)) for x in c["entry_points"][0]] for c in document["contours"]]
    machine = {name: Fraction(repr(document["machine"][name])) for name in ("v_cut", "t_aux")}
    work = [Fraction(repr(c["perimeter"])) / machine["v_cut"] + machine["t_aux"] for c in document["contours"]]
    found = []
    for sides in product((1, -1), repeat=len(places)):
        if abs(sum(s * w for s, w in zip(sides, work, strict=True))) <= limit:
            pairs = combinations(range(len(places)), 2)
            found.append(
                sum(
                    sum((a - b) ** 2 for a, b in zip(places[i], places[j], strict=True))
                    for i, j in pairs
                    if sides[i] == sides[j]
                )
            )
    return found


@cache
def bisection_of(seed: int, holes: int, limit: float) -> tuple[dict[str, Any], dict[str, Any]]:
    part = instance_of(seed, holes, "uniform" if seed % 2 else "grid")
    return bisection(part, limit).certificate, document_of(part)


@battery
def factors_prove_no_more_than_the_least_spread(api: Any) -> None:
    rng = np.random.default_rng(3)
    for seed, limit in product(range(4), (0.5, 2.0, 20.0)):
        certificate, document = bisection_of(seed, 6, limit)
        verdict = api.verify_bisection(certificate, document)
        found = spreads(document, Fraction(repr(limit)))
        assert verdict.limit == Fraction(repr(limit))
        if verdict.bound is None:
            assert found == []
            continue
        problem = api.problem_of(document)
        for step in range(40):
            price = int(certificate["price"] * rng.uniform(0.8, 1.2)) if step else certificate["price"]
            size = 10 ** int(rng.integers(0, 9)) if step else 1
            factors = [[v + int(rng.integers(-size, size)) for v in f] for f in certificate["factors"]]
            total, value = api.bisection.spread_value(
                problem, verdict.limit, certificate["scale"], price, factors
            )
            assert all(total + value <= 4 * certificate["scale"] * each for each in found)
            if not step:
                assert total + value >= 4 * certificate["bound"] * Fraction(999, 1000)


@battery
def four_corners_of_a_tetrahedron_split_in_pairs(api: Any) -> None:
    """Two of the six squared edges are left, and the bound is that: Q = 8 (J - I), s'Qs >= -32 exactly."""
    document = document_of(instance_of(0, 4, "grid"))
    corners = ([0, 0, 0], [2, 2, 0], [2, 0, 2], [0, 2, 2])
    for contour, corner in zip(document["contours"], corners, strict=True):
        contour |= {"entry_points": [corner], "perimeter": 40.0}
    made = {
        "format": "cutgap-bisection",
        "version": 1,
        "instance": api.instance_hash(document),
        "limit": 0,
        "scale": 2,
        "bound": 32,
        "price": 0,
        "factors": [[4, 4, 4, 4]],
    }
    assert api.verify_bisection(made, document).bound == 16
    with pytest.raises(api.Refused, match="prove less"):
        api.verify_bisection(made | {"bound": 33}, document)
    # What a factor misses counts twice: 192 - (3 * 16 + 9) - 6 * 4 = 111.
    missing = made | {"factors": [[4, 4, 4, 3]]}
    assert api.verify_bisection(missing | {"bound": 27}, document).bound == Fraction(27, 2)
    with pytest.raises(api.Refused, match="prove less"):
        api.verify_bisection(missing | {"bound": 28}, document)


@battery
def an_outweighing_contour_leaves_no_division(api: Any) -> None:
    document = document_of(instance_of(0, 3, "grid"))
    document["machine"] |= {"v_cut": 1.0, "t_aux": 0.0}
    for contour, perimeter in zip(document["contours"], (5.5, 1.0, 2.0), strict=True):
        contour["perimeter"] = perimeter
    # (w's)^2 = 2.5^2 at least: w w' less the diagonal 2.5 (5.5, -1, -2) is f f' + g g', about.
    matrix = np.outer((5.5, 1, 2), (5.5, 1, 2)) - np.diag(2.5 * np.array((5.5, -1, -2)))
    values, columns = np.linalg.eigh(matrix)
    factors = np.rint(1e5 * columns * np.sqrt(np.maximum(values, 0))).astype(int).T.tolist()
    made = {
        "format": "cutgap-bisection",
        "version": 1,
        "instance": api.instance_hash(document),
        "limit": 2.49,
        "scale": 10**9,
        "bound": None,
        "price": 10**10,
        "factors": factors,
    }
    assert api.verify_bisection(made, document).bound is None
    with pytest.raises(api.Refused, match="do not show"):
        api.verify_bisection(made | {"limit": 2.51}, document)


BISECTIONS: list[tuple[dict[str, Any], str]] = [
    ({"format": "cutgap-certificate"}, "format"),
    ({"version": 2}, "version"),
    ({"instance": "0" * 64}, "another instance"),
    ({"limit": -1}, "at least 0"),
    ({"limit": None}, "number"),
    ({"scale": 0}, "scale"),
    ({"price": -1}, "price"),
    ({"price": 0.5}, "whole number"),
    ({"bound": 0.5}, "bound"),
    ({"bound": None}, "do not show"),
    ({"factors": [[1] * 6] * 7}, "at most 6, got 7"),
    ({"factors": [[1] * 5]}, "expected 6 entries"),
    ({"factors": [[1.5] * 6]}, "whole number"),
    ({"factors": [[10**13] * 6]}, "beyond"),
    ({"factors": []}, "prove less"),
    ({"plan": None}, "unknown field"),
]


@battery
def forged_bisections_are_refused(api: Any) -> None:
    certificate, document = bisection_of(1, 6, 2.0)
    assert certificate["bound"] > 0
    more = {"bound": certificate["bound"] * 11 // 10}
    for change, message in [*BISECTIONS, (more, "prove less")]:
        with pytest.raises(api.Refused, match=message):
            api.verify_bisection(certificate | change, document)
    with pytest.raises(api.Refused, match="format"):
        api.verify(certificate, document)
    with pytest.raises(api.Refused, match="format"):
        api.verify_bisection(tour_bound("distances")[0], document)
    for change, message in (
        ({"machine": document["machine"] | {"metric": "matrix"}, "matrix": [[0] * 8] * 8}, "coordinates"),
        ({"contours": [c | {"entry_points": [[0, 0, 0], [1, 1, 1]]} for c in document["contours"]]}, "entry"),
        ({"contours": [c | {"id": f"{i} {c['id']}"} for c in document["contours"] for i in range(51)]}, "many"),
    ):
        other = document | change
        with pytest.raises(api.Refused, match=message):
            api.verify_bisection(certificate | {"instance": api.instance_hash(other)}, other)
