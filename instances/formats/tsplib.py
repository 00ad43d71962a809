"""TSPLIB files of type TSP and ATSP: points to visit (perimeter 0) under a rounded or an explicit metric.

The rounded metrics become matrices of whole numbers, because their optima are published for these. Contour
ids are the node numbers. Without homes a single head makes a closed tour. Homes can be given for files with
coordinates and a metric over them; their lengths are rounded in the same way.

Source: Reinelt, TSPLIB 95 (1995).
"""

import numpy as np

from cutgap.instances.arrays import Floats
from cutgap.instances.formats.numbers import parse_count, parse_number, parse_numbers
from cutgap.instances.formats.options import MachineOptions
from cutgap.instances.formats.tsplib_metrics import FORMATS, METRICS, entry_count, explicit_matrix
from cutgap.instances.formats.tsplib_sections import TsplibFile, TsplibSection, parse_sections
from cutgap.instances.instance import Contour, Head, Instance

TYPES = ("TSP", "ATSP")
NODE_LIMIT = 5000
"""Most nodes that are read: the matrix of more takes over 200 MB."""

COORDINATES = "NODE_COORD_SECTION"
WEIGHTS = "EDGE_WEIGHT_SECTION"
# DISPLAY_DATA only places nodes in a drawing, so it is no source of coordinates.
SECTIONS = (COORDINATES, WEIGHTS, "DISPLAY_DATA_SECTION")


def parse_instance(text: str, name: str, options: MachineOptions) -> Instance:
    """Return the instance in a TSPLIB text; errors are ``ValueError`` naming line, section and value."""
    file = parse_sections(text)
    kind = file.choice("TYPE", TYPES)
    file.refuse_sections(SECTIONS)
    size = dimension(file)
    metric = file.choice("EDGE_WEIGHT_TYPE", ("EXPLICIT", *METRICS))
    points = coordinates(file, size)
    homes = given_homes(options, metric)
    if metric == "EXPLICIT":
        matrix = weights(file, size)
        if kind == "TSP":
            require_symmetric(file, matrix, "ATSP")
    elif points is None:
        raise ValueError(f"{COORDINATES}: the section is missing; {metric} needs it")
    else:
        matrix = METRICS[metric](np.concatenate([points, homes]))
    places = np.zeros((size, 3)) if points is None else points
    field = file.fields.get("NAME")
    return Instance(
        name=field.value if field is not None and field.value else name,
        contours=tuple(Contour(str(n), places[[n - 1]], 0.0) for n in range(1, size + 1)),
        heads=options.heads() if options.homes else (Head("head"),),
        machine=options.machine(metric="matrix"),
        matrix=matrix,
        located=points is not None,
    )


def dimension(file: TsplibFile) -> int:
    """Return the number of nodes."""
    if "DIMENSION" not in file.fields:
        raise ValueError("DIMENSION: the field is missing; add the number of nodes")
    field = file.fields["DIMENSION"]
    size = parse_count(field.value, f"line {field.line}, DIMENSION")
    if size > NODE_LIMIT:
        raise ValueError(f"line {field.line}, DIMENSION: at most {NODE_LIMIT} nodes can be read, got {size}")
    return size


def coordinates(file: TsplibFile, size: int) -> Floats | None:
    """Return the places of nodes 1, 2, ... with shape (size, 3), or ``None`` without the section."""
    section = file.sections.get(COORDINATES)
    if section is None:
        return None
    points = np.zeros((size, 3))
    seen: set[int] = set()
    for line, words in section.rows:
        place = f"line {line}, {COORDINATES}"
        if len(words) not in (3, 4):
            raise ValueError(f"{place}: expected node, x, y (and z), got {len(words)} words")
        node = parse_count(words[0], f"{place}, node")
        if node > size or node in seen:
            reason = "appears more than once" if node in seen else f"is above DIMENSION {size}"
            raise ValueError(f"{place}: node {node} {reason}")
        seen.add(node)
        points[node - 1, : len(words) - 1] = [parse_number(word, f"{place}, node {node}") for word in words[1:]]
    if len(seen) < size:
        missing = next(node for node in range(1, size + 1) if node not in seen)
        raise ValueError(
            f"line {section.line}, {COORDINATES}: expected {size} nodes, got {len(seen)}; no node {missing}"
        )
    return points


def weights(file: TsplibFile, size: int, *, least: float = 0.0) -> Floats:
    """Return the matrix of an explicit file, its numbers at least ``least``."""
    section = file.sections.get(WEIGHTS)
    if section is None:
        raise ValueError(f"{WEIGHTS}: the section is missing; EXPLICIT needs it")
    layout = file.choice("EDGE_WEIGHT_FORMAT", FORMATS)
    numbers = _weight_numbers(section, entry_count(layout, size), layout, least)
    return explicit_matrix(layout, size, numbers)


def require_symmetric(file: TsplibFile, matrix: Floats, other_type: str) -> None:
    """Raise ``ValueError`` when the explicit matrix of a symmetric type is not; ``other_type`` takes it."""
    if (matrix == matrix.T).all():
        return
    a, b = np.argwhere(matrix != matrix.T)[0].tolist()
    raise ValueError(
        f"line {file.sections[WEIGHTS].line}, {WEIGHTS}: TYPE {file.fields['TYPE'].value} is symmetric, but "
        f"{a + 1} to {b + 1} is {matrix[a, b]:g} and back {matrix[b, a]:g}; "
        f"write TYPE {other_type} if that is meant"
    )


def _weight_numbers(section: TsplibSection, expected: int, layout: str, least: float) -> Floats:
    numbers: list[float] = []
    for line, words in section.rows:
        numbers += parse_numbers(words, f"line {line}, {WEIGHTS}", least=least)
        if len(numbers) > expected:
            raise ValueError(f"line {line}, {WEIGHTS}: more than the {expected} numbers of {layout}")
    if len(numbers) < expected:
        raise ValueError(
            f"line {section.line}, {WEIGHTS}: expected {expected} numbers for {layout}, got {len(numbers)}"
        )
    return np.array(numbers)


def given_homes(options: MachineOptions, metric: str) -> Floats:
    """Return the places of the given homes, shape (homes, 3), where lengths to them can be computed."""
    if not options.homes:
        return np.empty((0, 3))
    if metric == "EXPLICIT":
        raise ValueError("EDGE_WEIGHT_TYPE: EXPLICIT gives no lengths to other homes; leave --home out")
    homes = np.array([head.home for head in options.heads()])
    if homes[:, 2].any():
        raise ValueError(f"EDGE_WEIGHT_TYPE: {metric} has no z; give --home X,Y")
    return homes


def format_instance(instance: Instance) -> str:
    """Return an instance of points under a matrix as TSPLIB text, with the full matrix.

    Raises
    ------
    ValueError
        When the instance has more to it than the format holds.
    """
    for reason, found in _obstacles(instance).items():
        if found:
            raise ValueError(f"instance {instance.name!r}: TSPLIB cannot hold {reason}; write .json instead")
    assert instance.matrix is not None
    symmetric = bool((instance.matrix == instance.matrix.T).all())
    lines = [
        f"NAME : {instance.name}",
        f"TYPE : {'TSP' if symmetric else 'ATSP'}",
        f"DIMENSION : {len(instance.contours)}",
        *node_lines(instance.points if instance.located else None, instance.matrix),
        "EOF",
        "",
    ]
    return "\n".join(lines)


def node_lines(points: Floats | None, matrix: Floats) -> list[str]:
    """Return the lines of an explicit matrix, with the coordinates of its nodes where there are any."""
    lines = ["EDGE_WEIGHT_TYPE : EXPLICIT", "EDGE_WEIGHT_FORMAT : FULL_MATRIX"]
    if points is not None:
        lines += ["NODE_COORD_TYPE : THREED_COORDS", COORDINATES]
        lines += [f"{node} {_row(point)}" for node, point in enumerate(points.tolist(), start=1)]
    return [*lines, WEIGHTS, *(_row(row) for row in matrix.tolist())]


def _row(numbers: list[float]) -> str:
    """Write whole numbers without a point, as other readers of the format ask."""
    return " ".join(repr(number).removesuffix(".0") for number in numbers)


def obstacles(instance: Instance) -> dict[str, bool]:
    """Return what no file of the TSPLIB family holds, and whether the instance has it."""
    contours = instance.contours
    return {
        "geometry": any(contour.geometry is not None for contour in contours),
        "regions": any(contour.region is not None for contour in contours),
        "parts and rings": any(contour.part is not None or contour.ring != "hole" for contour in contours),
        "perimeters": any(contour.perimeter > 0 for contour in contours),
        "a material": instance.material is not None,
        "several heads": len(instance.heads) > 1,
        f"the metric {instance.machine.metric} unrounded": instance.matrix is None,
        "a name that is empty or has odd blanks": instance.name != (" ".join(instance.name.split()) or "-"),
    }


def _obstacles(instance: Instance) -> dict[str, bool]:
    contours = instance.contours
    return {
        "several entry points": any(len(contour.entry_points) > 1 for contour in contours),
        "precedence": bool(instance.precedence),
        "homes": any(head.home is not None for head in instance.heads),
        "no node": not contours,
        "ids other than 1, 2, ...": any(c.id != str(n) for n, c in enumerate(contours, start=1)),
        **obstacles(instance),
    }
