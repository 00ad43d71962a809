"""The battery notices each of the errors in ``mutants`` when it is put into the checker."""

import importlib
import shutil
import sys
from importlib.util import cache_from_source
from pathlib import Path
from types import ModuleType

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
from certificate.mutants import MUTANTS as PLAIN
from certificate.mutants_compact import COMPACT
from certificate.mutants_generalized import GENERALIZED
from certificate.mutants_heat import HEAT
from certificate.mutants_links import LINKS
from certificate.mutants_perspective import PERSPECTIVE
from certificate.mutants_positive import POSITIVE
from certificate.mutants_regions import REGIONS
from cutgap.formulations import certificate

MUTANTS = [*PLAIN, *COMPACT, *GENERALIZED, *HEAT, *LINKS, *PERSPECTIVE, *POSITIVE, *REGIONS]
SOURCE = Path(certificate.__file__).parent


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A copy of the checker; its modules are compiled once, and only the changed one again."""
    folder = tmp_path_factory.mktemp("mutants") / "mutant"
    shutil.copytree(SOURCE, folder, ignore=shutil.ignore_patterns("__pycache__"))
    for path in folder.rglob("*.py"):
        path.write_text(path.read_text().replace("cutgap.formulations.certificate", "mutant"))
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder.parent)
        patch.setattr(sys, "dont_write_bytecode", False)
        yield folder


@pytest.mark.parametrize("number", range(len(MUTANTS)), ids=lambda n: f"{MUTANTS[n].file}: {MUTANTS[n].new}")
def test_mutant_is_noticed(number, folder):
    mutant = MUTANTS[number]
    path = folder / mutant.file
    sound = path.read_text()
    assert mutant.old in sound, f"{mutant.old!r} is not in {mutant.file}"
    try:
        rewrite(path, sound.replace(mutant.old, mutant.new))
        with pytest.raises((Exception, pytest.fail.Exception)):
            CHECKS[mutant.killer](fresh_import())
    finally:
        rewrite(path, sound)


def test_an_unchanged_copy_passes(folder):
    """Else the way of copying would kill the mutants."""
    copy = fresh_import()
    assert copy.verify is not certificate.verify
    for name in ("forgeries_are_refused", "cells_are_all_partitions", "rows_of_a_tour_hold_and_are_tight"):
        CHECKS[name](copy)


def rewrite(path: Path, text: str) -> None:
    """Write a module; what was compiled goes, for it may have the same size and time."""
    path.write_text(text)
    Path(cache_from_source(str(path))).unlink(missing_ok=True)


def fresh_import() -> ModuleType:
    """Import the copy as if for the first time."""
    for name in [name for name in sys.modules if name.split(".")[0] == "mutant"]:
        del sys.modules[name]
    importlib.invalidate_caches()
    return importlib.import_module("mutant")
