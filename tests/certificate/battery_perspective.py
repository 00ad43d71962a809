"""Prices of tours through convex regions: they reach the relaxation and prove nothing untrue."""

import copy
from dataclasses import asdict, replace
from functools import cache
from math import ceil, floor
from typing import Any

import numpy as np
import pytest
from oracles.region_orders import shortest_of_orders

from certificate.battery import battery
from certificate.samples import document_of
from cutgap.formulations.relaxations.perspective import Prices, relax_perspective
from cutgap.formulations.relaxations.perspective_proof import MULTIPLIER_SCALE, perspective_proof
from cutgap.instances import Contour, Head, Instance, Machine, Rules
from cutgap.instances.free_entries import region_of
from cutgap.instances.region import Ellipsoid, Region, point_region

SCALE = 10**9
RULES = Rules("travel", free_entries=True)
Sample = tuple[Instance, Prices, float, float]


def convex_curve(rng: np.random.Generator, centre: Any) -> Any:
    angles = np.sort(rng.uniform(0, 2 * np.pi, 5))
    return centre[:2] + rng.uniform(5, 15) * np.column_stack((np.cos(angles), np.sin(angles)))


def random_contour(rng: np.random.Generator, name: str) -> Contour:
    """A disc, an ellipse in space, a polygon or a point."""
    centre = rng.uniform(0, 100, 3).round(2)
    kind = int(rng.integers(4))
    if kind == 0:
        return Contour(name, centre[None], 1.0, region=Ellipsoid(centre, rng.uniform(3, 15) * np.eye(3)[:2]))
    if kind == 1:
        return Contour(name, centre[None], 1.0, region=Ellipsoid(centre, rng.normal(size=(2, 3)) * 8))
    if kind == 2:
        return Contour(name, np.stack([centre, centre]), 1.0, geometry=convex_curve(rng, centre))
    return Contour(name, centre[None], 0.0)


def regions_of(instance: Instance) -> list[Region]:
    regions = [region_of(instance, each) for each in range(len(instance.contours))]
    return regions + [point_region(head.home) for head in instance.heads if head.home is not None]


@cache
def samples() -> list[Sample]:
    """Instances, prices of their relaxation, its value and the optimum."""
    found = []
    for seed in range(14):
        rng = np.random.default_rng(seed)
        contours = tuple(random_contour(rng, f"c{i}") for i in range(int(rng.integers(3, 5))))
        head = Head("h", rng.uniform(0, 100, 3) if seed % 2 else None)
        instance = Instance("regions", contours, (head,))
        relaxed = relax_perspective(regions_of(instance))
        found.append((instance, relaxed.prices, relaxed.value, shortest_of_orders(regions_of(instance))))
    return found


def certificate_of(
    api: Any, instance: Instance, proof: Any, bound: int, rules: Rules = RULES
) -> dict[str, Any]:
    return {
        "format": "cutgap-certificate",
        "version": 1,
        "instance": api.problem_of(document_of(instance)).digest,
        "rules": asdict(rules),
        "scale": SCALE,
        "multiplier_scale": MULTIPLIER_SCALE,
        "bound": bound,
        "plan": None,
        "proof": proof,
    }


def proved(api: Any, instance: Instance, proof: Any) -> int:
    problem = api.problem_of(document_of(instance))
    length: int = api.perspective.perspective_length(
        problem, proof, SCALE, MULTIPLIER_SCALE, api.proof.Budget()
    )
    return length


@battery
def prices_reach_the_relaxation(api: Any) -> None:
    for instance, prices, value, _ in samples():
        length = proved(api, instance, perspective_proof(prices))
        assert abs(length / SCALE - value) <= 1e-4
        certificate = certificate_of(api, instance, perspective_proof(prices), length)
        assert api.verify(certificate, document_of(instance)).bound * SCALE == length
        with pytest.raises(api.Refused, match="less than the claimed"):
            api.verify(certificate | {"bound": length + 1}, document_of(instance))


@battery
def no_prices_prove_more_than_the_optimum(api: Any) -> None:
    """Prices far and near, of which the last are the best that small changes find."""
    for number, (instance, prices, _, optimum) in enumerate(samples()):
        rng = np.random.default_rng(number)
        best, best_length = prices, proved(api, instance, perspective_proof(prices))
        for size in (1.0, 0.3, *np.geomspace(0.1, 1e-6, 25)):
            changed = Prices(
                best.steps + size * rng.normal(size=best.steps.shape),
                best.shifts + size * rng.normal(size=best.shifts.shape),
                best.potentials + 100 * size * rng.normal(size=best.potentials.shape),
            )
            length = proved(api, instance, perspective_proof(changed))
            assert length <= (optimum + 1e-5) * SCALE
            if length > best_length:
                best, best_length = changed, length


@battery
def makespans_of_free_entries_count_the_work(api: Any) -> None:
    instance, prices, *_ = samples()[0]
    proof = perspective_proof(prices)
    length = proved(api, instance, proof)
    work = sum(api.problem_of(document_of(instance)).work(c, SCALE) for c in range(len(instance.contours)))
    rules = replace(RULES, objective="makespan")
    assert work > 0
    api.verify(certificate_of(api, instance, proof, length + floor(work), rules), document_of(instance))
    beyond = certificate_of(api, instance, proof, length + ceil(work) + 1, rules)
    with pytest.raises(api.Refused, match="less than the claimed"):
        api.verify(beyond, document_of(instance))


@battery
def least_over_a_region_is_rounded_down(api: Any) -> None:
    rng = np.random.default_rng(0)
    for _ in range(200):
        corners = rng.integers(-50, 50, (int(rng.integers(1, 5)), 3))
        direction = rng.integers(-5, 6, 3)
        assert api.regions.Shape(tuple(map(tuple, corners.tolist())), ()).least(direction.tolist()) == int(
            (corners @ direction).min()
        )
        axes = rng.integers(-9, 10, (int(rng.integers(1, 4)), 3))
        ball = api.regions.Shape((tuple(corners[0].tolist()),), tuple(map(tuple, axes.tolist())))
        true = corners[0] @ direction - np.linalg.norm(axes @ direction)
        assert ball.least(direction.tolist()) == floor(true + 1e-9)


@battery
def regions_are_those_of_the_file(api: Any) -> None:
    """Ellipsoids before curves, curves at the height of the entry points, single points; nothing else."""
    curve = np.array([[0.0, 0], [10, 0], [10, 10], [5, 2], [0, 10]])
    disc = Ellipsoid(np.array([1.0, 2, 0.5]), np.array([[3.0, 0, 0]]))
    one, two = np.array([[0.0, 0, 7]]), np.array([[0.0, 0, 7], [10, 0, 7]])
    contours = (
        Contour("a", two, 1.0, geometry=curve, region=disc),
        Contour("b", two, 1.0, geometry=curve),
        Contour("c", one, 1.0),
    )
    instance = Instance("shapes", contours, (Head("h", np.array([1.0, 1, 1])),))
    a, b, c, home = api.regions.regions_of(api.problem_of(document_of(instance))).shapes
    assert (a.points, a.axes) == (((2, 4, 1),), ((6, 0, 0),))  # in halves of a mm
    assert b.points == tuple((2 * x, 2 * y, 14) for x, y in curve.astype(int).tolist())
    assert (b.axes, c.axes, home.axes) == ((), (), ())
    assert (c.points, home.points) == (((0, 0, 14),), ((2, 2, 2),))
    slanted = Contour("d", np.array([[0.0, 0, 7], [10, 0, 8]]), 1.0, geometry=curve)
    for bad in (slanted, Contour("d", two, 1.0)):
        other = replace(instance, contours=(*contours, bad))
        with pytest.raises(api.Refused, match=r"d.*(differ in z|no region)"):
            api.regions.regions_of(api.problem_of(document_of(other)))


def long_step(proof: dict[str, Any]) -> None:
    proof["steps"][0] = [MULTIPLIER_SCALE, 1, 0]


FORGED: list[tuple[str, Any, str]] = [
    ("a step longer than 1", long_step, "longer than 1"),
    ("a step too few", lambda p: p["steps"].pop(), "entries"),
    ("a step in the plane", lambda p: p["steps"][0].pop(), "entries"),
    ("a shift too few", lambda p: p["shifts"].pop(), "entries"),
    ("half a shift", lambda p: p["shifts"].__setitem__(0, [0.5, 0, 0]), "whole number"),
    ("a potential too few", lambda p: p["potentials"].pop(), "entries"),
    ("a potential that is none", lambda p: p["potentials"].__setitem__(0, True), "whole number"),
    ("more than asked", lambda p: p.update(more=0), "unknown field"),
]


@battery
def forged_prices_are_refused(api: Any) -> None:
    instance, prices, *_ = samples()[1]
    good = perspective_proof(prices)
    for _, forge, message in FORGED:
        proof = copy.deepcopy(good)
        forge(proof)
        with pytest.raises(api.Refused, match=message):
            api.verify(certificate_of(api, instance, proof, 0), document_of(instance))
    given = replace(RULES, free_entries=False)
    with pytest.raises(api.Refused, match="given entries"):
        api.verify(certificate_of(api, instance, good, 0, given), document_of(instance))
    with pytest.raises(api.Refused, match="free entries"):
        api.verify(certificate_of(api, instance, {"kind": "tour"}, 0), document_of(instance))
    others = (
        (replace(instance, heads=(Head("l"), Head("r"))), "one head"),
        (replace(instance, machine=Machine(metric="chebyshev")), "euclidean"),
        (replace(instance, contours=instance.contours[:2], heads=(Head("h"),)), "3 regions"),
    )
    for other, message in others:
        with pytest.raises(api.Refused, match=message):
            api.verify(certificate_of(api, other, good, 0), document_of(other))
