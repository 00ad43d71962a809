"""Writes entry-point instances as ``.gtsp`` and ``.pcglns``, so that they read back exactly.

A contour's id is the number of its set. A home becomes a set of its own, which takes the number that no
contour has, and the tour starts there. An arc that the ordering forbids is written as -1 where its length is
that of the way back, which the reader puts in its place; otherwise its length is written.
"""

from collections.abc import Sequence
from itertools import accumulate, groupby, pairwise

import numpy as np

from cutgap.instances.formats.gtsp import FORBIDDEN, forbidden_arcs
from cutgap.instances.formats.gtsp_sets import COUNT, ORDERING, SETS, START, NodeSets
from cutgap.instances.formats.tsplib import node_lines, obstacles
from cutgap.instances.instance import Instance


def format_gtsp(instance: Instance) -> str:
    """Return a closed tour through sets as GTSPLIB text, with the full matrix.

    Raises
    ------
    ValueError
        When the instance has more to it than the format holds.
    """
    _refuse_obstacles(instance, "GTSPLIB")
    for reason, found in {
        "precedence": bool(instance.precedence),
        "homes": instance.heads[0].home is not None,
    }.items():
        if found:
            raise ValueError(f"instance {instance.name!r}: GTSPLIB cannot hold {reason}; write .pcglns instead")
    assert instance.matrix is not None
    return _text(instance, "GTSP" if (instance.matrix == instance.matrix.T).all() else "AGTSP")


def format_pcglns(instance: Instance) -> str:
    """Return an instance with one head as PCGLNS text, with the full matrix; errors as for ``format_gtsp``."""
    _refuse_obstacles(instance, "PCGLNS")
    return _text(instance, "PCGLNS")


def _refuse_obstacles(instance: Instance, format_name: str) -> None:
    found = obstacles(instance)
    found["no node"] = instance.node_count == 0
    found["ids other than the numbers of sets: 1, 2, ..., of which a home may take one"] = (
        _set_numbers(instance) is None
    )
    for reason, is_there in found.items():
        if is_there:
            raise ValueError(
                f"instance {instance.name!r}: {format_name} cannot hold {reason}; write .json instead"
            )


def _set_numbers(instance: Instance) -> list[int] | None:
    """Return the set of each contour, from 0, or ``None`` when the ids are not the numbers of sets."""
    count = len(instance.contours) + (instance.heads[0].home is not None)
    numbers = {str(number + 1): number for number in range(count)}
    found = [numbers.get(contour.id, -1) for contour in instance.contours]
    return found if -1 not in found and found == sorted(found) else None


def _text(instance: Instance, kind: str) -> str:
    sets, nodes = _sets(instance)
    assert instance.matrix is not None
    matrix = instance.matrix[np.ix_(nodes, nodes)]
    if kind == "PCGLNS":
        matrix = np.where(forbidden_arcs(sets) & (matrix == matrix.T), FORBIDDEN, matrix)
    lines = [
        f"NAME : {instance.name}",
        f"TYPE : {kind}",
        f"DIMENSION : {len(nodes)}",
        f"{COUNT} : {len(sets.members)}",
        *node_lines(instance.points[nodes] if instance.located else None, matrix),
        SETS,
        *(_list(number, members) for number, members in enumerate(sets.members)),
    ]
    if sets.before:
        runs = groupby(sets.before, key=lambda pair: pair[0])
        lines += [ORDERING, *(_list(first, [after for _, after in pairs]) for first, pairs in runs)]
    if sets.start is not None:
        lines += [START, str(sets.start + 1)]
    return "\n".join([*lines, "EOF", ""])


def _sets(instance: Instance) -> tuple[NodeSets, list[int]]:
    """Return the sets of a file, and the node of the instance that each node of the file is."""
    numbers = _set_numbers(instance)
    assert numbers is not None
    home = instance.home_node(0)
    places = [list(range(a, b)) for a, b in pairwise(instance.first_node.tolist())]
    start = None
    if home is not None:
        start = next(number for number in range(len(numbers) + 1) if number not in numbers)
        places.insert(start, [home])
    firsts = [0, *accumulate(map(len, places))]
    members = tuple(tuple(range(a, b)) for a, b in pairwise(firsts))
    before = tuple((numbers[a], numbers[b]) for a, b in instance.precedence)
    return NodeSets(members, before, start), [node for each in places for node in each]


def _list(number: int, others: Sequence[int]) -> str:
    return " ".join(str(each + 1) for each in (number, *others)) + " -1"
