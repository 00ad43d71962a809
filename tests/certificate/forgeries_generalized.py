"""Forged proofs of tours through one entry point of each contour: nodes 0 and 1, 2 and 3, 4 and 5, home 6."""

from certificate.forgeries import Document, Forge, asymmetric, branch, setting


def row(*name: object) -> Forge:
    """One more row."""
    return lambda certificate, document: certificate["proof"]["rows"].append(list(name))


def two_nodes(*variable: object) -> Forge:
    return setting("proof", "nodes", [branch(1, 2, variable)])


def longer(certificate: Document, document: Document) -> None:
    certificate["proof"]["length"] += 100
    certificate["bound"] += 100


def no_rows(certificate: Document, document: Document) -> None:
    del certificate["proof"]["rows"], certificate["proof"]["nodes"]


HANDLE = [0, 2, 4]
TEETH = [[0, 1], [2, 3], [4, 5]]

GENERALIZED: list[tuple[str, Forge, str]] = [
    ("asymmetric", asymmetric, "gtsp: takes symmetric"),
    ("higher bound", lambda c, d: c.update(bound=c["bound"] + 1), "less than the claimed"),
    ("claims infeasible", lambda c, d: c.update(bound=None, plan=None), "claimed"),
    ("longer", longer, "worth"),
    ("no rows", no_rows, "needs rows"),
    ("no nodes", setting("proof", "nodes", None), "nodes"),
    ("rows of a tour", row("cut", [[0, 1]]), "no row"),
    ("contour beyond", row("contour", 4), "no row"),
    ("contour from the end", row("contour", -1), "no row"),
    ("degree beyond", row("degree", 7), "no row"),
    ("empty border", row("border", [], 0, 1), "different nodes"),
    ("repeated node", row("border", [1, 1], 0, 1), "different nodes"),
    ("node beyond", row("border", [1, 7], 0, 1), "different nodes"),
    ("border of no contour", row("border", [0, 2], 4, 1), "no contour"),
    ("border from the end", row("border", [0, 2], -1, 1), "at least 0"),
    ("border of a half", row("border", [0, 2], 0.5, 1), "whole number"),
    ("border without end", row("border", [0, 2], 0), "no row"),
    ("no whole inside", row("border", [0, 2], None, 3), "no whole contour"),
    ("no whole outside", row("border", [0, 2, 4, 6], 0, None), "no whole contour"),
    ("one tooth", row("comb", [HANDLE, TEETH[0]], [[0, 0]]), "1 teeth"),
    ("no tooth", row("comb", [HANDLE], []), "no row"),
    ("teeth overlap", row("comb", [HANDLE, [0, 1], [2, 1], [4, 5]], [[0, 0], [1, 1], [2, 2]]), "overlap"),
    ("tooth in the handle", row("comb", [HANDLE, [0], [2, 3], [4, 5]], [[0, 0], [1, 1], [2, 2]]), "meet"),
    ("pair missing", row("comb", [HANDLE, *TEETH], [[0, 0], [1, 1]]), "3 entries"),
    ("pair of three", row("comb", [HANDLE, *TEETH], [[0, 0, 0], [1, 1], [2, 2]]), "2 entries"),
    ("no whole in a tooth", row("comb", [HANDLE, *TEETH], [[None, 0], [1, 1], [2, 2]]), "no whole contour"),
    ("no whole off the handle", row("comb", [HANDLE, *TEETH], [[0, None], [1, 1], [2, 2]]), "no whole contour"),
    ("node beyond in branching", two_nodes("y", 7), "no variable"),
    ("edge the other way", two_nodes("x", 1, 0), "no variable"),
    ("no such variable", two_nodes("z", 0), "no variable"),
]
