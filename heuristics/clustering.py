r"""Partitions by clustering the pierce points, with the genetic algorithm on each side.

The two baselines of Wang et al. (2025): K-means and fuzzy c-means with two clusters; the cluster with the
smaller mean x is the left head's. Neither looks at the work of a contour or at the partition gap, so that
plans may break the rules: ``check`` says so.

Fuzzy c-means (Bezdek, 1981) with fuzzifier m = 2, d_ic the distance of point i to centre c:

    (1) J = sum_i sum_c u_ic^2 d_ic^2                    falls with every step                 [mm^2]
    (2) u_ic = d_ic^-2 / sum_j d_ij^-2                   memberships, sum_c u_ic = 1           [-]
    (3) v_c = sum_i u_ic^2 x_i / sum_i u_ic^2            centres                               [mm]
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial.distance import cdist
from sklearn.cluster import KMeans

from cutgap.heuristics.genetic import GeneticParameters, genetic_tour
from cutgap.heuristics.sides import Clock, plan_of, require_two_sides, score, side_tour
from cutgap.instances import Instance, Plan, Rules
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.progress import Progress, Watch, nobody

RESTARTS = 10
"""Starts of K-means; the best by its own criterion is taken."""

MOST_STEPS = 300
SETTLED = 1e-9
"""Fuzzy c-means stops after this many steps, or when no membership changes by more than this."""

Clustering = Callable[[Floats, np.random.Generator], Ints]


@dataclass(frozen=True, slots=True)
class FuzzyClusters:
    """Memberships, shape (points, clusters), and J of (1) after each step, mm^2."""

    memberships: Floats
    objectives: tuple[float, ...]


def k_means(
    instance: Instance,
    rules: Rules,
    *,
    rng: np.random.Generator,
    watch: Watch = nobody,
    time_limit: float | None = None,
    parameters: GeneticParameters | None = None,
) -> Plan:
    """Plan two heads by K-means; the work is fixed, about 0.2 s, and the time limit is not looked at.

    Raises
    ------
    ValueError
        Unless there are two heads, coordinates, one entry point per contour and no precedence.
    """
    require_two_sides(instance, "k-means")
    return plan_clusters(instance, rules, k_means_labels, rng, watch, parameters)


def fuzzy_c_means(
    instance: Instance,
    rules: Rules,
    *,
    rng: np.random.Generator,
    watch: Watch = nobody,
    time_limit: float | None = None,
    parameters: GeneticParameters | None = None,
) -> Plan:
    """Plan two heads by fuzzy c-means; the work is fixed, about 0.2 s, and the time limit is not looked at.

    Raises
    ------
    ValueError
        Unless there are two heads, coordinates, one entry point per contour and no precedence.
    """
    require_two_sides(instance, "fuzzy-c-means")
    return plan_clusters(instance, rules, fuzzy_labels, rng, watch, parameters)


def plan_clusters(
    instance: Instance,
    rules: Rules,
    clustering: Clustering,
    rng: np.random.Generator,
    watch: Watch,
    parameters: GeneticParameters | None,
) -> Plan:
    """Cluster, give the left cluster to the left head, and plan both by the genetic algorithm."""
    clock = Clock(None)
    parts = left_and_right(instance.points[instance.first_node[:-1]], clustering, rng)
    sides = []
    for head, part in enumerate(parts):
        tour = genetic_tour(instance, rules, head, part, rng=rng, parameters=parameters or GeneticParameters())
        sides.append(side_tour(instance, head, tour))
    watch(Progress(clock.seconds, value=score(instance, rules, sides)[1]))
    return plan_of(sides)


def left_and_right(
    points: Floats, clustering: Clustering, rng: np.random.Generator
) -> tuple[list[int], list[int]]:
    """Return the contours of both clusters, the one with the smaller mean x first.

    Points that all coincide make no clusters: the first half goes left.
    """
    n = len(points)
    if len(np.unique(points, axis=0)) < 2:
        half = (n + 1) // 2
        return list(range(half)), list(range(half, n))
    labels = clustering(points, rng)
    parts = [np.flatnonzero(labels == label).tolist() for label in (0, 1)]
    parts.sort(key=lambda part: float(points[part, 0].mean()) if part else np.inf)
    return parts[0], parts[1]


def k_means_labels(points: Floats, rng: np.random.Generator) -> Ints:
    """Return the cluster of each point, 0 or 1."""
    seed = int(rng.integers(2**31 - 1))
    return np.asarray(KMeans(n_clusters=2, n_init=RESTARTS, random_state=seed).fit_predict(points))


def fuzzy_labels(points: Floats, rng: np.random.Generator) -> Ints:
    """Return the cluster with the largest membership of each point, 0 or 1."""
    return np.argmax(fuzzy_clusters(points, 2, rng).memberships, axis=1)


def fuzzy_clusters(points: Floats, clusters: int, rng: np.random.Generator) -> FuzzyClusters:
    """Alternate (3) and (2) from random memberships until they settle."""
    memberships = rng.dirichlet(np.ones(clusters), size=len(points))
    objectives = []
    for _ in range(MOST_STEPS):
        weights = memberships**2
        centres = (weights.T @ points) / weights.sum(axis=0)[:, None]
        squares = cdist(points, centres, "sqeuclidean")
        previous, memberships = memberships, fuzzy_memberships(squares)
        objectives.append(float((memberships**2 * squares).sum()))
        if np.abs(memberships - previous).max() < SETTLED:
            break
    return FuzzyClusters(memberships, tuple(objectives))


def fuzzy_memberships(squares: Floats) -> Floats:
    """Return (2) from squared distances; a point on a centre belongs to it (shared among equal centres)."""
    on_centre = np.less_equal(squares, 0.0)
    with np.errstate(divide="ignore", over="ignore"):
        closeness = np.where(on_centre.any(axis=1, keepdims=True), on_centre, 1.0 / squares)
    return closeness / closeness.sum(axis=1, keepdims=True)
