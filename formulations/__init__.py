"""Models and bounds."""

from cutgap.formulations.solve import METHODS, solve

__all__ = ["METHODS", "solve"]
