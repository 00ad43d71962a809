"""The checker against everything in the battery."""

import subprocess
import sys

import pytest

from certificate import (  # noqa: F401, they enter their checks
    battery_compact,
    battery_contours,
    battery_generalized,
    battery_heat,
    battery_links,
    battery_perspective,
    battery_positive,
    battery_problem,
    battery_regions,
    battery_rows,
    battery_split,
    battery_whole,
)
from certificate.battery import CHECKS
from cutgap.formulations import certificate


@pytest.mark.parametrize("name", CHECKS)
def test_checker(name):
    CHECKS[name](certificate)


def test_no_numpy_and_no_solver_are_imported():
    code = (
        "import cutgap.formulations.certificate, sys;"
        "print([m for m in sys.modules if m.split('.')[0] in {'numpy', 'scipy', 'highspy', 'ortools', 'cvxpy'}"
        " or m.startswith('cutgap.') and not m.startswith('cutgap.formulations')])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
