"""Bounds by multipliers of rows of compact models, as docs/formulations.md writes them down."""

from cutgap.formulations.certificate.compact.rows import CompactRows
from cutgap.formulations.certificate.compact.value import check_compact, compact_value

__all__ = ["CompactRows", "check_compact", "compact_value"]
