"""What the exact methods take, said once."""

from cutgap.instances import Instance, Rules
from cutgap.instances.check import require_coordinates


def require_two_heads(instance: Instance, rules: Rules, method: str) -> None:
    """Raise ``ValueError``, saying why, when a method for two heads and single entry points does not apply."""
    if len(instance.heads) != 2:
        name = f"instance {instance.name!r}, method {method}"
        raise ValueError(f"{name}: needs two heads, got {len(instance.heads)}")
    require_single_entries(instance, rules, method)


def require_single_entries(instance: Instance, rules: Rules, method: str) -> None:
    """Raise ``ValueError``, saying why, when a method for single entry points in any order does not apply."""
    require_any_order(instance, rules, method)
    several = next((c.id for c in instance.contours if len(c.entry_points) > 1), None)
    if several is not None:
        name = f"instance {instance.name!r}, method {method}"
        raise ValueError(f"{name}: contour {several!r} has several entry points, needs one each")
    require_symmetric(instance, method)


def require_any_order(instance: Instance, rules: Rules, method: str) -> None:
    """Raise ``ValueError``, saying why, when a method without precedence and process rules does not apply."""
    name = f"instance {instance.name!r}, method {method}"
    require_coordinates(instance, rules)
    if rules.process:
        raise ValueError(f"{name}: does not take the rule {rules.process[0]}")
    if instance.precedence:
        raise ValueError(f"{name}: does not take precedence pairs")


def require_symmetric(instance: Instance, method: str) -> None:
    """Raise ``ValueError`` when rapid lengths differ by direction."""
    if instance.matrix is not None and (instance.matrix != instance.matrix.T).any():
        raise ValueError(f"instance {instance.name!r}, method {method}: needs symmetric rapid lengths")


def require_given_entries(instance: Instance, rules: Rules, method: str) -> None:
    """Raise ``ValueError`` when contours may be entered anywhere or by links, which other bounds miss."""
    if rules.links:
        raise ValueError(f"instance {instance.name!r}, {method}: pierces each contour, takes no links")
    if rules.free_entries:
        raise ValueError(f"instance {instance.name!r}, {method}: takes given entry points, not free entries")


def require_no_peak(instance: Instance, rules: Rules, method: str) -> None:
    """Raise ``ValueError`` when the peak temperature is to be least; a cap alone only forbids plans."""
    if rules.objective == "peak":
        raise ValueError(f"instance {instance.name!r}, {method}: does not take the objective peak")


def require_euclidean_links(instance: Instance, rules: Rules, method: str) -> None:
    """Raise ``ValueError``, saying why, when a method for links and Euclidean rapids does not apply."""
    name = f"instance {instance.name!r}, {method}"
    if not rules.links:
        raise ValueError(f"{name}: needs rules with links")
    require_coordinates(instance, rules)
    if instance.machine.metric != "euclidean":
        raise ValueError(f"{name}: takes Euclidean rapids, not {instance.machine.metric}")
