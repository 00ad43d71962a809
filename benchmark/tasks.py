"""What a benchmark runs: a suite of instances, and one task for each instance, method and seed."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache, cached_property, lru_cache
from importlib.metadata import version
from pathlib import Path

from cutgap.benchmark.methods import is_exact, require_known
from cutgap.instances import Instance, Rules
from cutgap.instances.formats import READABLE_SUFFIXES, MachineOptions, read_instance
from cutgap.instances.formats.json_format import format_instance
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


@dataclass(frozen=True)
class Suite:
    """Instances under one name; ``name`` also names the folder of the results."""

    name: str
    instances: tuple[Instance, ...]


def find_suite(name: str, options: MachineOptions) -> Suite:
    """Return a shipped suite, or the instances of a file or folder.

    Parameters
    ----------
    name
        Name of a shipped suite, or a path. Of a folder every file of a known format is read, by name.
    options
        Homes and speeds for formats that carry none, or in place of the given ones.

    Raises
    ------
    ValueError
        When there is no such suite, the folder holds no instance, or a file is refused.
    """
    if name in SUITES:
        return Suite(name, tuple(_overridden(instance, options) for instance in load_suite(name)))
    path = Path(name)
    if path.is_dir():
        files = [file for file in sorted(path.iterdir()) if file.suffix.lower() in READABLE_SUFFIXES]
        if not files:
            raise ValueError(f"suite {name!r}: the folder holds no {', '.join(READABLE_SUFFIXES)} file")
        return Suite(path.resolve().name, tuple(read_instance(file, options) for file in files))
    if path.is_file():
        return Suite(path.stem, (read_instance(path, options),))
    raise ValueError(f"suite: expected one of {', '.join(SUITES)}, or a file or folder, got {name!r}")


def _overridden(instance: Instance, options: MachineOptions) -> Instance:
    heads = options.heads() if options.homes else instance.heads
    return replace(instance, heads=heads, machine=options.machine(instance.machine))


def suite_tasks(
    suite: Suite,
    rules: Rules,
    methods: Sequence[str],
    *,
    seeds: int,
    time_limit: float | None = None,
) -> list[Task]:
    """Return the tasks of a suite: exact methods once, heuristics with seeds 0 .. seeds - 1.

    Raises
    ------
    ValueError
        When a method is unknown or named twice, or there is no seed.
    """
    if seeds < 1:
        raise ValueError(f"seeds: expected at least 1, got {seeds}")
    if not methods:
        raise ValueError("methods: expected at least one, got none")
    for method in methods:
        require_known(method)
        if methods.count(method) > 1:
            raise ValueError(f"methods: {method!r} is named more than once")
    return [
        Task(instance, rules, method, seed, time_limit)
        for instance in suite.instances
        for method in methods
        for seed in range(1 if is_exact(method) else seeds)
    ]


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
