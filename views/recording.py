"""A watch that keeps what a run shows, for a page that steps through it.

A step is the state after an event. Only so many are kept: of the first ``FIRST`` events all, of the later ones
each k-th, with k the least power of two for which they are ``MOST`` at most and the text of all has ``BYTES``
at most; where the first ones alone have more, the half of them, and so on. Events with a new incumbent and the
last one always stay.

Written are differences: a field that a step does not have is as in the step before.
"""

import json
from collections.abc import Iterable
from dataclasses import asdict
from itertools import pairwise
from math import isfinite
from typing import Any

from cutgap.instances import Instance, Result
from cutgap.instances.progress import Progress
from cutgap.instances.scene import Branch, Decision, Scene, plan_nodes

FIRST = 150
"""Events from the beginning that are all kept: there a run changes most."""

MOST = 250
"""Most of the later ones, but for those that always stay."""

BYTES = 1_700_000
"""Most characters of the steps: a page with them stays below 2 MB."""

TREE = 1500
"""Nodes of the tree that are drawn: the first ones."""

Json = dict[str, Any]

PASSING: Json = {"rows": [], "branch": None, "threshold": None}
"""Fields that a scene says nothing of when they are over; the others last until a scene changes them."""


class Recorder:
    """Collects the steps of one run; ``document`` is what a page shows."""

    def __init__(self, instance: Instance) -> None:
        self._names = names_of(instance)
        self._instance = instance
        self._state: Json = {}
        self._steps: list[Json] = []
        self._first, self._stride = FIRST, 1
        self._tree: dict[int, Json] = {}

    @property
    def _events(self) -> int:
        return int(self._state.get("at", -1)) + 1

    def watch(self, progress: Progress) -> None:
        """Take an event; one without a scene shows nothing."""
        if progress.scene is None:
            return
        scene = progress.scene()
        self._add(scene, progress.seconds, progress.value, progress.lower_bound)
        for branch in scene.branches:
            self._grow(branch)

    def finish(self, result: Result) -> None:
        """Add the last step: what the run established."""
        allowed = result.plan is not None and not result.violations
        best = plan_nodes(self._instance, result.plan) if result.plan is not None and allowed else None
        value = result.value if allowed else None
        self._add(Scene(_ending(result), legs=(), best=best), result.seconds, value, result.lower_bound)
        self._state["stays"] = True  # the step that was added holds the same dictionary

    def _add(self, scene: Scene, seconds: float, value: float | None, bound: float | None) -> None:
        before = self._state.get("value")
        figures = {"seconds": round(seconds, 3), "value": figure(value), "lower": figure(bound)}
        self._state = {**self._state, **PASSING, **_fields(scene), **figures, "at": self._events}
        self._state["stays"] = self._state["value"] != before
        if self._steps and not self._kept(self._steps[-1]):
            self._steps.pop()
        self._steps.append(self._state)
        if sum(not step["stays"] for step in self._steps) > self._first + MOST:
            self._thin()

    def _kept(self, step: Json) -> bool:
        return step["stays"] or step["at"] < self._first or step["at"] % self._stride == 0

    def _thin(self) -> None:
        """Keep every other one of the later steps, or half as many first ones once no later one is left.

        The last step stays for now, whatever it is.
        """
        if self._stride < self._events:
            self._stride *= 2
        else:
            self._first //= 2
        self._steps = [step for step in self._steps[:-1] if self._kept(step)] + self._steps[-1:]

    def _grow(self, branch: Branch) -> None:
        """Note what became of a node of the tree."""
        if branch.number not in self._tree:
            decision = None if branch.decision is None else self._decision(branch.decision)
            self._tree[branch.number] = {"parent": branch.parent, "decision": decision, "history": []}
        history = self._tree[branch.number]["history"]
        seen = [branch.state, figure(branch.bound)]
        if not history or history[-1][1:] != seen:
            history.append([self._state["at"], *seen])

    def _decision(self, decision: Decision) -> str:
        """Return a decision as text, places by their names."""
        places = ", ".join(self._names[node] for node in decision.nodes)
        symbol = decision.symbol + ("" if decision.head is None else "⁰¹"[decision.head])
        sign, limit = ("≥", decision.lower) if decision.lower > 0.0 else ("≤", decision.upper)
        sign = "=" if decision.lower == decision.upper else sign
        return f"{symbol}({places}) {sign} {limit:g}" if places else f"{symbol} {sign} {limit:g}"

    def document(self) -> Json:
        """Return steps, tree, and by which rule steps were left out."""
        steps = differences(self._steps)
        while len(json.dumps(steps)) > BYTES and self._first > 0:
            self._thin()
            steps = differences(self._steps)
        tree = dict(sorted(self._tree.items(), key=lambda item: item[1]["history"][0][0])[:TREE])
        return {
            "steps": steps,
            "tree": tree,
            "events": self._events,
            "stride": self._stride,
            "first": self._first,
            "tree_left_out": len(self._tree) - len(tree),
        }


def names_of(instance: Instance) -> list[str]:
    """Return what each node is called: the id of its contour (and its entry point), or the home of a head."""
    names = [
        contour.id if len(contour.entry_points) == 1 else f"{contour.id}/{entry + 1}"
        for contour in instance.contours
        for entry in range(len(contour.entry_points))
    ]
    homes = [head for head in instance.heads if head.home is not None]
    return names + [f"home {head.id}" if len(homes) > 1 else "home" for head in homes]


def figure(number: float | None) -> float | None:
    """Return a figure as it is shown, ``None`` for one that is not finite."""
    return None if number is None or not isfinite(number) else round(number, 4)


def differences(steps: Iterable[Json]) -> list[Json]:
    """Return what each step changes."""
    whole = [{}, *({k: v for k, v in step.items() if k != "stays"} for step in steps)]
    return [
        {field: value for field, value in step.items() if field not in last or last[field] != value}
        for last, step in pairwise(whole)
    ]


def _fields(scene: Scene) -> Json:
    """Return what a scene says, as JSON; lists of legs and thresholds hold lists of figures."""
    fields: Json = {"text": scene.text, "rows": [asdict(row) for row in scene.rows]}
    for row in fields["rows"]:
        row["left"], row["right"] = figure(row["left"]), figure(row["right"])
    fields |= {"branch": scene.branch, "threshold": scene.threshold}
    lasting: Json = {"bound": figure(scene.bound), "best": scene.best, "owners": scene.owners}
    if scene.legs is not None:
        lasting["legs"] = [[leg.start, leg.end, figure(leg.value), leg.head] for leg in scene.legs]
    if scene.thresholds is not None:
        lasting["thresholds"] = [
            [round(each.x, 2), each.count, *(figure(time) for pair in each.times for time in pair)]
            for each in scene.thresholds
        ]
    if scene.dp is not None:
        lasting |= asdict(scene.dp)
        lasting["prices"] = [round(price, 2) for price in scene.dp.prices]
    return fields | {field: value for field, value in lasting.items() if value is not None}


def _ending(result: Result) -> str:
    """Return the last step's sentence."""
    if result.status == "infeasible":
        return f"No plan is allowed: {result.reason}." if result.reason else "No plan is allowed."
    if result.status == "optimal":
        return "The bound meets the best plan: it is optimal."
    why = f" ({result.reason})" if result.reason else ""
    return f"The run ends{why} with a gap." if result.gap is not None else f"The run ends{why}."
