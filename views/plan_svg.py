"""Plans from above as small SVG for pages with many of them: the sheet is written once, each plan refers to it.

Heads are told apart without colour too: round, square, hollow round and hollow square dots, in this order.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from itertools import pairwise

import numpy as np

from cutgap.instances import Instance, Plan, Visit
from cutgap.instances.arrays import Floats
from cutgap.instances.evaluate import require_known
from cutgap.instances.free_entries import pinned
from cutgap.instances.simulate import tour_nodes
from cutgap.views.plots import HEAD_COLOURS, MOST_NUMBERED, outline

WIDTH = 520.0
"""Width of a picture in its own units."""
MARGIN = 16.0
SHORTEST, LONGEST = 110.0, 620.0
"""Limits of a picture's height."""
RADII = (2.5, 9.0)
"""Radius of the smallest and the largest disc that stands for a contour without an outline."""
MOST_CHOICES = 800
"""Entry points to choose from that are drawn; of more nothing could be seen."""
ARROW = 3.2
BAR_SHARE = 0.25
"""Longest bar of the scale, as a share of the width."""


@dataclass(frozen=True, slots=True)
class Sheet:
    """An instance on paper: x to the right, y upwards; build it with ``sheet_of``.

    Attributes
    ----------
    id
        By which plans refer to the drawing of the contours.
    left, top
        Least x and largest y in mm.
    scale
        Units of the picture for a mm.
    height
        Height of the picture in its units.
    """

    id: str
    instance: Instance
    left: float
    top: float
    scale: float
    height: float

    def on_paper(self, points: Floats) -> Floats:
        """Return points (k, 2 or more) in mm as points (k, 2) of the picture."""
        return np.column_stack(
            (
                MARGIN + (points[:, 0] - self.left) * self.scale,
                MARGIN + (self.top - points[:, 1]) * self.scale,
            )
        )


def sheet_of(instance: Instance, name: str) -> Sheet:
    """Return where an instance, which must carry coordinates, is drawn."""
    curves = [curve for contour in instance.contours if (curve := outline(contour)) is not None]
    places = np.concatenate([instance.points[:, :2], *(curve[:, :2] for curve in curves), np.empty((0, 2))])
    if len(places) == 0:
        return Sheet(name, instance, 0.0, 0.0, 1.0, SHORTEST)
    (left, bottom), (right, top) = places.min(axis=0), places.max(axis=0)
    wide, high = right - left, top - bottom
    # On a line or a point alone the other extent, or any, decides.
    extent = max(wide, high) or 1.0
    scale = min((WIDTH - 2 * MARGIN) / (wide or extent), (LONGEST - 3 * MARGIN) / (high or extent))
    # The scale's bar stands in a margin of its own below.
    return Sheet(name, instance, left, top, scale, max(SHORTEST, high * scale + 3 * MARGIN))


def sheet_svg(sheet: Sheet) -> str:
    """Return the drawing of contours, entry points to choose from and scale, which plans refer to by its id."""
    instance = sheet.instance
    curves, discs = [], []
    largest = max(float(instance.perimeters.max(initial=0.0)), 1e-9)
    for contour in instance.contours:
        curve = outline(contour)
        if curve is not None:
            curves.append(_line(sheet.on_paper(curve)) + "z")
        elif len(contour.entry_points) == 1:
            ((x, y),) = sheet.on_paper(contour.entry_points)
            radius = RADII[0] + (RADII[1] - RADII[0]) * (contour.perimeter / largest) ** 0.5
            discs.append(f'<circle class="disc" cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}"/>')
    choices = [contour.entry_points for contour in instance.contours if len(contour.entry_points) > 1]
    dots = ""
    if choices and sum(map(len, choices)) <= MOST_CHOICES:
        dots = _path("choices", _dots(sheet.on_paper(np.concatenate(choices))))
    drawing = _path("outline", "".join(curves)) + dots + "".join(discs) + _scale(sheet)
    return f'<svg class="sheet" aria-hidden="true"><defs><g id="{sheet.id}">{drawing}</g></defs></svg>'


def plan_svg(sheet: Sheet, plan: Plan, label: str) -> str:
    """Return the drawing of a plan, to be shown on a page that has the drawing of its sheet.

    Raises
    ------
    ValueError
        When the plan does not fit the instance.
    """
    require_known(sheet.instance, plan)
    instance, plan = pinned(sheet.instance, plan)
    points = sheet.on_paper(instance.points)
    links = "".join(
        _line(points[[instance.node(link.contour, link.entry), instance.node(link.to_contour, link.to_entry)]])
        for link in plan.links
    )
    heads = [_head(instance, points, head, tour) for head, tour in enumerate(plan.tours)]
    return (
        f'<svg viewBox="0 0 {WIDTH:g} {sheet.height:.0f}" role="img" aria-label="{escape(label)}">'
        f"{_partition(instance, points, plan, sheet)}"
        f'<use href="#{sheet.id}"/>{_path("link", links)}{"".join(heads)}</svg>'
    )


def _head(instance: Instance, points: Floats, head: int, tour: Sequence[Visit]) -> str:
    """Draw a head's tour: rapids with arrows, dashed from and to the home, dots where it pierces, its home."""
    nodes = tour_nodes(instance, head, tuple(tour))
    home = instance.home_node(head)
    parts = []
    if nodes:
        path = points[nodes]
        inner = path if home is None else path[1:-1]
        ends = "" if home is None else _line(path[:2]) + _line(path[-2:])
        pierced = path[:-1] if home is None else inner
        dots = _dots(pierced)
        parts += [_path("ends", ends), _path("rapid", _line(inner)), _path("arrow", _arrows(path))]
        parts += [_path("dots", dots), _path("holes", dots) if head % 4 >= 2 else ""]
        x, y = inner[0]
        parts.append(f'<circle class="first" cx="{x:.1f}" cy="{y:.1f}" r="7"/>')
        if len(pierced) <= MOST_NUMBERED:
            # The first one has a ring around it.
            numbers = (
                f'<text x="{x + right:.1f}" y="{y - up:.1f}">{number}</text>'
                for number, (x, y) in enumerate(pierced, start=1)
                for right, up in [(8, 6) if number == 1 else (4, 4)]
            )
            parts.append("".join(numbers))
    if home is not None:
        x, y = points[home]
        parts.append(f'<path class="home" d="M{x:.1f},{y - 6:.1f}l6,6l-6,6l-6,-6z"/>')
    mark = "square" if head % 2 else "round"
    return f'<g class="head-{head % len(HEAD_COLOURS)} {mark}">{"".join(parts)}</g>'


def _partition(instance: Instance, points: Floats, plan: Plan, sheet: Sheet) -> str:
    """Draw the line half way between neighbouring ranges; where they overlap, a band over the overlap."""
    ranges = [points[[instance.node(*visit[:2]) for visit in tour], 0] for tour in plan.tours if tour]
    parts = []
    for left, right in pairwise(ranges):
        start, end = sorted((float(left.max()), float(right.min())))
        if left.max() <= right.min():
            parts.append(_path("partition", f"M{(start + end) / 2:.1f},0v{sheet.height - 2 * MARGIN:.0f}"))
        else:
            parts.append(
                f'<rect class="overlap" x="{start:.1f}" y="0" width="{end - start:.1f}" '
                f'height="{sheet.height - 2 * MARGIN:.0f}"/>'
            )
    return "".join(parts)


def _scale(sheet: Sheet) -> str:
    """Draw a bar of 1, 2 or 5 times a power of ten mm."""
    longest = BAR_SHARE * WIDTH / sheet.scale
    power = 10.0 ** np.floor(np.log10(longest))
    length = power * max(digit for digit in (1, 2, 5) if digit * power <= longest)
    x, y = MARGIN, sheet.height - MARGIN / 2
    bar = _path("scale", f"M{x:g},{y - 3:.1f}v6m0,-3h{length * sheet.scale:.1f}m0,-3v6")
    return (
        f'{bar}<text class="scale" x="{x + length * sheet.scale + 6:.1f}" y="{y + 4:.1f}">{length:g} mm</text>'
    )


def _path(kind: str, d: str) -> str:
    return f'<path class="{kind}" d="{d}"/>' if d else ""


def _line(points: Floats) -> str:
    """Return a polyline; points that fall on their predecessor at this precision are left out."""
    places = _places(points)
    kept = places[:1] + [after for before, after in pairwise(places) if before != after]
    return f"M{'L'.join(kept)}"


def _places(points: Iterable[Floats]) -> list[str]:
    return [f"{x:.1f},{y:.1f}" for x, y in points]


def _dots(points: Floats) -> str:
    """Return lines without length: what they look like is for their caps."""
    return "".join(f"M{place}h0" for place in _places(points))


def _arrows(path: Floats) -> str:
    """Return an open arrow head in the middle of each leg that is long enough to hold it."""
    legs = np.diff(path, axis=0)
    lengths = np.linalg.norm(legs, axis=1)
    long = lengths > 4 * ARROW
    along = ARROW * legs[long] / lengths[long, None]
    across = np.column_stack((-along[:, 1], along[:, 0]))
    tips = (path[:-1] + legs / 2)[long] + along / 2
    heads = np.stack((tips - along * 1.6 + across, tips, tips - along * 1.6 - across), axis=1)
    return "".join(map(_line, heads))
