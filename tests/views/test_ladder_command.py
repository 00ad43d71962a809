"""The command ``ladder``: table, CSV, JSON, picture and proofs, and what it refuses."""

import csv
import json

import pytest

from cutgap.instances.formats import write_instance
from cutgap.instances.generate import generate
from cutgap.views.cli import main


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "part.json"
    write_instance(generate("random", holes=6, seed=3), path)
    return path


NAMES = "mtz,multi-commodity,held-karp"


def test_table_and_files(file, tmp_path, capsys):
    out, plot, folder = tmp_path / "ladder.csv", tmp_path / "ladder.png", tmp_path / "proofs"
    options = ["--out", str(out), "--plot", str(plot), "--certificates", str(folder)]
    assert main(["ladder", str(file), "--formulations", NAMES, *options]) == 0
    printed = capsys.readouterr().out
    assert "least makespan" in printed
    assert "best plan" in printed
    rows = list(csv.DictReader(out.open()))
    assert {row["formulation"] for row in rows} == {*NAMES.split(","), "split"}
    bounds = [float(row["bound"]) for row in rows]
    assert bounds[:-1] == sorted(bounds[:-1])
    assert all(row["proof"] == "certified" for row in rows)
    assert plot.read_bytes().startswith(b"\x89PNG")
    for row in rows:
        proof = folder / f"{row['formulation']}.json"
        assert main(["verify", str(proof), str(file), "--json"]) == 0
        proved = json.loads(capsys.readouterr().out)["lower_bound"].split("/")
        assert float(proved[0]) / float(proved[-1] if len(proved) > 1 else 1) == pytest.approx(
            float(row["bound"])
        )


def test_json(file, capsys):
    assert main(["ladder", str(file), "--formulations", NAMES, "--objective", "travel", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["unit"] == "mm"
    assert document["status"] == "optimal"
    for row in document["rungs"]:
        assert 0 <= row["bound"] <= document["value"] * (1 + 1e-9)
        expected = 100 * max(0.0, document["value"] - row["bound"]) / document["value"]
        assert row["gap_percent"] == pytest.approx(expected, abs=1e-6)


def test_what_does_not_apply_is_said(file, capsys):
    assert main(["ladder", str(file), "--formulations", "perspective,mtz"]) == 0
    printed = capsys.readouterr()
    assert "perspective: " in printed.err
    assert "free entries" in printed.err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--formulations", "simplex"], "'simplex'"),
        (["--out", "ladder.txt"], ".csv"),
        (["--plot", "ladder.txt"], ".png"),
        (["--time-limit", "-1"], "time"),
        (["--out", "nowhere/ladder.csv"], "nowhere"),
    ],
)
def test_bad_input_is_refused_before_the_work(file, options, message, capsys):
    assert main(["ladder", str(file), *options]) == 2
    assert message in capsys.readouterr().err
