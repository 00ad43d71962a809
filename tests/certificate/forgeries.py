"""Certificates and plans that must be refused, and what the refusal must say."""

import json
from collections.abc import Callable
from typing import Any

from cutgap.formulations.certificate import instance_hash

Document = dict[str, Any]
Forge = Callable[[Document, Document], Any]


def setting(*path: Any) -> Forge:
    """Set the field of the certificate at a path; the last entry is the value."""
    *steps, last, value = path

    def forge(certificate: Document, document: Document) -> None:
        place: Any = certificate
        for step in steps:
            place = place[step]
        place[last] = value

    return forge


def removing(*path: Any) -> Forge:
    *steps, last = path

    def forge(certificate: Document, document: Document) -> None:
        place: Any = certificate
        for step in steps:
            place = place[step]
        del place[last]

    return forge


def instance_setting(*path: Any) -> Forge:
    change = setting(*path)
    return lambda certificate, document: change(document, certificate)


def tour_nodes(*nodes: Any) -> Forge:
    """Nodes of the tour's tree; "good" stands for the leaf or fixing of the true root."""

    def forge(certificate: Document, document: Document) -> None:
        tour = certificate["proof"]["tour"]
        root = tour["nodes"][0]
        good = {"leaf": root.get("leaf") or root.get("fix")}
        # Low enough for the root's multipliers to prove it.
        tour["length"] = tour["length"] * 9 // 10
        certificate["bound"] = tour["length"]
        tour["nodes"] = [good if node == "good" else node for node in nodes]

    return forge


def branch(down: int, up: int, edge: Any = ("x", 0, 1), at: Any = 0) -> Document:
    return {"branch": list(edge), "at": at, "down": down, "up": up}


def tour_row(row: Any) -> Forge:
    """One more row for the tour."""
    return lambda certificate, document: certificate["proof"]["tour"]["rows"].append(row)


def row(name: Any) -> Forge:
    """One more row for two heads."""
    return lambda certificate, document: certificate["proof"]["rows"].append(name)


def two_nodes(variable: Any) -> Forge:
    return setting("proof", "nodes", [branch(1, 2, variable)])


def small_tour(certificate: Document, document: Document) -> None:
    tour = certificate["proof"]["tour"]
    del tour["rows"], tour["nodes"]


def longer_small_tour(certificate: Document, document: Document) -> None:
    certificate["proof"]["tour"]["length"] += 1
    certificate["bound"] += 1


def left_out(certificate: Document, document: Document) -> None:
    certificate["proof"]["tour"]["contours"].pop()
    certificate["proof"]["tour"]["length"] = certificate["bound"] = 0


def twice(certificate: Document, document: Document) -> None:
    contours = certificate["proof"]["tour"]["contours"]
    contours[1] = contours[0]


def one_tree(certificate: Document, document: Document) -> None:
    tour = certificate["proof"]["tour"]
    tour["one_tree"] = {"potentials": [0] * 7}
    del tour["rows"], tour["nodes"]


def one_tree_beside_rows(certificate: Document, document: Document) -> None:
    certificate["proof"]["tour"]["one_tree"] = {"potentials": [0] * 7}


def fewer_tours(certificate: Document, document: Document) -> None:
    certificate["proof"]["tours"] = certificate["proof"]["tours"][:2]


def several_entry_points(certificate: Document, document: Document) -> None:
    document["contours"][0]["entry_points"].append([1, 2, 3])
    certificate["instance"] = instance_hash(document)


def precedence(certificate: Document, document: Document) -> None:
    document["precedence"] = [["c0", "c1"]]
    certificate["instance"] = instance_hash(document)


def same_ids(certificate: Document, document: Document) -> None:
    document["contours"][0]["id"] = document["contours"][1]["id"]


def asymmetric(certificate: Document, document: Document) -> None:
    nodes = sum(len(each["entry_points"]) for each in document["contours"]) + len(document["heads"])
    document["machine"]["metric"] = "matrix"
    document["matrix"] = [[abs(i - j) for j in range(nodes)] for i in range(nodes)]
    document["matrix"][0][1] = 2
    certificate["instance"] = instance_hash(document)


def tie_root(**changes: Any) -> Forge:
    return lambda certificate, document: certificate["proof"]["ties"][0][0].update(changes)


def one_more_tie_node(certificate: Document, document: Document) -> None:
    certificate["proof"]["ties"][0].append({"leaf": True})


def tie(*nodes: Any) -> Forge:
    return setting("proof", "ties", 0, list(nodes))


FORGERIES: list[tuple[str, str, Forge, str]] = [
    # The frame.
    ("format", "tour", setting("format", "cutgap-plan"), "format"),
    ("version", "tour", setting("version", 2), "version"),
    ("unknown field", "tour", setting("comment", "trust me"), "unknown field"),
    ("missing field", "tour", removing("scale"), "scale is missing"),
    ("hash", "tour", setting("instance", "0" * 64), "another instance"),
    ("scale", "tour", setting("scale", 0), "scale"),
    ("fractional scale", "tour", setting("scale", 1.5), "whole number"),
    ("multiplier scale", "tour", setting("multiplier_scale", 0), "multiplier_scale"),
    ("negative multiplier scale", "tour", setting("multiplier_scale", -(2**24)), "multiplier_scale"),
    ("fractional bound", "tour", setting("bound", 0.5), "bound"),
    ("truth as bound", "tour", setting("bound", True), "bound"),
    ("higher bound", "tour", lambda c, d: c.update(bound=c["bound"] + 1), "less than the claimed"),
    ("rules", "tour", setting("rules", "objective", "beauty"), "objective"),
    ("negative weight", "split", setting("rules", "weight", -1), "weight"),
    ("weight without its objective", "split", setting("rules", "weight", 1), "weight"),
    ("rules missing", "split", removing("rules", "balance"), "balance is missing"),
    ("kind", "tour", setting("proof", "kind", "authority"), "no kind"),
    ("no proof", "tour", setting("proof", None), "proof"),
    ("other kind", "split", setting("proof", {"kind": "tour", "tour": {}}), "one head"),
    ("gtsp for two heads", "split", setting("proof", {"kind": "gtsp", "length": 0}), "one head"),
    ("split for one head", "tour", setting("proof", {"kind": "split", "tours": [], "ties": []}), "two heads"),
    ("two-heads for one head", "tour", setting("proof", {"kind": "two-heads", "rows": [], "nodes": []}), "two"),
    # The instance.
    ("other figure", "tour", instance_setting("machine", "v_cut", 41), "another instance"),
    ("speed", "tour", instance_setting("machine", "v_jump", 0), "speeds"),
    ("metric", "tour", instance_setting("machine", "metric", "taxi"), "metric"),
    ("perimeter", "tour", instance_setting("contours", 0, "perimeter", -1), "perimeter"),
    ("text for a number", "tour", instance_setting("contours", 0, "perimeter", "12"), "number"),
    ("infinite", "tour", instance_setting("contours", 0, "perimeter", float("inf")), "no number"),
    ("no entry point", "tour", instance_setting("contours", 0, "entry_points", []), "at least one"),
    ("part", "tour", instance_setting("contours", 0, "part", 7), "part"),
    ("coordinates", "tour", instance_setting("contours", 0, "entry_points", [[1, 2]]), "3 entries"),
    ("equal ids", "tour", same_ids, "one id"),
    ("precedence of nothing", "tour", instance_setting("precedence", [["c0", "c99"]]), "no contour"),
    ("precedence of three", "tour", instance_setting("precedence", [["c0", "c1", "c2"]]), "2 entries"),
    ("price of going back", "split", setting("rules", "backward_price", 1), "backward_price"),
    ("heads", "tour", instance_setting("heads", [{"id": str(i)} for i in range(3)]), "one and two"),
    ("matrix beside coordinates", "tour", instance_setting("matrix", [[0]]), "matrix"),
    ("nowhere", "tour", instance_setting("located", False), "located"),
    ("format of the instance", "tour", instance_setting("format", "cutgap-plan"), "cutgap-instance"),
    # What a kind of proof does not cover.
    *(
        (f"{what} of {base}", base, forge, f"{base.replace(' ', '-')}: takes {what}")
        for base in ("tour", "split", "two heads")
        for what, forge in (
            ("one entry point", several_entry_points),
            ("no precedence", precedence),
            ("symmetric", asymmetric),
        )
    ),
    # Trees.
    ("no nodes", "tour", setting("proof", "tour", "nodes", []), "at least one"),
    ("empty leaf", "tour", setting("proof", "tour", "nodes", [{"leaf": []}]), "node 0: .*worth 0"),
    ("up not proved", "tour", tour_nodes(branch(1, 2), "good", {"leaf": []}), "node 2: .*worth"),
    ("down not proved", "tour", tour_nodes(branch(1, 2), {"leaf": []}, "good"), "node 1: .*worth"),
    (
        "bounds of another node",
        "tour",
        tour_nodes(branch(1, 2), {"leaf": []}, branch(3, 4, ("x", 0, 2), -1), {"leaf": []}, "good"),
        "node 1: .*worth",
    ),
    ("child twice", "tour", tour_nodes(branch(1, 1), "good"), "reached twice"),
    ("child is its parent", "tour", tour_nodes(branch(0, 1), "good"), "must come later"),
    ("child from the end", "tour", tour_nodes(branch(-1, 1), "good", "good"), "must come later"),
    ("no such child", "tour", tour_nodes(branch(1, 2), "good"), "must come later"),
    ("node never reached", "tour", tour_nodes("good", "good"), "node 1 is never reached"),
    ("fractional branching", "tour", tour_nodes(branch(1, 2, at=0.5), "good", "good"), "whole number"),
    ("no variable", "tour", tour_nodes(branch(1, 2, ("x", 1, 0)), "good", "good"), "no variable"),
    ("loop of an edge", "tour", tour_nodes(branch(1, 2, ("x", 1, 1)), "good", "good"), "no variable"),
    ("far node", "tour", tour_nodes(branch(1, 2, ("x", 0, 7)), "good", "good"), "no variable"),
    ("two kinds of node", "tour", tour_nodes({"leaf": [], "fix": [], "then": 1}, "good"), "unknown field"),
    ("fix without then", "tour", tour_nodes({"fix": []}), "then is missing"),
    ("fix to itself", "tour", tour_nodes({"fix": [], "then": 0}), "must come later"),
    ("no node", "tour", tour_nodes([]), "expected an object"),
    ("row of a multiplier", "tour", tour_nodes({"leaf": [[10**6, 1]]}), "no row"),
    ("row from the end", "tour", tour_nodes({"leaf": [[-1, 1]]}), "at least 0"),
    ("fractional multiplier", "tour", tour_nodes({"leaf": [[0, 0.5]]}), "whole number"),
    ("negative multiplier", "tour", tour_nodes({"leaf": [[7, -(2**40)]]}), "multiplier"),
    # Rows of a tour of 7 nodes.
    ("unknown row", "tour", tour_row(["wish", 1]), "no row"),
    ("no row", "tour", tour_row(7), "no row"),
    ("degree", "tour", tour_row(["degree", 7]), "no row"),
    ("via without via points", "tour", tour_row(["via"]), "no row"),
    ("via of a closed tour", "closed tour", tour_row(["via"]), "no row"),
    ("empty set", "tour", tour_row(["cut", [[]]]), "different nodes"),
    ("no set", "tour", tour_row(["cut", []]), "comb with -1 teeth"),
    ("everything", "tour", tour_row(["cut", [list(range(7))]]), "everything"),
    ("repeated node", "tour", tour_row(["cut", [[1, 1]]]), "different nodes"),
    ("node beyond", "tour", tour_row(["cut", [[1, 7]]]), "different nodes"),
    ("node from the end", "tour", tour_row(["cut", [[1, -1]]]), "different nodes"),
    ("one tooth", "tour", tour_row(["cut", [[0, 1], [1, 2]]]), "1 teeth"),
    ("two teeth", "tour", tour_row(["cut", [[0, 1], [0, 2], [1, 3]]]), "2 teeth"),
    ("overlap of teeth", "tour", tour_row(["cut", [[0, 1, 2], [0, 3], [1, 4], [2, 4]]]), "teeth overlap"),
    (
        "tooth off the handle",
        "tour",
        tour_row(["cut", [[0, 1], [0, 2], [1, 3], [4, 5]]]),
        "meet the handle",
    ),
    (
        "tooth in the handle",
        "tour",
        tour_row(["cut", [[0, 1, 2], [0], [1, 4], [2, 5]]]),
        "meet the handle",
    ),
    # Tours.
    ("no rows for many nodes", "tour", small_tour, "needs rows and nodes"),
    ("longer than it is", "small tour", longer_small_tour, "the tour has length"),
    ("contour left out", "small tour", left_out, "leaves contours out"),
    ("contour twice", "small tour", twice, "listed twice"),
    ("unknown contour", "tour", setting("proof", "tour", "contours", 0, "c99"), "no contour"),
    ("unknown head", "tour", setting("proof", "tour", "head", 1), "head 1"),
    ("head from the end", "tour", setting("proof", "tour", "head", -1), "head"),
    ("via not asked", "tour", setting("proof", "tour", "via", True), "via"),
    ("weak one_tree", "tour", one_tree, "one_tree"),
    ("one_tree beside rows", "tour", one_tree_beside_rows, "not beside"),
    ("claims infeasible", "tour", lambda c, d: c.update(bound=None, plan=None), "claimed"),
    # Cells.
    ("tour missing", "split", fewer_tours, "cell of .*below"),
    ("ties missing", "split with ties", setting("proof", "ties", []), "ties: expected"),
    ("overlap allowed", "split", setting("rules", "non_overlap", None), "allow overlap"),
    ("feasible after all", "split", lambda c, d: c.update(bound=None, plan=None), "not infeasible"),
    ("gap that splits allow", "split, infeasible", setting("rules", "empty_heads", True), "not infeasible"),
    (
        "ties: child twice",
        "split with ties",
        tie_root(left=1, right=1),
        "twice",
    ),
    ("ties: parent", "split with ties", tie_root(left=0), "come later"),
    (
        "ties: unknown",
        "split with ties",
        tie_root(branch="x"),
        "no undecided",
    ),
    ("ties: leaf false", "split with ties", tie({"leaf": False}), "leaf must be true"),
    ("ties: never reached", "split with ties", one_more_tie_node, "never reached"),
    ("ties: no tree", "split with ties", tie(), "no node 0"),
    # Rows of two heads, 4 contours.
    ("contour beyond", "two heads", row(["degree", 0, 4]), "no contour"),
    ("home as a contour", "two heads", row(["degree", 0, -1]), "no contour"),
    ("head beyond", "two heads", row(["home", 2]), "no head"),
    ("arguments", "two heads", row(["home"]), "expected head"),
    ("no row of two heads", "two heads", row(["trust", 0]), "no row"),
    ("empty row", "two heads", row([]), "no row"),
    ("contour outside its set", "two heads", row(["connect", 0, 0, [[1, 2]]]), "with the contour in it"),
    ("home in a set", "two heads", row(["connect", 0, 0, [[0, -1]]]), "different nodes"),
    ("comb as connect", "two heads", row(["connect", 0, 0, [[0, 1], [0, 2]]]), "1 teeth"),
    ("visit elsewhere", "two heads", row(["visit", 0, 0, 1, 2]), "at contour i"),
    ("visit of a home", "two heads", row(["visit", 0, 0, -1, 0]), "no contour"),
    ("order with overlap", "two heads", row(["order", 0, 1]), "overlap"),
    ("via not asked of heads", "two heads", row(["via", 0, 1]), "via"),
    ("used with no rest", "two heads", row(["used", 0, 1]), "rest"),
    ("balance without limit", "two heads", row(["balance", 1]), "limit"),
    ("imbalance not priced", "two heads", row(["imbalance", 1]), "price"),
    ("makespan of another objective", "two heads, travel", row(["makespan", 0]), "objective"),
    ("sign", "two heads, travel", row(["balance", 2]), "no sign"),
    ("rest not allowed", "two heads", two_nodes(("e", 0)), "no whole variable"),
    (
        "branching on makespan",
        "two heads",
        two_nodes(("m",)),
        "no whole variable",
    ),
    ("not infeasible", "two heads", lambda c, d: c.update(bound=None, plan=None), "worth|reduced cost"),
    (
        "a looser limit is not infeasible",
        "two heads, infeasible",
        setting("rules", "balance", 1000),
        "worth",
    ),
    ("plan of the infeasible", "two heads, infeasible", setting("plan", [[], []]), "plan"),
]


def visits(problem: Any, *tours: str) -> list[list[list[Any]]]:
    """Tours by letters: contours from left to right are a, b, c ..."""
    order = sorted(range(len(problem.ids)), key=lambda c: problem.xs[c])
    return [[[problem.ids[order[ord(letter) - 97]], 0] for letter in tour] for tour in tours]


def plan(*tours: str) -> Callable[[Any], Any]:
    return lambda problem: visits(problem, *tours)


def changed(change: Callable[[Any], Any], *tours: str) -> Callable[[Any], Any]:
    def make(problem: Any) -> Any:
        made = json.loads(json.dumps(visits(problem, *tours)))
        change(made)
        return made

    return make


REST = {"empty_heads": True}
OVERLAP = {"non_overlap": None}

PLANS: list[tuple[str, str, Callable[[Any], Any], Document, str | None]] = [
    ("good", "split", plan("ab", "edc"), {}, None),
    ("overlap allowed", "split", plan("ac", "edb"), OVERLAP, None),
    ("rest allowed", "split", plan("abcde", ""), REST, None),
    ("overlap", "split", plan("ac", "edb"), {}, "overlap"),
    ("small gap", "split", plan("ab", "edc"), {"non_overlap": 10_000}, "overlap"),
    ("rest", "split", plan("abcde", ""), {}, "no work"),
    ("via", "split", plan("ba", "cde"), {"via_points": True}, "leftmost"),
    ("via of the right head", "split", plan("ab", "dce"), {"via_points": True}, "leftmost"),
    ("via kept", "split", plan("ab", "ced"), {"via_points": True}, None),
    ("balance", "split", plan("a", "bcde"), {"balance": 0.5}, "balanced"),
    ("balance kept", "split", plan("a", "bcde"), {"balance": 1000}, None),
    ("contour missing", "split", plan("ab", "cd"), {}, "each contour once"),
    ("contour twice", "split", plan("aba", "cde"), {}, "each contour once"),
    ("one tour", "split", plan("abcde"), {}, "2 entries"),
    ("entry point", "split", changed(lambda p: p[0][0].__setitem__(1, 1), "ab", "cde"), {}, "entry point"),
    (
        "entry point from the end",
        "split",
        changed(lambda p: p[0][0].__setitem__(1, -1), "ab", "cde"),
        {},
        "at least",
    ),
    ("curves", "split", plan("ab", "edc"), {"neighbours_only": True}, "leave it out"),
    ("clear rapids", "split", plan("ab", "edc"), {"clear_rapids": True}, "leave it out"),
    ("unknown contour", "split", changed(lambda p: p[0][0].__setitem__(0, "x"), "ab", "cde"), {}, "no contour"),
    ("no visit", "split", changed(lambda p: p[0].__setitem__(0, "c0"), "ab", "cde"), {}, "visit"),
]
