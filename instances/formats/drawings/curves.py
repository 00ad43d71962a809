"""Basic elements of a drawing: straight segments and curves as polylines that know their true length.

    (1) line      P(t) = p + t (q - p)                                   0 <= t <= 1
    (2) ellipse   P(t) = c + u cos t + v sin t                          u, v conjugate half axes
    (3) spline    P(t) = sum_i w_i N_i(t) p_i / sum_i w_i N_i(t)         rational B-spline (Bezier too)
    (4) length    L = integral of |P'(t)| dt

(4) is exact to rounding for (1) and circles, and to ``LENGTH_ERROR`` by Gauss-Legendre quadrature otherwise.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import BSpline

from cutgap.instances.arrays import Floats

LENGTH_ERROR = 1e-10
"""Relative error at which (4) is taken as found."""

MOST_POINTS = 1_000_000
"""Points of one curve; more come from no drawing of a plate."""

Function = Callable[[Floats], Floats]
"""From parameters of shape (k,) to points or derivatives of shape (k, 2)."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
_HALVINGS = 14


@dataclass(frozen=True, slots=True)
class Element:
    """A straight segment or a curve.

    Parameters
    ----------
    points
        Shape (k, 2), mm, k >= 2: the polyline, both ends included.
    length
        True length (4), mm.
    curved
        Whether it is a curve.
    directions
        Shape (2, 2): unit vectors of the true tangents at start and end, along the element.
    """

    points: Floats
    length: float
    curved: bool
    directions: Floats

    def reverse(self) -> "Element":
        """Return the same element, run the other way."""
        return Element(self.points[::-1], self.length, self.curved, -self.directions[::-1])


@dataclass(frozen=True, slots=True)
class Strand:
    """Elements of one entity, end to start.

    ``place`` names the entity for people: its kind and handle, and the block that holds it.
    """

    elements: tuple[Element, ...]
    layer: str
    place: str

    @property
    def ends(self) -> Floats:
        """Start and end, shape (2, 2), mm."""
        return np.stack((self.elements[0].points[0], self.elements[-1].points[-1]))

    @property
    def extent(self) -> float:
        """Larger side of the bounding box, mm."""
        return float(np.ptp(np.concatenate([each.points for each in self.elements]), axis=0).max())

    def reverse(self) -> "Strand":
        """Return the same strand, run the other way."""
        return Strand(tuple(each.reverse() for each in reversed(self.elements)), self.layer, self.place)


def line(start: Sequence[float] | Floats, end: Sequence[float] | Floats) -> list[Element]:
    """Return (1); nothing when both ends are the same."""
    points = np.array((start, end), dtype=np.float64)
    step = points[1] - points[0]
    length = float(np.hypot(*step))
    if length == 0.0:
        return []
    return [Element(points, length, False, np.stack((step, step)) / length)]


def polygon_line(points: Sequence[Sequence[float]] | Floats) -> list[Element]:
    """Return straight segments through points."""
    return [each for start, end in pairwise(points) for each in line(start, end)]


def ellipse(centre: Floats, u: Floats, v: Floats, start: float, end: float, chord: float) -> list[Element]:
    """Return (2) between two parameters, in either direction; nothing for an ellipse without extent.

    The polyline has equal steps of t: within a step the unit circle leaves its chord by 1 - cos(step / 2),
    and an ellipse by at most that times its larger half axis.
    """
    axes = np.stack((u, v))
    largest = float(np.linalg.norm(axes, 2))
    if largest == 0.0 or start == end:
        return []
    step = 2 * np.arccos(max(0.0, 1 - chord / largest))
    # A multiple of 4, so that quarter points are vertices.
    pieces = 4 * int(np.ceil(max(abs(end - start) / step, 1.0) / 4))
    _refuse_too_many(pieces)

    def point(t: Floats) -> Floats:
        return centre + np.column_stack((np.cos(t), np.sin(t))) @ axes

    def velocity(t: Floats) -> Floats:
        return np.column_stack((-np.sin(t), np.cos(t))) @ axes

    radius = float(np.hypot(*u))
    is_circle = abs(u @ v) <= 1e-12 * radius**2 and np.isclose(np.hypot(*v), radius, rtol=1e-12, atol=0.0)
    length = radius * abs(end - start) if is_circle else arc_length(velocity, np.linspace(start, end, 5))
    points = point(np.linspace(start, end, pieces + 1))
    return [Element(points, length, True, _directions(points, velocity(np.array((start, end))), start > end))]


def bulge(start: Floats, end: Floats, value: float, chord: float) -> list[Element]:
    """Return the arc from start to end whose included angle is 4 atan(value), counter-clockwise if positive."""
    if value == 0.0:
        return line(start, end)
    half = (end - start) / 2
    left = np.array((-half[1], half[0]))
    centre = start + half + left * (1 - value * value) / (2 * value)
    u = start - centre
    v = np.array((-u[1], u[0])) * np.sign(value)
    found = ellipse(centre, u, v, 0.0, 4 * abs(np.arctan(value)), chord)
    for each in found:
        each.points[[0, -1]] = start, end
    return found


def spline(degree: int, knots: Floats, controls: Floats, weights: Floats | None, chord: float) -> list[Element]:
    """Return (3) over its domain, cut where an inner knot of full multiplicity lets it have a corner.

    Raises
    ------
    ValueError
        When knots, control points and weights do not fit together.
    """
    count = len(controls)
    if degree < 1 or count <= degree or len(knots) != count + degree + 1 or (np.diff(knots) < 0).any():
        raise ValueError(f"spline of degree {degree} with {count} control points and {len(knots)} knots")
    if degree == 1 and weights is None:
        return polygon_line(controls)
    weights = np.ones(count) if weights is None else weights
    if (weights <= 0).any():
        raise ValueError(f"spline with a weight of {weights.min():g}; weights must be above 0")
    numerator = BSpline(knots, controls * weights[:, None], degree)
    denominator = BSpline(knots, weights, degree)
    above, below = numerator.derivative(), denominator.derivative()

    def point(t: Floats) -> Floats:
        return numerator(t) / denominator(t)[:, None]

    def velocity(t: Floats) -> Floats:
        bottom = denominator(t)[:, None]
        return (above(t) - numerator(t) / bottom * below(t)[:, None]) / bottom

    domain = knots[degree : count + 1]
    breaks, times = np.unique(domain, return_counts=True)
    corners = [0, *(np.flatnonzero(times[1:-1] >= degree) + 1).tolist(), len(breaks) - 1]
    return [
        _parametric(point, velocity, breaks[first : last + 1], chord)
        for first, last in pairwise(corners)
        if last > first
    ]


def bezier(controls: Floats, chord: float) -> list[Element]:
    """Return the Bezier curve of control points, shape (degree + 1, 2)."""
    degree = len(controls) - 1
    return spline(degree, np.repeat((0.0, 1.0), degree + 1), controls, None, chord)


def _parametric(point: Function, velocity: Function, breaks: Floats, chord: float) -> Element:
    # At a break the derivative is that of the span on its right: look a little inside for the last one.
    inside = np.array((breaks[0], breaks[-1] - 1e-9 * (breaks[-1] - breaks[-2])))
    points = flatten(point, breaks, chord)
    return Element(points, arc_length(velocity, breaks), True, _directions(points, velocity(inside), False))


def flatten(point: Function, breaks: Floats, chord: float) -> Floats:
    """Return points of a curve such that between them it leaves the chord by at most ``chord``.

    The distance is measured at the inner quarter points of each step; steps are halved until all fit.
    """
    shares = np.array((0.25, 0.5, 0.75))
    t = _refined(breaks, 4)
    while True:
        _refuse_too_many(len(t))
        points, steps = point(t), np.diff(t)
        inner = point((t[:-1, None] + steps[:, None] * shares).ravel()).reshape(-1, 3, 2)
        legs = np.diff(points, axis=0)[:, None]
        squares = np.maximum((legs**2).sum(axis=2), np.finfo(float).tiny)
        along = np.clip(((inner - points[:-1, None]) * legs).sum(axis=2) / squares, 0.0, 1.0)
        away = np.linalg.norm(inner - points[:-1, None] - along[..., None] * legs, axis=2).max(axis=1)
        halve = (away > chord) & (steps > 1e-12 * (t[-1] - t[0]))
        if not halve.any():
            return points
        t = np.sort(np.concatenate((t, (t[:-1] + steps / 2)[halve])))


def arc_length(velocity: Function, breaks: Floats) -> float:
    """Return (4) by quadrature between breaks, which are halved until nothing changes."""
    previous = np.inf
    t = breaks
    for _ in range(_HALVINGS):
        half = np.diff(t) / 2
        at = (t[:-1] + half)[:, None] + half[:, None] * _NODES
        speeds = np.linalg.norm(velocity(at.ravel()), axis=1).reshape(at.shape)
        length = float(np.abs(half) @ (speeds @ _WEIGHTS))
        if abs(length - previous) <= LENGTH_ERROR * length:
            break
        previous, t = length, _refined(t, 2)
    return length


def _refined(breaks: Floats, pieces: int) -> Floats:
    """Return the breaks with each step cut into equal pieces."""
    shares = np.arange(pieces) / pieces
    inner = breaks[:-1, None] + np.diff(breaks)[:, None] * shares
    return np.append(inner.ravel(), breaks[-1])


def _directions(points: Floats, velocities: Floats, backwards: bool) -> Floats:
    """Return unit tangents at both ends; where the curve stands still, those of the outermost chords."""
    tangents = -velocities if backwards else velocities
    chords = np.stack((points[1] - points[0], points[-1] - points[-2]))
    sizes = np.linalg.norm(tangents, axis=1, keepdims=True)
    still = sizes <= 1e-9 * np.linalg.norm(np.ptp(points, axis=0))
    tangents = np.where(still, chords, tangents)
    sizes = np.linalg.norm(tangents, axis=1, keepdims=True)
    return np.divide(tangents, sizes, out=np.zeros((2, 2)), where=sizes > 0)


def _refuse_too_many(points: int) -> None:
    if points > MOST_POINTS:
        raise ValueError(f"a curve needs more than {MOST_POINTS} points; raise --chord")
