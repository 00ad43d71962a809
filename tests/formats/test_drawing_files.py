"""Drawings from file to instance: the child process, its limits, commands, and the round trip through JSON."""

import json
import signal
import subprocess
import time
from threading import Timer, main_thread

import pytest

from cutgap.instances.formats import DrawingOptions, FormatNote, MachineOptions, read_instance, write_instance
from cutgap.instances.formats.drawings import child
from cutgap.instances.formats.drawings.child import Limits, read_outlines
from cutgap.instances.formats.drawings.plate import sheet_note
from cutgap.views.cli import main
from formats.drawing_samples import dxf_bytes, new_drawing, outlines_of, plate_of, square
from formats.strategies import same_bits

HOME = MachineOptions(homes=((0, 0),))


def plate():
    document = new_drawing()
    square(document.modelspace(), 0, 0, 100)
    document.modelspace().add_circle((50, 50), 20)
    return document


def endless():
    """Return a drawing of some kilobytes that shows an empty block ten thousand million times."""
    document = new_drawing()
    document.blocks.new("NOTHING")
    inner = "NOTHING"
    for level in range(5):
        block = document.blocks.new(f"LEVEL{level}")
        array = block.add_blockref(inner, (0, 0))
        array.dxf.row_count = array.dxf.column_count = 10
        array.dxf.row_spacing = array.dxf.column_spacing = 1
        inner = f"LEVEL{level}"
    document.modelspace().add_blockref(inner, (0, 0))
    return document


def test_files_become_what_the_reader_says_and_survive_json(tmp_path):
    (tmp_path / "plate.dxf").write_bytes(dxf_bytes(plate()))
    instance = read_instance(tmp_path / "plate.dxf", HOME)
    assert same_bits(instance, plate_of(plate()))
    write_instance(instance, tmp_path / "plate.json")
    assert same_bits(read_instance(tmp_path / "plate.json"), instance)


def test_convert_takes_all_options_and_prints_notes(tmp_path, capsys):
    source, target = tmp_path / "PLATE.DXF", tmp_path / "plate.json"
    document = plate()
    document.header["$INSUNITS"] = 0
    document.modelspace().add_line((200, 0), (300, 0.4), dxfattribs={"layer": "Cut"})
    document.modelspace().add_line((200, 0), (300, 0), dxfattribs={"layer": "Cut"})
    source.write_bytes(dxf_bytes(document))
    options = ["--home", "0,0", "--entries", "6", "--layers", "0,cut", "--tolerance", ".2", "--chord", "1"]
    assert main(["convert", str(source), str(target), *options, "--skip", "open,copies"]) == 0
    fields = json.loads(target.read_text())
    assert [each["id"] for each in fields["contours"]] == ["1", "1.1"]
    assert [len(each["entry_points"]) for each in fields["contours"]] == [6, 6]
    assert len(fields["contours"][1]["geometry"]) < 30
    assert fields["precedence"] == [["1.1", "1"]]
    messages = capsys.readouterr().err
    assert "cutgap: note: the drawing has no units" in messages
    assert "cutgap: note: left out as asked: 1 fault\n  open: layer 'Cut'" in messages


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--entries", "0"], "--entries: expected auto or a number from 1 to 10000, got 0"),
        (["--entries", "few"], "--entries: expected auto or a number, got 'few'"),
        (["--tolerance", "0"], "--tolerance: expected a number above 0"),
        (["--chord=-1"], "--chord: expected a number above 0"),
        (["--skip", "holes"], "--skip: expected some of open,copies,crossing, got 'holes'"),
        (["--layers", "A,,B"], "--layers: expected names A,B,..., got 'A,,B'"),
    ],
)
def test_bad_options_are_named(tmp_path, capsys, options, message):
    assert main(["convert", str(tmp_path / "plate.dxf"), "plate.json", "--home", "0,0", *options]) == 2
    assert message in capsys.readouterr().err


def test_without_a_home_the_head_makes_a_closed_tour_and_a_note_says_so(tmp_path):
    (tmp_path / "plate.dxf").write_bytes(dxf_bytes(plate()))
    with pytest.warns(FormatNote, match="closed tour; give --home"):
        instance = read_instance(tmp_path / "plate.dxf")
    assert [head.home for head in instance.heads] == [None]


def test_garbage_is_refused(tmp_path):
    content = dxf_bytes(plate()).replace(b"AcDbPolyline", b"\0\xff").replace(b"ENTITIES", b"\n0\nEOF\nX\n")
    (tmp_path / "broken.dxf").write_bytes(content)
    with pytest.raises(ValueError, match=r"broken\.dxf: "):
        read_instance(tmp_path / "broken.dxf", HOME)


def test_reading_ends_at_its_limits():
    content = dxf_bytes(endless())
    assert len(content) < 50_000
    begin = time.monotonic()
    with pytest.raises(ValueError, match=r"takes more than 2 s; the file is broken, or too large"):
        read_outlines("dxf", content, DrawingOptions(), Limits(seconds=2))
    assert time.monotonic() - begin < 20
    large = new_drawing()
    large.modelspace().add_circle((0, 0), 1e6)
    with pytest.raises(ValueError, match="takes more than 64 MiB"):
        read_outlines("dxf", dxf_bytes(large), DrawingOptions(chord=3e-5), Limits(memory_mib=64))


def test_ctrl_c_ends_the_child(monkeypatch):
    started = []

    class Recorded(subprocess.Popen):
        def __init__(self, *arguments, **options):
            super().__init__(*arguments, **options)
            started.append(self)
            Timer(0.5, signal.pthread_kill, (main_thread().ident, signal.SIGINT)).start()

    monkeypatch.setattr(child.subprocess, "Popen", Recorded)
    with pytest.raises(KeyboardInterrupt):
        read_outlines("dxf", dxf_bytes(endless()), DrawingOptions(), Limits())
    (process,) = started
    assert process.returncode is not None


def test_a_sheet_on_a_layer_of_its_own_is_pointed_out():
    document = plate()
    assert sheet_note(outlines_of(document)[0]) == []
    square(document.modelspace(), -10, -10, 150, layer="Sheet")
    (note,) = sheet_note(outlines_of(document)[0])
    assert "layer 'Sheet' encloses all others" in note
    assert "--layers 0" in note
