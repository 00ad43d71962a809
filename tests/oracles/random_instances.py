"""Random tiny instances, with the ties that break exact methods: equal x, equal points, points on a line."""

from dataclasses import replace
from typing import Literal

import numpy as np

from cutgap.instances import Contour, Head, Instance, Machine, Plan, Visit
from cutgap.instances.arrays import Floats, Ints

Layout = Literal["uniform", "grid", "equal points", "line", "column", "slanted line"]
LAYOUTS: tuple[Layout, ...] = ("uniform", "grid", "equal points", "line", "column", "slanted line")


def layout_points(rng: np.random.Generator, layout: Layout, count: int) -> Floats:
    """Return points of shape (count, 3), mm; all layouts but ``uniform`` have integer coordinates."""
    if layout == "uniform":
        return rng.uniform((0, 0, 0), (2000, 1000, 200), (count, 3))
    step = rng.integers(0, 6, count)[:, None]
    if layout == "grid":
        return np.multiply(rng.integers(0, 4, (count, 3)), 50.0)
    if layout == "equal points":
        places = np.multiply(rng.integers(0, 9, (2, 3)), 30.0)
        return places[rng.integers(0, 2, count)]
    if layout == "line":
        return np.multiply(step, (40.0, 0.0, 0.0))
    if layout == "column":
        return np.array([200.0, 0.0, 0.0]) + np.multiply(step, (0.0, 40.0, 0.0))
    return np.multiply(step, (30.0, 40.0, 0.0))


def random_instance(
    rng: np.random.Generator,
    holes: int,
    *,
    layout: Layout | None = None,
    heads: int = 2,
    homes: bool | None = True,
    metric: Literal["euclidean", "chebyshev", "matrix"] = "euclidean",
    entries: int = 1,
    precedence: float = 0.0,
) -> Instance:
    """Draw an instance.

    Parameters
    ----------
    layout
        ``None`` draws one.
    homes
        Whether heads have homes; ``None`` draws it for each head.
    metric
        ``matrix`` is an asymmetric one, without triangle inequality, with zeros.
    entries
        Largest number of entry points of a contour.
    precedence
        Share of the pairs i < j that are in the precedence.
    """
    layout = layout or LAYOUTS[int(rng.integers(len(LAYOUTS)))]
    sizes = rng.integers(1, entries + 1, holes)
    points = np.split(layout_points(rng, layout, int(sizes.sum())), np.cumsum(sizes)[:-1]) if holes else []
    perimeters = rng.choice([0.0, 40.0, 80.0], holes) if layout != "uniform" else rng.uniform(0, 100, holes)
    contours = tuple(Contour(f"c{i}", points[i], float(perimeters[i])) for i in range(holes))
    places = layout_points(rng, layout, heads)
    stays = [rng.random() < 0.5 if homes is None else homes for _ in range(heads)]
    machine = Machine(
        v_jump=float(rng.choice([50.0, 150.0])), t_aux=float(rng.choice([0.0, 1.0])), metric=metric
    )
    nodes = int(sizes.sum()) + sum(stays)
    pairs = [(i, j) for i in range(holes) for j in range(i + 1, holes) if rng.random() < precedence]
    return Instance(
        f"random {layout}",
        contours,
        tuple(Head(f"h{i}", places[i] if stays[i] else None) for i in range(heads)),
        machine,
        tuple(pairs),
        rng.integers(0, 200, (nodes, nodes)).astype(float) if metric == "matrix" else None,
    )


def random_plan(rng: np.random.Generator, instance: Instance) -> Plan:
    """Draw a plan that cuts each contour once, at any of its entry points, on any head."""
    tours: list[list[Visit]] = [[] for _ in instance.heads]
    for contour in rng.permutation(len(instance.contours)):
        entry = int(rng.integers(len(instance.contours[contour].entry_points)))
        tours[int(rng.integers(len(tours)))].append(Visit(int(contour), entry))
    return Plan(tuple(tuple(tour) for tour in tours))


def moved(instance: Instance, rotation: Floats, shift: Floats | float = 0.0) -> Instance:
    """Return the instance with every point ``p`` at ``p @ rotation + shift``."""
    contours = tuple(
        replace(contour, entry_points=contour.entry_points @ rotation + shift) for contour in instance.contours
    )
    heads = tuple(
        replace(head, home=None if head.home is None else head.home @ rotation + shift)
        for head in instance.heads
    )
    return replace(instance, contours=contours, heads=heads)


def mirrored(instance: Instance) -> Instance:
    """Return the mirror image, x to -x, with the heads in the opposite order (contours keep theirs)."""
    image = moved(instance, np.diag([-1.0, 1.0, 1.0]))
    return replace(image, heads=image.heads[::-1])


def permuted(instance: Instance, order: Ints) -> Instance:
    """Return the instance with contour ``order[i]`` in place i; for coordinates and without precedence."""
    return replace(instance, contours=tuple(instance.contours[i] for i in order))


def scaled(instance: Instance, factor: float) -> Instance:
    """Return the instance with all lengths and speeds multiplied: the same in time."""
    image = moved(instance, np.eye(3) * factor)
    machine = instance.machine
    return replace(
        image,
        contours=tuple(replace(c, perimeter=c.perimeter * factor) for c in image.contours),
        machine=replace(machine, v_jump=machine.v_jump * factor, v_cut=machine.v_cut * factor),
        matrix=None if instance.matrix is None else instance.matrix * factor,
    )
