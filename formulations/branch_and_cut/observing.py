"""Scenes of a search: what the engine shows to whoever watches it."""

from collections import Counter
from typing import TYPE_CHECKING, Literal

from cutgap.instances.scene import Branch, Inequality, Scene, State

if TYPE_CHECKING:
    from cutgap.formulations.branch_and_cut.engine import BranchAndCut, Node
    from cutgap.formulations.branch_and_cut.model import Model

Event = Literal["began", "relaxed", "cut", "divided", "bound", "infeasible", "solution"]

SENTENCES: dict[Event, str] = {
    "began": "The linear program begins with these rows; cuts join it where a point breaks them.",
    "relaxed": "Node {node}: the relaxation is solved.",
    "cut": "Node {node}: the point breaks {count}, which join the linear program.",
    "divided": "Node {node}: no further cut is sought. It is divided in two.",
    "bound": "Node {node} is closed: nothing below it is better than the incumbent.",
    "infeasible": "Node {node} is closed: nothing is allowed there.",
    "solution": "Node {node} is closed: its point is a solution.",
}
STATES: dict[Event, State] = {
    "divided": "divided",
    "bound": "bound",
    "infeasible": "infeasible",
    "solution": "solution",
}


def scene_of(search: "BranchAndCut", node: "Node", event: Event, added: int) -> Scene:
    """Return the scene of an event at a node; of the rows, the last ``added`` are new."""
    model = search.model
    rows = tuple(model.inequality(row) for row in model.rows[len(model.rows) - added :])
    # A look ahead has replaced the point when a node is divided.
    at_point = event not in ("began", "divided", "infeasible")
    touched = [_branch(model, node, STATES.get(event, "open"))]
    touched += [_branch(model, child, "open") for child in node.children]
    return Scene(
        SENTENCES[event].format(node=node.number, count="1 row" if added == 1 else f"{added} rows"),
        # Once rows have joined, the duals are no longer those of the linear program.
        bound=model.bound() if event in ("relaxed", "bound") else None,
        legs=model.legs() if at_point else None,
        rows=families(model) if event == "began" else rows,
        branch=node.number,
        branches=tuple(touched),
        best=None if search.incumbent is None else model.tours(search.incumbent[1]),
    )


def _branch(model: "Model", node: "Node", state: State) -> Branch:
    decision = model.decision(node.fixings[-1]) if node.fixings else None
    # A look ahead may show that a child has no solutions.
    state = "infeasible" if state == "open" and node.bound == float("inf") else state
    return Branch(node.number, node.parent, node.bound, state, decision)


def families(model: "Model") -> tuple[Inequality, ...]:
    """Return the kinds of the rows that never leave, with how many there are of each."""
    kinds = Counter(row.name[0] for row in model.rows[: model.permanent] if isinstance(row.name, tuple))
    return tuple(Inequality(*model.wording[kind], count=count) for kind, count in kinds.items())
