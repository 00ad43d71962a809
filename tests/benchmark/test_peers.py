"""Side by side: the table's rows, on parts small enough for a test."""

import pytest

from cutgap.benchmark.peers import BENCHMARKS, FAST, Options, certified, main, part
from cutgap.instances import Machine


def test_peers_agree_and_are_compared():
    columns, rows = BENCHMARKS["non-overlap"]
    ours, theirs = (dict(zip(columns, row, strict=True)) for row in rows(Options(FAST, 1, (7,), 20.0)))
    assert (ours["method"], theirs["method"]) == ("split", "cpsat")
    assert theirs["value"] == ours["value"]
    assert float(theirs["times slower"].removeprefix("> ")) > 0.0
    assert ours["times slower"] == ""


def test_the_command_prints_a_row_for_each_rule_and_method(capsys):
    assert main(["overlap", "--holes", "5", "--limit", "20", "--default-machine"]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if "random-5-s1" in line]
    assert len(lines) == 4


def test_a_certified_row_shows_what_was_verified():
    instance = part("columns", 12, Options(Machine(), 2, (), None))
    columns, _ = BENCHMARKS["structured"]
    row = dict(zip(columns, certified(instance, None), strict=True))
    assert (row["holes"], row["gap %"], row["proved gap %"]) == ("12", "0.0000", "0.0000")
    assert row["value"] == row["bound"]


def test_an_unknown_benchmark_is_refused(capsys):
    with pytest.raises(SystemExit):
        main(["everything"])
    assert "non-overlap" in capsys.readouterr().err
