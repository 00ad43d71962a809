"""Regions as arrays for the kernels, each a unit ball or a polytope in coordinates of its own."""

from collections.abc import Sequence
from typing import NamedTuple

import numba
import numpy as np
import numpy.typing as npt
from scipy.spatial import ConvexHull

from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.region import Ellipsoid, Region

FLAT = 1e-12
"""Relative size below which a dimension of a region counts as none."""


class Shapes(NamedTuple):
    """Regions for kernels, in E coordinates (2 where all are at one height) and at most D of their own.

    ``rows`` and ``limits`` are G and h of hulls, ``corners`` their vertices; those of region k are from
    ``first_row[k]`` (``first_corner[k]``) on, none for ellipsoids. ``sizes`` holds the dimension of each, and
    ``heights`` the z of its centre.
    """

    centres: Floats
    bases: Floats
    sizes: Ints
    is_hull: npt.NDArray[np.bool_]
    first_row: Ints
    rows: Floats
    limits: Floats
    first_corner: Ints
    corners: Floats
    heights: Floats


@numba.njit(cache=True, error_model="numpy")
def support(shapes: Shapes, k: int, s: Floats) -> float:
    """Return the least s.p over region k."""
    axes = len(s)
    if shapes.is_hull[k]:
        least = np.inf
        for j in range(shapes.first_corner[k], shapes.first_corner[k + 1]):
            height = 0.0
            for e in range(axes):
                height += s[e] * shapes.corners[j, e]
            least = min(least, height)
        return least
    middle, square = 0.0, 0.0
    for e in range(axes):
        middle += s[e] * shapes.centres[k, e]
    for d in range(shapes.sizes[k]):
        along = 0.0
        for e in range(axes):
            along += s[e] * shapes.bases[k, e, d]
        square += along * along
    return middle - np.sqrt(square)


def shapes_of(regions: Sequence[Region]) -> Shapes:
    """Return regions as arrays; heights are left out when all are equal."""
    canonical = [_ball(each) if isinstance(each, Ellipsoid) else _polytope(each.vertices) for each in regions]
    centres = np.array([centre for centre, *_ in canonical])
    level = all(
        (basis[2] == 0.0).all() and (corners[:, 2] == centres[0, 2]).all()
        for _, basis, _, _, corners in canonical
    ) and bool((centres[:, 2] == centres[0, 2]).all())
    axes = 2 if level else 3
    most = max(1, max(basis.shape[1] for _, basis, *_ in canonical))
    bases = np.zeros((len(regions), axes, most))
    for k, (_, basis, *_) in enumerate(canonical):
        bases[k, :, : basis.shape[1]] = basis[:axes]
    rows = [np.pad(each, ((0, 0), (0, most - each.shape[1]))) for _, _, each, _, _ in canonical]
    counts = np.array([[len(each[3]), len(each[4])] for each in canonical])
    firsts = np.concatenate((np.zeros((1, 2), dtype=np.int64), np.cumsum(counts, axis=0)))
    return Shapes(
        np.ascontiguousarray(centres[:, :axes]),
        bases,
        np.array([basis.shape[1] for _, basis, *_ in canonical], dtype=np.int64),
        np.array([not isinstance(each, Ellipsoid) for each in regions]),
        np.ascontiguousarray(firsts[:, 0]),
        np.concatenate(rows),
        np.concatenate([limits for *_, limits, _ in canonical]),
        np.ascontiguousarray(firsts[:, 1]),
        np.ascontiguousarray(np.concatenate([corners[:, :axes] for *_, corners in canonical])),
        np.ascontiguousarray(centres[:, 2]),
    )


Canonical = tuple[Floats, Floats, Floats, Floats, Floats]
"""Centre (3,), basis (3, d), rows (m, d), limits (m,), corners (v, 3)."""


def _ball(region: Ellipsoid) -> Canonical:
    """Return an ellipsoid by its principal axes: the same set, whatever the given ones are."""
    _, sizes, directions = np.linalg.svd(region.axes, full_matrices=False)
    kept = sizes > FLAT * max(float(sizes.max(initial=0.0)), float(np.abs(region.centre).max()))
    basis = (directions[kept] * sizes[kept, None]).T
    if (region.axes @ region.axes.T == np.diag(np.diag(region.axes @ region.axes.T))).all() and kept.all():
        basis = region.axes.T  # as they are, without rounding
    nothing = np.zeros((0, basis.shape[1]))
    return region.centre, basis, nothing, np.zeros(0), np.zeros((0, 3))


def _polytope(vertices: Floats) -> Canonical:
    """Return a hull by the plane, line or point that it spans, its sides there, and its vertices."""
    centre = vertices.mean(axis=0)
    _, sizes, directions = np.linalg.svd(vertices - centre, full_matrices=False)
    size = float(sizes.max(initial=0.0))
    kept = (
        sizes > 1e-9 * size if size > FLAT * np.abs(vertices).max(initial=0.0) else np.zeros(len(sizes), bool)
    )
    basis = directions[kept].T * size
    if not kept.any():
        return vertices[0], np.zeros((3, 0)), np.zeros((0, 0)), np.zeros(0), vertices[:1]
    own = (vertices - centre) @ basis / size**2
    if kept.sum() == 1:
        ends = [int(np.argmin(own)), int(np.argmax(own))]
        rows, limits = np.array([[-1.0], [1.0]]), np.array([-own[ends[0], 0], own[ends[1], 0]])
        return centre, basis, rows, limits, vertices[ends]
    hull = ConvexHull(own)
    sides = np.unique(hull.equations.round(12), axis=0)
    return centre, basis, sides[:, :-1], -sides[:, -1], vertices[hull.vertices]
