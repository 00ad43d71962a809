"""Relaxations of tours: valid, tight where theory says so, in the order that theory says, and certified."""

import numpy as np
import pytest
from oracles.brute_force import brute_force
from oracles.held_karp import shortest_tour
from oracles.random_instances import LAYOUTS, random_instance

from cutgap.formulations.certificate import verify
from cutgap.formulations.relaxations.assignment import (
    assignment,
    assignment_of_tour,
    two_matching,
    two_matching_of_tour,
)
from cutgap.formulations.relaxations.connectivity import MOST_NODES as MOST_CONNECTED
from cutgap.formulations.relaxations.connectivity import connectivity, connectivity_of_tour
from cutgap.formulations.relaxations.cycle_distances import MOST_NODES as MOST_DISTANT
from cutgap.formulations.relaxations.cycle_distances import cycle_distances, distances_of_tour
from cutgap.formulations.relaxations.held_karp import (
    held_karp,
    held_karp_of_tour,
    one_tree,
    one_tree_of_tour,
)
from cutgap.instances import Contour, Head, Instance, Machine, Rules
from cutgap.instances.formats.json_format import format_instance

OF_TOURS = {
    assignment: assignment_of_tour,
    two_matching: two_matching_of_tour,
    one_tree: one_tree_of_tour,
    held_karp: held_karp_of_tour,
    connectivity: connectivity_of_tour,
    cycle_distances: distances_of_tour,
}
ALL = tuple(OF_TOURS)
SEMIDEFINITE = (connectivity, cycle_distances)
TRAVEL = Rules("travel")
NO_VIA = np.empty(0, dtype=np.int64)


def closed(lengths):
    """One head without home, symmetric lengths between its contours."""
    contours = tuple(Contour(f"c{i}", np.zeros((1, 3)), 0.0) for i in range(len(lengths)))
    matrix = np.array(lengths, dtype=float)
    return Instance("closed", contours, (Head("h"),), Machine(metric="matrix"), matrix=matrix, located=False)


def graph_metric(nodes, edges):
    """Lengths of shortest ways along edges of length 1."""
    lengths = np.full((nodes, nodes), float(nodes))
    np.fill_diagonal(lengths, 0)
    for u, v in edges:
        lengths[u, v] = lengths[v, u] = 1
    for k in range(nodes):
        lengths = np.minimum(lengths, lengths[:, [k]] + lengths[[k]])
    return lengths


def clusters(nodes):
    """Two halves at one place each, one apart."""
    left = np.arange(nodes) < nodes // 2
    return (left[:, None] != left).astype(float)


def three_paths():
    """Two triangles, joined corner to corner by three paths of two edges."""
    triangles = [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3)]
    paths = [(0, 6), (6, 3), (1, 7), (7, 4), (2, 8), (8, 5)]
    return graph_metric(9, triangles + paths)


def regular(nodes):
    angle = 2 * np.pi * np.arange(nodes) / nodes
    points = 100 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.linalg.norm(points[:, None] - points, axis=2)


def random_lengths(seed, nodes):
    lengths = np.triu(np.random.default_rng(seed).integers(1, 100, (nodes, nodes)), 1)
    return (lengths + lengths.T).astype(float)


def proved(relaxation, lengths):
    """The bound of a closed tour, as the checker gives it."""
    part = closed(lengths)
    bound = relaxation(part, TRAVEL)
    assert verify(bound.certificate, format_instance(part)).bound >= bound.bound
    return bound.bound


@pytest.mark.parametrize("relaxation", ALL)
@pytest.mark.parametrize("layout", LAYOUTS)
def test_one_head_stays_below_the_optimum(relaxation, layout):
    rng = np.random.default_rng(LAYOUTS.index(layout))
    for holes in (0, 2, 3, 6):
        part = random_instance(rng, holes, layout=layout, heads=1, homes=None)
        rules = Rules(str(rng.choice(["makespan", "travel"])), via_points=bool(rng.integers(2)))
        bound, best = relaxation(part, rules), brute_force(part, rules)
        verdict = verify(bound.certificate, format_instance(part))
        assert 0 <= bound.bound <= verdict.bound <= best.value * (1 + 1e-12)
        if holes + (part.heads[0].home is not None) <= 3:
            assert bound.bound == pytest.approx(best.value, rel=1e-6, abs=1e-5)


@pytest.mark.parametrize("relaxation", ALL)
@pytest.mark.parametrize("seed", range(4))
def test_the_proved_bound_is_the_value_of_the_solver(relaxation, seed):
    lengths = random_lengths(seed, 9)
    value = OF_TOURS[relaxation](lengths, NO_VIA).value
    assert proved(relaxation, lengths) == pytest.approx(value, rel=1e-6)


@pytest.mark.parametrize("relaxation", ALL)
def test_no_lengths_at_all(relaxation):
    assert proved(relaxation, np.zeros((5, 5))) == 0


@pytest.mark.parametrize("relaxation", ALL)
@pytest.mark.parametrize("nodes", [6, 7])
def test_equal_lengths_and_regular_polygons_are_closed(relaxation, nodes):
    equal = 7.0 * (1 - np.eye(nodes))
    assert proved(relaxation, equal) == pytest.approx(7 * nodes, rel=1e-6)
    if relaxation is not assignment:  # which goes back and forth between neighbours
        around = 200 * nodes * np.sin(np.pi / nodes)
        assert proved(relaxation, regular(nodes)) == pytest.approx(around, rel=1e-6)


@pytest.mark.parametrize("relaxation", [two_matching, held_karp, *SEMIDEFINITE])
@pytest.mark.parametrize("nodes", [4, 5])
def test_up_to_five_nodes_the_degrees_say_all(relaxation, nodes):
    for seed in range(3):
        lengths = random_lengths(seed, nodes)
        assert proved(relaxation, lengths) == pytest.approx(shortest_tour(lengths)[0], rel=1e-6)


@pytest.mark.parametrize("relaxation", SEMIDEFINITE)
@pytest.mark.parametrize("nodes", [6, 10])
def test_two_clusters_are_joined_by_the_second_eigenvalue(relaxation, nodes):
    """f = 1 and -1 on the clusters: 4 x(delta) >= beta n, and an even mixture of edges reaches it."""
    beta = 2 - 2 * np.cos(2 * np.pi / nodes)
    assert proved(relaxation, clusters(nodes)) == pytest.approx(beta * nodes / 4, rel=1e-6)


@pytest.mark.parametrize("seed", range(6))
def test_the_order_of_bounds(seed):
    lengths = random_lengths(seed, 8)
    bound = {relaxation: proved(relaxation, lengths) for relaxation in ALL}
    slack = 1e-5
    assert bound[assignment] <= bound[two_matching] + slack
    assert bound[two_matching] <= bound[held_karp] + slack
    assert bound[one_tree] <= bound[held_karp] + slack
    assert bound[connectivity] <= bound[held_karp] + slack
    assert bound[connectivity] <= bound[cycle_distances] + slack
    assert max(bound.values()) <= shortest_tour(lengths)[0]


def test_distances_can_beat_held_karp_and_lose():
    lengths = three_paths()
    assert proved(held_karp, lengths) == pytest.approx(9, abs=1e-5)
    assert proved(cycle_distances, lengths) > 9.1
    assert shortest_tour(lengths)[0] == 10
    assert proved(held_karp, clusters(8)) == pytest.approx(2, abs=1e-5)
    assert proved(cycle_distances, clusters(8)) < 1.5


def test_subtour_duals_are_the_best_potentials():
    """The 1-tree of the potentials is worth the linear program, via points included."""
    for seed in range(5):
        part = random_instance(np.random.default_rng(seed), 14, layout="uniform", heads=1, homes=True)
        rules = Rules("travel", via_points=bool(seed % 2))
        via = np.array([1 + int(part.points[:14, 0].argmin())]) if seed % 2 else NO_VIA
        lengths = np.roll(part.rapids, 1, axis=(0, 1))
        value = held_karp_of_tour(lengths, via).value
        assert held_karp(part, rules).bound == pytest.approx(value, rel=1e-9)
        assert one_tree(part, rules).bound <= value + 1e-5


@pytest.mark.parametrize("relaxation", [two_matching, held_karp, *SEMIDEFINITE])
def test_via_points_count(relaxation):
    """A leftmost contour far from the home, which tours without via points reach from a neighbour."""
    places = [(0, 60), (1, 0), (2, 0), (3, 0), (4, 60)]
    contours = tuple(Contour(f"c{i}", np.array([[*place, 0.0]]), 0.0) for i, place in enumerate(places))
    part = Instance("far", contours, (Head("h", np.array([2.0, -1.0, 0.0])),))
    free, asked = (relaxation(part, Rules("travel", via_points=via)).bound for via in (False, True))
    best = [brute_force(part, Rules("travel", via_points=via)).value for via in (False, True)]
    assert free <= best[0] < asked <= best[1]


@pytest.mark.parametrize("relaxation", ALL)
def test_what_does_not_apply_is_refused(relaxation):
    part = random_instance(np.random.default_rng(0), 4)
    with pytest.raises(ValueError, match="two heads need a non-overlap limit"):
        relaxation(part, Rules(non_overlap=None))
    uneven = np.array([[0, 1, 2], [2, 0, 1], [1, 2, 0]])
    with pytest.raises(ValueError, match="symmetric"):
        relaxation(closed(uneven), TRAVEL)


@pytest.mark.parametrize(
    ("relaxation", "most"), [(connectivity, MOST_CONNECTED), (cycle_distances, MOST_DISTANT)]
)
def test_too_many_nodes_are_refused_with_the_limit(relaxation, most):
    with pytest.raises(ValueError, match=f"{most + 1} nodes is too large, the most is {most}"):
        relaxation(closed(random_lengths(0, most + 1)), TRAVEL)
