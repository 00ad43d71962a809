r"""From bounds on tours to a bound on the objective: one head, or two heads without overlap.

One head cuts everything, so its tour's length decides. Two heads without overlap divide the contours at a
threshold in x (``certificate/split.py``), so the objective is at least the least, over all divisions that are
allowed, of what the lengths of the two tours make of it (``two_heads.bound``):

    (1) bound = min over divisions (S, rest) of f(l_0(S), l_1(rest)),   l_a(C) <= shortest tour of head a of C

The search keeps the divisions on a heap by their bound, with lengths inherited from subsets where the checker
allows it, and asks the relaxation only for tours of the division that holds the least bound down. A group of
equal x, which may be divided in any way, is one cell whose contours float between the heads; it is divided step
by step.
"""

import heapq
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import groupby
from typing import Any

import numpy as np

from cutgap.formulations.certificate import Problem, problem_of
from cutgap.formulations.certificate.reading import number
from cutgap.formulations.certificate.tours import TourBounds
from cutgap.formulations.certify import SCALE, certificate_of
from cutgap.formulations.relaxations.bound import RelaxationBound, Size, float_below
from cutgap.formulations.relaxations.tour_proof import MULTIPLIER_SCALE, Table, TourRelaxation, prove
from cutgap.formulations.scope import require_given_entries, require_no_peak, require_single_entries
from cutgap.formulations.sides import Sides
from cutgap.formulations.two_heads.bound import objective_bound
from cutgap.instances import Instance, Rules
from cutgap.instances.formats.json_format import format_instance

SHARE = 1e-3
"""Of the usual margins: the lengths are exact, and only what is made of them is computed in floating point."""


def bound_of_tours(
    instance: Instance,
    rules: Rules,
    name: str,
    relaxation: TourRelaxation,
    *,
    time_limit: float | None = None,
) -> RelaxationBound:
    """Return the bound on the objective that a relaxation of tours gives, with its certificate.

    Parameters
    ----------
    time_limit
        Seconds after which no further tour is bounded; the bound proved so far is returned.

    Raises
    ------
    ValueError
        When the instance or the rules are beyond the relaxation; it says why.
    """
    started = time.perf_counter()
    require_given_entries(instance, rules, f"relaxation {name}")
    require_no_peak(instance, rules, f"relaxation {name}")
    require_single_entries(instance, rules, name)
    where = f"instance {instance.name!r}, relaxation {name}"
    if len(instance.heads) > 2:
        raise ValueError(f"{where}: takes one head or two, got {len(instance.heads)}")
    if len(instance.heads) == 2 and rules.non_overlap is None:
        raise ValueError(f"{where}: two heads need a non-overlap limit")
    tours = Tours(instance, rules, name, relaxation)
    deadline = np.inf if time_limit is None else started + time_limit
    claimed, proof = (
        _one_head(instance, rules, tours)
        if len(instance.heads) == 1
        else Thresholds(instance, rules, tours, deadline).search()
    )
    unit = instance.machine.v_jump if rules.objective == "makespan" else 1.0

    def claim(margin: float) -> tuple[int | None, Table]:
        if claimed is None:
            return None, proof
        return max(0, int(np.floor((claimed * unit - SHARE * margin) * SCALE))), proof

    certificate = certificate_of(instance, rules, None, MULTIPLIER_SCALE, claim)
    if certificate is None:
        raise AssertionError(f"{where}: its certificate was refused")
    divisor = SCALE * (tours.problem.v_jump if rules.objective == "makespan" else 1)
    bound = None if claimed is None else float_below(Fraction(certificate["bound"]) / divisor)
    size, seconds = tours.size, time.perf_counter() - started
    return RelaxationBound(name, bound, size.variables, size.constraints, size.nonzeros, seconds, certificate)


class Tours:
    """The tours that were bounded, as the checker will see them."""

    def __init__(self, instance: Instance, rules: Rules, name: str, relaxation: TourRelaxation) -> None:
        self.instance, self.name, self.relaxation = instance, name, relaxation
        self.problem: Problem = problem_of(format_instance(instance))
        self.bounds = TourBounds(self.problem, [])
        self.tables: list[Table] = []
        self.size = Size(0, 0, 0)
        heads = range(len(instance.heads))
        self.sides = {
            (head, via): Sides(instance, head, via_points=via, inherits=False)
            for head in heads
            for via in (False, True)
        }
        self.has_via = [rules.via_points and instance.home_node(head) is not None for head in heads]
        self._tried: set[tuple[int, tuple[int, ...], bool]] = set()

    def add(self, head: int, contours: list[int], via: bool) -> bool:
        """Bound the tours of a head; False if they were bounded before."""
        key = head, tuple(sorted(contours)), via and self.has_via[head]
        if key in self._tried:
            return False
        self._tried.add(key)
        sides = self.sides[head, key[2]]
        lengths, proof = sides.lengths(key[1]), None
        if len(lengths) > 3:
            try:
                proof = self.relaxation(lengths, sides.via(key[1]))
            except ValueError as error:
                raise ValueError(
                    f"instance {self.instance.name!r}, relaxation {self.name}, head {head}: {error}"
                ) from None
            self.size = max(self.size, proof.size, key=lambda size: size.nonzeros)
        tour, table = prove(self.problem, head, list(key[1]), key[2], proof)
        self.bounds.of_head[head].append(tour)
        self.tables.append(table)
        return True

    def length(self, head: int, contours: list[int], floating: list[int]) -> float:
        """Return the best bound on a head's tours of contours and any of those that float, mm."""
        return self.bounds.length(head, contours, floating) / SCALE


def _one_head(instance: Instance, rules: Rules, tours: Tours) -> tuple[float, Table]:
    everything = list(range(len(instance.contours)))
    tours.add(0, everything, True)
    length = tours.length(0, everything, [])
    work = float(instance.service_times.sum())
    value = length / instance.machine.v_jump + work if rules.objective == "makespan" else length
    return value, {"kind": "tour", "tour": tours.tables[0]}


@dataclass(order=True, slots=True)
class Cell:
    """Divisions in which the heads have at least ``sides``; ``group`` and ``node``: its place in ``ties``."""

    bound: float
    number: int
    sides: tuple[list[int], list[int]] = field(compare=False)
    floating: list[int] = field(compare=False, default_factory=list)
    group: int = field(compare=False, default=-1)
    node: int = field(compare=False, default=0)


class Thresholds:
    """One search over the divisions of an instance; see the module."""

    def __init__(self, instance: Instance, rules: Rules, tours: Tours, deadline: float) -> None:
        self.instance, self.rules, self.tours, self.deadline = instance, rules, tours, deadline
        self.ties: list[list[dict[str, Any]]] = []
        self.heap: list[Cell] = []
        self.numbers = 0
        for sides, floating in self._first_cells():
            if floating:
                self.ties.append([{"leaf": True}])
            self._push(sides, floating, len(self.ties) - 1, 0)

    def search(self) -> tuple[float | None, Table]:
        """Return the bound, ``None`` when no division is allowed, and the certificate's proof."""
        while self.heap and time.perf_counter() <= self.deadline:
            cell = self.heap[0]
            bound = self._bound(cell)
            if bound > cell.bound or self._tighten(cell):
                cell.bound = max(cell.bound, self._bound(cell))
                heapq.heapreplace(self.heap, cell)
            elif cell.floating:
                self._divide(heapq.heappop(self.heap))
            else:
                break
        proof = {"kind": "split", "tours": self.tours.tables, "ties": self.ties}
        return (self.heap[0].bound if self.heap else None), proof

    def _first_cells(self) -> Iterator[tuple[tuple[list[int], list[int]], list[int]]]:
        """Yield the two sides, and what floats, as the checker divides the contours, in its exact numbers."""
        xs, gap = self.tours.problem.xs, number(self.rules.non_overlap, "non_overlap")
        order = sorted(range(len(xs)), key=lambda contour: xs[contour])
        groups = [list(group) for _, group in groupby(order, key=lambda contour: xs[contour])]
        left: list[int] = []
        for group in groups:
            right = order[len(left) :]
            if not left or xs[group[0]] - xs[left[-1]] >= gap:
                yield (left, right), []
            if gap == 0 and len(group) > 1:
                yield (left, right[len(group) :]), group
            left = left + group
        yield (left, []), []

    def _push(self, sides: tuple[list[int], list[int]], floating: list[int], group: int, node: int) -> None:
        """Put a cell on the heap, unless its only division leaves a head without work against the rules."""
        may_rest = self.rules.empty_heads or len(self.instance.contours) < 2
        if not floating and not all(sides) and not may_rest:
            return
        self.numbers += 1
        cell = Cell(0.0, self.numbers, sides, floating, group, node)
        cell.bound = self._bound(cell)
        heapq.heappush(self.heap, cell)

    def _bound(self, cell: Cell) -> float:
        """Return (1) for one cell; what floats is the work of either head."""
        one, two = (self.tours.length(head, cell.sides[head], cell.floating) for head in (0, 1))
        works = [float(self.instance.service_times[each].sum()) for each in (*cell.sides, cell.floating)]
        return objective_bound(self.instance.machine, self.rules, (one, two), (works[0], works[1]), works[2])

    def _tighten(self, cell: Cell) -> bool:
        """Bound a tour of the cell that was not bounded yet, first the one of more contours; False without."""
        if cell.floating and not self.tours.bounds.metric:
            return False  # then decided contours say nothing about a tour of more
        xs = self.tours.problem.xs
        heads = sorted((0, 1), key=lambda head: -len(cell.sides[head]))
        for head in heads:
            side = cell.sides[head]
            if not side:
                continue
            # Beside or left of contours that float, none is known to be a leftmost one.
            via = all(min(xs[each] for each in side) < xs[other] for other in cell.floating)
            if self.tours.add(head, side, via):
                return True
        return False

    def _divide(self, cell: Cell) -> None:
        """Give the first contour that floats to either head."""
        contour, *rest = cell.floating
        tree, (left, right) = self.ties[cell.group], cell.sides
        name = self.instance.contours[contour].id
        tree[cell.node] = {"branch": name, "left": len(tree), "right": len(tree) + 1}
        tree += [{"leaf": True}, {"leaf": True}]
        self._push(([*left, contour], right), rest, cell.group, len(tree) - 2)
        self._push((left, [*right, contour]), rest, cell.group, len(tree) - 1)
