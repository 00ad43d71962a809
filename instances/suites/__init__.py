"""The suites that come with the package: generated parts with fixed seeds, as JSON files.

``table1``
    Ten simulated parts with 45 to 90 holes, as in Table 1 of Wang et al. (2025), whose own are not published.
``b-pillars``, ``door-panel``
    Stand-ins for the real parts of its Table 2: 76 and 91 holes.
``nest28``
    A nest of 28 sheet-metal parts with the boxes and perimeters of Table 1 of Li et al. (2019): 47 contours.
``flame108``
    Three nests of 108 irregular outlines for flame cutting, with link points; that of Chen, Li, Chu is not
    published.
``plate30``, ``plate30-dense``, ``small-plates``
    Plates under heat like that of Yang, Liu, Ju (2012), which is not published: three on its 10 m x 5 m, three
    small and close together, and twelve such ones of 6 to 12 contours.
``small``
    6 to 14 holes: random, tied in x, coincident, collinear, all in one column.
"""

from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from pathlib import Path

from cutgap.instances.formats import NO_OVERRIDES, json_format, write_instance
from cutgap.instances.generate import generate
from cutgap.instances.instance import Instance


@dataclass(frozen=True, slots=True)
class Recipe:
    """Name of a shipped part, and the arguments of ``generate`` that make it."""

    name: str
    kind: str
    holes: int
    seed: int


# The seed is the number of holes: any would do, and this one is easy to remember.
RECIPES: dict[str, tuple[Recipe, ...]] = {
    "table1": tuple(Recipe(f"table1-{holes}", "random", holes, holes) for holes in range(45, 95, 5)),
    "b-pillars": (Recipe("b-pillars", "b-pillars", 76, 76),),
    "door-panel": (Recipe("door-panel", "door-panel", 91, 91),),
    "nest28": (Recipe("nest28", "nest28", 47, 28),),
    "flame108": tuple(Recipe(f"flame108-{seed}", "flame", 108, seed) for seed in range(3)),
    "plate30": tuple(Recipe(f"plate30-{seed}", "plate", 30, seed) for seed in range(3)),
    "plate30-dense": tuple(Recipe(f"plate30-dense-{seed}", "dense-plate", 30, seed) for seed in range(3)),
    "small-plates": tuple(
        Recipe(f"small-plate-{holes:02d}-{seed}", "dense-plate", holes, seed)
        for holes in (6, 8, 10, 12)
        for seed in range(3)
    ),
    "small": tuple(
        Recipe(f"small-{kind}-{holes:02d}", kind, holes, holes)
        for kind, sizes in {
            "random": range(6, 15),
            "ties": (8, 13),
            "coincident": (7, 12),
            "collinear": (6, 11),
            "one-column": (6, 10),
        }.items()
        for holes in sizes
    ),
}

SUITES: tuple[str, ...] = tuple(RECIPES)
"""Names of the shipped suites."""


def load_suite(name: str) -> list[Instance]:
    """Return the instances of a shipped suite, in the order of its recipes.

    Raises
    ------
    ValueError
        When there is no such suite.
    """
    return list(_load(_known(name)))


def build_suite(name: str) -> list[Instance]:
    """Generate the instances of a suite anew; raises ``ValueError`` when there is no such suite."""
    return [
        replace(generate(recipe.kind, holes=recipe.holes, seed=recipe.seed), name=recipe.name)
        for recipe in RECIPES[_known(name)]
    ]


def write_suites(folder: Path = Path(__file__).parent) -> None:
    """Write every suite into its folder below ``folder``: how the shipped files were made."""
    for suite in SUITES:
        (folder / suite).mkdir(parents=True, exist_ok=True)
        for instance in build_suite(suite):
            write_instance(instance, folder / suite / f"{instance.name}.json")


@cache
def _load(suite: str) -> tuple[Instance, ...]:
    folder = files(__name__) / suite
    return tuple(
        json_format.parse_instance(
            (folder / f"{recipe.name}.json").read_text("utf-8"), recipe.name, NO_OVERRIDES
        )
        for recipe in RECIPES[suite]
    )


def _known(suite: str) -> str:
    if suite not in RECIPES:
        raise ValueError(f"suite: expected one of {', '.join(SUITES)}, got {suite!r:.40}")
    return suite
