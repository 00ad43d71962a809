"""The command as a process: exit codes, Ctrl-C, kill -9, a closed pipe."""

import json
import os
import pty
import signal
import subprocess
import sys
import time

import pytest

from cutgap.benchmark.records import read_records
from cutgap.instances.formats import read_instance, read_plan
from cutgap.views.cli import main

COMMAND = [sys.executable, "-m", "cutgap.views.cli"]
SEEDS = 5


def start(*tokens, **options):
    """Start the command with Ctrl-C as a terminal gives it, whatever runs these tests."""
    return subprocess.Popen(
        [*COMMAND, *map(str, tokens)],
        stdout=subprocess.PIPE,
        stderr=options.pop("stderr", subprocess.PIPE),
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        **options,
    )


def wait_for(condition, process, seconds=60.0):
    """Wait until ``condition()`` holds while the process runs."""
    deadline = time.monotonic() + seconds
    while not condition():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.01)


def lines(path):
    return path.read_bytes().count(b"\n") if path.exists() else 0


def test_exit_codes(part, tmp_path):
    for tokens, code in (
        (["convert", tmp_path / "missing.json", part], 2),
        (["convert", part, tmp_path / "copy.json"], 0),
    ):
        process = start(*tokens)
        _, error = process.communicate()
        assert process.returncode == code, error
        assert "Traceback" not in error


def test_a_closed_pipe_is_no_error():
    process = start("generate", "random", "--holes", 20000, "--seed", 1)
    process.stdout.read(10)
    process.stdout.close()
    assert process.wait() == 0
    assert process.stderr.read() == ""


def test_ctrl_c_of_solve_prints_the_best_found(tmp_path):
    path, plan = tmp_path / "part.json", tmp_path / "plan.json"
    main(["generate", "random", "--holes", "400", "--seed", "1", "--out", str(path)])
    terminal, stderr = pty.openpty()
    tokens = ("solve", path, "--objective", "travel", "--json", "--out", plan)
    process = start(*tokens, stderr=stderr, env={**os.environ, "COLUMNS": "200", "TERM": "xterm"})
    seen = b""
    while b"bound" not in seen:
        assert process.poll() is None
        seen += os.read(terminal, 4096)
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=60)
    seen += os.read(terminal, 65536)
    assert process.returncode == 0
    fields = json.loads(out)
    assert fields["status"] == "feasible"
    assert fields["value"] >= fields["lower_bound"]
    assert b"interrupted" in seen
    read_plan(plan, read_instance(path))


@pytest.mark.parametrize(("how", "jobs"), [(signal.SIGKILL, 1), (signal.SIGINT, 2)])
def test_a_stopped_suite_goes_on_where_it_was(parts, tmp_path, how, jobs):
    out = tmp_path / "results"
    results = out / "results.jsonl"
    tokens = ["gaps", parts, "--seeds", SEEDS, "--out", out, "--methods", "split,fuzzy-c-means"]
    process = start(*tokens, "--jobs", jobs, start_new_session=True)
    wait_for(lambda: lines(results) >= 3, process)
    # All processes of the run, as a terminal does with Ctrl-C.
    os.killpg(process.pid, how)
    _, error = process.communicate(timeout=60)
    before = results.read_bytes()
    finished, _ = read_records(results)
    total = 3 * (1 + SEEDS)
    assert 3 <= len(finished) < total
    if how == signal.SIGINT:
        assert process.returncode == 1, error
        assert "--resume" in error
        assert (out / "report.html").exists()
    assert main([*map(str, tokens), "--resume"]) == 0
    records, _ = read_records(results)
    keys = [record.key for record in records]
    assert results.read_bytes().startswith(before)
    assert len(keys) == len(set(keys)) == total
