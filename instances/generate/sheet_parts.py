"""Sheet-metal parts of a given bounding box and perimeter: outlines, holes and windows.

A draft is a part with one free measure t in 0 .. 1 (a radius, the size of a cut corner, the depth of a notch,
the diameter of a bore); t is found by bisection so that the rings of the part have the asked perimeter in all.
Boxes begin at (0, 0); the outline touches all four sides of its box at every t. Lengths in mm.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np

from cutgap.instances.generate.rings import Point, Ring, circle, rectangle

Draft = Callable[[float], list[Ring]]
"""The rings of a part at t, the outline first."""

Outline = Callable[[float, float, np.random.Generator], Callable[[float], Ring]]
"""Draws an outline for a box of two sides; its perimeter changes steadily with t."""

SHARP_TO_SOFT = (0.0, 8.0, 12.0, 20.0)
"""Radii of corners that nothing else shapes."""


def rounded(width: float, height: float, rng: np.random.Generator) -> Callable[[float], Ring]:
    """All corners rounded."""
    half = min(width, height) / 2
    return lambda t: rectangle((width / 2, height / 2), width, height, t * half)


def chamfered(width: float, height: float, rng: np.random.Generator) -> Callable[[float], Ring]:
    """All corners cut at 45 degrees."""
    half = 0.49 * min(width, height)
    return lambda t: cut_plate(width, height, [(t * half, t * half)] * 4, 0.0)


def trapezoid(width: float, height: float, rng: np.random.Generator) -> Callable[[float], Ring]:
    """Both upper corners cut, steeply or flat."""
    x, y = width * rng.uniform(0.25, 0.45), height * rng.uniform(0.6, 0.95)
    radius = float(rng.choice(SHARP_TO_SOFT))
    return lambda t: cut_plate(width, height, [(0, 0), (0, 0), (t * x, t * y), (t * x, t * y)], radius)


def gusset(width: float, height: float, rng: np.random.Generator) -> Callable[[float], Ring]:
    """One corner cut away, up to nearly the whole triangle."""
    x, y = width * rng.uniform(0.75, 0.92), height * rng.uniform(0.75, 0.92)
    radius = float(rng.choice(SHARP_TO_SOFT))
    return lambda t: cut_plate(width, height, [(0, 0), (0, 0), (t * x, t * y), (0, 0)], radius)


def arrow(width: float, height: float, rng: np.random.Generator) -> Callable[[float], Ring]:
    """Both right corners cut: a house on its side."""
    x, y = width * rng.uniform(0.3, 0.6), height * rng.uniform(0.35, 0.48)
    radius = float(rng.choice(SHARP_TO_SOFT))
    return lambda t: cut_plate(width, height, [(0, 0), (t * x, t * y), (t * x, t * y), (0, 0)], radius)


def slanted(width: float, height: float, rng: np.random.Generator) -> Callable[[float], Ring]:
    """Two opposite corners cut."""
    x, y = width * rng.uniform(0.35, 0.6), height * rng.uniform(0.5, 0.9)
    radius = float(rng.choice(SHARP_TO_SOFT))
    return lambda t: cut_plate(width, height, [(0, 0), (t * x, t * y), (0, 0), (t * x, t * y)], radius)


def tongue(width: float, height: float, rng: np.random.Generator) -> Callable[[float], Ring]:
    """Both right corners rounded, up to a half circle."""
    half, radius = min(width, height) / 2, float(rng.choice(SHARP_TO_SOFT))
    corners = rectangle((width / 2, height / 2), width, height, 0.0).corners
    return lambda t: Ring(corners, (radius, t * half, t * half, radius))


def bracket(width: float, height: float, rng: np.random.Generator) -> Callable[[float], Ring]:
    """An L, all corners rounded alike."""
    x, y = width * rng.uniform(0.4, 0.6), height * rng.uniform(0.4, 0.6)
    corners = ((0.0, 0.0), (width, 0.0), (width, y), (x, y), (x, height), (0.0, height))
    half = 0.49 * min(x, y, width - x, height - y)
    return lambda t: Ring(corners, (t * half,) * 6)


def channel(width: float, height: float, rng: np.random.Generator) -> Callable[[float], Ring]:
    """A U: a notch from above, t being its depth."""
    left, right = width * rng.uniform(0.28, 0.36), width * rng.uniform(0.64, 0.72)
    outer, inner, deepest = rng.uniform(20.0, 40.0), rng.uniform(8.0, 15.0), 0.62 * height

    def ring(t: float) -> Ring:
        # A notch has room for its radii at any depth.
        floor = height - 2 * inner - t * (deepest - 2 * inner)
        upper = ((right, height), (right, floor), (left, floor), (left, height))
        corners = ((0.0, 0.0), (width, 0.0), (width, height), *upper, (0.0, height))
        return Ring(corners, (outer, outer, outer, inner, inner, inner, inner, outer))

    return ring


def cut_plate(width: float, height: float, cuts: Sequence[Point], radius: float) -> Ring:
    """Return a rectangle with straight cuts (extent in x, in y) at its corners; corners not cut are rounded.

    Corners are lower left, lower right, upper right, upper left. The radius is less where cuts leave no room.
    """
    (a, b), (c, d), (e, f), (g, h) = cuts
    radius = min(radius, (width - max(a + c, e + g)) / 2, (height - max(b + h, d + f)) / 2)
    box = ((0.0, 0.0), (width, 0.0), (width, height), (0.0, height))
    corners: list[Point] = []
    radii: list[float] = []
    for number, ((x, y), (along_x, along_y)) in enumerate(zip(box, cuts, strict=True)):
        if along_x <= 0.0 or along_y <= 0.0:
            corners, radii = [*corners, (x, y)], [*radii, radius]
            continue
        on_x, on_y = (abs(x - along_x), y), (x, abs(y - along_y))
        # Counter-clockwise, the lower right and the upper left corner are reached along x.
        corners += [on_x, on_y] if number % 2 else [on_y, on_x]
        radii += [0.0, 0.0]
    return Ring(tuple(corners), tuple(radii))


def plain(outline: Outline) -> Callable[[float, float, np.random.Generator], Draft]:
    """Return the maker of parts that are their outline."""
    return lambda width, height, rng: _with_holes(outline(width, height, rng), [])


def drilled(outline: Outline, holes: int) -> Callable[[float, float, np.random.Generator], Draft]:
    """Return the maker of parts with equal holes in a row along the middle line."""

    def draft(width: float, height: float, rng: np.random.Generator) -> Draft:
        diameter = rng.uniform(18.0, 28.0)
        places = [(width * (2 * k + 1) / (2 * holes), height / 2) for k in range(holes)]
        return _with_holes(outline(width, height, rng), [circle(place, diameter) for place in places])

    return draft


def _with_holes(outline: Callable[[float], Ring], holes: list[Ring]) -> Draft:
    return lambda t: [outline(t), *holes]


def strap(width: float, height: float, rng: np.random.Generator) -> Draft:
    """A strap with a slot at either end, t being the length of the slots."""
    radius, across, inset = rng.uniform(0.15, 0.3) * height, rng.uniform(14.0, 22.0), rng.uniform(70.0, 90.0)
    outline = rectangle((width / 2, height / 2), width, height, radius)

    def rings(t: float) -> list[Ring]:
        along = across + 1.0 + t * 80.0
        places = [(inset, height / 2), (width - inset, height / 2)]
        return [outline, *(rectangle(place, along, across, across / 2) for place in places)]

    return rings


def clevis(width: float, height: float, rng: np.random.Generator) -> Draft:
    """A U with a hole in each arm."""
    outline, diameter = channel(width, height, rng), rng.uniform(18.0, 30.0)
    places = [(0.14 * width, 0.75 * height), (0.86 * width, 0.75 * height)]
    return _with_holes(outline, [circle(place, diameter) for place in places])


def panel(width: float, height: float, rng: np.random.Generator) -> Draft:
    """A rounded plate with a window, t being its size, between two holes."""
    radius, diameter = rng.uniform(25.0, 60.0), rng.uniform(20.0, 40.0)
    outline = rectangle((width / 2, height / 2), width, height, radius)
    ratio, soft = rng.uniform(0.5, 0.9), rng.uniform(8.0, 14.0)
    holes = [circle((share * width, height / 2), diameter) for share in (0.15, 0.85)]

    def rings(t: float) -> list[Ring]:
        along = 40.0 + t * min(0.55 * width, 0.7 * height / ratio)
        return [outline, rectangle((width / 2, height / 2), along, ratio * along, soft), *holes]

    return rings


def flange(width: float, height: float, rng: np.random.Generator) -> Draft:
    """A round flange (a square box is asked for) with four bolt holes, t being the size of the bore."""
    diameter = rng.uniform(18.0, 26.0)
    centre, first = (width / 2, height / 2), rng.uniform(0.0, math.pi / 2)

    def rings(t: float) -> list[Ring]:
        bore = width * (0.3 + 0.5 * t)
        reach = (width + bore) / 4
        angles = [first + quarter * math.pi / 2 for quarter in range(4)]
        bolts = [(centre[0] + reach * math.cos(a), centre[1] + reach * math.sin(a)) for a in angles]
        return [circle(centre, width), circle(centre, bore), *(circle(bolt, diameter) for bolt in bolts)]

    return rings


def perimeter(rings: Sequence[Ring]) -> float:
    """Return the length of all rings."""
    return math.fsum(ring.length for ring in rings)


def fitted(draft: Draft, asked: float) -> list[Ring] | None:
    """Return the rings at the t that gives the asked perimeter; ``None`` when no t does."""
    low, high = 0.0, 1.0
    rising = perimeter(draft(high)) > perimeter(draft(low))
    ends = sorted((perimeter(draft(low)), perimeter(draft(high))))
    if not ends[0] < asked < ends[1]:
        return None
    for _ in range(50):
        middle = (low + high) / 2
        if (perimeter(draft(middle)) < asked) == rising:
            low = middle
        else:
            high = middle
    return draft((low + high) / 2)
