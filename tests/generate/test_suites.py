"""The shipped suites are what their recipes make, fit the schema, and are all packed."""

import json
import tomllib
from pathlib import Path

import jsonschema
import pytest

from cutgap.instances import formats, suites
from cutgap.instances.formats import read_instance
from cutgap.instances.formats.json_format import format_instance
from cutgap.instances.suites import SUITES, build_suite, load_suite, write_suites

FOLDER = Path(suites.__file__).parent
SCHEMA = json.loads((Path(formats.__file__).parent / "instance.schema.json").read_text())


def test_shipped_files_are_what_the_recipes_make(tmp_path):
    write_suites(tmp_path)
    shipped = {path.relative_to(FOLDER): path.read_text() for path in FOLDER.glob("*/*.json")}
    made = {path.relative_to(tmp_path): path.read_text() for path in tmp_path.glob("*/*.json")}
    assert shipped == made


@pytest.mark.parametrize("suite", SUITES)
def test_suites_load_in_order_and_fit_the_published_schema(suite):
    loaded = load_suite(suite)
    assert list(map(format_instance, loaded)) == list(map(format_instance, build_suite(suite)))
    assert {instance.name for instance in loaded} == {path.stem for path in (FOLDER / suite).iterdir()}
    validator = jsonschema.Draft202012Validator(SCHEMA)
    for instance in loaded:
        path = FOLDER / suite / f"{instance.name}.json"
        validator.validate(json.loads(path.read_text()))
        assert read_instance(path).name == instance.name


def test_sizes_are_those_of_the_reference():
    assert [len(part.contours) for part in load_suite("table1")] == list(range(45, 95, 5))
    assert [part.name for part in load_suite("table1")] == [f"table1-{n}" for n in range(45, 95, 5)]
    assert [len(part.contours) for part in load_suite("b-pillars")] == [76]
    assert [len(part.contours) for part in load_suite("door-panel")] == [91]
    assert [len({contour.part for contour in nest.contours}) for nest in load_suite("nest28")] == [28]
    assert {len(part.contours) for part in load_suite("small")} == set(range(6, 15))
    assert [len(nest.contours) for nest in load_suite("flame108")] == [108] * 3
    assert [len(plate.contours) for plate in load_suite("plate30")] == [30] * 3
    assert [len(plate.contours) for plate in load_suite("plate30-dense")] == [30] * 3
    assert {len(plate.contours) for plate in load_suite("small-plates")} == {6, 8, 10, 12}


def test_an_unknown_suite_lists_the_known_ones():
    for function in (load_suite, build_suite):
        with pytest.raises(ValueError, match=f"suite: expected one of {', '.join(SUITES)}, got 'x'"):
            function("x")


def test_changing_a_loaded_list_changes_no_other():
    load_suite("small").clear()
    assert load_suite("small")


def test_data_files_are_packed():
    root = Path(__file__).resolve().parents[2]
    packed = tomllib.loads((root / "pyproject.toml").read_text())["tool"]["setuptools"]["package-data"]
    found = {
        path
        for package, globs in packed.items()
        for pattern in globs
        for path in root.joinpath(*package.split(".")[1:]).glob(pattern)
    }
    data = {path for path in (root / "instances").rglob("*.json") if path.is_file()}
    assert data <= found
