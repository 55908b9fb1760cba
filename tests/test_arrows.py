"""Imports run one way: what is low in the house knows nothing of what is above it."""

import ast
from pathlib import Path

import pytest

import hotlap

ROOT = Path(hotlap.__file__).parent
FORBIDDEN = {  # room: rooms that it must not reach
    "tuners": {"flight", "planning", "worlds", "objective", "tuning", "study", "report", "cli", "course", "race", "scoring"},
    "planning": {"flight", "worlds", "scoring", "objective", "tuning", "study", "report", "cli", "tuners"},
    "flight": {"planning", "worlds", "scoring", "objective", "tuning", "study", "report", "cli", "tuners", "files"},
    "worlds": {"scoring", "objective", "tuning", "study", "report", "cli", "tuners", "files"},
    "scoring": {"flight", "planning", "worlds", "objective", "tuning", "study", "report", "cli", "tuners"},
    "objective": {"tuning", "study", "report", "cli", "tuners", "files"},
    "tuning": {"study", "report", "cli", "files", "database", "flight", "planning"},
    "study": {"report", "cli"},
    "analysis": {"report", "cli"},
    "report": {"cli"},
    "export": {"report", "cli"},
    "optuna": {"flight", "planning", "worlds", "objective", "tuning", "study", "report", "cli", "course", "race", "scoring", "files"},
}


def imports(room: str) -> set[tuple[str, str]]:
    """(file, module of hotlap) of every import in a room, wherever it stands in a file."""
    place = ROOT / room
    found = set()
    for path in sorted(place.rglob("*.py")) if place.is_dir() else [place.with_suffix(".py")]:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("hotlap"):
                parts = [*node.module.split(".")[1:2]] or [alias.name for alias in node.names]
                found |= {(path.name, part) for part in parts}
    return found


@pytest.mark.parametrize("room", FORBIDDEN)
def test_a_room_imports_nothing_from_above(room):
    assert imports(room), "a room without imports is not looked into"
    assert [(file, module) for file, module in sorted(imports(room)) if module in FORBIDDEN[room]] == []
