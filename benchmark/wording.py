"""Rules in words."""

from collections.abc import Iterable
from dataclasses import replace

from cutgap.instances import Rules


def question(rules: Rules) -> str:
    """Return what is minimised, and whether under a cap; instances may have caps of their own."""
    return rules.objective if rules.temperature_cap is None else f"{rules.objective} under cap"


def describe_all(asked: Iterable[Rules], heads: int = 2) -> str:
    """Return different rules in words; those that differ in the cap alone are said once, with its range."""
    groups: dict[tuple[str, Rules], set[float | None]] = {}
    for rules in asked:
        key = question(rules), replace(rules, temperature_cap=None)
        groups.setdefault(key, set()).add(rules.temperature_cap)
    texts = []
    for (_, rules), found in groups.items():
        caps = [cap for cap in found if cap is not None]
        many = len(caps) > 1
        text = describe(rules if many or not caps else replace(rules, temperature_cap=caps[0]), heads)
        texts.append(f"{text}, cap of {min(caps):g} to {max(caps):g} deg C" if many else text)
    return "; ".join(texts)


def describe(rules: Rules, heads: int = 2) -> str:
    """Return the rules in words, as far as they say something about so many heads."""
    if rules.objective == "weighted":
        parts = [f"least travel + {rules.weight:g} mm/s of imbalance"]
    else:
        parts = [f"least {rules.objective}"]
    if rules.backward_price > 0:
        parts[0] += f" + {rules.backward_price:g} times the way back in x"
    if heads > 1:
        overlap = rules.non_overlap is None
        parts.append("overlap allowed" if overlap else f"partition gap at least {rules.non_overlap:g} mm")
    if rules.balance is not None:
        parts.append(f"imbalance at most {rules.balance:g} s")
    if rules.links:
        parts.append("contours joined by links")
    if rules.pierces is not None:
        parts.append(f"at most {rules.pierces} pierce{'s' if rules.pierces > 1 else ''}")
    if rules.via_points:
        parts.append("leftmost contour first")
    if rules.temperature_cap is not None:
        parts.append(f"no start point above {rules.temperature_cap:g} deg C")
    if rules.empty_heads:
        parts.append("a head may stay without work")
    if rules.free_entries:
        parts.append("entered anywhere in their regions")
    parts += [name for name in rules.process if name != "backward price"]
    return ", ".join(parts)
