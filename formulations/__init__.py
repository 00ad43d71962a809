"""Models and bounds.

The solvers are loaded on first use, so that the checker of certificates runs without them and without numpy.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cutgap.formulations.solve import METHODS, resolve, solve

__all__ = ["METHODS", "resolve", "solve"]


class _Package(ModuleType):
    """Properties, as the import system would store the module ``solve`` under the name of the function."""

    @property
    def METHODS(self) -> Any:  # noqa: N802
        return import_module("cutgap.formulations.solve").METHODS

    @property
    def resolve(self) -> Any:
        return import_module("cutgap.formulations.solve").resolve

    @property
    def solve(self) -> Any:
        return import_module("cutgap.formulations.solve").solve

    @solve.setter
    def solve(self, module: ModuleType) -> None:
        """Keep the function: the import system hands over the module."""


sys.modules[__name__].__class__ = _Package
