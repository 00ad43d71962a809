"""The readable model of links: agreement with brute force, statuses, the rows."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from oracles.linked_strokes import least_value
from oracles.random_outlines import random_outlines

from cutgap.formulations import links_model
from cutgap.formulations.compact.solvers import run
from cutgap.instances import Contour, Head, Instance, Machine, Rules, Status


def random_rules(rng):
    objective = str(rng.choice(["travel", "makespan"]))
    return Rules(objective, links=True, pierces=[None, None, 1, 2][int(rng.integers(4))])


@pytest.mark.parametrize("seed", range(24))
def test_agrees_with_brute_force(seed):
    rng = np.random.default_rng(seed)
    instance = random_outlines(rng, int(rng.integers(1, 5)), entries=3)
    rules = random_rules(rng)
    result = links_model(instance, rules).solve()
    least = least_value(instance, rules)
    if least is None:
        assert result.status is Status.INFEASIBLE
        return
    assert result.status is Status.OPTIMAL
    assert result.value == pytest.approx(least, rel=1e-9)
    assert links_model(instance, rules).relax().safe_bound(0.0) <= least


def box(name, x, y, entries):
    corners = np.array([[x, y], [x + 10, y], [x + 10, y + 10], [x, y + 10]], dtype=float)
    return Contour(name, np.column_stack((corners, np.zeros(4)))[entries], 40.0, geometry=corners)


def row(*contours, t_aux=7.0, **others):
    machine = Machine(v_jump=100.0, v_cut=10.0, t_aux=t_aux)
    return Instance("row", contours, (Head("head", np.zeros(3)),), machine, **others)


def test_the_price_of_a_pierce_decides():
    """Two boxes 4 mm apart: a link of 0.4 s, against another pierce and the same way by a rapid."""
    boxes = box("a", 10, 0, [0, 1]), box("b", 24, 0, [0])
    for t_aux, strokes in ((0.05, 2), (80.0, 1)):
        result = links_model(row(*boxes, t_aux=t_aux), Rules("makespan", links=True)).solve()
        assert (result.status, result.evaluation.pierces) == (Status.OPTIMAL, (strokes,))


def test_a_relaxation_without_leaders_joins_strokes_that_no_plan_has():
    """The rows on leaders matter: without them several strokes would pass through one group."""
    rng = np.random.default_rng(2)
    cut_off = 0
    for _ in range(12):
        instance = random_outlines(rng, 3, entries=3, nested=0.0)
        model = links_model(instance, Rules("travel", links=True))
        whole = model.programme(integer=True)
        kept = [each for each in whole.families if each.name not in ("leader", "member", "follows", "together")]
        rest = run(replace(whole, families=tuple(kept)).problem(), "HIGHS", None, integer=True)
        least = least_value(instance, model.rules)
        assert rest.value <= least * (1 + 1e-7)
        cut_off += rest.value < least * (1 - 1e-6)
    assert cut_off > 0


def test_rows_are_those_of_the_docs():
    """Each family is there, and nothing else."""
    model = links_model(row(box("a", 10, 0, [0, 1]), box("b", 24, 0, [0])), Rules(links=True, pierces=1))
    page = (Path(__file__).parents[2] / "docs" / "formulations.md").read_text(encoding="utf-8")
    names = {each.name for each in model.programme().families}
    table = page[page.index("## Links") : page.index("## In code")]
    assert names == set(re.findall(r"^\| `([a-z]+)` \|", table, re.MULTILINE))
    # Two links, 4 rapids between nodes and 6 to and from the home, 3 nodes, 2 contours, 4 ways for the flow.
    assert model.size().variables == 2 * 2 + (4 + 6) + 3 + 2 * 2 + 4 + 1


def test_statuses():
    hole = Contour("hole", np.array([[12.0, 2.0, 0.0]]), 12.0, geometry=np.array([[12, 2], [16, 2], [12, 5]]))
    plate = row(box("plate", 10, 0, [0]), hole)
    assert links_model(plate, Rules(links=True, pierces=1)).solve().status is Status.INFEASIBLE
    assert links_model(plate, Rules(links=True)).solve().status is Status.OPTIMAL
    nothing = links_model(row(), Rules(links=True))
    assert (nothing.solve().status, nothing.size().variables) == (Status.OPTIMAL, 0)
    assert nothing.relax().safe_bound(0.0) == 0.0
    rng = np.random.default_rng(1)
    stopped = links_model(random_outlines(rng, 5, entries=3), Rules("travel", links=True)).solve(time_limit=0.0)
    assert stopped.status in (Status.UNKNOWN, Status.FEASIBLE)
    assert stopped.reason is not None


def test_what_does_not_suit_is_refused():
    pair = box("a", 10, 0, [0]), box("b", 24, 0, [0])
    with pytest.raises(ValueError, match="needs rules with links"):
        links_model(row(*pair), Rules("travel"))
    with pytest.raises(ValueError, match="precedence"):
        links_model(row(*pair, precedence=((0, 1),)), Rules(links=True))
    with pytest.raises(ValueError, match="is not installed"):
        links_model(row(*pair), Rules(links=True)).solve("NONE")
