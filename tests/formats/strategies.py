"""Random instances of every kind, and their comparison bit for bit."""

from dataclasses import replace

import numpy as np
from hypothesis import strategies as st

from cutgap.instances import Contour, Head, Instance, Machine, Material, Plan, Visit
from cutgap.instances.region import Ellipsoid

TEXT = st.text(st.characters(codec="utf-8"), max_size=8)
NAMES = st.text(st.characters(codec="utf-8"), min_size=1, max_size=6)
# Beyond this size distances overflow, which an instance refuses.
FINITE = st.floats(-1e150, 1e150)
LENGTHS = st.floats(min_value=0.0, allow_infinity=False)
POSITIVE = st.floats(min_value=0.0, exclude_min=True, allow_infinity=False)


def points(columns: int, least: int, most: int) -> st.SearchStrategy[np.ndarray]:
    row = st.lists(FINITE, min_size=columns, max_size=columns)
    return st.lists(row, min_size=least, max_size=most).map(np.array)


def contours(name: str) -> st.SearchStrategy[Contour]:
    return st.builds(
        Contour,
        st.just(name),
        points(3, 1, 3),
        LENGTHS,
        part=st.none() | TEXT,
        ring=st.sampled_from(["hole", "inner", "outer"]),
        geometry=st.none() | points(2, 3, 4),
        region=st.none() | st.builds(Ellipsoid, points(3, 1, 1).map(lambda rows: rows[0]), points(3, 1, 3)),
    )


@st.composite
def instances(draw: st.DrawFn) -> Instance:
    ids = draw(st.lists(NAMES, max_size=5, unique=True))
    machine = draw(st.builds(Machine, POSITIVE, POSITIVE, LENGTHS, st.sampled_from(["euclidean", "chebyshev"])))
    heads = [
        Head(name, draw(st.none() | st.lists(FINITE, min_size=3, max_size=3).map(np.array)))
        for name in draw(st.lists(NAMES, min_size=1, max_size=3, unique=True))
    ]
    pairs = [(a, b) for b in range(len(ids)) for a in range(b)]
    instance = Instance(
        name=draw(TEXT),
        contours=tuple(draw(contours(name)) for name in ids),
        heads=tuple(heads),
        machine=machine,
        precedence=tuple(draw(st.lists(st.sampled_from(pairs), max_size=3)) if pairs else ()),
        material=draw(st.none() | st.builds(Material, TEXT, *[POSITIVE] * 5, st.floats(-273.15, 1e150))),
    )
    return with_matrix(draw, instance) if draw(st.booleans()) else instance


def with_matrix(draw: st.DrawFn, instance: Instance) -> Instance:
    size = instance.node_count
    numbers = draw(st.lists(LENGTHS, min_size=size * size, max_size=size * size))
    return replace(
        instance,
        machine=replace(instance.machine, metric="matrix"),
        matrix=np.array(numbers).reshape(size, size),
        located=draw(st.booleans()),
    )


@st.composite
def plans(draw: st.DrawFn, instance: Instance) -> Plan:
    """Any visits on any heads, allowed or not."""
    nodes = [(c, e) for c, contour in enumerate(instance.contours) for e in range(len(contour.entry_points))]
    place = st.none() | st.tuples(FINITE, FINITE, FINITE)
    visit = st.builds(lambda node, point: Visit(*node, point), st.sampled_from(nodes), place) if nodes else None
    tour = st.just([]) if visit is None else st.lists(visit, max_size=6)
    return Plan(tuple(draw(tour) for _ in instance.heads))


def same_bits(a: object, b: object) -> bool:
    """Compare values field by field; arrays and floats by their bits, so that 0.0 and -0.0 differ."""
    if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
        return a.shape == b.shape and a.dtype == b.dtype and a.tobytes() == b.tobytes()
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(map(same_bits, a, b))
    if type(a) is not type(b):
        return False
    if isinstance(a, float):
        return np.float64(a).tobytes() == np.float64(b).tobytes()
    if fields := getattr(a, "__dataclass_fields__", None):
        return all(same_bits(getattr(a, name), getattr(b, name)) for name in fields)
    return a == b
