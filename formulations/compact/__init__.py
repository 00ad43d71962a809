"""Compact models: readable programmes in cvxpy that can be written down whole (docs/formulations.md).

A problem (``problem``, ``rules``, ``clock``) goes with any tour formulation (``tours``).
"""

from cutgap.formulations.compact.model import CompactModel, compact_model
from cutgap.formulations.compact.relaxing import Relaxation, Size
from cutgap.formulations.compact.tours import TOUR_FORMULATIONS

__all__ = ["TOUR_FORMULATIONS", "CompactModel", "Relaxation", "Size", "compact_model"]
