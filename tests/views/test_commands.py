"""The commands for one instance: what they print and write, and the exit codes."""

import json
import math

import pytest

from cutgap.instances import Rules, check, evaluate
from cutgap.instances.formats import MachineOptions, read_instance, read_plan
from cutgap.views.cli import main

HOLES = "id,x,y,z,perimeter\na,10,5,0,30\nb,40,50,2,0\nc,90,20,0,12.5\n"
HOMES = ["--home", "-5,3", "--home", "120,-3,7"]


@pytest.fixture
def holes(tmp_path):
    path = tmp_path / "holes.csv"
    path.write_text(HOLES)
    return path


def solve_json(capsys, *tokens):
    code = main(["solve", *map(str, tokens), "--json"])
    return code, json.loads(capsys.readouterr().out)


def test_json_of_solve_has_the_published_fields(part, capsys):
    code, fields = solve_json(capsys, part)
    assert code == 0
    assert list(fields) == [
        "status",
        "value",
        "lower_bound",
        "gap",
        "objective",
        "method",
        "seconds",
        "seed",
        "reason",
        "evaluation",
        "plan",
    ]
    assert list(fields["evaluation"]) == [
        "travel_mm",
        "time_s",
        "makespan_s",
        "imbalance_s",
        "partition_gap_mm",
        "backward_mm",
        "link_mm",
        "pierces",
        "peak_temperature_c",
    ]
    assert (fields["status"], fields["method"], fields["objective"]) == ("optimal", "split", "makespan")
    assert fields["value"] == fields["evaluation"]["makespan_s"] == max(fields["evaluation"]["time_s"])
    assert fields["gap"] == pytest.approx(0, abs=1e-8)


@pytest.mark.parametrize(
    ("options", "rules"),
    [
        ([], Rules()),
        (["--objective", "travel", "--overlap"], Rules("travel", non_overlap=None)),
        (["--objective", "weighted", "--weight", "150"], Rules("weighted", weight=150.0)),
        (["--non-overlap", "3.5", "--via-points"], Rules(non_overlap=3.5, via_points=True)),
    ],
)
def test_the_written_plan_is_the_printed_one(part, tmp_path, capsys, options, rules):
    path = tmp_path / "plan.json"
    method = ["--method", "local-search"] if rules.non_overlap is None else []
    _, fields = solve_json(capsys, part, *options, *method, "--out", path)
    instance = read_instance(part)
    plan = read_plan(path, instance)
    assert json.loads(path.read_text()) == fields["plan"]
    assert not check(instance, rules, plan)
    assert fields["value"] == evaluate(instance, plan).objective(rules)
    assert main(["check", str(part), str(path), *options]) == 0
    assert "is allowed" in capsys.readouterr().out


def test_check_names_what_a_plan_breaks(part, tmp_path, capsys):
    path = tmp_path / "plan.json"
    main(["solve", str(part), "--out", str(path)])
    capsys.readouterr()
    code = main(["check", str(part), str(path), "--non-overlap", "1e6", "--json"])
    fields = json.loads(capsys.readouterr().out)
    assert code == 1
    assert not fields["allowed"]
    (violation,) = fields["violations"]
    assert (violation["constraint"], violation["unit"]) == ("non-overlap", "mm")
    assert main(["check", str(part), str(path), "--non-overlap", "1e6"]) == 1
    assert "breaks rules" in capsys.readouterr().out


def test_no_plan_is_exit_code_1(part, tmp_path, capsys):
    out = tmp_path / "plan.json"
    assert main(["solve", str(part), "--non-overlap", "1e6", "--out", str(out), "--json"]) == 1
    captured = capsys.readouterr()
    fields = json.loads(captured.out)
    assert fields["status"] == "infeasible"
    assert fields["plan"] is None
    assert captured.err.startswith("cutgap: ")
    assert not out.exists()


def test_seconds_speeds_and_homes_come_from_the_options(holes, tmp_path, capsys):
    speeds = ["--v-jump", "200", "--v-cut", "25", "--t-aux", "0.5"]
    plan = tmp_path / "plan.json"
    code, fields = solve_json(capsys, holes, *HOMES, *speeds, "--out", plan)
    assert code == 0
    options = MachineOptions(homes=((-5, 3), (120, -3, 7)), v_jump=200.0, v_cut=25.0, t_aux=0.5)
    instance = read_instance(holes, options)
    assert fields["evaluation"]["time_s"] == list(evaluate(instance, read_plan(plan, instance)).time_s)


def test_a_heuristic_repeats_itself_for_a_seed(part, capsys):
    runs = [solve_json(capsys, part, "--method", "task-balancing", "--seed", seed)[1] for seed in (7, 7)]
    assert runs[0]["seed"] == 7
    assert runs[0]["plan"] == runs[1]["plan"]
    assert runs[0]["lower_bound"] is None
    assert runs[0]["status"] == "feasible"


def test_readable_output_names_figures_with_units(part, capsys):
    assert main(["solve", str(part)]) == 0
    text = capsys.readouterr().out
    assert "optimal" in text
    assert all(word in text for word in ("lower bound", "makespan", "partition gap", " mm", " s"))


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_pictures(part, tmp_path, suffix):
    plan, first, second = (tmp_path / name for name in ("plan.json", f"a.{suffix}", f"b.{suffix}"))
    assert main(["solve", str(part), "--out", str(plan), "--plot", str(first)]) == 0
    assert main(["plot", str(part), str(plan), "--out", str(second)]) == 0
    magic = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[suffix]
    assert first.read_bytes().startswith(magic)
    assert second.read_bytes().startswith(magic)


def test_generate_and_convert(tmp_path, capsys):
    assert main(["generate", "random", "--holes", "4", "--seed", "3"]) == 0
    printed = tmp_path / "printed.json"
    printed.write_text(capsys.readouterr().out)
    written = tmp_path / "written.json"
    assert main(["generate", "random", "--holes", "4", "--seed", "3", "--out", str(written)]) == 0
    assert written.read_text() == printed.read_text()
    table = tmp_path / "holes.csv"
    assert main(["convert", str(written), str(table)]) == 0
    instance, again = read_instance(written), read_instance(table, MachineOptions(homes=((0, 0), (9, 9))))
    assert (instance.points[:4] == again.points[:4]).all()
    assert (instance.perimeters == again.perimeters).all()


def test_help_and_version(capsys):
    for tokens in ([], ["--help"], ["gaps", "--help"], ["solve", "--help"]):
        assert main(tokens) == 0
        assert "Usage: cutgap" in capsys.readouterr().out
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.strip()


BAD = {
    "not a number": (HOLES.replace("12.5", "nan"), HOMES, ("holes.csv", "perimeter", "nan")),
    "infinite": (HOLES.replace("90", "inf"), HOMES, ("holes.csv", "column x", "inf")),
    "negative perimeter": (HOLES.replace("12.5", "-1"), HOMES, ("holes.csv", "perimeter", "-1")),
    "duplicate id": (HOLES.replace("b,", "a,"), HOMES, ("holes.csv", "'a'")),
    "missing column": (HOLES.replace(",perimeter", ""), HOMES, ("holes.csv", "perimeter")),
    "no homes": (HOLES, [], ("holes.csv", "--home")),
    "home of one number": (HOLES, ["--home", "5"], ("--home", "5")),
    "home of letters": (HOLES, ["--home", "a,b"], ("--home", "'a,b'")),
    "home not finite": (HOLES, ["--home", "nan,1"], ("--home", "nan")),
    "no speed": (HOLES, [*HOMES, "--v-jump", "0"], ("--v-jump", "0")),
    "negative time": (HOLES, [*HOMES, "--t-aux", "-1"], ("--t-aux", "-1")),
    "unknown method": (HOLES, [*HOMES, "--method", "magic"], ("method", "'magic'", "split")),
    "unknown objective": (HOLES, [*HOMES, "--objective", "beauty"], ("--objective", "beauty", "travel")),
    "unknown option": (HOLES, [*HOMES, "--magic", "1"], ("--magic",)),
    "weight without its objective": (HOLES, [*HOMES, "--weight", "3"], ("weight", "makespan")),
    "negative weight": (HOLES, [*HOMES, "--objective", "weighted", "--weight", "-3"], ("weight", "-3")),
    "overlap both ways": (HOLES, [*HOMES, "--overlap", "--non-overlap", "3"], ("--overlap", "3")),
    "negative gap": (HOLES, [*HOMES, "--non-overlap", "-3"], ("non_overlap", "-3")),
    "negative seed": (HOLES, [*HOMES, "--seed", "-1"], ("--seed", "-1")),
    "no time": (HOLES, [*HOMES, "--time-limit", "0"], ("--time-limit", "0")),
    "time not a number": (HOLES, [*HOMES, "--time-limit", "nan"], ("--time-limit", "nan")),
    "plan of another kind": (HOLES, [*HOMES, "--out", "plan.txt"], ("plan.txt", ".json")),
    "picture of another kind": (HOLES, [*HOMES, "--plot", "plan.bmp"], ("plan.bmp", ".png")),
    "no such folder": (HOLES, [*HOMES, "--out", "nowhere/plan.json"], ("nowhere",)),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_exit_code_2(holes, capsys, case):
    text, options, words = BAD[case]
    holes.write_text(text)
    assert main(["solve", str(holes), *options]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("cutgap: ")
    assert "Traceback" not in captured.err
    for word in words:
        assert word in captured.err


def test_files_that_are_not_there_are_exit_code_2(tmp_path, part, capsys):
    missing = str(tmp_path / "missing.json")
    for tokens in (
        ["solve", missing],
        ["check", missing, missing],
        ["check", str(part), missing],
        ["convert", missing, str(tmp_path / "out.json")],
        ["convert", str(part), str(tmp_path / "out.dwg")],
        ["plot", missing, "--out", str(tmp_path / "out.png")],
        ["plot", str(part), "--out", str(tmp_path / "nowhere" / "out.png")],
        ["generate", "castle"],
        ["generate", "random", "--holes", "-1"],
        ["solve"],
        ["dance"],
    ):
        assert main(tokens) == 2, tokens
        assert capsys.readouterr().err.startswith("cutgap: ")


@pytest.mark.parametrize("count", [0, 1, 2])
def test_tiny_parts_are_solved(tmp_path, capsys, count):
    path = tmp_path / "tiny.json"
    main(["generate", "random", "--holes", str(count), "--seed", "0", "--out", str(path)])
    code, fields = solve_json(capsys, path)
    assert (code, fields["status"]) == (0, "optimal")
    assert math.isfinite(fields["value"])
    assert sum(len(tour["visits"]) for tour in fields["plan"]["tours"]) == count
