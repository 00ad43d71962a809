"""Sampled against continuous entry points, and our method beside its peer, on parts small enough for a test."""

import sys
from types import SimpleNamespace
from typing import ClassVar

import cvxpy as cp
import pytest

from cutgap.benchmark import continuous, region_peers
from cutgap.benchmark.regions import convex_plate, random_discs, random_mix
from cutgap.formulations import solve
from cutgap.instances import Rules
from cutgap.instances.free_entries import region_of


def table(instance, counts):
    rows = continuous.rows(instance, "perspective", counts, 60.0)
    return [dict(zip(continuous.COLUMNS, row, strict=True)) for row in rows]


@pytest.mark.parametrize("instance", [random_discs(4, 1), random_mix(4, 2), convex_plate(2, 2, 3)])
def test_the_sampled_optimum_falls_to_the_continuous_one(instance):
    best, bound, *rows = table(instance, (1, 4, 16))
    values = [float(row["optimum"]) for row in (*rows, best, bound)]
    assert values == sorted(values, reverse=True)
    for row in rows:
        assert float(bound["optimum"]) <= float(row["polished"]) <= float(row["optimum"])
        assert 0 <= float(row["polished %"]) <= float(row["above %"]) <= float(row["estimate %"])
    assert float(rows[-1]["above %"]) < 2.0


def test_curves_that_are_not_convex_have_the_bound_of_their_hulls(capsys):
    nest = continuous.nest_instance(4, 0)
    assert continuous.main(["nest", "--contours", "4", "--samples", "2", "--method", "perspective"]) == 0
    assert capsys.readouterr().out.count("nest-4") >= 3
    _, bound, row = table(nest, (2,))
    assert float(bound["optimum"]) <= float(row["polished"]) <= float(row["optimum"])
    hulls = continuous.with_hulls(nest)
    assert all(region_of(hulls, each) is not None for each in range(4))


class Graph:
    """Stands in for the peer's graph: remembers what it is given, and knows the value."""

    made: ClassVar[list["Graph"]] = []
    status, value = "optimal", 1.0

    def __init__(self, directed):
        self.edges, self.vertices = 0, 0
        Graph.made.append(self)

    def add_vertex(self, name):
        self.vertices += 1
        return SimpleNamespace(add_variable=cp.Variable, add_constraint=lambda constraint: None)

    def add_edge(self, tail, head):
        self.edges += 1
        return SimpleNamespace(add_cost=lambda cost: None)

    def solve_traveling_salesman(self, **options):
        assert options["scip_params"] == {"limits/time": 9.0}


def test_the_peer_is_asked_the_same_and_compared(monkeypatch):
    monkeypatch.setitem(sys.modules, "gcsopt", SimpleNamespace(GraphOfConvexSets=Graph, __spec__=object()))
    found = region_peers.rows((4,), 1, "perspective", 9.0)
    ours, theirs = (dict(zip(region_peers.COLUMNS, row, strict=True)) for row in found)
    assert (Graph.made[-1].vertices, Graph.made[-1].edges) == (4, 6)
    instance = random_discs(4, 1)
    value = solve(instance, Rules("travel", free_entries=True), method="perspective").value
    assert float(ours["value"]) == pytest.approx(value, abs=1e-3)
    assert (theirs["method"], theirs["value"]) == ("gcsopt", "1.0000")
    assert float(theirs["times slower"]) >= 0.0


def test_a_missing_peer_is_named_with_the_mend(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "gcsopt", None)
    assert region_peers.main(["--discs", "3"]) == 2
    assert "gcsopt: not installed; pip install" in capsys.readouterr().err
