"""The problem: what is to be cut, a plan for it, its value, and whether it is allowed. No solver."""

from cutgap.instances.check import check
from cutgap.instances.evaluate import Evaluation, evaluate
from cutgap.instances.instance import Contour, Head, Instance, Machine, Material
from cutgap.instances.plan import Link, Plan, Visit
from cutgap.instances.result import Result, Status, conclude
from cutgap.instances.rules import Rules
from cutgap.instances.violation import Violation

__all__ = [
    "Contour",
    "Evaluation",
    "Head",
    "Instance",
    "Link",
    "Machine",
    "Material",
    "Plan",
    "Result",
    "Rules",
    "Status",
    "Violation",
    "Visit",
    "check",
    "conclude",
    "evaluate",
]
