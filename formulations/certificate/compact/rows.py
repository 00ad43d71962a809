"""The rows of a compact model by their names, as docs/formulations.md writes them: ["flow-most", h, -1, j]."""

from fractions import Fraction
from typing import Any

from cutgap.formulations.certificate.compact.problem_rows import problem_families
from cutgap.formulations.certificate.compact.terms import DEPOT, CompactRow, Setting
from cutgap.formulations.certificate.compact.tour_rows import tour_families
from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.proof import Budget
from cutgap.formulations.certificate.reading import entries, require, show
from cutgap.formulations.certificate.rules import Rules


class CompactRows:
    """The rows of a problem with a tour formulation, each built when it is asked for.

    Attributes
    ----------
    imbalance_price
        weight / v_jump where the imbalance is a variable, else 0.
    """

    def __init__(self, problem: Problem, rules: Rules, formulation: Any, scale: int, budget: Budget) -> None:
        require(isinstance(formulation, str), f"formulation: expected a text, got {show(formulation)}")
        self.formulation = formulation
        self.setting = Setting(problem, rules, scale, budget)
        self.families = {**problem_families(self.setting), **tour_families(self.setting, formulation)}
        self.imbalance_price = rules.weight / problem.v_jump if "imbalance" in self.families else Fraction(0)
        self.ranges = {
            "head": self.setting.heads,
            "contour": range(self.setting.count),
            "place": range(DEPOT, self.setting.count),
            "node": range(len(problem.xs)),
            "part": range(max(problem.parts, default=-1) + 1),
            "position": range(1, self.setting.count + 1),
        }

    def row(self, name: Any) -> CompactRow:
        """Return the row of a name; refuses names of rows that are not in the model."""
        family, *arguments = entries(name, "row") or [None]
        known = isinstance(family, str) and family in self.families
        require(known, f"no row {show(family)} in {self.formulation} under these rules")
        kinds, build = self.families[family]
        expected = kinds.split()
        require(len(arguments) == len(expected), f"{family}: expected {kinds}")
        for kind, argument in zip(expected, arguments, strict=True):
            if kind == "set":
                self._require_set(argument)
            else:
                fits = type(argument) is int and argument in self.ranges[kind]
                require(fits, f"{family}: {show(argument)} is no {kind}")
        row = build(self.setting, *arguments)
        self.setting.budget.spend(4 * len(row.terms) + 10)
        return row

    def _require_set(self, members: Any) -> None:
        known = all(type(i) is int and 0 <= i < self.setting.count for i in entries(members, "set"))
        require(known and len(members) >= 2, "set: expected two contours or more")
        require(members == sorted(set(members)), "set: expected different contours, ascending")
