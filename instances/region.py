r"""Convex regions in which a contour may be entered.

    (1) Ellipsoid  { c + sum_i u_i a_i : |u| <= 1 },  1 to 3 axes a_i: segment, disc, ellipse, ball, ellipsoid
    (2) Hull       { sum_j w_j v_j : w >= 0, sum w = 1 },  any number of vertices v_j
    (3) min of s.x over (1) = s.c - |(s.a_1, ..., s.a_k)|,  over (2) = min_j s.v_j

Coordinates are mm. Of a contour the region is what its curve encloses: a tour that comes there from outside
crosses the curve.
"""

from dataclasses import dataclass

import numpy as np

from cutgap.instances.arrays import Floats, frozen_array

STEPS = 100
"""Most steps of the iterations here; they take about ten."""
FINE = 4096
"""Steps in which the length along an ellipse is summed."""


@dataclass(frozen=True, eq=False)
class Ellipsoid:
    """Equation (1): a segment, disc, ellipse, ball or ellipsoid.

    Parameters
    ----------
    centre
        Shape (3,), mm.
    axes
        Shape (k, 3), k = 1 to 3, mm: half axes (any vectors; where they are no right angles apart, conjugate
        half diameters). Zero vectors make it flat; all of them, a point.
    """

    centre: Floats
    axes: Floats

    def __post_init__(self) -> None:
        centre = frozen_array(self.centre, "ellipsoid, centre", columns=3)
        axes = frozen_array(self.axes, "ellipsoid, axes", columns=3)
        if centre.ndim != 1:
            raise ValueError(f"ellipsoid, centre: expected x, y, z, got shape {centre.shape}")
        if axes.ndim != 2 or not 1 <= len(axes) <= 3:
            raise ValueError(f"ellipsoid, axes: expected 1 to 3 rows x, y, z, got shape {axes.shape}")
        object.__setattr__(self, "centre", centre)
        object.__setattr__(self, "axes", axes)

    def support_minimum(self, directions: Floats) -> Floats:
        """Return the least s.x over the region for each direction s; shape (d, 3) in, (d,) out."""
        widths: Floats = np.linalg.norm(directions @ self.axes.T, axis=-1)
        return directions @ self.centre - widths

    def nearest(self, point: Floats) -> Floats:
        """Return the point of the region nearest to a point, shape (3,).

        With the singular values s_i of the axes it is u_i = s_i d_i / (s_i^2 + t), t >= 0 so that |u| <= 1.
        """
        frame, sizes, mixing = np.linalg.svd(self.axes.T, full_matrices=False)
        offset = (np.asarray(point) - self.centre) @ frame
        kept = sizes > 1e-14 * sizes.max(initial=0.0)
        sizes, offset, mixing = sizes[kept], offset[kept], mixing[kept]
        weights = offset / sizes
        # |u| falls and is convex in t, so Newton's steps for 1 / |u| = 1 rise to the solution.
        shift = 0.0
        for _ in range(STEPS):
            norm = float(np.linalg.norm(weights))
            if norm <= 1.0 + 1e-15:
                break
            slope = float(weights**2 @ (1.0 / (sizes**2 + shift)))
            shift += (norm - 1.0) * norm**2 / slope
            weights = sizes * offset / (sizes**2 + shift)
        weights = weights / max(1.0, float(np.linalg.norm(weights)))
        return self.centre + (weights @ mixing) @ self.axes

    def contains(self, point: Floats, tolerance: float = 0.0) -> bool:
        """Whether a point is in the region or at most ``tolerance`` mm away."""
        return _is_near(self, point, tolerance)

    def boundary(self, count: int) -> Floats:
        """Return points on the curve, evenly spaced along it, shape (count, 3).

        The curve is that of the first two axes (a ball's equator); of one axis the segment from end to end.
        """
        if len(self.axes) == 1:
            places = np.linspace(-1.0, 1.0, count) if count > 1 else np.zeros(count)
            return self.centre + places[:, None] * self.axes
        angles = np.linspace(0.0, 2 * np.pi, FINE + 1)
        curve = self.centre + np.cos(angles)[:, None] * self.axes[0] + np.sin(angles)[:, None] * self.axes[1]
        along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))))
        chosen = np.interp(np.arange(count) * along[-1] / max(count, 1), along, angles)
        return self.centre + np.cos(chosen)[:, None] * self.axes[0] + np.sin(chosen)[:, None] * self.axes[1]


@dataclass(frozen=True, eq=False)
class Hull:
    """Equation (2): the convex hull of points; one point is a point.

    Parameters
    ----------
    vertices
        Shape (m, 3), m >= 1, mm. Of a closed curve in order: ``boundary`` goes along it.
    """

    vertices: Floats

    def __post_init__(self) -> None:
        vertices = frozen_array(self.vertices, "hull, vertices", columns=3)
        if vertices.ndim != 2 or len(vertices) == 0:
            raise ValueError(f"hull, vertices: expected at least one row x, y, z, got shape {vertices.shape}")
        object.__setattr__(self, "vertices", vertices)

    def support_minimum(self, directions: Floats) -> Floats:
        """Return the least s.x over the region for each direction s; shape (d, 3) in, (d,) out."""
        least: Floats = (directions @ self.vertices.T).min(axis=-1)
        return least

    def nearest(self, point: Floats) -> Floats:
        """Return the point of the region nearest to a point, shape (3,), by Wolfe's algorithm (1976).

        It keeps a simplex of vertices that contains its own nearest point in its inside, takes in a vertex that
        lies beyond the plane through that point, and drops vertices whose weights would become negative.
        """
        points = self.vertices - np.asarray(point)
        scale = float(np.abs(points).max(initial=0.0)) ** 2
        chosen = [int(np.argmin((points**2).sum(axis=1)))]
        weights = np.ones(1)
        for _ in range(STEPS):
            here = weights @ points[chosen]
            heights = points @ here
            entering = int(np.argmin(heights))
            if heights[entering] >= here @ here - 1e-15 * scale or entering in chosen:
                break
            chosen, weights = _reduced(points, [*chosen, entering], np.append(weights, 0.0))
        return weights @ self.vertices[chosen]

    def contains(self, point: Floats, tolerance: float = 0.0) -> bool:
        """Whether a point is in the region or at most ``tolerance`` mm away."""
        return _is_near(self, point, tolerance)

    def boundary(self, count: int) -> Floats:
        """Return points evenly spaced along the closed polyline of the vertices, shape (count, 3)."""
        closed = np.concatenate((self.vertices, self.vertices[:1]))
        along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))))
        places = np.arange(count) * along[-1] / max(count, 1)
        return np.stack([np.interp(places, along, closed[:, axis]) for axis in range(3)], axis=1)


Region = Ellipsoid | Hull


def point_region(point: Floats) -> Hull:
    """Return the region of one point, shape (3,)."""
    return Hull(np.asarray(point)[None])


def _is_near(region: Region, point: Floats, tolerance: float) -> bool:
    return bool(np.linalg.norm(np.asarray(point) - region.nearest(point)) <= tolerance)


def _reduced(points: Floats, chosen: list[int], weights: Floats) -> tuple[list[int], Floats]:
    """Return the simplex and weights of the nearest point to the origin, with vertices dropped on the way."""
    while True:
        size = len(chosen)
        corner = points[chosen]
        system = np.ones((size + 1, size + 1))
        system[0, 0] = 0.0
        system[1:, 1:] = corner @ corner.T
        asked = np.zeros(size + 1)
        asked[0] = 1.0
        target = np.linalg.lstsq(system, asked, rcond=None)[0][1:]
        if (target >= 0.0).all():
            return chosen, target / target.sum()
        falling = target < 0.0
        step = float((weights[falling] / (weights[falling] - target[falling])).min())
        weights = np.maximum(0.0, weights + step * (target - weights))
        weights[falling & (weights <= 1e-15)] = 0.0
        kept = weights > 0.0
        if kept.all():  # rounding: drop the vertex that should have gone
            kept[int(np.argmin(np.where(falling, weights, np.inf)))] = False
        chosen = [each for each, stays in zip(chosen, kept, strict=True) if stays]
        weights = weights[kept] / weights[kept].sum()
