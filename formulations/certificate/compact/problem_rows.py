"""Rows on who cuts what, when and at what cost, whatever keeps a head's way in one piece.

    cut-once i           sum_h z[h,i] = 1
    continuity h u       q[h,u] - out[h,u] = 0
    leave-once h         -sum_j y[h,-1,j] >= -1;   no head may rest: sum_j y[h,-1,j] = 1
    makespan h           makespan - T[h] >= 0
    imbalance h o        imbalance - T[h] + T[o] >= -E
    balance h o          T[o] - T[h] >= -floor(balance * scale * v_jump) - E
    apart u v            -q[0,u] - q[1,v] >= -1                             x_v - x_u < F
    via h u v            -first[h,u] - q[h,v] >= -1                         x_v < x_u
    one-go h part        -sum of y[h,i,j], i in the part, j in another or -1  >= -1
    precedence h i j     p[h,j] - p[h,i] - n z[h,i] - n z[h,j] >= 1 - 2 n;  one head: p[j] - p[i] >= 1
    clear h u v k        p[h,k] - p[h,C(u)] - n x[h,u,v] - n z[h,k] >= 1 - 2 n;  one head: no z and 1 - n

E = 2 n + 1: a head has at most n + 1 legs and n works, each less than 1 above its floor. Why the last ones
hold: p is between 1 and n, so p[h,j] - p[h,i] >= 1 - n always. That is all that ``precedence`` says unless head
h cuts both, and all that ``clear`` says unless it goes from u to v and cuts k. Then k, which that rapid
crosses, is cut after C(u): if it were not, it would be cut when the rapid begins.
"""

from math import floor

from cutgap.formulations.certificate.compact.terms import (
    DEPOT,
    CompactRow,
    Families,
    Setting,
    Terms,
    difference,
)
from cutgap.formulations.certificate.reading import require
from cutgap.formulations.certificate.rules import may_rest


def problem_families(setting: Setting) -> Families:
    """Return the families that the rules ask for."""
    rules, alone = setting.rules, setting.alone
    families: Families = {
        "cut-once": ("contour", cut_once),
        "continuity": ("head node", continuity),
        "leave-once": ("head", leave_once),
    }
    if rules.objective == "makespan":
        families["makespan"] = ("head", makespan)
    if rules.objective == "weighted" and not alone:
        families["imbalance"] = ("head head", imbalance)
    if rules.balance is not None and not alone:
        families["balance"] = ("head head", balance)
    if rules.non_overlap is not None and not alone:
        families["apart"] = ("node node", apart)
    if rules.via_points:
        families["via"] = ("head node node", via)
    if rules.parts_in_one_go:
        families["one-go"] = ("head part", one_go)
    if setting.problem.precedence:
        families["precedence"] = ("head contour contour", precedence)
    if rules.clear_rapids:
        families["clear"] = ("head node node contour", clear)
    return families


def cut_once(setting: Setting, i: int) -> CompactRow:
    """Some head cuts each contour."""
    return CompactRow(True, 1, [(1, ("z", h, i)) for h in setting.heads])


def continuity(setting: Setting, h: int, u: int) -> CompactRow:
    """A head leaves an entry point as often as it comes to it."""
    return CompactRow(True, 0, [(1, ("q", h, u)), (-1, ("out", h, u))])


def leave_once(setting: Setting, h: int) -> CompactRow:
    """A head begins once, or may rest."""
    rests = may_rest(setting.problem, setting.rules)
    sign = -1 if rests else 1
    return CompactRow(not rests, sign, [(sign, ("y", h, DEPOT, j)) for j in range(setting.count)])


def makespan(setting: Setting, h: int) -> CompactRow:
    """Floors are not above a head's time."""
    return CompactRow(False, 0, [(1, ("makespan",)), (-1, ("T", h))])


def imbalance(setting: Setting, h: int, other: int) -> CompactRow:
    """The imbalance is at least T[h] - T[other], of true times."""
    return CompactRow(False, -slack(setting), [(1, ("imbalance",)), *_later(h, other)])


def balance(setting: Setting, h: int, other: int) -> CompactRow:
    """T[h] - T[other], of true times, is at most the limit."""
    limit = (setting.rules.balance or 0) * setting.scale * setting.problem.v_jump
    return CompactRow(False, -floor(limit) - slack(setting), _later(h, other))


def slack(setting: Setting) -> int:
    """Return E."""
    return 2 * setting.count + 1


def _later(h: int, other: int) -> Terms:
    require(h != other, "expected two different heads")
    return [(-1, ("T", h)), (1, ("T", other))]


def apart(setting: Setting, u: int, v: int) -> CompactRow:
    """Head 0 stays to the left of head 1, by the least gap."""
    gap = setting.problem.xs[v] - setting.problem.xs[u]
    _require_different(setting, u, v)
    require(gap < (setting.rules.non_overlap or 0), f"apart: node {v} is far enough to the right of node {u}")
    return CompactRow(False, -1, [(-1, ("q", 0, u)), (-1, ("q", 1, v))])


def via(setting: Setting, h: int, u: int, v: int) -> CompactRow:
    """A head begins with a leftmost one of its entry points."""
    _require_different(setting, u, v)
    require(setting.problem.xs[v] < setting.problem.xs[u], f"via: node {v} is not left of node {u}")
    return CompactRow(False, -1, [(-1, ("first", h, u)), (-1, ("q", h, v))])


def one_go(setting: Setting, h: int, part: int) -> CompactRow:
    """A head leaves a part once at most, for another part or for good."""
    parts = setting.problem.parts
    require(parts.count(part) >= 2, f"one-go: part {part} is a single contour")
    inside = [i for i, each in enumerate(parts) if each == part]
    outside = [DEPOT, *(j for j, each in enumerate(parts) if each != part)]
    setting.budget.spend(len(inside) * len(outside))
    return CompactRow(False, -1, [(-1, ("y", h, i, j)) for i in inside for j in outside])


def precedence(setting: Setting, h: int, i: int, j: int) -> CompactRow:
    """If a head cuts both contours of a pair, the first comes first."""
    n = setting.count
    require((i, j) in setting.problem.precedence, f"precedence: contour {i} needs not come before {j}")
    if setting.alone:
        return CompactRow(False, 1, difference(h, i, j))
    return CompactRow(False, 1 - 2 * n, [*difference(h, i, j), (-n, ("z", h, i)), (-n, ("z", h, j))])


def clear(setting: Setting, h: int, u: int, v: int, k: int) -> CompactRow:
    """What a rapid crosses is cut after the contour that it leaves, if by the same head."""
    n, i = setting.count, setting.contour_of[u]
    _require_different(setting, u, v)
    require(k not in (i, setting.contour_of[v]), f"clear: the rapid goes from or to contour {k}")
    crossed = bool(setting.curves.crossed(u, v) >> k & 1) and not setting.is_barred(u, v)
    require(crossed, f"clear: no rapid from node {u} to {v} crosses contour {k}")
    terms: Terms = [*difference(h, i, k), (-n, ("x", h, u, v))]
    if setting.alone:
        return CompactRow(False, 1 - n, terms)
    return CompactRow(False, 1 - 2 * n, [*terms, (-n, ("z", h, k))])


def _require_different(setting: Setting, u: int, v: int) -> None:
    different = setting.contour_of[u] != setting.contour_of[v]
    require(different, f"nodes {u} and {v} are of one contour")
