"""Certificates of unknown origin: refused with a clear sentence, in bounded time and memory."""

import copy
import json
import subprocess
import sys
import time
from fractions import Fraction

import pytest

from certificate.battery_positive import bisection_of, spreads, tour_bound
from certificate.producer import MULTIPLIER_SCALE
from certificate.samples import SCALE, document_of, instance_of, sample
from cutgap.formulations.certificate import (
    Refused,
    problem_of,
    reading,
    tour_relaxation,
    verify,
    verify_bisection,
)
from cutgap.formulations.certificate.__main__ import main
from cutgap.formulations.certificate.proof import Budget, build_rows, check_tree


def texts(name="tour"):
    made = sample(name)
    return json.dumps(made.certificate), json.dumps(made.document)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "not JSON"),
        ("cutgap", "not JSON"),
        ("[]", "JSON object"),
        ("null", "JSON object"),
        ("{}", "format"),
        ('{"a": NaN}', "NaN"),
        ('{"a": -Infinity}', "Infinity"),
        ('{"a": 1, "a": 2}', "more than once"),
        ('{"a": 1e1000000}', "out of range"),
        ('{"a": 1E-999999999}', "out of range"),
        ('{"a": ' + "9" * 65 + "}", "digits"),
        ('{"a": 0.' + "9" * 65 + "}", "digits"),
        ("[" * 100_000, "deep"),
        ('{"a":' * 100_000, "deep"),
        ('{"a": "\ud800"}', "format"),
    ],
)
def test_broken_text_is_refused(text, message):
    certificate, document = texts()
    with pytest.raises(Refused, match=message):
        verify(text, document)
    with pytest.raises(Refused, match="instance" if message == "format" else message):
        verify(certificate, text)


def test_every_truncation_is_refused():
    certificate, document = texts("two heads")
    step = len(certificate) // 50
    for length in range(0, len(certificate), step):
        with pytest.raises(Refused):
            verify(certificate[:length], document)


def test_too_long_a_text_is_not_parsed():
    _, document = texts()
    started = time.perf_counter()
    with pytest.raises(Refused, match="longer"):
        verify('{"a": [' + "0," * (reading.MAX_CHARACTERS // 2), document)
    assert time.perf_counter() - started < 5


def test_another_instance_is_refused():
    with pytest.raises(Refused, match="another instance"):
        verify(texts("tour")[0], texts("split")[1])


def replaced(document, value, path=()):
    """Every document with one part replaced."""
    yield path, value
    items = document.items() if isinstance(document, dict) else enumerate(document)
    for key, part in items:
        if isinstance(part, dict | list):
            steps = list(replaced(part, value, (*path, key)))
            # Of long lists the ends say it all.
            yield from steps if len(steps) < 200 else steps[::40]
        else:
            yield (*path, key), value


@pytest.mark.parametrize("value", [None, [], {}, "", -1, 10**40, 0.5, [[[]]], True])
@pytest.mark.parametrize("name", ["tour", "split with ties", "two heads, travel"])
def test_nonsense_anywhere_is_verified_or_refused(name, value):
    """Never another exception: each field in turn holds something odd."""
    made, refusals = sample(name), []
    for path, odd in replaced(made.certificate, value):
        certificate = copy.deepcopy(made.certificate)
        place = certificate
        for step in path[:-1]:
            place = place[step]
        if not path:
            certificate = odd
        else:
            place[path[-1]] = odd
        try:
            verdict = verify(certificate, made.document)
        except Refused as refusal:
            refusals.append(str(refusal))
            continue
        # Other rules are another problem; else odd values may at most weaken the bound.
        if path[0] not in ("rules", "scale"):
            unit = SCALE * (problem_of(made.document).v_jump if verdict.unit == "s" else 1)
            assert verdict.bound * unit <= made.optimum
    assert max(map(len, refusals)) < 400


@pytest.mark.parametrize("value", [None, [], {}, "", -1, 10**40, 0.5, True])
def test_nonsense_in_the_instance_is_refused(value):
    made = sample("split")
    for path, odd in replaced(made.document, value):
        document = copy.deepcopy(made.document)
        place = document
        for step in path[:-1]:
            place = place[step]
        if path and path[-1] not in ("name", "located") and place[path[-1]] != odd:
            place[path[-1]] = odd
            with pytest.raises(Refused):
                verify(made.certificate, document)


def test_steps_are_limited():
    problem = problem_of(document_of(instance_of(1, 6, "uniform", heads=1)))
    relaxation = tour_relaxation(problem, 0, list(range(6)), False, SCALE, MULTIPLIER_SCALE)
    branching = {"branch": ["x", 0, 1], "at": 0}
    tree = [branching | {"down": 2 * i + 1, "up": 2 * i + 2} for i in range(500)] + [{"leaf": []}] * 501
    with pytest.raises(Refused, match="too many steps"):
        check_tree(relaxation, [], tree, 0, Budget(1000))
    with pytest.raises(Refused, match="too many steps"):
        build_rows(relaxation, [["cut", [[1, 2, 3]]]] * 1000, Budget(1000))


def test_a_deep_tree_takes_no_recursion():
    problem = problem_of(document_of(instance_of(1, 6, "uniform", heads=1)))
    relaxation = tour_relaxation(problem, 0, list(range(6)), False, SCALE, MULTIPLIER_SCALE)
    # Below the crossed bounds of the first branching everything is proved.
    depth = 20_000
    tree = [{"branch": ["x", 0, 1], "at": 5 + i, "down": i + 1, "up": depth + i} for i in range(depth)]
    tree = tree[:depth] + [{"leaf": []}] * (depth + 1)
    for index in range(depth):
        tree[index] = tree[index] | {"up": depth + 1 + index}
    check_tree(relaxation, [], tree, 0, Budget())


def test_relaxations_are_limited():
    contours = [{"id": str(i), "entry_points": [[i, 0, 0]], "perimeter": 1} for i in range(2300)]
    document = sample("tour").document | {"contours": contours}
    problem = problem_of(document)
    with pytest.raises(Refused, match="too many"):
        tour_relaxation(problem, 0, list(range(2300)), False, SCALE, MULTIPLIER_SCALE)
    with pytest.raises(Refused, match="more than"):
        problem_of(document | {"contours": contours * 5})


@pytest.fixture
def files(tmp_path):
    for name, text in zip(("certificate.json", "instance.json"), texts(), strict=True):
        (tmp_path / name).write_text(text)
    return [str(tmp_path / "certificate.json"), str(tmp_path / "instance.json")]


def test_command_line(files, tmp_path, capsys):
    assert main(files) == 0
    assert "travel at least" in capsys.readouterr().out
    assert main(files[:1]) == 2
    assert main([files[0], str(tmp_path / "missing.json")]) == 2
    (tmp_path / "binary").write_bytes(b"\xff\xfe\x00")
    assert main([files[0], str(tmp_path / "binary")]) == 2
    assert main(files[::-1]) == 1
    assert "refused: format" in capsys.readouterr().err


def test_command_line_as_a_module(files):
    command = [sys.executable, "-m", "cutgap.formulations.certificate", *files]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "travel at least" in done.stdout


@pytest.mark.parametrize("value", [None, [], -1, 10**40, 0.5])
@pytest.mark.parametrize("name", ["connectivity", "distances", "bisection"])
def test_nonsense_among_vectors_is_verified_or_refused(name, value):
    if name == "bisection":
        (certificate, document), check = bisection_of(1, 6, 2.0), verify_bisection
        most = min(spreads(document, Fraction(2)))
    else:
        (certificate, document, most), check = tour_bound(name), verify
    refused = 0
    for path, odd in replaced(certificate, value):
        made = copy.deepcopy(certificate)
        place = made
        for step in path[:-1]:
            place = place[step]
        if path:
            place[path[-1]] = odd
        else:
            made = odd
        try:
            verdict = check(made, document)
        except Refused:
            refused += 1
            continue
        # Other limits and rules are another problem.
        if path[0] not in ("rules", "limit"):
            assert verdict.bound <= most * (1 + 1e-12)
    assert refused
