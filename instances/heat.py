r"""Heat: how warm earlier contours have made a start point by the time it is pierced.

    Data      q              power of the beam, W            v    cutting speed, m/s
              h              thickness of the sheet, m       a    lambda / (c rho), m^2/s
              lambda, c, rho conductivity W/(m K), specific heat J/(kg K), density kg/m^3
    Kernel    (1) T(L, t) = q / (v h sqrt(4 pi lambda c rho t)) exp(-L^2 / (4 a t))                  [K]
    Rise      (2) R_i = sum over contours j that are done when i starts of T(L_ij, start_i - end_j)   [K]
    Peak      (3) ambient + max_i R_i                                                               [deg C]
    Window    (4) T(L, t) > theta  iff  t- < t < t+,  t = L^2 / (2 a u),  u e^-u = (theta L / k)^2 / (2 a),
                  k = T(0, t) sqrt(t);   L = 0: t- = 0, t+ = (k / theta)^2

L_ij is the distance from the start point of contour i to the nearest point of the closed curve of contour j,
along which the source ran: to the segment for a straight one, never to the infinite line through it, and to the
polyline for a curved one. The kernel is that of a line source that passed at once, so the time t runs from the
end of contour j, as in the source, whatever part of j is nearest. A start that coincides with the end of the
contour before, on its curve, has no temperature: (1) has no limit at L = t = 0; it counts as infinite.

For fixed L > 0 the kernel rises up to t = L^2 / (2 a) and falls after it, hence (4). Dropping all terms below
T_min, as the source allows, errs by less than T_min times the number of earlier contours; here all count.

Source: Yang, Liu, Ju (2012).
"""

from functools import lru_cache

import numpy as np
import numpy.typing as npt
import shapely
from scipy.special import lambertw

from cutgap.instances.arrays import Floats
from cutgap.instances.instance import Instance, Material
from cutgap.instances.plan import Plan
from cutgap.instances.process import require_geometry
from cutgap.instances.simulate import start_times

MM = 1e-3


def require_heat(instance: Instance) -> Material:
    """Return the material.

    Raises
    ------
    ValueError
        When the instance has no material, or a contour has no curve.
    """
    if instance.material is None:
        raise ValueError(f"instance {instance.name!r}, material: missing, which temperatures need")
    require_geometry(instance, "temperature")
    return instance.material


def has_heat(instance: Instance) -> bool:
    """Whether temperatures can be told: the material and all curves are known."""
    return instance.material is not None and all(c.geometry is not None for c in instance.contours)


def kernel_constant(instance: Instance) -> float:
    """Return k of (4), K s^(1/2): the rise on the curve itself is k / sqrt(t)."""
    material = require_heat(instance)
    speed, thickness = instance.machine.v_cut * MM, material.thickness_mm * MM
    stored = material.conductivity_w_per_m_k * material.specific_heat_j_per_kg_k * material.density_kg_per_m3
    return float(material.power_w / (speed * thickness * np.sqrt(4.0 * np.pi * stored)))


def diffusivity(instance: Instance) -> float:
    """Return a in mm^2/s, the unit of lengths here."""
    material = require_heat(instance)
    capacity = material.specific_heat_j_per_kg_k * material.density_kg_per_m3
    return material.conductivity_w_per_m_k / capacity / MM**2


def rise(instance: Instance, distance_mm: npt.ArrayLike, lag_s: npt.ArrayLike) -> Floats:
    """Return (1), K; infinite for lag and distance 0, and 0 for lag 0 at a distance.

    Parameters
    ----------
    distance_mm, lag_s
        L and t, at least 0, broadcast against each other.
    """
    distance, lag = np.asarray(distance_mm, dtype=np.float64), np.asarray(lag_s, dtype=np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        warmth = np.exp(-(distance**2) / (4.0 * diffusivity(instance) * lag)) / np.sqrt(lag)
    limits = np.where(distance > 0.0, 0.0, np.inf)
    return np.asarray(kernel_constant(instance) * np.where(lag > 0.0, warmth, limits), dtype=np.float64)


@lru_cache(maxsize=8)
def curve_distances(instance: Instance) -> Floats:
    """Return L: distance from each entry point to the curve of each contour, shape (points, contours), mm."""
    require_geometry(instance, "temperature")
    curves = [shapely.LinearRing(contour.geometry) for contour in instance.contours]
    points = shapely.points(instance.points[: int(instance.first_node[-1]), :2])
    table = shapely.distance(points[:, None], np.array(curves, dtype=object)[None, :])
    distances = np.asarray(table, dtype=np.float64).reshape(len(points), len(curves))
    distances.setflags(write=False)
    return distances


def rises(instance: Instance, plan: Plan) -> dict[int, float]:
    """Return (2) for each contour of a plan, K; on one head the order says what is done, on others the time."""
    distances, starts = curve_distances(instance), start_times(instance, plan)
    service = instance.service_times
    found = {}
    for head, tour in enumerate(plan.tours):
        others = [visit.contour for k, each in enumerate(plan.tours) if k != head for visit in each]
        for turn, visit in enumerate(tour):
            start, before = starts[visit.contour], [each.contour for each in tour[:turn]]
            before += [other for other in others if starts[other] + float(service[other]) <= start]
            ends = np.array([starts[other] + float(service[other]) for other in before])
            lags = np.maximum(0.0, start - ends)
            apart = distances[instance.node(*visit[:2]), before]
            found[visit.contour] = float(rise(instance, apart, lags).sum())
    return found


def peak_temperature(instance: Instance, plan: Plan) -> float:
    """Return (3), deg C.

    Raises
    ------
    ValueError
        When the instance has no material, or a contour has no curve.
    """
    return require_heat(instance).ambient_c + max(rises(instance, plan).values(), default=0.0)


def temperatures(instance: Instance, plan: Plan, places: npt.ArrayLike, times_s: npt.ArrayLike) -> Floats:
    """Return how warm places of the sheet are at times, deg C: ambient plus (1) of every contour done by then.

    The places need be no start points, so a plan can be watched as it warms the sheet.

    Parameters
    ----------
    places
        x and y, shape (places, 2), mm.
    times_s
        Since the heads left home, shape (times,).

    Returns
    -------
    Floats
        Shape (times, places); infinite on a curve at the very end of its cut.

    Raises
    ------
    ValueError
        When the instance has no material, or a contour has no curve.
    """
    ambient = require_heat(instance).ambient_c
    spots = shapely.points(np.asarray(places, dtype=np.float64).reshape(-1, 2))
    moments = np.asarray(times_s, dtype=np.float64).reshape(-1, 1)
    found = np.full((len(moments), len(spots)), ambient)
    for contour, start in start_times(instance, plan).items():
        end = start + float(instance.service_times[contour])
        apart = shapely.distance(spots, shapely.LinearRing(instance.contours[contour].geometry))
        done = moments[:, 0] >= end
        found[done] += rise(instance, apart[None, :], moments[done] - end)
    return found


def lag_window(instance: Instance, distance_mm: float, theta: float) -> tuple[float, float] | None:
    """Return (4) in s, ``None`` when the kernel never exceeds ``theta`` K > 0."""
    constant, spread = kernel_constant(instance), diffusivity(instance)
    if distance_mm == 0.0:
        return 0.0, (constant / theta) ** 2
    level = (theta * distance_mm / constant) ** 2 / (2.0 * spread)
    if level >= np.exp(-1.0):
        return None
    late, soon = (float(-lambertw(-level, branch).real) for branch in (0, -1))
    lag = distance_mm**2 / (2.0 * spread)
    # A level that underflows to 0 means that the window never ends.
    return lag / soon, lag / late if late > 0.0 else float("inf")
