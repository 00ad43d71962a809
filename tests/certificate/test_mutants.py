"""The battery notices each of the errors in ``mutants`` when it is put into the checker."""

import importlib
import shutil
import sys
from pathlib import Path

import pytest

from certificate import (  # noqa: F401, they enter their checks
    battery_compact,
    battery_contours,
    battery_generalized,
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
from certificate.mutants import MUTANTS as PLAIN
from certificate.mutants import Mutant
from certificate.mutants_compact import COMPACT
from certificate.mutants_generalized import GENERALIZED
from certificate.mutants_links import LINKS
from certificate.mutants_perspective import PERSPECTIVE
from certificate.mutants_positive import POSITIVE
from certificate.mutants_regions import REGIONS
from cutgap.formulations import certificate

MUTANTS = [*PLAIN, *COMPACT, *GENERALIZED, *LINKS, *PERSPECTIVE, *POSITIVE, *REGIONS]
SOURCE = Path(certificate.__file__).parent


@pytest.mark.parametrize("number", range(len(MUTANTS)), ids=lambda n: f"{MUTANTS[n].file}: {MUTANTS[n].new}")
def test_mutant_is_noticed(number, tmp_path, monkeypatch):
    package = copy_of_checker(tmp_path, f"mutant_{number}", MUTANTS[number])
    monkeypatch.syspath_prepend(tmp_path)
    try:
        mutant = importlib.import_module(package)
        with pytest.raises((Exception, pytest.fail.Exception)):
            CHECKS[MUTANTS[number].killer](mutant)
    finally:
        for name in [name for name in sys.modules if name.split(".")[0] == package]:
            del sys.modules[name]


def test_an_unchanged_copy_passes(tmp_path, monkeypatch):
    """Else the way of copying would kill the mutants."""
    package = copy_of_checker(tmp_path, "mutant_none", None)
    monkeypatch.syspath_prepend(tmp_path)
    copy = importlib.import_module(package)
    assert copy.verify is not certificate.verify
    for name in ("forgeries_are_refused", "cells_are_all_partitions", "rows_of_a_tour_hold_and_are_tight"):
        CHECKS[name](copy)


def copy_of_checker(folder: Path, package: str, mutant: Mutant | None) -> str:
    """Copy the checker under another name, with the error put in; return the name."""
    shutil.copytree(SOURCE, folder / package, ignore=shutil.ignore_patterns("__pycache__"))
    for path in (folder / package).rglob("*.py"):
        text = path.read_text().replace("cutgap.formulations.certificate", package)
        if mutant is not None and path.relative_to(folder / package).as_posix() == mutant.file:
            assert mutant.old in text, f"{mutant.old!r} is not in {mutant.file}"
            text = text.replace(mutant.old, mutant.new)
        path.write_text(text)
    return package
