"""Rules in words."""

from cutgap.instances import Rules


def describe(rules: Rules) -> str:
    """Return the rules in words."""
    if rules.objective == "weighted":
        parts = [f"least travel + {rules.weight:g} mm/s of imbalance"]
    else:
        parts = [f"least {rules.objective}"]
    overlap = rules.non_overlap is None
    parts.append("overlap allowed" if overlap else f"partition gap at least {rules.non_overlap:g} mm")
    if rules.balance is not None:
        parts.append(f"imbalance at most {rules.balance:g} s")
    if rules.via_points:
        parts.append("leftmost contour first")
    if rules.empty_heads:
        parts.append("a head may stay without work")
    return ", ".join(parts)
