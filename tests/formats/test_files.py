"""Choosing a format, writing as a whole, homes and machine figures given with a file."""

import os
from pathlib import Path

import numpy as np
import pytest

from cutgap.instances import Contour, Head, Instance, Machine
from cutgap.instances.formats import (
    MachineOptions,
    files,
    read_instance,
    read_plan,
    write_atomically,
    write_instance,
)

HOLE = Instance("hole", (Contour("a", np.zeros((1, 3)), 1.0),), (Head("head", np.ones(3)),))


def test_an_unknown_suffix_lists_the_known_ones(tmp_path):
    known = r"\.json, \.csv, \.tsp, \.atsp, \.gtsp, \.pcglns, \.cetsp, \.txt, \.dxf, \.svg"
    with pytest.raises(ValueError, match=rf"part\.dwg: unknown suffix '\.dwg'; .*read end in {known}"):
        read_instance(tmp_path / "part.dwg")
    with pytest.raises(ValueError, match=r"part: unknown suffix ''"):
        read_instance(tmp_path / "part")
    with pytest.raises(
        ValueError, match=r"discs\.cetsp: .*written end in \.json, \.csv, \.tsp, \.atsp, \.gtsp"
    ):
        write_instance(HOLE, tmp_path / "discs.cetsp")
    with pytest.raises(ValueError, match=r"plan\.csv: .*end in \.json$"):
        read_plan(tmp_path / "plan.csv", HOLE)


def test_the_suffix_may_be_in_capitals(tmp_path):
    write_instance(HOLE, tmp_path / "PART.JSON")
    assert read_instance(tmp_path / "PART.JSON").contours[0].id == "a"


def test_a_failed_write_keeps_the_old_file_and_leaves_nothing_behind(tmp_path, monkeypatch):
    path = tmp_path / "part.json"
    write_atomically(path, "old")

    def full_disk(descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(files.os, "fsync", full_disk)
    with pytest.raises(OSError, match="No space left"):
        write_instance(HOLE, path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_writing_replaces_content_and_keeps_mode_and_links(tmp_path):
    path, link = tmp_path / "part.csv", tmp_path / "link.csv"
    path.write_text("old")
    path.chmod(0o640)
    link.symlink_to(path)
    write_atomically(link, b"new")
    assert path.read_bytes() == b"new"
    assert path.stat().st_mode & 0o777 == 0o640
    assert link.is_symlink()


def test_a_new_file_gets_the_mode_of_any_new_file(tmp_path):
    (tmp_path / "plain").touch()
    write_atomically(tmp_path / "atomic", "x")
    assert (tmp_path / "atomic").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_what_could_not_be_read_again_is_not_written(tmp_path, monkeypatch):
    monkeypatch.setattr("cutgap.instances.formats.SIZE_LIMIT", 100)
    with pytest.raises(ValueError, match=r"part\.json: larger than"):
        write_instance(HOLE, tmp_path / "part.json")
    assert os.listdir(tmp_path) == []


def test_a_missing_folder_is_an_error_of_the_system(tmp_path):
    with pytest.raises(OSError, match="No such file"):
        write_instance(HOLE, tmp_path / "none" / "part.json")


@pytest.mark.parametrize(
    ("homes", "ids", "xs"),
    [
        (((3, 1),), ["head"], [3]),
        (((1, 1), (2, 2)), ["left", "right"], [1, 2]),
        (((2, 2), (1, 1)), ["left", "right"], [1, 2]),
        (((3, 0), (1, 0), (2, 0)), ["head-1", "head-2", "head-3"], [1, 2, 3]),
    ],
)
def test_heads_are_named_from_left_to_right(homes, ids, xs):
    heads = MachineOptions(homes=homes).heads()
    assert [head.id for head in heads] == ids
    assert [head.home[0] for head in heads] == xs


def test_homes_of_equal_x_keep_their_order_and_z_defaults_to_0():
    heads = MachineOptions(homes=((1, 9), (1, 5, 7))).heads()
    assert [head.home.tolist() for head in heads] == [[1, 9, 0], [1, 5, 7]]


def test_figures_not_given_are_those_of_the_default_machine():
    assert MachineOptions(v_jump=500.0).machine() == Machine(v_jump=500.0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"homes": ((1,),)}, "--home: expected X,Y or X,Y,Z, got 1 numbers"),
        ({"homes": ((1, 2, 3, 4),)}, "--home: expected X,Y or X,Y,Z, got 4 numbers"),
        ({"homes": ((1, float("nan")),)}, "--home: expected a finite number, got nan"),
        ({"v_jump": 0.0}, "--v-jump: expected a number above 0, got 0"),
        ({"v_cut": -1.0}, "--v-cut: expected a number above 0, got -1"),
        ({"v_cut": float("inf")}, "--v-cut: expected a finite number"),
        ({"t_aux": -1.0}, "--t-aux: expected a number of at least 0, got -1"),
    ],
)
def test_bad_options_are_named(options, message):
    with pytest.raises(ValueError, match=message):
        MachineOptions(**options)


def test_no_path_object_is_needed(tmp_path):
    write_instance(HOLE, str(tmp_path / "part.json"))
    assert read_instance(str(tmp_path / "part.json")).name == "hole"
    assert Path(tmp_path / "part.json").read_text().endswith("}\n")
