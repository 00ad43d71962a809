"""Kernels are compiled once: no rule changes the types of what they read."""

import numba
import numpy as np
import pytest
from oracles.random_plates import random_plate

from cutgap.heuristics.ant_colony import sheet_of
from cutgap.heuristics.hot_routes import plate_of
from cutgap.instances import Rules
from cutgap.instances.entry_tours import entry_task, plain_task

PLATE = random_plate(np.random.default_rng(0), 4)
RULES = [
    Rules("travel"),
    Rules("travel", clear_rapids=True),
    Rules("travel", neighbours_only=True),
    Rules("travel", parts_in_one_go=True),
    Rules("travel", backward_price=1.0),
]


@pytest.mark.parametrize("reads", [sheet_of, plate_of, entry_task])
def test_no_rule_changes_the_types_that_a_kernel_reads(reads):
    assert len({numba.typeof(reads(PLATE, rules)) for rules in RULES}) == 1


def test_plain_tours_are_of_the_types_of_tours_under_rules():
    plain = plain_task(PLATE.rapids, np.arange(len(PLATE.rapids) + 1))
    assert numba.typeof(plain) == numba.typeof(entry_task(PLATE, RULES[0]))
