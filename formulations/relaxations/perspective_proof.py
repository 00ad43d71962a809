"""The perspective relaxation of an instance, and its prices as a certificate (``certificate.perspective``)."""

import time
from math import floor
from typing import Any

import cvxpy as cp
import numpy as np

from cutgap.formulations.certificate import problem_of, verify
from cutgap.formulations.certificate.perspective import perspective_length
from cutgap.formulations.certificate.proof import Budget
from cutgap.formulations.certify import SCALE, Certificate, certificate_of
from cutgap.formulations.relaxations.bound import RelaxationBound
from cutgap.formulations.relaxations.perspective import (
    PerspectiveModel,
    Prices,
    relaxed_solution,
    solve_relaxation,
)
from cutgap.formulations.scope import require_any_order
from cutgap.instances import Instance, Plan, Rules
from cutgap.instances.formats.json_format import format_instance
from cutgap.instances.free_entries import region_of
from cutgap.instances.region import Region, point_region

NAME = "perspective"
MULTIPLIER_SCALE = 2**40
"""Vectors are rounded to this part: over regions of a metre that is a nanometre."""


def perspective_proof(prices: Prices) -> dict[str, Any]:
    """Return the proof in integers; the vectors w are shortened so that rounding leaves none longer than 1."""
    lengths = np.linalg.norm(prices.steps, axis=1, keepdims=True)
    steps = prices.steps / np.maximum(1.0, lengths) * (MULTIPLIER_SCALE - 1)
    return {
        "kind": "perspective",
        "steps": np.rint(steps).astype(np.int64).tolist(),
        "shifts": np.rint(prices.shifts * MULTIPLIER_SCALE).astype(np.int64).tolist(),
        "potentials": np.rint(prices.potentials * SCALE).astype(np.int64).tolist(),
    }


def proved_length(instance: Instance, prices: Prices) -> float:
    """Return what the prices prove of the tour's length, mm, in exact arithmetic and then rounded down."""
    return float(np.nextafter(_whole_length(instance, perspective_proof(prices)) / SCALE, -np.inf))


def perspective_certificate(
    instance: Instance, rules: Rules, plan: Plan | None, prices: Prices
) -> Certificate | None:
    """Return a verified certificate of the best bound that the prices prove, or ``None``."""
    problem, proof = problem_of(format_instance(instance)), perspective_proof(prices)
    work = sum(problem.work(contour, SCALE) for contour in range(len(instance.contours)))
    bound = _whole_length(instance, proof) + (floor(work) if rules.objective == "makespan" else 0)
    return certificate_of(instance, rules, plan, MULTIPLIER_SCALE, lambda _: (bound, proof))


def tour_regions(instance: Instance, rules: Rules) -> list[Region]:
    """Return the regions of the contours, then that of the home.

    Raises
    ------
    ValueError
        When the model does not apply to the instance and the rules.
    """
    name = f"instance {instance.name!r}, method {NAME}"
    require_any_order(instance, rules, NAME)
    if not rules.free_entries:
        raise ValueError(f"{name}: is for free entries (Rules.free_entries)")
    if len(instance.heads) != 1:
        raise ValueError(f"{name}: needs one head, got {len(instance.heads)}")
    if instance.machine.metric != "euclidean":
        raise ValueError(f"{name}: needs the metric euclidean, got {instance.machine.metric}")
    if rules.via_points:
        raise ValueError(f"{name}: does not take via points")
    home = instance.heads[0].home
    regions = [region_of(instance, contour) for contour in range(len(instance.contours))]
    return regions if home is None else [*regions, point_region(home)]


def perspective_bound(instance: Instance, rules: Rules, *, time_limit: float | None = None) -> RelaxationBound:
    """Return the certified bound of the perspective relaxation; the time limit is not looked at.

    Raises
    ------
    ValueError
        When entry points are given, or the model does not apply.
    """
    begun = time.perf_counter()
    regions = tour_regions(instance, rules)
    model = PerspectiveModel(regions, whole=False)
    solve_relaxation(model)
    certificate = perspective_certificate(instance, rules, None, relaxed_solution(model).prices)
    bound = proved_bound(instance, certificate)
    if certificate is None or bound is None:
        raise ValueError(f"instance {instance.name!r}, perspective: no bound, its prices prove nothing")
    rows = model.problem(conic=True).get_problem_data(cp.CLARABEL)[0]["A"]
    return RelaxationBound(
        "perspective", bound, rows.shape[1], rows.shape[0], rows.nnz, time.perf_counter() - begun, certificate
    )


def _whole_length(instance: Instance, proof: dict[str, Any]) -> int:
    problem = problem_of(format_instance(instance))
    return perspective_length(problem, proof, SCALE, MULTIPLIER_SCALE, Budget())


def proved_bound(instance: Instance, certificate: Certificate | None) -> float | None:
    """Return what a certificate proves, rounded down to a float; ``None`` without one."""
    if certificate is None:
        return None
    bound = verify(certificate, format_instance(instance)).bound
    return None if bound is None else float(np.nextafter(float(bound), -np.inf))
