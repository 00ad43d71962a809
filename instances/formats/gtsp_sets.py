"""Sets of nodes in files of the GTSPLIB family: what belongs together, what comes first, where a tour starts.

=======================  ===========================================================================
``GTSP_SETS``            number of sets
``GTSP_SET_SECTION``     lists ``k a b c -1``: set k holds the nodes a, b, c
``GTSP_SET_ORDERING``    lists ``a b c -1``: set a is visited before set b and before set c
``START_GROUP_SECTION``  the set that the tour starts in
=======================  ===========================================================================

Every node is in one set. A list may run over several lines.
"""

from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter

from cutgap.instances.formats.numbers import parse_count, parse_integer
from cutgap.instances.formats.tsplib_sections import TsplibFile, TsplibSection

COUNT = "GTSP_SETS"
SETS = "GTSP_SET_SECTION"
ORDERING = "GTSP_SET_ORDERING"
START = "START_GROUP_SECTION"


@dataclass(frozen=True, slots=True)
class NodeSets:
    """Sets and nodes, both numbered from 0.

    Attributes
    ----------
    members
        Nodes of each set, in the order of the file.
    before
        Pairs (a, b): set a is visited before set b. Without cycles.
    start
        The set that the tour starts in; ``None`` when the file names none.
    """

    members: tuple[tuple[int, ...], ...]
    before: tuple[tuple[int, int], ...]
    start: int | None


def parse_sets(file: TsplibFile, size: int) -> NodeSets:
    """Return the sets of a file with ``size`` nodes; errors are ``ValueError`` naming line, set and value."""
    if COUNT not in file.fields:
        raise ValueError(f"{COUNT}: the field is missing; add the number of sets")
    field = file.fields[COUNT]
    count = parse_count(field.value, f"line {field.line}, {COUNT}")
    if count > size:
        raise ValueError(f"line {field.line}, {COUNT}: {count} sets of {size} nodes: some would be empty")
    if SETS not in file.sections:
        raise ValueError(f"{SETS}: the section is missing; list the nodes of each set")
    members = _members(file.sections[SETS], count, size)
    before = _ordering(file.sections[ORDERING], count) if ORDERING in file.sections else ()
    start = _start(file.sections[START], count) if START in file.sections else None
    return NodeSets(members, before, start)


def _lists(section: TsplibSection, keyword: str) -> list[tuple[str, list[int]]]:
    """Return the lists of a section without their -1, each with the place where it begins."""
    lists: list[tuple[str, list[int]]] = []
    begun = False
    for line, words in section.rows:
        for word in words:
            number = parse_integer(word, f"line {line}, {keyword}")
            if not begun:
                lists.append((f"line {line}, {keyword}", []))
            begun = number != -1
            if begun:
                lists[-1][1].append(number)
            elif not lists[-1][1]:
                raise ValueError(f"line {line}, {keyword}: a list with no number before its -1; remove it")
    if begun:
        raise ValueError(
            f"{lists[-1][0]}: the list that begins here does not end; put -1 behind its last number"
        )
    return lists


def _members(section: TsplibSection, count: int, size: int) -> tuple[tuple[int, ...], ...]:
    members: dict[int, tuple[int, ...]] = {}
    owner: dict[int, int] = {}
    for place, (number, *nodes) in _lists(section, SETS):
        _require_set(number, count, place)
        place = f"{place}, set {number}"
        if number in members:
            raise ValueError(f"{place}: listed more than once; does the list before end with -1?")
        if not nodes:
            raise ValueError(f"{place}: has no node; give it one, or remove it and lower {COUNT}")
        for node in nodes:
            if not 1 <= node <= size:
                raise ValueError(f"{place}: node {node} is not among the nodes 1 to {size}")
            if node in owner:
                raise ValueError(
                    f"{place}: node {node} is in set {owner[node]} already; keep it in one of them"
                )
            owner[node] = number
        members[number] = tuple(node - 1 for node in nodes)
    for number in range(1, count + 1):
        if number not in members:
            raise ValueError(f"line {section.line}, {SETS}: {COUNT} is {count}, but there is no set {number}")
    for node in range(1, size + 1):
        if node not in owner:
            raise ValueError(f"line {section.line}, {SETS}: node {node} is in no set; put it into one")
    return tuple(members[number] for number in range(1, count + 1))


def _ordering(section: TsplibSection, count: int) -> tuple[tuple[int, int], ...]:
    pairs: list[tuple[int, int]] = []
    for place, (first, *others) in _lists(section, ORDERING):
        for number in (first, *others):
            _require_set(number, count, place)
        if first in others:
            raise ValueError(f"{place}: set {first} cannot come before itself; remove it from its list")
        pairs += [(first - 1, other - 1) for other in others]
    graph: TopologicalSorter[int] = TopologicalSorter()
    for a, b in pairs:
        graph.add(b, a)
    try:
        graph.prepare()
    except CycleError as error:
        cycle = ", ".join(str(number + 1) for number in error.args[1])
        raise ValueError(
            f"line {section.line}, {ORDERING}: no order is possible, for each of the sets {cycle:.200} "
            "comes before the next; take one of these pairs out"
        ) from None
    return tuple(pairs)


def _start(section: TsplibSection, count: int) -> int:
    place = f"line {section.line}, {START}"
    words = [word for _, row in section.rows for word in row]
    # Some files end the section with -1.
    numbers = [parse_integer(word, place) for word in words if word != "-1"]
    if len(numbers) != 1:
        raise ValueError(f"{place}: expected the number of one set, got {' '.join(words)[:40]!r}")
    _require_set(numbers[0], count, place)
    return numbers[0] - 1


def _require_set(number: int, count: int, place: str) -> None:
    if not 1 <= number <= count:
        raise ValueError(f"{place}: there is no set {number}; {COUNT} is {count}")
