r"""Strokes: what is cut from one pierce when contours are joined by links.

Contours and links make a graph: the entry points are its nodes, the contours its cycles. A visit starts a
stroke through the connected part of the graph that it lies in, which cuts every contour of it once and every
link as often as it says. By Euler that is possible if and only if

    (1) no node is the end of an odd number of passes: the stroke ends where it starts, or
    (2) exactly two are, the visited one and another: the stroke ends there.

The head comes to the start of a stroke and leaves from its end by rapids.

Source: Chen, Li, Chu (Euler circuit over doubled links); (2) also lets a stroke end elsewhere.
"""

from collections import Counter
from dataclasses import dataclass

import numpy as np

from cutgap.instances.instance import Instance
from cutgap.instances.plan import Link, Plan


@dataclass(frozen=True, slots=True)
class Stroke:
    """What is cut from one pierce.

    Attributes
    ----------
    start, end
        Nodes at which it starts and ends.
    contours
        What it cuts, in order of number; empty when another visit cuts them already.
    links
        The links that it passes.
    """

    start: int
    end: int
    contours: tuple[int, ...]
    links: tuple[Link, ...] = ()


def link_ends(instance: Instance, link: Link) -> tuple[int, int]:
    """Return the nodes that a link joins."""
    return instance.node(link.contour, link.entry), instance.node(link.to_contour, link.to_entry)


def link_length(instance: Instance, link: Link) -> float:
    """Return the length of one pass, mm: Euclidean whatever the metric of rapids, since it is cut."""
    start, end = link_ends(instance, link)
    return float(np.linalg.norm(instance.points[start] - instance.points[end]))


def groups(instance: Instance, links: tuple[Link, ...]) -> list[int]:
    """Return for each contour the least number among the contours that it is linked to."""
    leader = list(range(len(instance.contours)))

    def find(contour: int) -> int:
        while leader[contour] != contour:
            leader[contour] = contour = leader[leader[contour]]
        return contour

    for link in links:
        one, other = sorted((find(link.contour), find(link.to_contour)))
        leader[other] = one
    return [find(contour) for contour in range(len(leader))]


def odd_nodes(instance: Instance, links: tuple[Link, ...]) -> list[int]:
    """Return the nodes that are the end of an odd number of passes."""
    ends = Counter(node for link in links if link.passes % 2 for node in link_ends(instance, link))
    return sorted(node for node, count in ends.items() if count % 2)


def strokes(instance: Instance, plan: Plan) -> tuple[tuple[Stroke, ...], ...]:
    """Return the strokes of each head, one a visit.

    A plan may break rules: of several visits to one group the first gets it all, and where neither (1) nor (2)
    holds a stroke ends where it starts.
    """
    if not plan.links:
        return tuple(
            tuple(
                Stroke(node, node, (visit.contour,)) for visit in tour for node in [instance.node(*visit[:2])]
            )
            for tour in plan.tours
        )
    leaders = groups(instance, plan.links)
    members: dict[int, list[int]] = {}
    for contour, leader in enumerate(leaders):
        members.setdefault(leader, []).append(contour)
    links: dict[int, list[Link]] = {}
    for link in plan.links:
        links.setdefault(leaders[link.contour], []).append(link)
    found = []
    for tour in plan.tours:
        made = []
        for visit in tour:
            leader, start = leaders[visit.contour], instance.node(*visit[:2])
            own = tuple(links.pop(leader, ()))
            ends = set(odd_nodes(instance, own)) ^ {start}
            end = ends.pop() if len(ends) == 1 else start
            made.append(Stroke(start, end, tuple(members.pop(leader, ())), own))
        found.append(tuple(made))
    return tuple(found)
