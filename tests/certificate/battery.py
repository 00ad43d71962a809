"""What any checker of certificates must do. Each check takes the package, so that it can try a mutant too."""

from collections.abc import Callable
from typing import Any

Check = Callable[[Any], None]
CHECKS: dict[str, Check] = {}
"""The checks of the modules ``battery_...``, by name."""


def battery(check: Check) -> Check:
    """Enter a check."""
    CHECKS[check.__name__] = check
    return check
