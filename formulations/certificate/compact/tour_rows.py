"""Rows that keep a head's way in one piece, by tour formulation.

    position h i j          p[h,j] - p[h,i] - n y[h,i,j] >= 1 - n
    lifted-position h i j   p[h,j] - p[h,i] - n y[h,i,j] - (n - 2) y[h,j,i] >= 1 - n
    lifted-first h i        p[h,i] + y[h,-1,i] >= 2;        one head: p[i] + y[-1,i] - (n - 2) y[i,-1] >= 2
    lifted-last h i         one head: -p[i] - (n - 2) y[-1,i] + y[i,-1] >= 1 - n
    flow-keep h j           sum_i f[h,i,j] - sum_i f[h,j,i] - z[h,j] = 0
    flow-most h i j         (n - 1) y[h,i,j] - f[h,i,j] >= 0,    from the depot n y[h,-1,j] - f[h,-1,j] >= 0
    load-keep h j           as flow-keep, with f to the depot
    space-keep h j          sum_i g[h,j,i] - sum_i g[h,i,j] - z[h,j] = 0
    load-and-space h i j    f[h,i,j] + g[h,i,j] - n y[h,i,j] = 0;       one head: without f[i,-1] and g[-1,j]
    to-sink h k             sum_i unit[h,k,i,k] - sum_i unit[h,k,k,i] - z[h,k] = 0
    through h k j           sum_i unit[h,k,i,j] - sum_i unit[h,k,j,i] = 0
    flow-within h k i j     y[h,i,j] - unit[h,k,i,j] >= 0
    step h t i              sum_j w[h,t-1,j,i] - sum_j w[h,t,i,j] = 0
    timed h i j             sum_t w[h,t,i,j] - y[h,i,j] = 0
    enter h S k             sum of y[h,i,j], i outside S, j in S - z[h,k] >= 0;      one head, no k: >= 1

Why they hold, with the values that ``terms`` gives to a plan:

- position, lifted-position: the difference is at least 1 - n, it is 1 along y[h,i,j] and -1 along y[h,j,i].
- lifted-first, from two contours on: the first has position 1 and no other one has, contours of other heads
  included. On one head the last is not the first and has position n, which takes off n - 2. lifted-last is the
  same, read from the end.
- flows: a head that comes to j with m contours still to cut, j included, leaves with m - 1. It has none to cut
  on its way back, and at most n - 1 where it is not on its way from the depot. g = n - f grows likewise; a
  single head has all n before it when it begins, so g = 0.
- units: the way from the depot to k enters and leaves what is between, and ends at k.
- step, timed: the contour at position t is come to from position t - 1 (the depot for t = 1), and each y is at
  one position. A single head goes back after position n and no earlier.
- enter: when k in S is cut, the way from the depot to it enters S.
"""

from cutgap.formulations.certificate.compact.terms import (
    DEPOT,
    CompactRow,
    Families,
    Name,
    Setting,
    Terms,
    difference,
)
from cutgap.formulations.certificate.reading import require, show

FORMULATIONS = (
    "assignment",
    "mtz",
    "lifted-mtz",
    "single-commodity",
    "two-commodity",
    "multi-commodity",
    "time-indexed",
    "dfj",
    "dfj-rounds",
)


def tour_families(setting: Setting, formulation: str) -> Families:
    """Return the families of a formulation, and positions where a rule on order needs them."""
    require(formulation in FORMULATIONS, f"formulation: no {show(formulation)}")
    families: Families = {}
    if formulation == "mtz" or setting.problem.precedence or setting.rules.clear_rapids:
        families["position"] = ("head contour contour", position)
    if formulation == "lifted-mtz" and setting.count >= 2:
        families |= {
            "lifted-position": ("head contour contour", lifted_position),
            "lifted-first": ("head contour", lifted_first),
        }
        if setting.alone:
            families["lifted-last"] = ("head contour", lifted_last)
    if formulation == "single-commodity":
        families |= {"flow-keep": ("head contour", flow_keep), "flow-most": ("head place contour", flow_most)}
    if formulation == "two-commodity":
        families |= {
            "load-keep": ("head contour", load_keep),
            "space-keep": ("head contour", space_keep),
            "load-and-space": ("head place place", load_and_space),
        }
    if formulation == "multi-commodity":
        families |= {
            "to-sink": ("head contour", to_sink),
            "through": ("head contour contour", through),
            "flow-within": ("head contour place contour", flow_within),
        }
    if formulation == "time-indexed":
        families |= {"step": ("head position contour", step), "timed": ("head place place", timed)}
    if formulation in ("dfj", "dfj-rounds"):
        families["enter"] = ("head set", enter) if setting.alone else ("head set contour", enter)
    return families


def position(setting: Setting, h: int, i: int, j: int) -> CompactRow:
    """Positions grow along the way."""
    _require_different(i, j)
    n = setting.count
    return CompactRow(False, 1 - n, [*difference(h, i, j), (-n, ("y", h, i, j))])


def lifted_position(setting: Setting, h: int, i: int, j: int) -> CompactRow:
    """Positions grow by one along the way."""
    row = position(setting, h, i, j)
    return CompactRow(False, row.rhs, [*row.terms, (2 - setting.count, ("y", h, j, i))])


def lifted_first(setting: Setting, h: int, i: int) -> CompactRow:
    """Only the first contour has position 1, and the last of a single head has position n."""
    terms: Terms = [(1, ("p", h, i)), (1, ("y", h, DEPOT, i))]
    if setting.alone:
        terms.append((2 - setting.count, ("y", h, i, DEPOT)))
    return CompactRow(False, 2, terms)


def lifted_last(setting: Setting, h: int, i: int) -> CompactRow:
    """Only the last contour has position n, and the first has position 1."""
    n = setting.count
    return CompactRow(False, 1 - n, [(-1, ("p", h, i)), (2 - n, ("y", h, DEPOT, i)), (1, ("y", h, i, DEPOT))])


def flow_keep(setting: Setting, h: int, j: int) -> CompactRow:
    """A contour that is cut is one less to be cut; nothing flows back to the depot."""
    contours = _others(setting, j)
    into: Terms = [(1, ("f", h, i, j)) for i in [DEPOT, *contours]]
    return CompactRow(True, 0, [*into, *((-1, ("f", h, j, i)) for i in contours), (-1, ("z", h, j))])


def flow_most(setting: Setting, h: int, i: int, j: int) -> CompactRow:
    """All contours are to be cut at first, later one less at least."""
    _require_different(i, j)
    most = setting.count if i == DEPOT else setting.count - 1
    return CompactRow(False, 0, [(most, ("y", h, i, j)), (-1, ("f", h, i, j))])


def load_keep(setting: Setting, h: int, j: int) -> CompactRow:
    """A contour that is cut is one less to be cut."""
    return CompactRow(True, 0, _grows(setting, "f", h, j, -1))


def space_keep(setting: Setting, h: int, j: int) -> CompactRow:
    """A contour that is cut makes room for one."""
    return CompactRow(True, 0, _grows(setting, "g", h, j, 1))


def _grows(setting: Setting, kind: str, h: int, j: int, sign: int) -> Terms:
    """Return sign * (what leaves j - what comes to it) - z[h,j]."""
    terms: Terms = [(-1, ("z", h, j))]
    for i in [DEPOT, *_others(setting, j)]:
        for factor, name in ((sign, (kind, h, j, i)), (-sign, (kind, h, i, j))):
            if not _is_empty(setting, name):
                terms.append((factor, name))
    return terms


def _is_empty(setting: Setting, name: Name) -> bool:
    """Whether a single head has nothing left on its way back, or no room yet on its way out."""
    kind, _, i, j = name
    return setting.alone and (j if kind == "f" else i) == DEPOT


def load_and_space(setting: Setting, h: int, i: int, j: int) -> CompactRow:
    """What is to be cut and the room add up to n along the way."""
    _require_different(i, j)
    flows = [name for name in (("f", h, i, j), ("g", h, i, j)) if not _is_empty(setting, name)]
    return CompactRow(True, 0, [*((1, name) for name in flows), (-setting.count, ("y", h, i, j))])


def to_sink(setting: Setting, h: int, k: int) -> CompactRow:
    """A unit comes to each contour that is cut."""
    return CompactRow(True, 0, [*_units(setting, h, k, k), (-1, ("z", h, k))])


def through(setting: Setting, h: int, k: int, j: int) -> CompactRow:
    """It stays nowhere else."""
    _require_different(k, j)
    return CompactRow(True, 0, _units(setting, h, k, j))


def _units(setting: Setting, h: int, k: int, j: int) -> Terms:
    """Return what of the unit for k comes to j - what leaves it."""
    contours = _others(setting, j)
    into: Terms = [(1, ("unit", h, k, i, j)) for i in [DEPOT, *contours]]
    return [*into, *((-1, ("unit", h, k, j, i)) for i in contours)]


def flow_within(setting: Setting, h: int, k: int, i: int, j: int) -> CompactRow:
    """The unit goes where the head goes."""
    _require_different(i, j)
    return CompactRow(False, 0, [(1, ("y", h, i, j)), (-1, ("unit", h, k, i, j))])


def step(setting: Setting, h: int, t: int, i: int) -> CompactRow:
    """What comes to a contour at position t leaves it at position t."""
    before = [DEPOT] if t == 1 else _others(setting, i)
    after = [] if t == setting.count else _others(setting, i)
    if t == setting.count or not setting.alone:
        after = [DEPOT, *after]
    into: Terms = [(1, ("w", h, t - 1, j, i)) for j in before]
    return CompactRow(True, 0, [*into, *((-1, ("w", h, t, i, j)) for j in after)])


def timed(setting: Setting, h: int, i: int, j: int) -> CompactRow:
    """The head goes from i to j at one position."""
    _require_different(i, j)
    n = setting.count
    if i == DEPOT:
        times = range(1)
    elif j == DEPOT:
        times = range(n if setting.alone else 1, n + 1)
    else:
        times = range(1, n)
    return CompactRow(True, 0, [*((1, ("w", h, t, i, j)) for t in times), (-1, ("y", h, i, j))])


def enter(setting: Setting, h: int, members: list[int], k: int | None = None) -> CompactRow:
    """A set of contours is entered when one of it is cut, and a single head cuts all."""
    inside = set(members)
    outside = [DEPOT, *(i for i in range(setting.count) if i not in inside)]
    setting.budget.spend(len(members) * len(outside))
    entering: Terms = [(1, ("y", h, i, j)) for i in outside for j in members]
    if k is None:
        return CompactRow(False, 1, entering)
    require(k in inside, f"enter: contour {k} is not in the set")
    return CompactRow(False, 0, [*entering, (-1, ("z", h, k))])


def _others(setting: Setting, j: int) -> list[int]:
    setting.budget.spend(setting.count)
    return [i for i in range(setting.count) if i != j]


def _require_different(i: int, j: int) -> None:
    require(i != j, f"expected two different places, got {i} twice")
