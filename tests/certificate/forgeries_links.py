"""Forged proofs of plans with links. In the row nodes 0-3, 4-7, 8-11 are corners of squares, 12 is the home."""

from typing import Any

from certificate.forgeries import Document, Forge, branch, instance_setting, setting
from cutgap.instances import Link, Plan, Visit


def row(*name: object) -> Forge:
    """One more row."""
    return lambda certificate, document: certificate["proof"]["rows"].append(list(name))


def blocked(*entry: object) -> Forge:
    """One more blocked link."""
    return lambda certificate, document: certificate["proof"]["blocked"].append(list(entry))


def two_nodes(*variable: object, at: int = 0) -> Forge:
    return setting("proof", "nodes", [branch(1, 2, variable, at), {"leaf": []}, {"leaf": []}])


def negative(certificate: Document, document: Document) -> None:
    names = certificate["proof"]["rows"]
    index = next(k for k, name in enumerate(names) if name[0] != "home")
    certificate["proof"]["nodes"] = [{"leaf": [[index, -1]]}]


def without(key: str) -> Forge:
    return lambda certificate, document: certificate["proof"].pop(key)


def no_blocked(certificate: Document, document: Document) -> None:
    certificate["proof"]["blocked"] = certificate["proof"]["blocked"][:-1]


def closed_home(certificate: Document, document: Document) -> None:
    document["heads"][0]["home"] = None


TWICE = [branch(1, 1, ("d", 0, 1)), {"leaf": []}]
ODD = ["s", 1, 4]

LINKS: list[tuple[str, str, Forge, str]] = [
    ("higher bound", "row", lambda c, d: c.update(bound=c["bound"] + 10**7, plan=None), "worth"),
    ("higher makespan", "row, makespan", lambda c, d: c.update(bound=c["bound"] + 10**7, plan=None), "worth"),
    ("claims infeasible", "row", lambda c, d: c.update(bound=None, plan=None), "worth"),
    ("more pierces", "rings", setting("rules", "pierces", 3), "worth|no row|negative"),
    ("not blocked", "rings", no_blocked, "worth"),
    ("without links", "row", lambda c, d: c["rules"].update(links=False, pierces=None), "without links"),
    ("another kind", "row", setting("proof", {"kind": "gtsp", "length": 0}), "with links"),
    ("via points", "row", setting("rules", "via_points", True), "no rule but"),
    ("weighted", "row", setting("rules", "objective", "weighted"), "travel or makespan"),
    ("no pierces", "row", setting("rules", "pierces", 0), "at least 1"),
    ("no rows", "row", without("rows"), "rows is missing"),
    ("no nodes", "row", setting("proof", "nodes", []), "at least one"),
    ("unknown row", "row", row("cut", [[0]]), "no row"),
    ("no parts", "row", row("partition", []), "no row"),
    ("parts overlap", "row", row("partition", [[0, 1], [1]]), "overlap"),
    ("part of the home", "row", row("partition", [[3]]), "below 3"),
    ("empty part", "row", row("partition", [[0], []]), "different numbers"),
    ("repeated contour", "row", row("partition", [[0, 0]]), "different numbers"),
    ("parity of nothing", "row", row("parity", [1], []), "odd number"),
    ("even parity", "row", row("parity", [1], [ODD, ["s", 1, 5]]), "odd number"),
    ("one edge thrice", "row", row("parity", [1], [ODD, ODD, ODD]), "odd number"),
    ("link and its rapid", "row, makespan", row("parity", [1], [ODD, ["r", 1, 4], ["s", 1, 5]]), "odd number"),
    ("edge inside", "row", row("parity", [1, 4], [ODD]), "out of the set"),
    ("edge outside", "row", row("parity", [2], [ODD]), "out of the set"),
    ("edge of one contour", "row", row("parity", [1], [["s", 1, 2]]), "within a contour"),
    ("edge the other way", "row", row("parity", [1], [["s", 4, 1]]), "no link or rapid"),
    ("link of the home", "row", row("parity", [1], [["s", 1, 12]]), "no link or rapid"),
    ("node beyond", "row", row("parity", [13], [ODD]), "below 13"),
    ("rapid beyond", "row", row("parity", [1], [["r", 1, 13]]), "no link or rapid"),
    ("group of the home", "row", row("group", [0, 3], []), "below 3"),
    ("circle of joints", "row", row("group", [0, 1, 2], [[0, 1], [1, 2], [0, 2]]), "circle"),
    ("two joints of two", "row", row("group", [0, 1], [[0, 1], [0, 1, 1, 4]]), "circle"),
    ("joint outside", "row", row("group", [0, 1], [[1, 2]]), "other contours"),
    ("joint backwards", "row", row("group", [0, 1], [[1, 0]]), "other contours"),
    ("joint of one node", "row", row("group", [0, 1], [[0, 1, 1]]), "two contours"),
    ("link of another joint", "row", row("group", [0, 1, 2], [[0, 1, 5, 8]]), "other contours"),
    ("once backwards", "row", row("once", 1, 0), "no row"),
    ("once beyond", "row", row("once", 0, 4), "no row"),
    ("bundle of one place", "row", row("bundle", 1, 1, []), "no row"),
    ("bundle beyond", "row", row("bundle", 0, 4, []), "no row"),
    ("node of another place", "row", row("bundle", 0, 1, [4]), "another place"),
    ("node of the wrong side", "row", row("triangle", 0, 1, 2, [0], [8]), "another place"),
    ("triangle of two", "row", row("triangle", 0, 1, 1, [], []), "three places"),
    ("triangle beyond", "row", row("triangle", 0, 1, 4, [], []), "three places"),
    ("triples that overlap", "row", row("rank", [[0], [1]], [[0, 1, 2], [0, 1, 3]]), "share two"),
    ("triple twice", "row", row("rank", [[0], [1]], [[0, 1, 2], [0, 1, 2]]), "share two"),
    ("triple backwards", "row", row("rank", [[0], [1]], [[2, 1, 0]]), "ascending"),
    ("ranks of overlapping parts", "row", row("rank", [[0], [0]], []), "overlap"),
    ("negative multiplier", "row", negative, "negative multiplier"),
    ("row beyond", "row", setting("proof", "nodes", [{"leaf": [[10**6, 1]]}]), "no row"),
    ("row from the end", "row", setting("proof", "nodes", [{"leaf": [[-1, 1]]}]), "no row"),
    ("nothing proved", "row", setting("proof", "nodes", [{"leaf": []}]), "worth"),
    ("branch without proof", "row", two_nodes("d", 0, 1), "worth"),
    ("branch elsewhere", "row", two_nodes("d", 0, 1, at=1), "expected 0"),
    ("double of nothing", "row", two_nodes("d", 0, 4), "no link or rapid"),
    ("double the other way", "row", two_nodes("d", 1, 0), "no link or rapid"),
    (
        "one child twice",
        "row",
        setting("proof", "nodes", [branch(1, 1, ("d", 0, 1)), {"leaf": []}]),
        "twice|worth",
    ),
    ("its own child", "row", setting("proof", "nodes", [branch(0, 0, ("d", 0, 1))]), "come later"),
    ("blocked in the open", "row", blocked(1, 4, 500_000), "not deep"),
    ("blocked on the edge", "row", blocked(0, 5, 0), "not deep"),
    ("blocked backwards", "row", blocked(4, 1, 500_000), "no link"),
    ("blocked beyond its end", "row", blocked(1, 6, 10**6 + 1), "no link"),
    ("blocked way home", "row", blocked(1, 12, 500_000), "no link"),
    ("another instance", "row", instance_setting("machine", "v_cut", 20.0), "another instance"),
]


def visited(*visits: list[Any], links: list[list[Any]] | None = None) -> Document:
    return {"tours": [list(visits)], "links": links or []}


ONE = [["a", 1, "b", 0, 2], ["b", 1, "c", 0, 2]]
ALONG = (Link(0, 1, 1, 0), Link(1, 1, 2, 0))

PLANS: list[tuple[str, Document, Plan, str | None]] = [
    ("doubled tree", visited(["a", 0], links=ONE), Plan(((Visit(0, 0),),), ALONG), None),
    (
        "two strokes",
        visited(["a", 0], ["c", 3], links=ONE[:1]),
        Plan(((Visit(0, 0), Visit(2, 3)),), ALONG[:1]),
        None,
    ),
    (
        "open stroke",
        visited(["a", 1], links=[["a", 1, "b", 0, 1], ["b", 0, "c", 0, 1]]),
        Plan(((Visit(0, 1),),), (Link(0, 1, 1, 0, 1), Link(1, 0, 2, 0, 1))),
        None,
    ),
    (
        "stroke from the wrong end",
        visited(["a", 0], links=[["a", 1, "b", 0, 1], ["b", 0, "c", 0, 1]]),
        Plan(((),)),
        "odd number",
    ),
    (
        "odd nodes",
        visited(["a", 1], links=[["a", 1, "b", 0, 1], ["b", 1, "c", 0, 1]]),
        Plan(((),)),
        "odd number",
    ),
    ("not cut", visited(["a", 0], links=ONE[:1]), Plan(((),)), "each contour once"),
    ("cut twice", visited(["a", 0], ["b", 0], links=ONE), Plan(((),)), "each contour once"),
    ("three pierces", visited(["a", 0], ["b", 0], ["c", 0]), Plan(((),)), "too many pierces"),
    ("through a part", visited(["a", 0], links=[["a", 0, "b", 2, 2], ONE[1]]), Plan(((),)), "not surely clear"),
    ("link twice", visited(["a", 0], links=[*ONE, ["b", 0, "a", 1, 2]]), Plan(((),)), "same nodes"),
    ("three passes", visited(["a", 0], links=[["a", 1, "b", 0, 3], ONE[1]]), Plan(((),)), "once or twice"),
    ("own contour", visited(["a", 0], links=[["a", 1, "a", 0, 2], *ONE]), Plan(((),)), "own contour"),
    ("no such contour", visited(["x", 0], links=ONE), Plan(((),)), "no contour"),
    ("no such entry", visited(["a", 4], links=ONE), Plan(((),)), "no entry point"),
    ("tours alone", {"tours": [[["a", 0]]]}, Plan(((),)), "links is missing"),
]
