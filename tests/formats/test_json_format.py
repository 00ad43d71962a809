"""JSON: exact round trips, the published schemas, and files that nobody vouches for."""

import json
import time
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cutgap.instances import Contour, Head, Instance, Plan
from cutgap.instances.formats import (
    MachineOptions,
    files,
    json_models,
    read_instance,
    read_plan,
    write_instance,
    write_plan,
)
from cutgap.instances.formats.json_format import format_instance, format_plan, parse_instance, parse_plan
from cutgap.instances.formats.options import NO_OVERRIDES
from formats.strategies import instances, plans, same_bits

INSTANCE_SCHEMA = jsonschema.Draft202012Validator(json_models.json_schema("instance.schema.json"))
PLAN_SCHEMA = jsonschema.Draft202012Validator(json_models.json_schema("plan.schema.json"))


def small(**changes) -> Instance:
    contours = (
        Contour("a", np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]), 10.0),
        Contour("b", np.array([[7.0, 8.0, 9.0]]), 20.0),
    )
    heads = (Head("left", np.zeros(3)), Head("right", np.full(3, 9.0)))
    return replace(Instance("small", contours, heads, precedence=((0, 1),)), **changes)


def read(tmp_path: Path, text: str | bytes, **options) -> Instance:
    path = tmp_path / "part.json"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return read_instance(path, MachineOptions(**options))


def edited(path: list, value: object) -> str:
    """Return the JSON of ``small`` with one field set."""
    document = json.loads(format_instance(small()))
    *parents, last = path
    node = document
    for step in parents:
        node = node[step]
    node[last] = value
    return json.dumps(document)


@given(instances())
def test_instances_round_trip_bit_for_bit(instance):
    text = format_instance(instance)
    again = parse_instance(text, "unused", NO_OVERRIDES)
    assert same_bits(instance, again)
    assert format_instance(again) == text


@settings(max_examples=30)
@given(instances())
def test_written_instances_fit_the_published_schema(instance):
    INSTANCE_SCHEMA.validate(json.loads(format_instance(instance)))


@settings(max_examples=50)
@given(st.data())
def test_plans_round_trip_and_fit_the_published_schema(data):
    instance = data.draw(instances())
    plan = data.draw(plans(instance))
    text = format_plan(plan, instance)
    assert parse_plan(text, instance) == plan
    PLAN_SCHEMA.validate(json.loads(text))


@pytest.mark.parametrize("file_name", json_models.SCHEMAS)
def test_published_schemas_are_those_of_the_models(tmp_path, file_name):
    json_models.write_schemas(tmp_path)
    published = Path(json_models.__file__).parent / file_name
    assert published.read_text() == (tmp_path / file_name).read_text()
    jsonschema.Draft202012Validator.check_schema(json.loads(published.read_text()))


def test_files_round_trip(tmp_path):
    instance, plan = small(), Plan((((0, 1),), ((1, 0),)))
    write_instance(instance, tmp_path / "part.json")
    write_plan(plan, instance, tmp_path / "plan.json")
    assert same_bits(read_instance(tmp_path / "part.json"), instance)
    assert read_plan(tmp_path / "plan.json", instance) == plan


def test_a_byte_order_mark_is_no_content(tmp_path):
    assert same_bits(read(tmp_path, b"\xef\xbb\xbf" + format_instance(small()).encode()), small())


def test_given_options_replace_those_of_the_file(tmp_path):
    instance = read(tmp_path, format_instance(small()), homes=((5, 6),), v_cut=7.0)
    assert [head.id for head in instance.heads] == ["head"]
    assert instance.heads[0].home.tolist() == [5.0, 6.0, 0.0]
    assert instance.machine == replace(small().machine, v_cut=7.0)


def test_homes_do_not_fit_a_matrix(tmp_path):
    matrix_machine = replace(small().machine, metric="matrix")
    text = format_instance(small(machine=matrix_machine, matrix=np.ones((5, 5))))
    with pytest.raises(ValueError, match=r"part\.json: matrix: .*leave --home out"):
        read(tmp_path, text, homes=((1, 2),))


BAD_FIELDS = [
    (
        ["contours", 1, "perimeter"],
        float("nan"),
        r"contours\[1\]\.perimeter: expected a finite number, got nan",
    ),
    (["contours", 0, "entry_points", 1, 2], float("inf"), r"contours\[0\]\.entry_points\[1\]\[2\].*got inf"),
    (["contours", 0, "entry_points", 0, 0], -float("inf"), r"entry_points\[0\]\[0\].*got -inf"),
    (["contours", 0, "entry_points", 0, 0], 10**400, r"entry_points\[0\]\[0\].*got inf"),
    (["contours", 1, "perimeter"], -1, r"contours\[1\]\.perimeter: .*greater than or equal to 0, got -1"),
    (["contours", 1, "perimeter"], "20", r"contours\[1\]\.perimeter: expected a valid number, got '20'"),
    (["contours", 1, "perimeter"], True, r"contours\[1\]\.perimeter: expected a valid number, got True"),
    (["contours", 1, "perimeter"], None, r"contours\[1\]\.perimeter: expected a valid number, got None"),
    (["contours", 0, "entry_points"], [], r"contours\[0\]\.entry_points: "),
    (["contours", 0, "entry_points", 0], [1, 2], r"contours\[0\]\.entry_points\[0\]: "),
    (["contours", 0, "entry_points", 0], [1, 2, 3, 4], r"contours\[0\]\.entry_points\[0\]: "),
    (["contours", 0, "ring"], "square", r"contours\[0\]\.ring: expected 'hole', 'inner' or 'outer'"),
    (["contours", 0, "id"], "", r"contours\[0\]\.id: "),
    (["contours", 0, "id"], 7, r"contours\[0\]\.id: expected a valid string, got 7"),
    (
        ["contours"],
        [{"id": i, "entry_points": [[1, 2, 3]], "perimeter": 0} for i in "aba"],
        "contour id 'a' appears",
    ),
    (["name"], "\ud800", r"name: expected a valid string"),
    (["\ud800"], 1, r"a key: expected a valid string"),
    (["contours", 0, "perimetre"], 1.0, r"contours\[0\]\.perimetre: unknown field; remove it"),
    (["contours"], {}, r"contours: expected a valid list, got \{\}"),
    (["heads"], [], r"heads: "),
    (["heads", 1, "id"], "left", r"head id 'left' appears more than once"),
    (["machine", "v_jump"], 0, r"machine\.v_jump: expected greater than 0, got 0"),
    (["machine", "v_cut"], -5.0, r"machine\.v_cut: expected greater than 0, got -5\.0"),
    (["machine", "t_aux"], -0.5, r"machine\.t_aux: .*got -0\.5"),
    (["machine", "metric"], "manhattan", r"machine\.metric: expected 'euclidean'"),
    (["machine", "metric"], "matrix", r"matrix: missing"),
    (["matrix"], [[0.0]], r"matrix: given, but the metric is euclidean"),
    (["matrix"], [[0.0, 1.0], [2.0]], r"matrix\[1\]: expected 2 numbers as there are rows, got 1"),
    (["matrix"], [[0.0, -1.0], [2.0, 0.0]], r"matrix\[0\]\[1\]: .*got -1\.0"),
    (["precedence"], [["a", "z"]], r"precedence\[0\]: no contour has the id 'z'"),
    (["precedence"], [["a"]], r"precedence\[0\]: "),
    (["precedence"], [["a", "b"], ["b", "a"]], r"precedence: the pairs form a cycle"),
    (["material"], {"name": "steel"}, r"material\.conductivity_w_per_m_k: missing; add it"),
    (["located"], 1, r"located: expected a valid boolean, got 1"),
    (["format"], "cutgap-plan", r"format: expected 'cutgap-instance', got 'cutgap-plan'"),
    (["version"], 2, r"version: expected 1, got 2; a newer cutgap reads it"),
    (["version"], True, r"version: expected 1, got True"),
    (["version"], 1.0, r"version: expected 1, got 1\.0"),
]


@pytest.mark.parametrize(("path", "value", "message"), BAD_FIELDS)
def test_a_bad_field_is_named_with_file_and_value(tmp_path, path, value, message):
    with pytest.raises(ValueError, match=r"part\.json: .*" + message):
        read(tmp_path, edited(path, value))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"line 1, column 1: not JSON"),
        ("{", r"not JSON .*is the file complete"),
        ("[]", r"expected a JSON object with format 'cutgap-instance', got \[\]"),
        ("3", r"expected a JSON object"),
        ("{}", r"format: expected 'cutgap-instance', got None"),
        ('{"format": "cutgap-instance"}', r"version: expected 1, got None"),
        ('{"format": "cutgap-instance", "version": 1}', r"name: missing"),
        (b"\xff\xfe{}", r"not UTF-8 text: byte 0xff at offset 0; save the file as UTF-8"),
        ("[" * 200_000 + "]" * 200_000, r"nested too deeply"),
        ('{"a":' * 200_000, r"nested too deeply"),
        ('{"format": "cutgap-instance", "format": "x"}', r"format: the key appears more than once"),
        ('{"a": [1, {"b": 1, "b": 1}]}', r"a\[1\]\.b: the key appears more than once; keep one"),
    ],
)
def test_what_is_no_instance_is_refused_with_the_file_name(tmp_path, text, message):
    with pytest.raises(ValueError, match=r"(?s)part\.json: .*" + message) as caught:
        read(tmp_path, text)
    assert len(str(caught.value)) < 500


@pytest.mark.parametrize("number", ["1e999", "-1e999", "NaN", "Infinity", "9" * 5000])
def test_numbers_beyond_json_are_refused_in_their_place(tmp_path, number):
    text = edited(["contours", 1, "perimeter"], 12345).replace("12345", number)
    with pytest.raises(ValueError, match=r"contours\[1\]\.perimeter: expected a finite number"):
        read(tmp_path, text)


def test_a_huge_file_is_refused_unread(tmp_path, monkeypatch):
    monkeypatch.setattr(files, "SIZE_LIMIT", 1 << 20)
    with pytest.raises(ValueError, match=r"part\.json: larger than 1 MiB"):
        read(tmp_path, " " * ((1 << 20) + 1))


def test_millions_of_wrong_entries_give_one_error_soon(tmp_path):
    text = edited(["contours", 0, "entry_points"], ["x"] * 1_000_000)
    start = time.monotonic()
    with pytest.raises(ValueError, match=r"entry_points\[0\]: expected a valid list, got 'x'"):
        read(tmp_path, text)
    assert time.monotonic() - start < 10


def test_a_missing_file_is_bad_input(tmp_path):
    with pytest.raises(ValueError, match=r"none\.json: cannot be read: No such file"):
        read_instance(tmp_path / "none.json")
    with pytest.raises(ValueError, match=r"cannot be read: Is a directory"):
        read_instance(tmp_path.rename(tmp_path.with_suffix(".json")))


@given(st.data())
def test_a_damaged_file_is_read_or_refused(data):
    """Cut, change and repeat characters: nothing but an instance or a ``ValueError`` comes out."""
    text = format_instance(small())
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, len(text)))
        end = data.draw(st.integers(at, min(len(text), at + 20)))
        middle = data.draw(
            st.sampled_from(["", "1e999", "[", "}", ",", '"', "NaN", "null", "-1", text[at:end] * 2])
        )
        text = text[:at] + middle + text[end:]
    try:
        instance = parse_instance(text, "", NO_OVERRIDES)
    except ValueError as error:
        assert str(error)  # noqa: PT017
    else:
        assert same_bits(parse_instance(format_instance(instance), "", NO_OVERRIDES), instance)


BAD_PLANS = [
    ({"head": "middle", "visits": []}, r"tours\[0\]\.head: no head 'middle'; the instance has left, right"),
    ({"head": "right", "visits": []}, r"tours\[1\]\.head: 'right' has a tour already"),
    (
        {"head": "left", "visits": [{"contour": "z"}]},
        r"tours\[0\]\.visits\[0\]\.contour: no contour has the id",
    ),
    (
        {"head": "left", "visits": [{"contour": "a", "entry": 2}]},
        r"visits\[0\]\.entry: expected less than 2, got 2",
    ),
    ({"head": "left", "visits": [{"contour": "a", "entry": -1}]}, r"visits\[0\]\.entry: .*got -1"),
    ({"head": "left", "visits": [{"entry": 0}]}, r"tours\[0\]\.visits\[0\]\.contour: missing"),
    ({"head": "left"}, r"tours\[0\]\.visits: missing"),
]


@pytest.mark.parametrize(("tour", "message"), BAD_PLANS)
def test_a_bad_plan_is_refused(tmp_path, tour, message):
    other = {"head": "right", "visits": [{"contour": "b"}]}
    plan = {"format": "cutgap-plan", "version": 1, "instance": "small", "tours": [tour, other]}
    path = tmp_path / "plan.json"
    path.write_text(json.dumps(plan))
    with pytest.raises(ValueError, match=r"plan\.json: .*" + message):
        read_plan(path, small())


def test_a_plan_names_every_head(tmp_path):
    plan = {
        "format": "cutgap-plan",
        "version": 1,
        "instance": "small",
        "tours": [{"head": "left", "visits": []}],
    }
    (tmp_path / "plan.json").write_text(json.dumps(plan))
    with pytest.raises(ValueError, match=r"tours: none for head 'right'"):
        read_plan(tmp_path / "plan.json", small())


def test_a_plan_for_another_instance_is_not_written(tmp_path):
    with pytest.raises(ValueError, match="no contour 5"):
        write_plan(Plan.of_contours([[5], []]), small(), tmp_path / "plan.json")
    assert not (tmp_path / "plan.json").exists()
