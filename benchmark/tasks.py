"""What a benchmark runs: a suite of instances, and one task for each instance, method and seed."""

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cache, cached_property, lru_cache
from importlib.metadata import version
from pathlib import Path

from cutgap.benchmark.best_known import BestKnown, best_known
from cutgap.benchmark.methods import default_methods, is_exact, require_known, suits
from cutgap.benchmark.plate_caps import PLATE_RULES, PLATE_SUITES, further_rules
from cutgap.instances import Instance, Rules
from cutgap.instances.formats import READABLE_SUFFIXES, MachineOptions, read_instance
from cutgap.instances.formats.json_format import format_instance
from cutgap.instances.links.points import with_link_points
from cutgap.instances.suites import SUITES, load_suite


@dataclass(frozen=True)
class Task:
    """One run to be done; it can be sent to another process.

    Parameters
    ----------
    instance, rules, method
        What is solved, under which rules, by which method.
    seed
        Seed of the random numbers.
    time_limit
        Limit of the run in s; ``None`` sets none.
    """

    instance: Instance
    rules: Rules
    method: str
    seed: int
    time_limit: float | None = None

    def __post_init__(self) -> None:
        require_known(self.method)

    @cached_property
    def key(self) -> str:
        """Hash of all that decides the outcome: instance, rules, method, seed, limit and release."""
        return digest(
            {
                "instance": instance_hash(self.instance),
                "rules": asdict(self.rules),
                "method": self.method,
                "seed": self.seed,
                "time_limit": self.time_limit,
                "release": release(),
            }
        )


Problem = tuple[Instance, Rules]
"""What is cut, and what is asked of the plan."""


@dataclass(frozen=True)
class Suite:
    """Instances under one name.

    Attributes
    ----------
    name
        Also names the folder of the results.
    rules
        What is asked of plans unless something else is.
    published
        What is published about instances under these rules, by their names.
    further
        Other rules that are asked for besides, by names of instances.
    """

    name: str
    instances: tuple[Instance, ...]
    rules: Rules = field(default_factory=Rules)
    published: Mapping[str, BestKnown] = field(default_factory=dict)
    further: Mapping[str, tuple[Rules, ...]] = field(default_factory=dict)

    def problems(self, rules: Rules, change: Callable[[Rules], Rules] | None = None) -> list[Problem]:
        """Return what is to be solved: ``rules`` on each instance, and with ``change`` what is asked besides.

        Parameters
        ----------
        change
            Changes what is asked for besides, as the suite's own rules were changed into ``rules``.
        """
        return [
            (instance, asked)
            for instance in self.instances
            for asked in dict.fromkeys(
                [rules, *map(change, self.further.get(instance.name, ()))] if change is not None else [rules]
            )
        ]


FILE_SUITES: dict[str, str] = {"gtsp": ".gtsp", "pcgtsp": ".pcglns", "cutting-paths": ".txt", "nests": ".json"}
"""Suites ``NAME:PATH`` of files of one kind: name and suffix."""

ONE_STROKE = Rules("travel", links=True, pierces=1)
"""All in one stroke: what the suites for flame cutting ask for."""

SUITE_RULES: dict[str, Rules] = {
    **dict.fromkeys(FILE_SUITES, Rules("travel")),
    **dict.fromkeys(("nests", "flame108"), ONE_STROKE),
    **dict.fromkeys(PLATE_SUITES, PLATE_RULES),
    "nest28": Rules(
        "travel", parts_in_one_go=True, neighbours_only=True, clear_rapids=True, backward_price=0.1
    ),
}
"""What suites ask for by themselves; all others ask for the least makespan. Plates are asked more than this."""


def find_suite(name: str, options: MachineOptions) -> Suite:
    """Return a shipped suite, the files of one kind, or the instances of a file or folder.

    Parameters
    ----------
    name
        Name of a shipped suite; ``NAME:PATH`` with a name of ``FILE_SUITES``, for the files of this kind in a
        folder, or one of them; or a path alone. Of a folder every file of a known format is read, by name.
    options
        Homes and speeds for formats that carry none, or in place of the given ones.

    Raises
    ------
    ValueError
        When there is no such suite, the folder holds no instance, or a file is refused.
    """
    if name in SUITES:
        instances = tuple(_overridden(instance, options) for instance in load_suite(name))
        return Suite(name, instances, SUITE_RULES.get(name, Rules()), further=further_rules(name))
    kind, colon, place = name.partition(":")
    if colon and kind in FILE_SUITES:
        reading = options
        if kind == "nests":  # these files hold no home: the corner of the strip stands in
            reading = replace(options, homes=options.homes or ((0.0, 0.0),), link_points=True)
        title, instances = _read_all(Path(place), (FILE_SUITES[kind],), name, reading)
        # Other homes make another problem, about which nothing is published.
        published = {} if options.homes else best_known(kind, instances)
        return Suite(title if title == kind else f"{kind}-{title}", instances, SUITE_RULES[kind], published)
    return Suite(*_read_all(Path(name), READABLE_SUFFIXES, name, options))


def _read_all(
    path: Path, suffixes: tuple[str, ...], name: str, options: MachineOptions
) -> tuple[str, tuple[Instance, ...]]:
    """Return the name of a file or folder, and the instances in its files with one of the suffixes."""
    if path.is_dir():
        files = [file for file in sorted(path.iterdir()) if file.suffix.lower() in suffixes]
        if not files:
            raise ValueError(f"suite {name!r}: the folder holds no {', '.join(suffixes)} file")
        return path.resolve().name, tuple(read_instance(file, options) for file in files)
    if path.is_file():
        if path.suffix.lower() not in suffixes:
            raise ValueError(f"suite {name!r}: expected a file that ends in {', '.join(suffixes)}")
        return path.stem, (read_instance(path, options),)
    known = ", ".join((*SUITES, *(f"{kind}:PATH" for kind in FILE_SUITES)))
    raise ValueError(f"suite: expected one of {known}, or a file or folder, got {name!r}")


def _overridden(instance: Instance, options: MachineOptions) -> Instance:
    heads = options.heads() if options.homes else instance.heads
    changed = replace(instance, heads=heads, machine=options.machine(instance.machine))
    return with_link_points(changed) if options.link_points else changed


def suite_tasks(
    problems: Sequence[Problem],
    methods: Sequence[str] | None,
    *,
    seeds: int,
    time_limit: float | None = None,
) -> list[Task]:
    """Return the tasks of a suite: exact methods once, heuristics with seeds 0 .. seeds - 1.

    Without ``methods`` each problem gets those of ``default_methods``. Of several problems of an instance the
    first gets all ``methods``, and a further one those that suit it; heuristics are not run again where only
    the objective differs, since what they plan for one head does not depend on it.

    Raises
    ------
    ValueError
        When a method is unknown or named twice, or there is no seed.
    """
    if seeds < 1:
        raise ValueError(f"seeds: expected at least 1, got {seeds}")
    if methods is not None and not methods:
        raise ValueError("methods: expected at least one, got none")
    for method in methods or ():
        require_known(method)
        if methods is not None and methods.count(method) > 1:
            raise ValueError(f"methods: {method!r} is named more than once")
    planned: dict[str, list[Rules]] = {}
    tasks = []
    for instance, rules in problems:
        before = planned.setdefault(instance_hash(instance), [])
        chosen = default_methods((instance,), rules) if methods is None else methods
        if before:
            again = any(rules.constraints == each.constraints for each in before)
            chosen = [name for name in chosen if suits(name, instance, rules) and (is_exact(name) or not again)]
        before.append(rules)
        tasks += [
            Task(instance, rules, method, seed, time_limit)
            for method in chosen
            for seed in range(1 if is_exact(method) else seeds)
        ]
    return tasks


@cache
def release() -> str:
    """Return the version of the installed package."""
    return version("cutgap")


@lru_cache(maxsize=4096)
def instance_hash(instance: Instance) -> str:
    """Return a hash of the instance's whole content."""
    return digest(format_instance(instance))


def digest(content: object) -> str:
    """Return 16 hex digits of the SHA-256 of ``content`` as canonical JSON."""
    return hashlib.sha256(canonical(content)).hexdigest()[:16]


def canonical(content: object) -> bytes:
    """Return ``content`` as JSON with sorted keys and no spaces; floats are exact."""
    return json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False).encode()
