"""From the prices of the perspective relaxation to a verified certificate (``certificate.perspective``)."""

from math import floor
from typing import Any

import numpy as np

from cutgap.formulations.certificate import problem_of, verify
from cutgap.formulations.certificate.perspective import perspective_length
from cutgap.formulations.certificate.proof import Budget
from cutgap.formulations.certify import SCALE, Certificate, certificate_of
from cutgap.formulations.relaxations.perspective import Prices
from cutgap.instances import Instance, Plan, Rules
from cutgap.instances.formats.json_format import format_instance

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


def _whole_length(instance: Instance, proof: dict[str, Any]) -> int:
    problem = problem_of(format_instance(instance))
    return perspective_length(problem, proof, SCALE, MULTIPLIER_SCALE, Budget())


def proved_bound(instance: Instance, certificate: Certificate | None) -> float | None:
    """Return what a certificate proves, rounded down to a float; ``None`` without one."""
    if certificate is None:
        return None
    bound = verify(certificate, format_instance(instance)).bound
    return None if bound is None else float(np.nextafter(float(bound), -np.inf))
