"""Models and bounds.

The solvers are loaded on first use, so that the checker of certificates runs without them and without numpy.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cutgap.formulations.front_door import METHODS, choose, resolve, solve

__all__ = ["METHODS", "choose", "resolve", "solve"]


def __getattr__(name: str) -> Any:
    """Load the front door when one of its names is asked for."""
    if name in __all__:
        return getattr(import_module("cutgap.formulations.front_door"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
