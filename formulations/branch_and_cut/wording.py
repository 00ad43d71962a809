"""The rows of the models in words and symbols, by the tags of their docstrings, and their sides at a point."""

from collections.abc import Iterable, Mapping
from itertools import pairwise

from cutgap.formulations.branch_and_cut.generalized_cuts import GeneralizedCut, Point
from cutgap.formulations.branch_and_cut.separation import Cut, Support
from cutgap.instances.arrays import Floats, Ints
from cutgap.instances.scene import Inequality, Leg

Family = tuple[str, str, str]
"""Tag, symbols and words."""

TOUR_ROWS: Mapping[str, Family] = {
    "degree": ("(1) degree", "x(δ(v)) = 2", "Each node v is entered and left."),
    "via": ("(3) via", "x(0 : V) ≥ 1", "One of the via nodes V comes next to the home."),
}
GENERALIZED_ROWS: Mapping[str, Family] = {
    "contour": ("(1) contour", "y(C_h) = 1", "Each contour h is entered at one of its points."),
    "degree": ("(2) degree", "x(δ(v)) = 2 y_v", "A point v that is chosen is reached and left."),
}
TWO_HEADS_ROWS: Mapping[str, Family] = {
    "degree": ("(degree)", "xᵃ(δ(i)) = 2 zᵃ_i", "Head a reaches and leaves hole i if it cuts it."),
    "home": ("(home)", "xᵃ(δ(N)) = 2 e_a", "Head a leaves its home and comes back, if it has work."),
    "used": ("(used)", "e_a ≥ zᵃ_i", "A head that cuts a hole has work."),
    "makespan": ("(makespan)", "m ≥ T_a", "The part is done when the last head is."),
    "imbalance": ("(imbalance)", "d ≥ ±(T_0 - T_1)", "d is the imbalance of the heads."),
    "balance": ("(balance)", "±(T_0 - T_1) ≤ limit", "The imbalance keeps the limit asked for."),
    "order": ("(order)", "z_i ≥ z_j", "Ranges do not overlap: hole i goes left if hole j does."),
    "via": ("(via)", "xᵃ(N : left of i) ≥ zᵃ_i", "A head begins with the leftmost of its holes."),
}

SUBTOUR = "A tour comes into every set S of nodes and out again: it crosses the border of S at least twice."
BLOSSOM = "A tour crosses the border of H an even number of times, so not by the odd number of teeth alone."
COMB = "A tour that visits the handle H and an odd number of teeth crosses their borders so often at least."
CONNECT = "If the {head} head cuts hole i, its tour comes into S and out again."
PASSES = "Where a tour passes S and passes its outside, it crosses the border of S twice."
GENERALIZED_COMB = "As a comb; a tooth counts in full when the tour passes both its part in H and its rest."


def legs_of(tails: Ints, heads: Ints, values: Floats, head: int = 0) -> tuple[Leg, ...]:
    """Return the edges of a point with their values."""
    return tuple(Leg(int(u), int(v), float(x), head) for u, v, x in zip(tails, heads, values, strict=True))


def legs_around(tour: Iterable[int], head: int = 0) -> tuple[Leg, ...]:
    """Return the legs of a closed tour."""
    nodes = [int(node) for node in tour]
    return tuple(Leg(u, v, 1.0, head) for u, v in pairwise([*nodes, *nodes[:1]])) if len(nodes) > 1 else ()


def _named(sets: tuple[frozenset[int], ...]) -> tuple[tuple[str, tuple[int, ...]], ...]:
    """Name one set S, several as handle and teeth."""
    names = ["S"] if len(sets) == 1 else ["H", *(f"T_{i}" for i in range(1, len(sets)))]
    return tuple((name, tuple(sorted(members))) for name, members in zip(names, sets, strict=True))


def _crossings(sets: int) -> str:
    """Return the left side of a comb with so many sets."""
    return " + ".join(["x(δ(H))", *(f"x(δ(T_{i}))" for i in range(1, sets))])


def cut_in_words(cut: Cut, support: Support, tag: str) -> Inequality:
    """Return a sum of cuts, ``tag`` being the one of combs, or of subtours for a single set."""
    sets, left = _named(cut.sets), sum(support.cut_value(members) for members in cut.sets)
    if len(sets) == 1:
        return Inequality(f"{tag} subtour", f"x(δ(S)) ≥ {cut.least}", SUBTOUR, sets, left, cut.least)
    kind, words = ("blossom", BLOSSOM) if all(len(t) == 2 for t in cut.sets[1:]) else ("comb", COMB)
    symbols = f"{_crossings(len(sets))} ≥ {cut.least}"
    return Inequality(f"{tag} {kind}", symbols, words, sets, left, float(cut.least))


def connect_in_words(head: int, hole: int, members: frozenset[int], left: float, share: float) -> Inequality:
    """Return (connect a i S) with x^a(delta(S)) and z^a_i at the point."""
    sets = (("S", tuple(sorted(members))), ("i", (hole,)))
    superscript = "⁰¹"[head]
    symbols = f"x{superscript}(δ(S)) ≥ 2 z{superscript}_i"
    return Inequality(
        f"(connect {head} i S) subtour of one head",
        symbols,
        CONNECT.format(head=("first", "second")[head]),
        sets,
        left,
        2.0 * share,
    )


def generalized_in_words(cut: GeneralizedCut, point: Point) -> Inequality:
    """Return (G) or (K) with both sides at the point."""
    masks = cut.masks(len(point.y))
    left = sum(point.crossing(mask) for mask in masks)
    parts = [(masks[0], ~masks[0])] if len(masks) == 1 else [(t & masks[0], t & ~masks[0]) for t in masks[1:]]
    shares = [
        1.0 if contour is None else float(point.y[part & (point.contour_of == contour)].sum())
        for pair, contours in zip(parts, cut.pairs, strict=True)
        for part, contour in zip(pair, contours, strict=True)
    ]
    teeth = len(masks) - 1
    sets = _named(cut.sets)
    if teeth == 0:
        sets += _contours(cut.pairs[0], point)
        return Inequality(
            "(3) (G) generalised subtour", _border(cut.pairs[0]), PASSES, sets, left, 2.0 * (sum(shares) - 1.0)
        )
    right = 3.0 * teeth + 1.0 - 2.0 * (2.0 * teeth - sum(shares))
    symbols = f"{_crossings(len(masks))} ≥ {3 * teeth + 1} - 2 Σ (2 - y(T_i ∩ H) - y(T_i \\ H))"
    return Inequality("(4) (K) generalised comb", symbols, GENERALIZED_COMB, sets, left, right)


def _contours(pair: tuple[int | None, int | None], point: Point) -> tuple[tuple[str, tuple[int, ...]], ...]:
    named = zip(("C_h", "C_k"), pair, strict=True)
    return tuple(
        (name, tuple((point.contour_of == contour).nonzero()[0].tolist()))
        for name, contour in named
        if contour is not None
    )


def _border(pair: tuple[int | None, int | None]) -> str:
    """Return (G) as it reads when a whole contour makes a term 1."""
    inside, outside = pair
    if inside is None and outside is None:
        return "x(δ(S)) ≥ 2"
    if outside is None:
        return "x(δ(S)) ≥ 2 y(S ∩ C_h)"
    if inside is None:
        return "x(δ(S)) ≥ 2 y(C_k \\ S)"
    return "x(δ(S)) ≥ 2 (y(S ∩ C_h) + y(C_k \\ S) - 1)"
