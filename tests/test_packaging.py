"""The package list, the folders and the arrows between them agree with the design."""

import ast
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = ("instances", "formulations", "heuristics", "benchmark", "views")
ALLOWED = {
    "instances": {"instances"},
    "formulations": {"formulations", "instances"},
    "heuristics": {"heuristics", "instances"},
    "benchmark": {"benchmark", "formulations", "heuristics", "instances"},
    "views": set(FOLDERS),
}


def python_packages() -> set[str]:
    inits = [path for folder in FOLDERS for path in (ROOT / folder).rglob("__init__.py")]
    return {"cutgap." + ".".join(path.parent.relative_to(ROOT).parts) for path in inits}


def test_pyproject_lists_every_package():
    setuptools = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    assert set(setuptools["packages"]) == python_packages()
    assert set(setuptools["package-dir"]) == python_packages()
    for package, folder in setuptools["package-dir"].items():
        assert package == "cutgap." + folder.replace("/", ".")


def imported_folders(path: Path) -> set[str]:
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            module = node.module or ""
            names |= {f"{module}.{alias.name}" for alias in node.names}
    return {name.split(".")[1] for name in names if name.startswith("cutgap.")}


@pytest.mark.parametrize("folder", FOLDERS)
def test_arrows_point_one_way(folder):
    for path in (ROOT / folder).rglob("*.py"):
        extra = imported_folders(path) - ALLOWED[folder]
        assert not extra, f"{path} imports {extra}"


def test_instances_import_no_solver():
    solvers = {"highspy", "cvxpy", "ortools", "clarabel"}
    for path in (ROOT / "instances").rglob("*.py"):
        tree = ast.parse(path.read_text())
        roots = {a.name.split(".")[0] for n in ast.walk(tree) if isinstance(n, ast.Import) for a in n.names}
        roots |= {(n.module or "").split(".")[0] for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)}
        assert not roots & solvers, path
