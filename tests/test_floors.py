"""Imports run one way: a package knows nothing of those above it, and none is left out of the order."""

import ast
from functools import cache
from pathlib import Path

import pytest

import hotlap

ROOT = Path(hotlap.__file__).parent
FLOORS = (  # from the ground up: packages of one floor do not know each other
    {"core"},
    {"system", "dynamics"},
    {"race"},
    {"reference"},
    {"files", "flight"},
    {"reference_files"},
    {"planning", "feasibility", "worlds", "tuners", "logs"},
    {"tuning", "first_guess", "importers", "identification", "real_flight"},
    {"study", "optuna", "gym"},
    {"analysis", "exporters"},
    {"report"},
    {"reproduce", "api"},
    {"cli"},
)
STRANGERS = {  # packages that do not know each other although their floors would allow it
    "planning": {"flight"},
    "reference_files": {"flight"},
    "feasibility": {"flight"},
    "importers": {"flight", "reference_files"},
    "worlds": {"reference_files"},
    "tuners": {"system", "dynamics", "race", "reference", "files", "flight", "reference_files"},
    "tuning": {"files", "reference_files", "planning", "feasibility", "flight"},
    "optuna": {"system", "dynamics", "race", "reference", "files", "flight", "reference_files"}
    | {"planning", "feasibility", "worlds", "importers", "tuning", "first_guess"},
}
FLOOR_OF = {package: floor for floor, packages in enumerate(FLOORS) for package in packages}
PUBLIC_FACE = {"__init__.py", "__main__.py"}


@cache
def imports() -> list[tuple[str, str, str]]:
    """(file, its package, package that it imports) for every import of hotlap's own, wherever it stands in a file."""
    found = []
    for path in sorted(ROOT.rglob("*.py")):
        file = path.relative_to(ROOT)
        if len(file.parts) == 1:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.level == 0:
                names = [f"hotlap.{alias.name}" for alias in node.names] if node.module == "hotlap" else [node.module or ""]
            assert not (isinstance(node, ast.ImportFrom) and node.level), f"{file}: relative import"
            found += [(str(file), file.parts[0], name.split(".")[1]) for name in names if name.startswith("hotlap.")]
    return found


def test_every_package_has_its_floor_and_nothing_lies_loose():
    assert {path.name for path in ROOT.iterdir() if path.is_dir() and path.name not in {"__pycache__", "data"}} == set(FLOOR_OF)
    assert {path.name for path in ROOT.iterdir() if path.is_file()} == {*PUBLIC_FACE, "py.typed"}


@pytest.mark.parametrize("package", sorted(FLOOR_OF))
def test_a_package_imports_nothing_from_its_own_floor_above_it_or_from_strangers(package):
    rows = [(file, known) for file, own, known in imports() if own == package != known]
    strange = {known for known in FLOOR_OF if FLOOR_OF[known] >= FLOOR_OF[package]} | STRANGERS.get(package, set())
    assert [f"{file} ({package}) imports {known}" for file, known in rows if known in strange] == []


def test_the_tests_mirror_the_packages():
    tests = {path.name for path in Path(__file__).parent.iterdir() if path.is_dir() and path.name != "__pycache__"}
    assert set(FLOOR_OF) - tests == {"optuna"}, "tests/sampler would hide the library of that name if it were called tests/optuna"
