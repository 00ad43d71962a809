"""Certificates: proofs of bounds that are checked in exact arithmetic, without a solver and without numpy."""

from cutgap.formulations.certificate.bisection import SpreadVerdict, verify_bisection
from cutgap.formulations.certificate.checker import Verdict, verify
from cutgap.formulations.certificate.compact import CompactRows, compact_value
from cutgap.formulations.certificate.generalized import GeneralizedRelaxation
from cutgap.formulations.certificate.problem import Problem, instance_hash, problem_of
from cutgap.formulations.certificate.proof import one_tree_value
from cutgap.formulations.certificate.reading import Refused
from cutgap.formulations.certificate.relaxation import (
    Bounds,
    Relaxation,
    Row,
    TourRelaxation,
    leaf_value,
)
from cutgap.formulations.certificate.rules import Rules, rules_of
from cutgap.formulations.certificate.tours import tour_relaxation
from cutgap.formulations.certificate.two_heads import TwoHeadsRelaxation

__all__ = [
    "Bounds",
    "CompactRows",
    "GeneralizedRelaxation",
    "Problem",
    "Refused",
    "Relaxation",
    "Row",
    "Rules",
    "SpreadVerdict",
    "TourRelaxation",
    "TwoHeadsRelaxation",
    "Verdict",
    "compact_value",
    "instance_hash",
    "leaf_value",
    "one_tree_value",
    "problem_of",
    "rules_of",
    "tour_relaxation",
    "verify",
    "verify_bisection",
]
