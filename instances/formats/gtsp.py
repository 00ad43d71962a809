"""Entry-point instances of the GTSPLIB family: sets of nodes of which a tour visits one node each.

A set is a contour with its nodes as entry points, numbered as listed; contour ids are the numbers of the sets.
The instance is named after the file: the names inside published files are paths or wrong.

=========  =================  =============================================================================
TYPE       suffix             lengths and start
=========  =================  =============================================================================
GTSP       ``.gtsp``          symmetric, rounded as TSPLIB says or explicit
AGTSP      ``.gtsp``          explicit, possibly asymmetric
PCGLNS     ``.pcglns``        as AGTSP, with an ordering of the sets and a start set
PCGTSP     ``.txt``           industrial cutting paths: coordinates in mm, an ordering; set 1 is the home
=========  =================  =============================================================================

Start. A start set of one node is the home of the single head. A start set of several nodes is a contour that
is cut before all others on a closed tour: which node it starts from is chosen, and the tour returns there.
Without a start set the tour is closed, and starts anywhere that the ordering allows. In PCGTSP files set 1 is
the start set, unless it has several nodes or the ordering puts another set before it.

Arcs marked -1. An ordering that puts set a before set b forbids to go from b straight to a. PCGLNS files write
-1 for these arcs. Here the length of the way back, from a to b, is stored in its place; no allowed plan uses
it. A -1 anywhere else is refused. Without a start set, and into it, the way home can use the arc: refused too.

Cutting paths. Their ``EUC_2D`` is read as exact Euclidean length, not rounded: their authors call it "2D
Euclidean", coordinates are mm with many decimals, and no published value depends on rounding. Rounded lengths
differ by at most 0.5 mm a rapid. The points of a set run around its contour; the published sets are simple
polygons that enclose each other just as their ordering says, inner before outer. So the closed polygon through
the points is kept as geometry where it does not cross itself. Its length is the perimeter: on curves a little
short of the true one.

Source: Fischetti, Salazar, Toth (1997) for GTSPLIB; Khachay, Kudriavtsev, Petunin (2020) for PCGLNS.
"""

from collections import defaultdict
from dataclasses import replace
from graphlib import TopologicalSorter

import numpy as np
import numpy.typing as npt
import shapely

from cutgap.instances.arrays import Floats, closed_length
from cutgap.instances.formats.gtsp_sets import ORDERING, SETS, START, NodeSets, parse_sets
from cutgap.instances.formats.options import MachineOptions
from cutgap.instances.formats.tsplib import (
    COORDINATES,
    SECTIONS,
    WEIGHTS,
    coordinates,
    dimension,
    given_homes,
    require_symmetric,
    weights,
)
from cutgap.instances.formats.tsplib_metrics import METRICS
from cutgap.instances.formats.tsplib_sections import TsplibFile, parse_sections
from cutgap.instances.instance import Contour, Head, Instance

TYPES = ("GTSP", "AGTSP", "PCGLNS", "PCGTSP")
FORBIDDEN = -1.0
"""What stands in a matrix for an arc that the ordering forbids."""


def parse_instance(text: str, name: str, options: MachineOptions) -> Instance:
    """Return the instance in a text of the family; errors are ``ValueError`` naming line, section and value."""
    file = parse_sections(text)
    kind = file.choice("TYPE", TYPES)
    file.refuse_sections((*SECTIONS, SETS, ORDERING, START))
    size = dimension(file)
    metric = file.choice("EDGE_WEIGHT_TYPE", ("EXPLICIT", *METRICS))
    exact = kind == "PCGTSP" and metric == "EUC_2D"
    points = _points(file, size, metric, exact)
    sets = _with_start(parse_sets(file, size), kind)
    home = () if sets.start is None or len(sets.members[sets.start]) > 1 else sets.members[sets.start]
    numbers = [number for number, nodes in enumerate(sets.members) if nodes != home]
    homes = given_homes(options, metric)
    places = np.concatenate([np.zeros((size, 3)) if points is None else points, homes])
    nodes = [node for number in numbers for node in sets.members[number]]
    nodes += range(size, size + len(homes)) if options.homes else home
    return Instance(
        name=name,
        contours=tuple(
            _contour(str(number + 1), places[list(sets.members[number])], outlined=exact) for number in numbers
        ),
        heads=options.heads() if options.homes else (Head("head", places[home[0]] if home else None),),
        machine=options.machine(metric="euclidean" if exact else "matrix"),
        precedence=_precedence(sets, numbers),
        matrix=None if exact else _lengths(file, kind, metric, sets, places)[np.ix_(nodes, nodes)],
        located=points is not None,
    )


def _points(file: TsplibFile, size: int, metric: str, exact: bool) -> Floats | None:
    points = coordinates(file, size)
    if points is None and metric != "EXPLICIT":
        raise ValueError(f"{COORDINATES}: the section is missing; {metric} needs it")
    if exact and points is not None and points[:, 2].any():
        raise ValueError(
            f"line {file.sections[COORDINATES].line}, {COORDINATES}: {metric} has no z; give x and y"
        )
    return points


def _with_start(sets: NodeSets, kind: str) -> NodeSets:
    """Return the sets with set 1 of cutting paths as their start; refuse an ordering that contradicts it."""
    led = {after: before for before, after in sets.before}
    if sets.start is None and kind == "PCGTSP" and len(sets.members[0]) == 1 and 0 not in led:
        return replace(sets, start=0)
    if sets.start in led:
        raise ValueError(
            f"{ORDERING}: set {led[sets.start] + 1} cannot come before set {sets.start + 1}, "
            f"which {START} names; take one of them out"
        )
    return sets


def _contour(name: str, points: Floats, *, outlined: bool) -> Contour:
    if not outlined:
        return Contour(name, points, 0.0)
    perimeter, outline = closed_length(points), points[:, :2]
    simple = len(outline) > 2 and perimeter < np.inf and shapely.LinearRing(outline).is_simple
    return Contour(name, points, perimeter, geometry=outline if simple else None)


def _precedence(sets: NodeSets, numbers: list[int]) -> tuple[tuple[int, int], ...]:
    """Return the pairs of contours, given the sets that are contours; a home comes first in any case."""
    index = {number: contour for contour, number in enumerate(numbers)}
    pairs = [(index[a], index[b]) for a, b in sets.before if a in index]
    if sets.start in index:
        first = index[sets.start]
        known = set(pairs)
        pairs += [(first, c) for c in range(len(numbers)) if c != first and (first, c) not in known]
    return tuple(pairs)


def _lengths(file: TsplibFile, kind: str, metric: str, sets: NodeSets, places: Floats) -> Floats:
    """Return the lengths between all places: the nodes in the order of the file, then given homes."""
    if metric != "EXPLICIT":
        return METRICS[metric](places)
    if kind == "GTSP":
        matrix = weights(file, len(places))
        require_symmetric(file, matrix, "AGTSP")
        return matrix
    matrix = weights(file, len(places), least=FORBIDDEN)
    np.fill_diagonal(matrix, 0.0)
    negative = matrix < 0
    if not negative.any():
        return matrix
    marked = negative & forbidden_arcs(sets) & (matrix == FORBIDDEN)
    if (marked != negative).any():
        a, b = np.argwhere(marked != negative)[0].tolist()
        place = f"line {file.sections[WEIGHTS].line}, {WEIGHTS}: from node {a + 1} to node {b + 1}"
        raise ValueError(f"{place}: {_refusal(sets, float(matrix[a, b]), a, b)}")
    return np.where(marked, matrix.T, matrix)


def _refusal(sets: NodeSets, length: float, a: int, b: int) -> str:
    """Say why a negative length cannot stand for the arc from node a to node b."""
    if length != FORBIDDEN:
        return f"expected a length of at least 0, or -1 for a forbidden arc, got {length:g}"
    if sets.start is None:
        return f"-1 without a start set, so the arc may close the tour; give its length, or add {START}"
    owner = {node: number + 1 for number, nodes in enumerate(sets.members) for node in nodes}
    return (
        f"-1, but {ORDERING} does not forbid to go from set {owner[a]} to set {owner[b]}; "
        f"give the length, or put set {owner[b]} before set {owner[a]}"
    )


def forbidden_arcs(sets: NodeSets) -> npt.NDArray[np.bool_]:
    """Return the arcs between nodes that no tour from the start set can use, shape (nodes, nodes).

    These lead from a set straight to one that comes before it, directly or by others between. Not so for arcs
    into the start set, which end the tour. Without a start set any arc may end the tour.
    """
    count = len(sets.members)
    earlier = np.zeros((count, count), dtype=np.bool_)
    if sets.start is not None:
        leaders: dict[int, list[int]] = defaultdict(list)
        for a, b in sets.before:
            leaders[b].append(a)
        for b in list(TopologicalSorter(leaders).static_order()):
            for a in leaders[b]:
                earlier[b] |= earlier[a]
                earlier[b, a] = True
        earlier[:, sets.start] = False
    owner = np.zeros(sum(map(len, sets.members)), dtype=np.int64)
    for number, nodes in enumerate(sets.members):
        owner[list(nodes)] = number
    return earlier[np.ix_(owner, owner)]
