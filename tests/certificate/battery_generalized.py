"""Checks of tours through one entry point of each contour: rows, steps of lengths, small proofs."""

import copy
from dataclasses import replace
from itertools import permutations, product
from typing import Any

import numpy as np
import pytest

from certificate.battery import battery
from certificate.battery_rows import climb
from certificate.plans import excess
from certificate.producer import generalized_rows
from certificate.samples import SCALE, document_of, instance_of, sample
from cutgap.instances import Instance
from cutgap.instances.arrays import Floats

SHAPES = (((2, 2, 2), True), ((1, 3, 2, 1), False))
"""Numbers of entry points of the contours, and whether there is a home."""


def sized(seed: int, sizes: tuple[int, ...], homes: bool) -> Instance:
    """An instance of one head whose contours have so many entry points."""
    instance = instance_of(seed, sum(sizes), "uniform", heads=1, homes=homes)
    points = np.split(instance.points[: sum(sizes)], np.cumsum(sizes)[:-1])
    pairs = zip(instance.contours, points, strict=False)
    return replace(instance, contours=tuple(replace(contour, entry_points=each) for contour, each in pairs))


def relaxation_of(api: Any, seed: int, sizes: tuple[int, ...], homes: bool, scale: int = 10) -> Any:
    problem = api.problem_of(document_of(sized(seed, sizes, homes)))
    return api.GeneralizedRelaxation(problem, scale, 2)


def tour_points(relaxation: Any) -> Floats:
    """The variables of every tour, one a row."""
    points = []
    for order in permutations(range(1, len(relaxation.contours))):
        for nodes in product(*(relaxation.contours[h] for h in (0, *order))):
            point = np.zeros(len(relaxation.costs))
            for u, v in zip(nodes, (*nodes[1:], nodes[0]), strict=True):
                point[relaxation.variable(["y", u])] = 1
                point[relaxation.variable(["x", min(u, v), max(u, v)])] += 1
            points.append(point)
    return np.array(points)


@battery
def rows_of_generalized_tours_hold_and_are_tight(api: Any) -> None:
    for sizes, homes in (
        ((2, 2, 2), True),
        ((1, 3, 2, 1), False),
        ((2, 3), False),
        ((3,), True),
        ((2, 1, 2), False),
    ):
        relaxation = relaxation_of(api, 1, sizes, homes)
        points = tour_points(relaxation)
        assert (points <= np.array(relaxation.start.upper)).all()
        over = excess(relaxation, [relaxation.row(name) for name in generalized_rows(relaxation)], points)
        assert (over.min(axis=1) == 0).all()
        edges = points[:, relaxation.count :].sum(axis=1)
        assert (edges == len(relaxation.contours)).all()


@battery
def borders_hold_for_any_set_and_contours(api: Any) -> None:
    rng = np.random.default_rng(1)
    for sizes, homes in (*SHAPES, ((2, 2), False)):
        relaxation = relaxation_of(api, 2, sizes, homes)
        points = tour_points(relaxation)
        count, contours = relaxation.count, range(len(relaxation.contours))
        names = []
        for _ in range(60):
            inside = np.flatnonzero(rng.random(count) < rng.uniform(0.2, 0.9)).tolist() or [0]
            names.append(["border", inside, *rng.choice(contours, 2).tolist()])
        assert (excess(relaxation, [relaxation.row(name) for name in names], points) >= 0).all()


def any_comb(rng: np.random.Generator, contours: list[Any]) -> list[Any]:
    """Disjoint teeth, any handle that meets and leaves each, and asks as strong as allowed, or any."""
    count = sum(map(len, contours))
    while True:
        teeth = int(rng.choice([3, 3, 3, 5])) if count > 9 else 3
        label = rng.integers(0, teeth + 1, count)
        handle = rng.random(count) < 0.5
        sets = [handle, *(label == i for i in range(1, teeth + 1))]
        if all((tooth & handle).any() and (tooth & ~handle).any() for tooth in sets[1:]):
            break
    pairs = []
    for tooth in sets[1:]:
        pair: list[int | None] = []
        for part in (tooth & handle, tooth & ~handle):
            whole = any(part[list(contour)].all() for contour in contours)
            there = [h for h, contour in enumerate(contours) if part[list(contour)].any()]
            pair.append(None if whole else int(rng.choice(there)))
        pairs.append(pair)
    return ["comb", [np.flatnonzero(each).tolist() for each in sets], pairs]


@battery
def combs_of_generalized_tours_hold_and_are_tight(api: Any) -> None:
    rng = np.random.default_rng(2)
    for sizes, homes in (
        ((2, 2, 1, 1, 1, 1), True),
        ((3, 2, 2, 1), False),
        ((2, 3, 3), False),
        ((4, 4), False),
    ):
        relaxation = relaxation_of(api, 3, sizes, homes)
        points = tour_points(relaxation)
        names = [any_comb(rng, relaxation.contours) for _ in range(150)]
        over = excess(relaxation, [relaxation.row(name) for name in names], points)
        assert (over >= 0).all(), names[int(over.min(axis=1).argmin())]
        if len(sizes) > 3:
            assert (over.min(axis=1) == 0).sum() > 10


@battery
def whole_contours_make_combs_of_contours(api: Any) -> None:
    """Teeth of two contours each, one in the handle: no tour keeps less than the comb of a plain tour."""
    relaxation = relaxation_of(api, 4, (2, 1, 2, 1, 1, 1), False)
    points = tour_points(relaxation)
    sets = [[0, 1, 3, 4, 6], [0, 1, 2], [3, 4, 5], [6, 7]]
    name = ["comb", sets, [[None, None]] * 3]
    over = excess(relaxation, [relaxation.row(name)], points)
    assert over.min() == 0


@battery
def generalized_tours_prove_no_more(api: Any) -> None:
    rng = np.random.default_rng(3)
    for sizes, homes in SHAPES:
        relaxation = relaxation_of(api, 5, sizes, homes, scale=100)
        points = tour_points(relaxation)
        least = float((points @ np.array(relaxation.costs, dtype=float)).min())
        climb(api, rng, relaxation, generalized_rows(relaxation), relaxation.count, least)


@battery
def lengths_of_generalized_tours_go_in_steps(api: Any) -> None:
    made = copy.deepcopy(sample("gtsp, matrix"))
    problem = api.problem_of(made.document)
    step = api.GeneralizedRelaxation(problem, SCALE, 1).step
    between = [
        problem.lengths(u, [v], SCALE)[0] for h, k in permutations(problem.entries, 2) for u, v in product(h, k)
    ]
    assert step == np.gcd.reduce(between)
    assert step >= SCALE  # whole numbers of mm
    length = made.certificate["proof"]["length"]
    assert length == made.optimum
    for other in (length + 1, length + step):
        proof = made.certificate["proof"] | {"length": other}
        with pytest.raises(api.Refused, match="worth"):
            api.verify(made.certificate | {"proof": proof, "bound": other, "plan": None}, made.document)
    for other in (length, length - 1, length - step + 1, length - step):
        proof = made.certificate["proof"] | {"length": other}
        assert api.verify(made.certificate | {"proof": proof, "bound": other}, made.document).bound > 0


@battery
def a_single_place_needs_no_rows(api: Any) -> None:
    for sizes, homes in (((2,), False), ((), True)):
        document = document_of(sized(0, sizes, homes) if sizes else instance_of(0, 0, "uniform", heads=1))
        problem = api.problem_of(document)
        certificate = sample("gtsp").certificate | {
            "instance": problem.digest,
            "bound": 0,
            "plan": [[["c0", 1]] if sizes else []],
            "proof": {"kind": "gtsp", "length": 0},
        }
        assert api.verify(certificate, document).value == 0
        with pytest.raises(api.Refused, match="single place"):
            api.GeneralizedRelaxation(problem, SCALE, 1)
