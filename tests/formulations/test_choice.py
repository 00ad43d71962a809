"""Which exact method is chosen, and that its reason fits; the chosen one never refuses."""

from dataclasses import replace

import numpy as np
import pytest
from oracles.random_instances import random_instance
from oracles.random_sheets import random_sheet

from cutgap.formulations import METHODS, choose, resolve, solve
from cutgap.instances import Contour, Head, Instance, Rules


def points(heads=1, homes=True, **options):
    return random_instance(np.random.default_rng(3), 5, layout="uniform", heads=heads, homes=homes, **options)


def many(contours, precedence=(), points=2):
    rng = np.random.default_rng(0)
    holes = tuple(Contour(str(i), rng.uniform(0, 100, (points, 3)), 1.0) for i in range(contours))
    return Instance("many", holes, (Head("h"),), precedence=precedence)


SHEET = random_sheet(np.random.default_rng(0), 4)
OVERLAP = Rules("travel", non_overlap=None)
CASES = [
    (points(), Rules("travel"), "tour", "one entry point"),
    (points(entries=3), Rules("travel"), "contour-dp", "not too many contours"),
    (points(metric="matrix"), OVERLAP, "contour-dp", "direction"),
    (points(precedence=0.5), Rules("travel"), "contour-dp", "precedence"),
    (points(), Rules("travel", backward_price=1.0), "contour-dp", "backward price"),
    (
        random_sheet(np.random.default_rng(0), 4),
        Rules("travel", clear_rapids=True),
        "contour-dp",
        "clear rapids",
    ),
    (points(entries=3), Rules("travel", via_points=True), "cpsat", "via points"),
    (many(37), Rules("travel"), "gtsp", "many contours"),
    (many(63, (), 7), Rules("travel"), "gtsp", "many contours"),
    (many(63, ((0, 1),)), Rules("travel"), "gtsp", "leaves rules on order out"),
    (points(heads=2), Rules(), "split", "must not overlap"),
    (points(heads=2), OVERLAP, "free", "may overlap"),
    (points(heads=2, entries=3), Rules(), "contour-split", "entry points"),
    (points(heads=2, entries=3, homes=False), Rules(), "cpsat", "without homes"),
    (points(heads=2, precedence=0.5), OVERLAP, "cpsat", "precedence"),
]


@pytest.mark.parametrize(("instance", "rules", "method", "why"), CASES)
def test_the_most_special_method_is_chosen(instance, rules, method, why):
    choice = choose(instance, rules)
    assert choice.method == resolve("auto", instance, rules) == method
    assert why in choice.why
    result = solve(instance, rules, time_limit=3.0)
    assert result.method in (method, "free")
    assert result.plan is not None


def test_an_unknown_method_names_the_known_ones():
    with pytest.raises(ValueError, match=", ".join(METHODS)):
        solve(points(), Rules(), method="simplex")


def test_exact_methods_agree_where_several_apply():
    part = replace(points(entries=3), precedence=())
    values = [solve(part, Rules("travel"), method=name).value for name in ("contour-dp", "gtsp", "cpsat")]
    assert values == pytest.approx([values[0]] * 3)
