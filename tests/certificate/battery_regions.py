"""Checks of tours through regions: bounds of orders, proofs and forged ones, plans with their own points."""

import copy
from dataclasses import replace
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from oracles.random_regions import random_plate
from oracles.region_tours import shortest_in_order

from certificate.battery import battery
from certificate.samples import document_of
from cutgap.formulations import solve
from cutgap.instances import Contour, Head, Instance, Rules
from cutgap.instances.free_entries import region_of
from cutgap.instances.region import Ellipsoid, point_region

FREE = Rules("travel", free_entries=True)
SCALE = 10**9


@cache
def plate(seed: int, precedence: float = 0.0) -> Instance:
    return random_plate(np.random.default_rng(seed), 5, flat=seed % 2 == 0, precedence=precedence)


@cache
def proof(
    seed: int, precedence: float = 0.0, objective: Any = "travel"
) -> tuple[dict[str, Any], dict[str, Any]]:
    """A true certificate and its instance."""
    instance = plate(seed, precedence)
    result = solve(instance, replace(FREE, objective=objective), certify=True)
    assert result.certificate is not None
    return result.certificate, document_of(instance)


@battery
def bounds_of_orders_hold_and_are_tight(api: Any) -> None:
    regions_module = import_module(f"{api.__name__}.regions")
    budget = import_module(f"{api.__name__}.proof").Budget()
    for seed in range(6):
        instance, rng = plate(seed), np.random.default_rng(seed)
        regions = regions_module.regions_of(api.problem_of(document_of(instance)))
        shapes = [*(region_of(instance, k) for k in range(5)), point_region(instance.heads[0].home)]
        order = rng.permutation(6)[: int(rng.integers(2, 7))].tolist()
        length, points = shortest_in_order([shapes[k] for k in order])
        legs = np.roll(points, -1, axis=0) - points
        norms = np.linalg.norm(legs, axis=1, keepdims=True)
        along = legs / np.maximum(norms, 1e-300)
        for spread in (0.0, 0.01, 1.0):
            for _ in range(10):
                u = along + spread * rng.normal(size=along.shape)
                u /= np.maximum(1.0, np.linalg.norm(u, axis=1, keepdims=True)) * (1 + 1e-12)
                leaf = [SCALE, *np.trunc(u * SCALE).astype(int).ravel().tolist()]
                value = float(regions.bound(order, leaf, budget))
                assert value <= length + 1e-6
        if norms.min() > 0.1:  # else directions of legs are not all that there is to the multipliers
            exact = [SCALE, *np.trunc(along * (1 - 1e-12) * SCALE).astype(int).ravel().tolist()]
            assert float(regions.bound(order, exact, budget)) == pytest.approx(length, rel=1e-3)


@battery
def proofs_through_regions_reach_the_optimum(api: Any) -> None:
    for seed, precedence, objective in (
        (0, 0.0, "travel"),
        (1, 0.0, "makespan"),
        (2, 0.4, "travel"),
        (3, 0.4, "travel"),
    ):
        certificate, document = proof(seed, precedence, objective)
        verdict = api.verify(certificate, document)
        assert 0 <= verdict.gap < 1e-6 if verdict.value > 1 else verdict.value - verdict.bound < 1e-5


def set_rules(**changes: Any) -> Any:
    return lambda certificate: certificate["rules"].update(changes)


def set_nodes(change: Any) -> Any:
    return lambda certificate: change(certificate["proof"]["nodes"])


def lengthen(nodes: list[Any]) -> None:
    """A multiplier outside the unit ball would prove more than is true."""
    at = next(number for number, node in enumerate(nodes) if isinstance(node, list))
    nodes[at] = [nodes[at][0], *(2 * each for each in nodes[at][1:])]


def raise_bound(certificate: dict[str, Any]) -> None:
    certificate["bound"] += 10**7


def worthless(certificate: dict[str, Any], root: list[int]) -> None:
    """Another root, and one leaf, which proves that tours are not shorter than 0."""
    certificate["bound"] = 0
    certificate["proof"].update(root=root, nodes=[[1] + [0] * (2 * len(root))])


def move_point(by: float) -> Any:
    def change(certificate: dict[str, Any]) -> None:
        (tour,) = certificate["plan"]
        for visit in tour:
            visit[2] = [visit[2][0], visit[2][1] + by, visit[2][2]]

    return change


def other_kind(certificate: dict[str, Any]) -> None:
    certificate["proof"] = {"kind": "gtsp", "length": 0}
    certificate["bound"] = 0


def drop_point(certificate: dict[str, Any]) -> None:
    del certificate["plan"][0][0]


FORGED: list[tuple[Any, float, str]] = [
    (set_nodes(lengthen), 0.0, "a multiplier is above 1"),
    (set_nodes(lambda nodes: nodes.pop()), 0.0, "1 orders are left without one"),
    (set_nodes(lambda nodes: nodes.append(nodes[-1])), 0.0, "the tree has ended"),
    (set_nodes(lambda nodes: nodes.insert(0, 99)), 0.0, "there is no region 99"),
    (set_nodes(lambda nodes: nodes.__setitem__(-1, [])), 0.0, "leaf: empty"),
    (set_nodes(lambda nodes: nodes.__setitem__(-1, [1, 0])), 0.0, "expected 2 or 3 numbers"),
    (lambda c: c["proof"]["nodes"].insert(0, c["proof"]["root"][0]), 0.0, "is in the order already"),
    (raise_bound, 0.0, "less than"),
    (lambda c: worthless(c, [5, 0, 1, 2]), 0.0, "expected one to three"),
    (lambda c: worthless(c, [5, 0, 0]), 0.0, "a region is there twice"),
    (lambda c: worthless(c, [5, 9]), 0.0, "no such region"),
    (lambda c: worthless(c, [5, 0, 1]), 0.9, "expected one to three"),
    (lambda c: worthless(c, [0, 5]), 0.9, "begins with the home"),
    (move_point(30.0), 0.0, "outside its region"),
    (move_point(1e-5), 0.0, "outside its region"),
    (drop_point, 0.0, "cut each contour once"),
    (set_rules(free_entries=False), 0.0, "no kind for given entries"),
    (other_kind, 0.0, "no kind for free entries"),
    (set_rules(clear_rapids=True), 0.0, "no rule on curves"),
]


@battery
def forged_proofs_through_regions_are_refused(api: Any) -> None:
    for change, precedence, message in FORGED:
        certificate, document = proof(4, precedence)
        forged = copy.deepcopy(certificate)
        change(forged)
        with pytest.raises(api.Refused, match=message):
            api.verify(forged, document)


@battery
def precedence_limits_the_places_of_a_proof(api: Any) -> None:
    """A tree that leaves out places which precedence allows is refused."""
    for seed in (2, 3):
        certificate, document = proof(seed, 0.4)
        without = {**document, "precedence": []}
        for changed in (without, {**document, "precedence": document["precedence"][:1]}):
            forged = {**certificate, "instance": api.instance_hash(changed), "plan": None}
            with pytest.raises(api.Refused):
                api.verify(forged, changed)


def tilted() -> Instance:
    """Regions that hold few decimals exactly: a segment in space, a tilted disc, a triangle; and a point."""
    segment = Ellipsoid(np.array([1.0, 2.0, 3.0]), np.array([[1.0, 1.0, 0.7]]) / 3)
    disc = Ellipsoid(np.array([9.0, 2.0, 1.0]), np.array([[0.3, 0.1, 0.7], [-0.1, 0.3, 0.0]]))
    curve = np.array([[0.1, 7.0], [2.2, 7.3], [1.1, 9.7]])
    contours = (
        Contour("segment", segment.centre[None], 1.0, region=segment),
        Contour("disc", disc.centre[None], 1.0, region=disc),
        Contour("curve", np.array([[0.1, 7.0, 0.3]]), 1.0, geometry=curve),
        Contour("point", np.array([[5.0, 5.0, 5.0]]), 1.0),
    )
    return Instance("tilted", contours, (Head("head", np.zeros(3)),))


@battery
def points_of_plans_are_moved_into_their_regions(api: Any) -> None:
    instance = tilted()
    certificate = solve(instance, FREE, certify=True).certificate
    assert certificate is not None
    document = document_of(instance)
    true = float(api.verify(certificate, document).value)
    far = copy.deepcopy(certificate)
    (tour,) = far["plan"]
    ends = {
        "segment": [1.0 + 1 / 3, 2.0 + 1 / 3, 3.0 + 0.7 / 3],
        "disc": [9.3, 2.1, 1.7],
        "curve": [(0.1 + 2 * 1.1) / 3, (7.0 + 2 * 9.7) / 3, 0.3],
        "point": [5.0, 5.0, 5.0],
    }
    far["plan"] = [[[name, 0, ends[name]] for name, *_ in tour]]
    stops = np.array([[0.0, 0.0, 0.0], *(ends[name] for name, *_ in tour)])
    length = float(np.linalg.norm(stops - np.roll(stops, 1, axis=0), axis=1).sum())
    verdict = api.verify(far, document)
    assert float(verdict.value) == pytest.approx(length, abs=1e-9)
    assert float(verdict.value) > true
    ends["curve"] = [2.2, 7.3, 0.3]
    # To the side, and straight on behind the end of the segment, the disc and a side of the curve.
    aside = [*(1e-3 * np.eye(3))]
    ahead = {"segment": [1.0, 1.0, 0.7], "disc": [0.3, 0.1, 0.7], "curve": [2.1, 0.3, 0.0], "point": [1, 1, 1]}
    pairs = [(name, step) for name, on in ahead.items() for step in (*aside, np.array(on) / 1000)]
    for name, step in pairs:
        place = (np.array(ends[name]) + step).tolist()
        beyond = [[[each, entry, place if each == name else point] for each, entry, point in far["plan"][0]]]
        with pytest.raises(api.Refused, match="outside its region"):
            api.verify({**far, "plan": beyond}, document)
