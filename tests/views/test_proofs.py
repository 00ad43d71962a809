"""The commands around proofs: solve --certificate, verify, pareto."""

import json

import pytest

from cutgap.instances.formats import write_instance
from cutgap.instances.generate import generate
from cutgap.views.cli import main


@pytest.fixture
def part(tmp_path):
    path = tmp_path / "part.json"
    write_instance(generate("random", holes=9, seed=4), path)
    return path


@pytest.fixture
def proof(part, tmp_path, capsys):
    path = tmp_path / "proof.json"
    assert main(["solve", str(part), "--certificate", str(path)]) == 0
    assert "certified" in capsys.readouterr().out
    return path


def test_a_proof_is_verified(part, proof, capsys):
    assert main(["verify", str(proof), str(part)]) == 0
    assert "optimal within" in capsys.readouterr().out


def test_verify_prints_exact_numbers_as_json(part, proof, capsys):
    assert main(["verify", str(proof), str(part), "--json"]) == 0
    fields = json.loads(capsys.readouterr().out)
    assert (fields["objective"], fields["unit"]) == ("makespan", "s")
    assert "/" in fields["lower_bound"]
    assert 0 <= fields["gap"] < 1e-6


def test_a_larger_claim_is_refused(part, proof, capsys):
    document = json.loads(proof.read_text())
    document["bound"] += 10**9
    proof.write_text(json.dumps(document))
    assert main(["verify", str(proof), str(part)]) == 1
    assert "below the claimed" in capsys.readouterr().err


def test_a_proof_of_another_part_is_refused(proof, tmp_path, capsys):
    other = tmp_path / "other.json"
    write_instance(generate("random", holes=9, seed=5), other)
    assert main(["verify", str(proof), str(other)]) == 1
    assert "another instance" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["", "{", "[" * 50_000, '{"format": 1, "format": 2}', "\ufeff{}"])
def test_broken_proofs_are_refused(text, part, tmp_path, capsys):
    path = tmp_path / "broken.json"
    path.write_text(text)
    assert main(["verify", str(path), str(part)]) == 1
    assert "refused" in capsys.readouterr().err


def test_a_missing_proof_is_bad_input(part, tmp_path, capsys):
    assert main(["verify", str(tmp_path / "nothing.json"), str(part)]) == 2
    assert "nothing.json" in capsys.readouterr().err


def test_heuristics_give_no_proof(part, tmp_path, capsys):
    command = ["solve", str(part), "--method", "k-means", "--certificate", str(tmp_path / "proof.json")]
    assert main(command) == 2
    assert "proves no bound" in capsys.readouterr().err


def test_pareto_prints_and_proves_each_point(part, tmp_path, capsys):
    folder, picture = tmp_path / "proofs", tmp_path / "front.png"
    command = ["pareto", str(part), "--limits", "4,1", "--certificates", str(folder), "--plot", str(picture)]
    assert main([*command, "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["limit_s"] for row in rows] == [None, 1.0, 4.0]
    assert rows[0]["travel_mm"] <= rows[2]["travel_mm"] <= rows[1]["travel_mm"]
    assert all(row["imbalance_s"] <= row["limit_s"] + 1e-6 for row in rows[1:])
    assert picture.stat().st_size > 0
    for name in ("point-0.json", "point-1.json", "point-2.json"):
        assert main(["verify", str(folder / name), str(part)]) == 0


@pytest.mark.parametrize("option", [["--limits", "x"], ["--limits", "-1"], ["--points", "1"]])
def test_pareto_refuses_bad_limits(option, part, capsys):
    assert main(["pareto", str(part), *option]) == 2
    assert capsys.readouterr().err
