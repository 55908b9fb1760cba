"""Which modules of hotlap a module runs: those that it imports, at its top or inside its functions, and those that they import."""

from __future__ import annotations

import ast
from importlib.util import find_spec
from pathlib import Path


def reached(*modules: str) -> dict[str, Path]:
    """Files of the modules given and of all that they import, by dotted name; nothing is imported."""
    files: dict[str, Path] = {}
    waiting = list(modules)
    while waiting:
        name = waiting.pop()
        spec = find_spec(name) if name not in files else None
        if spec is None or spec.origin is None:
            continue
        files[name] = Path(spec.origin)
        for node in ast.walk(ast.parse(files[name].read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and node.module:
                names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
            waiting += [each for each in names if each.startswith("hotlap.") and is_module(each)]
    return files


def is_module(name: str) -> bool:
    """Whether a dotted name is a module, and not something within one."""
    try:
        return find_spec(name) is not None
    except ModuleNotFoundError:
        return False
