"""The way of the head through strokes: rapids, cuts along contours, links, as polylines in order.

Contours are cut counter-clockwise in pieces from link to link. Where a stroke comes to a node by a contour it
takes a link first; where it comes by a link it goes on by another link, then along the contour, and back over
the other pass of the same link only then ("bridge first, then edge"). On doubled trees this walk is complete;
on other graphs what it leaves out are closed walks, which are put in where they touch it (Hierholzer).

Source: Chen, Li, Chu.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import networkx
import numpy as np
import shapely

from cutgap.instances.arrays import Floats
from cutgap.instances.instance import Instance
from cutgap.instances.links.strokes import Stroke, link_ends, strokes
from cutgap.instances.plan import Plan

Kind = Literal["rapid", "cut", "link"]


@dataclass(frozen=True, slots=True)
class Phase:
    """A piece of the way: its ``kind``, the contour that it cuts (for a cut), and a polyline (k, 2) in mm."""

    kind: Kind
    contour: int | None
    points: Floats


@dataclass(frozen=True, slots=True)
class _Arc:
    """A directed step of a stroke between two nodes, over a link or along a contour."""

    source: int
    target: int
    contour: int | None  # None is a link
    number: int  # of the link, or of the arc along the contour


def trajectory(instance: Instance, plan: Plan) -> tuple[Phase, ...]:
    """Return the way of a plan's only head, from home to home.

    Raises
    ------
    ValueError
        When the plan has several heads or its strokes cannot be made without a break (``check`` says why).
    """
    if len(plan.tours) != 1:
        raise ValueError(f"trajectory: expected one head, got {len(plan.tours)}")
    home = instance.home_node(0)
    phases: list[Phase] = []
    at = home
    for stroke in strokes(instance, plan)[0]:
        if at is not None:
            phases.append(Phase("rapid", None, instance.points[[at, stroke.start], :2]))
        phases += stroke_phases(instance, stroke)
        at = stroke.end
    if at is not None and phases:
        last = home if home is not None else strokes(instance, plan)[0][0].start
        if at != last:
            phases.append(Phase("rapid", None, instance.points[[at, last], :2]))
    return tuple(phases)


def stroke_phases(instance: Instance, stroke: Stroke) -> Iterator[Phase]:
    """Yield the cuts and links of a stroke in order; errors as for ``trajectory``."""
    curves = {contour: oriented_curve(instance, contour) for contour in stroke.contours}
    for arc in walk(instance, stroke):
        if arc.contour is None:
            yield Phase("link", None, instance.points[[arc.source, arc.target], :2])
        else:
            yield Phase("cut", arc.contour, piece(instance, curves[arc.contour], arc.source, arc.target))


def walk(instance: Instance, stroke: Stroke) -> list[_Arc]:
    """Return the steps of a stroke in order; errors as for ``trajectory``."""
    leaving: dict[int, list[_Arc]] = {}
    arcs = [*_contour_arcs(instance, stroke), *_link_arcs(instance, stroke)]
    for arc in arcs:
        leaving.setdefault(arc.source, []).append(arc)
    way = _greedy(leaving, stroke.start, None)
    step = 0
    while step <= len(way):
        node = stroke.start if step == 0 else way[step - 1].target
        if leaving.get(node):
            way[step:step] = _greedy(leaving, node, way[step - 1] if step else None)
        step += 1
    if len(way) != len(arcs) or (way[-1].target if way else stroke.start) != stroke.end:
        raise ValueError(
            f"stroke from node {stroke.start}: no continuous way covers its contours and links once"
        )
    return way


def _greedy(leaving: dict[int, list[_Arc]], start: int, before: _Arc | None) -> list[_Arc]:
    """Walk, bridge first then edge, until no arc leaves; the arcs that are taken are removed."""
    way, node = [], start
    while leaving.get(node):
        arc = min(leaving[node], key=lambda each: _turn(each, before))
        leaving[node].remove(arc)
        way.append(arc)
        node, before = arc.target, arc
    return way


def _turn(arc: _Arc, before: _Arc | None) -> int:
    """Order what may follow: other links, the contour, the link just passed."""
    if arc.contour is not None:
        return 1
    came_by_it = before is not None and before.contour is None and before.number == arc.number
    return 2 if came_by_it else 0


def _contour_arcs(instance: Instance, stroke: Stroke) -> Iterator[_Arc]:
    """Yield the pieces of each contour from node to node, counter-clockwise."""
    used: dict[int, set[int]] = {contour: set() for contour in stroke.contours}
    for link in stroke.links:
        start, end = link_ends(instance, link)
        used[link.contour].add(start)
        used[link.to_contour].add(end)
    for node in (stroke.start, stroke.end):
        contour = int(np.searchsorted(instance.first_node, node, side="right")) - 1
        if contour in used:
            used[contour].add(node)
    for contour, nodes in used.items():
        curve = oriented_curve(instance, contour)
        order = sorted(nodes, key=lambda node: (_place(instance, curve, node), node))
        for number, (source, target) in enumerate(pairwise([*order, *order[:1]])):
            yield _Arc(source, target, contour, number)


def _link_arcs(instance: Instance, stroke: Stroke) -> list[_Arc]:
    """Return the passes of all links, directed so that as many enter a node as leave it.

    A stroke that ends elsewhere than it starts has one more leaving its start and entering its end.
    """
    graph = networkx.MultiGraph()
    for number, link in enumerate(stroke.links):
        for _ in range(link.passes):
            graph.add_edge(*link_ends(instance, link), number=number)
    if stroke.start != stroke.end:
        graph.add_edge(stroke.end, stroke.start, number=-1)
    arcs = []
    for nodes in networkx.connected_components(graph):
        part = graph.subgraph(nodes)
        if not networkx.is_eulerian(part):
            raise ValueError(f"stroke from node {stroke.start}: an odd number of links meets at a node")
        circuit = list(networkx.eulerian_circuit(part, keys=True))
        steps = [(a, b, part.edges[a, b, key]["number"]) for a, b, key in circuit]
        if (stroke.start, stroke.end, -1) in steps:
            steps = [(b, a, number) for a, b, number in steps]
        arcs += [_Arc(a, b, None, number) for a, b, number in steps if number >= 0]
    return arcs


def oriented_curve(instance: Instance, contour: int) -> Floats:
    """Return a contour's curve counter-clockwise, shape (k + 1, 2), the first point repeated."""
    given = instance.contours[contour].geometry
    if given is None:
        raise ValueError(f"contour {instance.contours[contour].id!r}: no geometry, which a trajectory needs")
    ring = shapely.LinearRing(given)
    return np.array((ring if ring.is_ccw else ring.reverse()).coords)


def _place(instance: Instance, curve: Floats, node: int) -> float:
    """Return where along a curve a node lies, mm from its first point."""
    return float(shapely.line_locate_point(shapely.LineString(curve), shapely.Point(instance.points[node, :2])))


def piece(instance: Instance, curve: Floats, source: int, target: int) -> Floats:
    """Return the part of a closed curve from one node on to another, or all of it back to the same one."""
    marks = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))))
    begin, end = (_place(instance, curve, node) for node in (source, target))
    # In the order of the nodes: of two at one place only one piece between them is the whole curve.
    if (end, target) <= (begin, source):
        end += float(marks[-1])
    corners = np.concatenate((marks[:-1], marks + marks[-1]))
    passed = np.flatnonzero((corners > begin) & (corners < end)) % (len(curve) - 1)
    ends = instance.points[[source, target], :2]
    return np.concatenate((ends[:1], curve[passed], ends[1:]))
