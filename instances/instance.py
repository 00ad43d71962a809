"""What is to be cut, and on which machine: one ``Instance`` for all problems of the library.

A hole with one entry point, a single head, no material: all are special cases of it.

Units are mm, s, degrees C, W, and SI for material constants.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np
from scipy.spatial.distance import cdist

from cutgap.instances.arrays import Floats, Ints, finite_number, frozen_array
from cutgap.instances.region import Ellipsoid

Ring = Literal["hole", "inner", "outer"]
Metric = Literal["euclidean", "chebyshev", "matrix"]

RINGS: tuple[Ring, ...] = ("hole", "inner", "outer")
ABSOLUTE_ZERO_C = -273.15
"""Nothing is colder, deg C."""
METRICS: tuple[Metric, ...] = ("euclidean", "chebyshev", "matrix")


@dataclass(frozen=True, eq=False)
class Contour:
    """A closed curve to be cut once: a hole, an inner ring or the outline of a part.

    Parameters
    ----------
    id
        Unique within the instance.
    entry_points
        Shape (m, 3), mm: the points at which cutting may start and then ends, m >= 1.
    perimeter
        Cut length in mm; zero is a point to be visited.
    part
        Name of the part that the contour bounds; ``None`` when it stands alone.
    ring
        ``hole`` (stands alone), ``inner`` or ``outer`` ring of its part.
    geometry
        Shape (k, 2), mm: the curve as a closed polyline, first point not repeated.
    region
        What the curve encloses, exactly, where a polyline would only be near it or there is none.
    """

    id: str
    entry_points: Floats
    perimeter: float
    part: str | None = None
    ring: Ring = "hole"
    geometry: Floats | None = None
    region: Ellipsoid | None = None

    def __post_init__(self) -> None:
        name = f"contour {self.id!r}"
        if not isinstance(self.id, str) or not self.id:
            raise ValueError(f"contour id: expected a non-empty text, got {self.id!r}")
        points = frozen_array(self.entry_points, f"{name}, entry_points", columns=3)
        if points.ndim != 2 or len(points) == 0:
            raise ValueError(f"{name}, entry_points: expected at least one row x, y, z")
        object.__setattr__(self, "entry_points", points)
        perimeter = finite_number(self.perimeter, f"{name}, perimeter", least=0.0)
        object.__setattr__(self, "perimeter", perimeter)
        if self.ring not in RINGS:
            raise ValueError(f"{name}, ring: expected one of {', '.join(RINGS)}, got {self.ring!r}")
        if self.geometry is not None:
            curve = frozen_array(self.geometry, f"{name}, geometry", columns=2)
            if curve.ndim != 2 or len(curve) < 3:
                raise ValueError(f"{name}, geometry: expected at least 3 rows x, y")
            object.__setattr__(self, "geometry", curve)


@dataclass(frozen=True, eq=False)
class Head:
    """A cutting head; with a home (3 numbers, mm) it starts and ends there, else its tour is closed."""

    id: str
    home: Floats | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.id, str) or not self.id:
            raise ValueError(f"head id: expected a non-empty text, got {self.id!r}")
        if self.home is not None:
            home = frozen_array(self.home, f"head {self.id!r}, home", columns=3)
            if home.ndim != 1:
                raise ValueError(f"head {self.id!r}, home: expected x, y, z, got shape {home.shape}")
            object.__setattr__(self, "home", home)


@dataclass(frozen=True, slots=True)
class Machine:
    """Speeds, time per contour and the metric of rapids.

    The defaults are inferred from the tables of Wang et al. (2025), which do not print them.

    Parameters
    ----------
    v_jump, v_cut
        Speed of rapids and of cutting, mm/s.
    t_aux
        Auxiliary time per contour (follow, beam, gas, pierce), s.
    metric
        Rapid length: ``euclidean`` (3D), ``chebyshev`` (axes move at once) or ``matrix`` (given).
    """

    v_jump: float = 150.0
    v_cut: float = 40.0
    t_aux: float = 1.0
    metric: Metric = "euclidean"

    def __post_init__(self) -> None:
        object.__setattr__(self, "v_jump", finite_number(self.v_jump, "machine, v_jump", above=0.0))
        object.__setattr__(self, "v_cut", finite_number(self.v_cut, "machine, v_cut", above=0.0))
        object.__setattr__(self, "t_aux", finite_number(self.t_aux, "machine, t_aux", least=0.0))
        if self.metric not in METRICS:
            raise ValueError(f"machine, metric: expected one of {', '.join(METRICS)}, got {self.metric!r}")


FLAME = Machine(v_jump=150.0, v_cut=10.0, t_aux=80.0)
"""Flame cutting: 80 s for each ignition (Chen, Li, Chu), cutting at 0.6 m/min; rapids as by default."""


@dataclass(frozen=True, slots=True)
class Material:
    """Sheet and beam, for the temperature model (Yang et al., 2012); SI units but for ``thickness_mm``."""

    name: str
    conductivity_w_per_m_k: float
    specific_heat_j_per_kg_k: float
    density_kg_per_m3: float
    thickness_mm: float
    power_w: float
    ambient_c: float = 20.0

    def __post_init__(self) -> None:
        for field_name in (
            "conductivity_w_per_m_k",
            "specific_heat_j_per_kg_k",
            "density_kg_per_m3",
            "thickness_mm",
            "power_w",
        ):
            value = finite_number(getattr(self, field_name), f"material, {field_name}", above=0.0)
            object.__setattr__(self, field_name, value)
        object.__setattr__(
            self, "ambient_c", finite_number(self.ambient_c, "material, ambient_c", least=ABSOLUTE_ZERO_C)
        )


@dataclass(frozen=True, eq=False)
class Instance:
    """The problem's data, validated once.

    Nodes number the places that a head can be at: the entry points of contour 0, 1, ... in
    order, then the homes of the heads that have one.

    Parameters
    ----------
    name
        What tables and pictures call it.
    contours, heads
        At least one head; two heads are ordered from left to right. No contours is allowed.
    machine
        Speeds and metric.
    precedence
        Pairs (a, b) of contour indices: a is cut before b. Must be acyclic.
    matrix
        Shape (nodes, nodes), mm: rapid lengths for the metric ``matrix``, possibly asymmetric. The
        diagonal is stored as 0, whatever is given (files put a large number there): to stay costs nothing.
    material
        Needed only where heat is asked for.
    located
        False when the points carry no coordinates (a bare matrix): rules in x and pictures are refused.
    """

    name: str
    contours: tuple[Contour, ...]
    heads: tuple[Head, ...]
    machine: Machine = field(default_factory=Machine)
    precedence: tuple[tuple[int, int], ...] = ()
    matrix: Floats | None = None
    material: Material | None = None
    located: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "contours", tuple(self.contours))
        object.__setattr__(self, "heads", tuple(self.heads))
        object.__setattr__(self, "precedence", tuple((int(a), int(b)) for a, b in self.precedence))
        if not self.heads:
            raise ValueError(f"instance {self.name!r}, heads: expected at least one, got none")
        _refuse_duplicates([c.id for c in self.contours], "contour")
        _refuse_duplicates([h.id for h in self.heads], "head")
        _check_precedence(self.precedence, [c.id for c in self.contours])
        self._check_matrix()
        self._check_extent()

    def _check_matrix(self) -> None:
        given, asked = self.matrix is not None, self.machine.metric == "matrix"
        if given != asked:
            raise ValueError(
                f"instance {self.name!r}, matrix: "
                + ("given, but the metric is " + self.machine.metric if given else "missing")
            )
        if self.matrix is None:
            if not self.located:
                raise ValueError(f"instance {self.name!r}: without coordinates the metric must be matrix")
            return
        matrix = frozen_array(self.matrix, f"instance {self.name!r}, matrix").copy()
        if matrix.shape != (self.node_count, self.node_count):
            raise ValueError(
                f"instance {self.name!r}, matrix: expected {self.node_count} x {self.node_count}, "
                f"got shape {matrix.shape}"
            )
        if (matrix < 0).any():
            raise ValueError(f"instance {self.name!r}, matrix: negative length {matrix.min():g}")
        np.fill_diagonal(matrix, 0.0)
        matrix.setflags(write=False)
        object.__setattr__(self, "matrix", matrix)

    def _check_extent(self) -> None:
        """Refuse points so far apart that the distance is no finite number."""
        if self.node_count == 0:
            return
        low, high = self.points.min(axis=0), self.points.max(axis=0)
        if not np.isfinite(cdist(low[None], high[None])).all():
            far = max(abs(low).max(), abs(high).max())
            raise ValueError(f"instance {self.name!r}: coordinates too far apart (up to {far:g} mm)")

    @property
    def node_count(self) -> int:
        """Number of entry points and homes."""
        return int(self.first_node[-1]) + sum(h.home is not None for h in self.heads)

    @cached_property
    def first_node(self) -> Ints:
        """Node of entry point 0 of each contour, then the number of entry points; shape (contours + 1,)."""
        sizes = [len(c.entry_points) for c in self.contours]
        return np.concatenate(([0], np.cumsum(sizes, dtype=np.int64))).astype(np.int64)

    @cached_property
    def points(self) -> Floats:
        """Coordinates of all nodes, shape (nodes, 3), mm."""
        rows = [c.entry_points for c in self.contours] + [
            h.home[None] for h in self.heads if h.home is not None
        ]
        return frozen_array(np.concatenate(rows) if rows else np.empty((0, 3)), "points", columns=3)

    @cached_property
    def perimeters(self) -> Floats:
        """Perimeter of each contour, mm."""
        return frozen_array([c.perimeter for c in self.contours], "perimeters")

    @cached_property
    def service_times(self) -> Floats:
        """Time to pierce and cut each contour, perimeter / v_cut + t_aux, in s."""
        return frozen_array(self.perimeters / self.machine.v_cut + self.machine.t_aux, "service times")

    def node(self, contour: int, entry: int = 0) -> int:
        """Return the node of an entry point."""
        return int(self.first_node[contour]) + entry

    def home_node(self, head: int) -> int | None:
        """Return the node of a head's home, or ``None`` for a closed tour."""
        if self.heads[head].home is None:
            return None
        return int(self.first_node[-1]) + sum(h.home is not None for h in self.heads[:head])

    def rapid_lengths(self, sources: Sequence[int] | Ints, targets: Sequence[int] | Ints) -> Floats:
        """Return rapid lengths between two lists of nodes, shape (sources, targets), mm."""
        rows, columns = np.asarray(sources, dtype=np.int64), np.asarray(targets, dtype=np.int64)
        if self.matrix is not None:
            return self.matrix[np.ix_(rows, columns)]
        return cdist(self.points[rows], self.points[columns], self.machine.metric)

    def rapid_length(self, source: int, target: int) -> float:
        """Return the rapid length from one node to another, mm."""
        return float(self.rapid_lengths([source], [target])[0, 0])

    @cached_property
    def rapids(self) -> Floats:
        """Rapid lengths between all nodes, shape (nodes, nodes), mm, read-only."""
        nodes = np.arange(self.node_count)
        return frozen_array(self.rapid_lengths(nodes, nodes), "rapids")


def _refuse_duplicates(names: list[str], kind: str) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise ValueError(f"{kind} id {name!r} appears more than once: ids must be unique")
        seen.add(name)


def _check_precedence(pairs: tuple[tuple[int, int], ...], names: list[str]) -> None:
    """Refuse pairs that name no contour, and cycles (found by repeatedly taking what is free)."""
    successors: dict[int, list[int]] = {}
    waiting = [0] * len(names)
    for before, after in pairs:
        if not (0 <= before < len(names) and 0 <= after < len(names)):
            raise ValueError(f"precedence: pair ({before}, {after}) names no contour of {len(names)}")
        successors.setdefault(before, []).append(after)
        waiting[after] += 1
    free = [contour for contour, count in enumerate(waiting) if count == 0]
    for contour in free:
        for after in successors.get(contour, ()):
            waiting[after] -= 1
            if waiting[after] == 0:
                free.append(after)
    if len(free) < len(names):
        stuck = ", ".join(repr(names[c]) for c, count in enumerate(waiting) if count > 0)
        raise ValueError(f"precedence: the pairs form a cycle among {stuck:.200}")
