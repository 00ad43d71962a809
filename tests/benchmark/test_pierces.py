"""The curve over ignition times on a small nest."""

import json

import pytest

from cutgap.benchmark.pierces import curve, main
from cutgap.instances import check, evaluate
from cutgap.instances.formats import read_instance
from cutgap.instances.formats.options import MachineOptions

T_AUX = (0.01, 2.0, 80.0)


@pytest.fixture
def nest(tmp_path):
    """Return the path of a nest of six squares, 30 mm apart."""
    places = [(40 * (i % 3), 40 * (i // 3)) for i in range(6)]
    parts = [
        {"item": i, "contour": [[x, y], [x + 10, y], [x + 10, y + 10], [x, y + 10]]}
        for i, (x, y) in enumerate(places)
    ]
    path = tmp_path / "six.json"
    path.write_text(json.dumps({"name": "six", "strip": [[0, 0], [1, 0], [1, 1]], "parts": parts}))
    return path


def test_the_best_plan_pierces_less_often_the_longer_ignition_takes(nest):
    sheet = read_instance(nest, MachineOptions(homes=((0.0, 0.0),), link_points=True))
    pierces = []
    for point in curve(sheet, T_AUX, time_limit=5.0):
        assert point.instance.machine.t_aux == point.t_aux
        assert point.best.rules.pierces is None
        assert not check(point.instance, point.best.rules, point.best.plan)
        assert point.best.value <= min(point.one_stroke.value, point.tour.value)
        pierces.append(evaluate(point.instance, point.best.plan).pierces[0])
        assert evaluate(point.instance, point.one_stroke.plan).pierces == (1,)
        assert evaluate(point.instance, point.tour.plan).pierces == (6,)
    assert pierces == sorted(pierces, reverse=True)
    assert pierces[0] > 1 == pierces[-1]


def test_the_command_prints_three_rows_a_time(nest, capsys):
    assert main([str(nest), "--t-aux", "1", "80", "--limit", "5"]) == 0
    out = capsys.readouterr().out
    assert "six: least makespan" in out
    assert out.count("euler-bridging") == out.count("entry-search") == 2
