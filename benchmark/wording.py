"""Rules in words."""

from cutgap.instances import Rules


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
