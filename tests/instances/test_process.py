"""What rapids cross, who are neighbours, and each process rule: against exact arithmetic and by hand."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.exact_sheet import sheet_of
from oracles.random_sheets import random_sheet

from cutgap.instances import Instance, Rules
from cutgap.instances.process import adjacent_parts, contours_in, crossings, part_of

SEEDS = st.integers(0, 2**32 - 1)
FREE = Rules("travel", non_overlap=None, empty_heads=True)


def sheet(seed: int, least: int, most: int, **options) -> tuple[Instance, np.random.Generator]:
    rng = np.random.default_rng(seed)
    return random_sheet(rng, int(rng.integers(least, most + 1)), **options), rng


def crossed(instance: Instance) -> dict[tuple[int, int, int, int], frozenset[int]]:
    """The table of the package, by contour and entry, for rapids between contours."""
    table = crossings(instance)
    places = [(c, e) for c, each in enumerate(instance.contours) for e in range(len(each.entry_points))]
    return {
        (*one, *other): frozenset(contours_in(table[instance.node(*one), instance.node(*other)]))
        for one in places
        for other in places
        if one[0] != other[0]
    }


def neighbours(instance: Instance) -> frozenset[tuple[str, str]]:
    names = [f"part {c.part}" if c.part is not None else f"contour {c.id}" for c in instance.contours]
    numbers, adjacent = part_of(instance), adjacent_parts(instance)
    return frozenset(
        (names[i], names[j])
        for i, a in enumerate(numbers)
        for j, b in enumerate(numbers)
        if a != b and adjacent[a, b]
    )


@settings(max_examples=100)
@given(SEEDS)
def test_crossings_and_neighbours_agree_with_exact_arithmetic(seed):
    instance, _ = sheet(seed, 1, 8, entries=4, shape="polygons")
    expected = sheet_of(instance)
    between = {pair: met for pair, met in expected.crossed.items() if pair[0] != pair[2]}
    assert crossed(instance) == between
    assert neighbours(instance) == expected.neighbours
