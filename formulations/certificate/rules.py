"""The rules of a certificate: what is asked of a plan, in exact numbers."""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from cutgap.formulations.certificate.problem import Problem
from cutgap.formulations.certificate.reading import fields, flag, integer, number, require, text_of


@dataclass(frozen=True)
class Rules:
    """What is asked of a plan; fields as in the library's ``Rules``.

    Process rules (``parts_in_one_go`` to ``backward_price``), ``free_entries``, ``temperature_cap``, ``links``
    and ``pierces`` are optional in a document. Process rules and the cap only forbid plans or add to their
    value, so proofs may leave them out of account. Free entries and links allow more plans: few kinds of
    proofs hold for them.
    """

    objective: str
    weight: Fraction
    non_overlap: Fraction | None
    balance: Fraction | None
    via_points: bool
    empty_heads: bool
    parts_in_one_go: bool
    neighbours_only: bool
    clear_rapids: bool
    backward_price: Fraction
    free_entries: bool
    temperature_cap: Fraction | None
    links: bool
    pierces: int | None


def rules_of(value: Any, problem: Problem) -> Rules:
    """Return the rules of a certificate."""
    table = fields(
        value,
        "rules",
        "objective weight non_overlap balance via_points empty_heads",
        "parts_in_one_go neighbours_only clear_rapids backward_price free_entries temperature_cap "
        "links pierces",
    )
    limits = {
        name: None if table[name] is None else number(table[name], f"rules.{name}", least=0)
        for name in ("non_overlap", "balance")
    }
    cap, pierces = table.get("temperature_cap"), table.get("pierces")
    rules = Rules(
        objective=text_of(table["objective"], "rules.objective"),
        weight=number(table["weight"], "rules.weight", least=0),
        via_points=flag(table["via_points"], "rules.via_points"),
        empty_heads=flag(table["empty_heads"], "rules.empty_heads"),
        parts_in_one_go=flag(table.get("parts_in_one_go", False), "rules.parts_in_one_go"),
        neighbours_only=flag(table.get("neighbours_only", False), "rules.neighbours_only"),
        clear_rapids=flag(table.get("clear_rapids", False), "rules.clear_rapids"),
        backward_price=number(table.get("backward_price", 0), "rules.backward_price", least=0),
        free_entries=flag(table.get("free_entries", False), "rules.free_entries"),
        temperature_cap=None if cap is None else number(cap, "rules.temperature_cap"),
        links=flag(table.get("links", False), "rules.links"),
        pierces=None if pierces is None else integer(pierces, "rules.pierces", least=1),
        **limits,
    )
    known = ("makespan", "travel", "weighted", "peak")
    require(rules.objective in known, "rules.objective: not known")
    require(
        rules.weight == 0 or rules.objective == "weighted", "rules.weight: goes with the objective weighted"
    )
    require(rules.links or pierces is None, "rules.pierces: goes with links")
    _require_links_alone(rules)
    priced = rules.backward_price > 0
    unpriced = rules.objective not in ("makespan", "peak")
    require(not priced or unpriced, f"rules.backward_price: not of the objective {rules.objective}")
    apart = rules.non_overlap is not None and len(problem.homes) > 1
    speaks_of_x = rules.via_points or apart or priced
    heated = rules.objective == "peak" or rules.temperature_cap is not None
    require(problem.material is not None or not heated, "rules: they speak of heat, and there is no material")
    require(problem.located or not speaks_of_x, "rules: they speak of x, and the points carry no coordinates")
    return rules


def _require_links_alone(rules: Rules) -> None:
    """Refuse rules beside links that nobody has said the meaning of."""
    others = rules.via_points or rules.free_entries or rules.temperature_cap is not None
    process = rules.parts_in_one_go or rules.neighbours_only or rules.clear_rapids or rules.backward_price > 0
    alone = rules.objective in ("travel", "makespan") and not others and not process
    require(alone or not rules.links, "rules.links: goes with travel or makespan and no rule but pierces")


def may_rest(problem: Problem, rules: Rules) -> bool:
    """Whether a head may stay without work."""
    return rules.empty_heads or len(problem.ids) < len(problem.homes)
