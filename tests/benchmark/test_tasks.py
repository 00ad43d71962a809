"""Suites and tasks: every named source of instances, and keys that tell runs apart."""

from dataclasses import replace

import numpy as np
import pytest
from oracles.random_instances import random_instance

from cutgap.benchmark.methods import known_methods, run
from cutgap.benchmark.tasks import Task, find_suite, suite_tasks
from cutgap.instances import Contour, Rules
from cutgap.instances.formats import MachineOptions, write_instance
from cutgap.instances.suites import SUITES, load_suite


@pytest.fixture
def instance():
    return random_instance(np.random.default_rng(3), 5, layout="uniform")


def test_the_key_tells_apart_all_that_decides_the_outcome(instance):
    task = Task(instance, Rules(), "split", 0)
    last = instance.contours[-1]
    moved = Contour(last.id, np.add(last.entry_points, [0, 0, 1e-9]), last.perimeter)
    others = [
        replace(task, instance=replace(instance, contours=(*instance.contours[:-1], moved))),
        replace(task, instance=replace(instance, machine=replace(instance.machine, t_aux=1.0625))),
        replace(task, rules=Rules(via_points=True)),
        replace(task, method="k-means"),
        replace(task, seed=1),
        replace(task, time_limit=1.0),
    ]
    keys = {each.key for each in (task, *others)}
    assert len(keys) == 1 + len(others)
    assert replace(task).key == task.key


def test_an_unknown_method_is_refused_with_the_known_ones(instance):
    for call in (
        lambda: Task(instance, Rules(), "magic", 0),
        lambda: run("magic", instance, Rules()),
    ):
        with pytest.raises(ValueError, match=r"'magic'") as error:
            call()
        assert all(method in str(error.value) for method in known_methods())


def test_exact_methods_run_once_and_heuristics_once_a_seed(instance):
    tasks = suite_tasks([(instance, Rules())], ("split", "k-means"), seeds=3)
    assert [(task.method, task.seed) for task in tasks] == [
        ("split", 0),
        ("k-means", 0),
        ("k-means", 1),
        ("k-means", 2),
    ]


@pytest.mark.parametrize(
    ("methods", "seeds", "message"),
    [(("split",), 0, "seeds"), (("split", "split"), 1, "more than once"), ((), 1, "at least one")],
)
def test_bad_tasks_are_refused(instance, methods, seeds, message):
    with pytest.raises(ValueError, match=message):
        suite_tasks([(instance, Rules())], methods, seeds=seeds)


def test_a_suite_is_a_name_a_file_or_a_folder(tmp_path, instance):
    shipped = find_suite("small", MachineOptions())
    assert [each.name for each in shipped.instances] == [each.name for each in load_suite("small")]
    write_instance(instance, tmp_path / "b.json")
    write_instance(instance, tmp_path / "a.csv")
    (tmp_path / "notes.md").write_text("not an instance")
    options = MachineOptions(homes=((0, 0), (900, 0)), v_jump=200.0)
    folder = find_suite(str(tmp_path), options)
    assert folder.name == tmp_path.name
    assert [each.name for each in folder.instances] == ["a", instance.name]
    assert all(each.machine.v_jump == 200.0 for each in folder.instances)
    single = find_suite(str(tmp_path / "a.csv"), options)
    assert (single.name, len(single.instances)) == ("a", 1)


def test_machine_options_hold_for_shipped_suites_too():
    options = MachineOptions(homes=((5, 6, 7),), v_cut=11.0)
    for instance in find_suite("small", options).instances:
        assert instance.machine.v_cut == 11.0
        assert [head.home.tolist() for head in instance.heads] == [[5, 6, 7]]


def test_what_is_no_suite_is_refused(tmp_path):
    with pytest.raises(ValueError, match="'nowhere'") as error:
        find_suite("nowhere", MachineOptions())
    assert all(name in str(error.value) for name in SUITES)
    with pytest.raises(ValueError, match="the folder holds no"):
        find_suite(str(tmp_path), MachineOptions())
